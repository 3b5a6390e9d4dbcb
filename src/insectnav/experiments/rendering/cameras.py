"""The camera that a world is seen with."""

from dataclasses import dataclass

import numpy as np

from insectnav.checks import InputError, check_choice, check_range
from insectnav.vision.cameras import AHEAD, LENSES, UPWARDS, Camera, fisheye, panorama
from insectnav.worlds.renderer import SUPERSAMPLING

KINDS = ("panorama", "fisheye", "pinhole")
LOOKS = {"ahead": AHEAD, "up": UPWARDS}
MAX_PIXELS = 50_000_000  # of a picture
# Of each kind: rows and columns, field of view [°], and where it looks.
USUAL: dict[str, tuple[tuple[int, int], float, str]] = {
    "fisheye": ((480, 480), 180.0, "up"),
    "pinhole": ((480, 640), 60.0, "ahead"),
}
_PANORAMA_ONLY = ("resolution_deg", "elevation_deg")


@dataclass(frozen=True, kw_only=True)
class CameraParams:
    """A camera; what is None has its usual value for the kind.

    Parameters
    ----------
    kind : "panorama", "fisheye" or "pinhole"
    resolution_deg : float or None
        Of a panorama [°]: width and height of a pixel.
    elevation_deg : pair of float or None
        Of a panorama [°]: lower and upper border.
    size : (rows, columns) or None
        Of the other kinds [px].
    field_of_view_deg : float or None
        Of a fisheye from rim to rim, of a pinhole camera from its left to its right edge [°].
    lens : str
        Of a fisheye: "equidistant", "equisolid", "stereographic" or "orthographic".
    look : "ahead", "up" or None
        Where the axis of the other kinds points in a level eye.
    supersampling : 1, 2, 4 or 8
        Rays along each side of a pixel.

    Raises
    ------
    InputError
        If a value makes no sense, or no sense for that kind.
    """

    kind: str = "panorama"
    resolution_deg: float | None = None
    elevation_deg: tuple[float, float] | None = None
    size: tuple[int, int] | None = None
    field_of_view_deg: float | None = None
    lens: str = "equidistant"
    look: str | None = None
    supersampling: int = 4

    def __post_init__(self) -> None:
        check_choice("camera", self.kind, KINDS)
        check_choice("lens", self.lens, LENSES)
        if self.look is not None:
            check_choice("look", self.look, tuple(LOOKS))
        if self.supersampling not in SUPERSAMPLING:
            raise InputError(f"supersampling is {self.supersampling}, expected one of 1, 2, 4, 8")
        is_panorama = self.kind == "panorama"
        for name in ("size", "field_of_view_deg", "look") if is_panorama else _PANORAMA_ONLY:
            if getattr(self, name) is not None:
                option = "--" + name.removesuffix("_deg").replace("_", "-")
                other = "--resolution and --elevation" if is_panorama else "--size and --field-of-view"
                raise InputError(f"{option} has no meaning for a {self.kind}, expected {other}: another --camera?")
        rows, columns = self.camera().size
        check_range("number of pixels of a picture", rows * columns, 1, MAX_PIXELS)

    def camera(self) -> Camera:
        """The camera in the frame of the eye."""
        if self.kind == "panorama":
            elevation = (-15.0, 90.0) if self.elevation_deg is None else self.elevation_deg  # thesis section 4.3
            return panorama(1.0 if self.resolution_deg is None else self.resolution_deg, elevation)
        usual_size, usual_field, usual_look = USUAL[self.kind]
        size = usual_size if self.size is None else self.size
        check_range("size", size, 1, 30_000, "px")
        field = usual_field if self.field_of_view_deg is None else self.field_of_view_deg
        mounting = LOOKS[usual_look if self.look is None else self.look]
        if self.kind == "fisheye":
            check_range("field of view", field, 1.0, 360.0, "degrees", "in radians?" if field < 1.0 else "")
            return fisheye(size, float(np.deg2rad(field)), model=self.lens, mounting=mounting)
        return _pinhole(size, field, mounting)


def _pinhole(size: tuple[int, int], field_deg: float, mounting: tuple[float, float, float]) -> Camera:
    """Camera without distortion that fills its picture to the corners."""
    check_range("field of view", field_deg, 1.0, 170.0, "degrees", "in radians?" if field_deg < 1.0 else "a fisheye?")
    rows, columns = size
    focal = columns / 2 / np.tan(np.deg2rad(field_deg) / 2)
    corner = float(np.arctan(np.hypot(rows, columns) / 2 / focal))
    return Camera(
        model="pinhole",
        size=size,
        focal_length=(float(focal), float(focal)),
        centre=(columns / 2, rows / 2),
        field=(0.0, corner),
        mounting=mounting,
    )
