"""The options of `insectnav render`, each with what it says in the help."""

from typing import Annotated, Any

import typer


def _option(*names: str, about: str, usual: str = "", metavar: str | None = None) -> Any:
    shown = f"{about} [default: {usual}]." if usual else f"{about}."
    return typer.Option(*names, help=shown, metavar=metavar)


# Which world.
World = Annotated[
    str,
    typer.Argument(
        help="ant-world, shrubland, city, forest-trail or suburban-street; or a mesh file: npz, OBJ, PLY or GLB."
    ),
]
Seed = Annotated[int | None, _option("--seed", about="Of the world that is built", usual="0")]
Set = Annotated[
    list[str] | None,
    _option("--set", about="A parameter of the builder, as in n_cars=0 or tree_height=4,9; may be repeated",
            metavar="NAME=VALUE"),
]  # fmt: skip
Foliage = Annotated[float | None, _option("--foliage", about="Season: 0 bare trees to 1 summer", usual="1")]
WorldTime = Annotated[
    float | None, _option("--world-time", about="When cars and people are seen at first [s]", usual="0")
]
Up = Annotated[
    str | None, _option("--up", about="Axis of a mesh file that points up: z or y", usual="y in GLB, else z")
]
MetresPerUnit = Annotated[float | None, _option("--metres-per-unit", about="Unit of a mesh file [m]", usual="1")]
MeshMaterial = Annotated[
    str | None, _option("--material", about="Of all surfaces of a mesh file, as leaves: lights a mesh that names none")
]
Light = Annotated[
    str | None,
    _option("--light", about="sky: daylight; flat: the two greys of published views",
            usual="sky where the materials are known"),
]  # fmt: skip

# Where.
Positions = Annotated[
    str | None,
    _option("--positions", about="Table with x_m, y_m and perhaps z_m, heading_deg, pitch_deg, roll_deg, time_s",
            metavar="TABLE.csv"),
]  # fmt: skip
At = Annotated[
    str | None,
    _option("--at", about="One picture from here [m]", usual="the middle of the route", metavar="X,Y[,Z]"),
]
Spacing = Annotated[float | None, _option("--spacing", about="Walk the route, a frame every so many metres")]
FrameRate = Annotated[float | None, _option("--frame-rate", about="Walk the route, so many frames in a second")]
Frames = Annotated[int | None, _option("--frames", about="Walk the route, so many frames in all")]
Speed = Annotated[float | None, _option("--speed", about="Of the walk [m/s]", usual="1.4")]
Start = Annotated[float | None, _option("--start", about="Where the walk starts, along the route [m]", usual="0")]
Stop = Annotated[float | None, _option("--stop", about="Where it ends [m]", usual="the end of the route")]
Reverse = Annotated[
    bool, typer.Option("--reverse", help="Walk the route from its end; --start and --stop count from there.")
]
Offset = Annotated[float | None, _option("--offset", about="To the right of the route [m]", usual="0")]
Heading = Annotated[
    float | None,
    _option("--heading", about="Where the camera faces, clockwise from +y [deg]",
            usual="along the way, or that of the table"),
]  # fmt: skip
Pitch = Annotated[float | None, _option("--pitch", about="Nose up, added to that of a table [deg]", usual="0")]
Roll = Annotated[float | None, _option("--roll", about="Right side down, added to that of a table [deg]", usual="0")]
EyeHeight = Annotated[
    float | None,
    _option("--eye-height", about="Above the ground [m]", usual="that of the world's animal or camera"),
]
YawJitter = Annotated[float | None, _option("--yaw-jitter", about="SD of the sway in heading [deg]", usual="0")]
PitchJitter = Annotated[float | None, _option("--pitch-jitter", about="SD of the sway in pitch [deg]", usual="0")]
RollJitter = Annotated[float | None, _option("--roll-jitter", about="SD of the sway in roll [deg]", usual="0")]
LateralJitter = Annotated[
    float | None, _option("--lateral-jitter", about="SD of the sway to right and left [m]", usual="0")
]
JitterLength = Annotated[
    float | None,
    _option("--jitter-length", about="Way after which a sway is forgotten [m]; 0: each frame on its own", usual="2"),
]
JitterSeed = Annotated[int | None, _option("--jitter-seed", about="Of the sway", usual="0")]

# When, and in what light.
Date = Annotated[str | None, _option("--date", about="Day", usual="2014-04-11", metavar="YYYY-MM-DD")]
Time = Annotated[
    str | None,
    _option("--time", about="Local mean solar time of the first frame; 09:30Z is UTC, 09:30+01:00 has an offset",
            usual="09:00", metavar="HH:MM"),
]  # fmt: skip
Latitude = Annotated[float | None, _option("--latitude", about="North is positive [deg]", usual="37.4, Seville")]
Longitude = Annotated[float | None, _option("--longitude", about="East is positive [deg]", usual="-5.98")]
Sun = Annotated[
    str | None,
    _option("--sun", about="Where the sun stands still, whatever date and place [deg]", metavar="AZIMUTH,ELEVATION"),
]
Weather = Annotated[str | None, _option("--weather", about="clear, scattered, broken or overcast", usual="clear")]
Turbidity = Annotated[float | None, _option("--turbidity", about="Haze: 2 very clear to 6 hazy", usual="3")]
CloudSeed = Annotated[int | None, _option("--cloud-seed", about="Of where the clouds are", usual="0")]
Wind = Annotated[str | None, _option("--wind", about="Drift of the clouds [m/s]", usual="8,3", metavar="EAST,NORTH")]
Refresh = Annotated[
    float | None,
    _option("--refresh", about="Seconds after which sun, clouds, cars and people move on", usual="30"),
]

# With which camera.
Camera = Annotated[str | None, _option("--camera", about="panorama, fisheye or pinhole", usual="panorama")]
Resolution = Annotated[float | None, _option("--resolution", about="Pixel of a panorama [deg]", usual="1")]
Elevation = Annotated[
    str | None, _option("--elevation", about="Borders of a panorama [deg]", usual="-15,90", metavar="LOW,HIGH")
]
Size = Annotated[
    str | None,
    _option("--size", about="Picture of a fisheye or pinhole camera [px]", usual="480x480, 640x480",
            metavar="WIDTHxHEIGHT"),
]  # fmt: skip
FieldOfView = Annotated[
    float | None,
    _option("--field-of-view", about="Of a fisheye across, of a pinhole camera from left to right [deg]",
            usual="180, 60"),
]  # fmt: skip
Lens = Annotated[
    str | None,
    _option("--lens", about="Of a fisheye: equidistant, equisolid, stereographic or orthographic",
            usual="equidistant"),
]  # fmt: skip
Look = Annotated[
    str | None, _option("--look", about="Axis of a fisheye or pinhole camera: ahead or up", usual="up, ahead")
]
Supersampling = Annotated[
    int | None, _option("--supersampling", about="Rays along each side of a pixel: 1, 2, 4 or 8", usual="4")
]

# What is written.
Pictures = Annotated[
    str | None,
    _option("--pictures", about="Some of uv, blue, green, red, visible, grey, sky_mask, sky_share, material, depth",
            usual="uv,green,visible,sky_mask", metavar="NAME,NAME"),
]  # fmt: skip
Format = Annotated[str | None, _option("--format", about="png or tiff", usual="png")]
Bits = Annotated[
    int | None,
    _option("--bits", about="8 or 16; 32: the radiance itself [W/(m2 nm sr)], in TIFF", usual="8"),
]
Response = Annotated[
    str | None,
    _option("--response", about="Of the numbers to light: srgb or linear", usual="srgb for 8 bits, else linear"),
]
Exposure = Annotated[
    str | None,
    _option("--exposure", about="Automatic for all (traverse) or for each (frame), or the radiance that is white",
            usual="traverse", metavar="traverse|frame|NUMBER"),
]  # fmt: skip
Meter = Annotated[
    str | None,
    _option("--meter", about="Automatic exposures bring the mean to 0.25 of white, or highlights to white",
            usual="mean"),
]  # fmt: skip
WhiteBalance = Annotated[
    str | None,
    _option("--white-balance", about="A white sheet is white in the light of the first frame (scene) or in daylight",
            usual="scene"),
]  # fmt: skip
Noise = Annotated[bool, typer.Option("--noise", help="Add the noise of photons and of the sensor.")]
NoiseSeed = Annotated[int | None, _option("--noise-seed", about="Of the noise", usual="0")]
Flare = Annotated[bool, typer.Option("--flare", help="Add the light that a lens spreads: veil, halo and ghosts.")]

# How.
Out = Annotated[str | None, _option("--out", about="Folder for the frames", usual="out/NAME OF THE WORLD")]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with what an unfinished run left.")]
Replace = Annotated[bool, typer.Option("--replace", help="Do without earlier frames in the same folder.")]
Workers = Annotated[int | None, _option("--workers", about="Number of threads", usual="one for each core")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
