"""The options of `insectnav render`: a table, from which its command is made."""

from collections.abc import Callable

from insectnav.cli.option_tables import COUNT, FLAG, NUMBER, TEXT, TEXTS, Option, with_table

OPTIONS: tuple[Option, ...] = (
    # Which world.
    ("--seed", COUNT, "Of the world that is built", "0", None),
    ("--set", TEXTS, "A parameter of the builder, as n_cars=0 or tree_height=4,9; may be repeated", "", "NAME=VALUE"),
    ("--foliage", NUMBER, "Season: 0 bare trees to 1 summer", "1", None),
    ("--world-time", NUMBER, "When cars and people are seen at first [s]", "0", None),
    ("--up", TEXT, "Axis of a mesh file that points up: z or y", "y in GLB, else z", None),
    ("--metres-per-unit", NUMBER, "Unit of a mesh file [m]", "1", None),
    ("--material", TEXT, "Of all surfaces of a mesh file, as leaves: lights a mesh that names none", "", None),
    ("--light", TEXT, "sky: daylight; flat: greys of published views", "sky where the materials are known", None),
    # Where.
    ("--positions", TEXT, "Table: x_m, y_m, perhaps z_m, heading_deg, pitch_deg, roll_deg, time_s", "", "TABLE.csv"),
    ("--at", TEXT, "One picture from here [m]", "the middle of the route", "X,Y[,Z]"),
    ("--spacing", NUMBER, "Walk the route, a frame every so many metres", "", None),
    ("--frame-rate", NUMBER, "Walk the route, so many frames in a second", "", None),
    ("--frames", COUNT, "Walk the route, so many frames in all", "", None),
    ("--speed", NUMBER, "Of the walk [m/s]", "1.4", None),
    ("--start", NUMBER, "Where the walk starts, along the route [m]", "0", None),
    ("--stop", NUMBER, "Where it ends [m]", "the end of the route", None),
    ("--reverse", FLAG, "Walk the route from its end; --start and --stop count from there", "", None),
    ("--offset", NUMBER, "To the right of the route [m]", "0", None),
    ("--heading", NUMBER, "Where the camera faces, clockwise from +y [deg]", "along the way, or as in the table", None),
    ("--pitch", NUMBER, "Nose up, added to that of a table [deg]", "0", None),
    ("--roll", NUMBER, "Right side down, added to that of a table [deg]", "0", None),
    ("--eye-height", NUMBER, "Above the ground [m]", "that of the world's animal or camera", None),
    ("--yaw-jitter", NUMBER, "SD of the sway in heading [deg]", "0", None),
    ("--pitch-jitter", NUMBER, "SD of the sway in pitch [deg]", "0", None),
    ("--roll-jitter", NUMBER, "SD of the sway in roll [deg]", "0", None),
    ("--lateral-jitter", NUMBER, "SD of the sway to right and left [m]", "0", None),
    ("--jitter-length", NUMBER, "Way after which a sway is forgotten [m]; 0: each frame on its own", "2", None),
    ("--jitter-seed", COUNT, "Of the sway", "0", None),
    # When, and in what light.
    ("--date", TEXT, "Day", "2014-04-11", "YYYY-MM-DD"),
    ("--time", TEXT, "Local mean solar time of the start; 09:30Z is UTC, 09:30+01:00 has an offset", "09:00", "HH:MM"),
    ("--latitude", NUMBER, "North is positive [deg]", "37.4, Seville", None),
    ("--longitude", NUMBER, "East is positive [deg]", "-5.98", None),
    ("--sun", TEXT, "Where the sun stands still, whatever date and place [deg]", "", "AZIMUTH,ELEVATION"),
    ("--weather", TEXT, "clear, scattered, broken or overcast", "clear", None),
    ("--turbidity", NUMBER, "Haze: 2 very clear to 6 hazy", "3", None),
    ("--cloud-seed", COUNT, "Of where the clouds are", "0", None),
    ("--wind", TEXT, "Drift of the clouds [m/s]", "8,3", "EAST,NORTH"),
    ("--refresh", NUMBER, "Seconds after which sun, clouds, cars and people move on", "30", None),
    # With which camera.
    ("--camera", TEXT, "panorama, fisheye or pinhole", "panorama", None),
    ("--resolution", NUMBER, "Pixel of a panorama [deg]", "1", None),
    ("--elevation", TEXT, "Borders of a panorama [deg]", "-15,90", "LOW,HIGH"),
    ("--size", TEXT, "Picture of a fisheye or pinhole camera [px]", "480x480 or 640x480", "WIDTHxHEIGHT"),
    ("--field-of-view", NUMBER, "Of a fisheye across, of a pinhole camera left to right [deg]", "180 or 60", None),
    ("--lens", TEXT, "Of a fisheye: equidistant, equisolid, stereographic or orthographic", "equidistant", None),
    ("--look", TEXT, "Axis of a fisheye or pinhole camera: up or ahead", "up of a fisheye, else ahead", None),
    ("--supersampling", COUNT, "Rays along each side of a pixel: 1, 2, 4 or 8", "4", None),
    # What is written.
    ("--pictures", TEXT, "Some of uv, blue, green, red, visible, grey, sky_mask, sky_share, material, depth",
     "uv,green,visible,sky_mask", "NAME,NAME"),
    ("--format", TEXT, "png or tiff", "png", None),
    ("--bits", COUNT, "8 or 16; 32: the radiance itself [W/(m2 nm sr)], in TIFF", "8", None),
    ("--response", TEXT, "Of the numbers to light: srgb or linear", "srgb for 8 bits, else linear", None),
    ("--exposure", TEXT, "Automatic for all (traverse) or for each (frame), or the radiance that is white",
     "traverse", "traverse|frame|NUMBER"),
    ("--meter", TEXT, "Automatic exposures bring the mean to 0.25 of white, or highlights to white", "mean", None),
    ("--white-balance", TEXT, "A white sheet is white in the first light (scene) or in daylight", "scene", None),
    ("--noise", FLAG, "Add the noise of photons and of the sensor", "", None),
    ("--noise-seed", COUNT, "Of the noise", "0", None),
    ("--flare", FLAG, "Add the light that a lens spreads: veil, halo and ghosts", "", None),
    # How.
    ("--out", TEXT, "Folder for the frames", "out/NAME OF THE WORLD", None),
    ("--resume", FLAG, "Go on with what an unfinished run left", "", None),
    ("--replace", FLAG, "Do without earlier frames in the same folder", "", None),
    ("--workers", COUNT, "Number of threads", "one for each core", None),
    ("--json", FLAG, "Print one JSON object and nothing else", "", None),
)  # fmt: skip
WORLD = "ant-world, shrubland, city, forest-trail or suburban-street; or a mesh file: npz, OBJ, PLY or GLB."


def with_options(command: Callable[..., None]) -> Callable[..., None]:
    """The command with the head that typer reads: WORLD, then `OPTIONS`; dashes become underscores in their names.

    Parameters
    ----------
    command : function of keywords
    """
    return with_table(command, [("world", str, WORLD, None)], OPTIONS)
