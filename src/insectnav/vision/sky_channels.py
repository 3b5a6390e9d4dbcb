"""Channels that sky is looked for in, as arrays of any type of picture.

Bands of a picture come as red, green, blue. The choices of Stone, Mangan, Ardin & Webb (2014), section II.A: the red
band of a full-spectrum camera behind a UV filter is its UV channel, a picture through a green filter becomes grey, the
two together are a picture of two bands; the mean of all bands is that of Stone, Differt, Milford & Webb (2016), ICRA,
section III (thesis, section 4.3).
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from insectnav.checks import InputError, as_numbers, check_choice, check_finite, check_range, check_shape

Picture = NDArray[Any]  # (rows, columns) or (rows, columns, band), uint8, uint16 or float32
Singles = NDArray[np.float32]

LUMA = (0.299, 0.587, 0.114)  # of red, green, blue; ITU-R BT.601
ONE_CHANNEL = {"mean": None, "grey": LUMA, "red": (1.0, 0.0, 0.0), "green": (0.0, 1.0, 0.0), "blue": (0.0, 0.0, 1.0)}
MORE_CHANNELS = ("rgb", "lab-ab", "uv-green")
CHANNELS = (*ONE_CHANNEL, *MORE_CHANNELS)
MAX_PIXELS = 200_000_000  # of a picture
MIN_SIDE = 4


def checked_picture(image: ArrayLike) -> Picture:
    """A picture as bytes, 16-bit numbers or single precision, with a band axis only where it has several.

    Raises
    ------
    InputError
        If it has no pixels to speak of, NaN, negative values, or a number of bands that a picture does not have.
    """
    array = as_numbers("image", image)
    if array.ndim not in (2, 3):
        raise InputError(f"image has {array.ndim} axes, expected (rows, columns) or (rows, columns, band)")
    if array.ndim == 3 and array.shape[2] == 1:
        array = array[..., 0]
    if array.ndim == 3 and array.shape[2] not in (2, 3):
        hint = {4: ": leave out the alpha channel"}.get(array.shape[2], ": bands first, or a stack of pictures?")
        raise InputError(f"image has {array.shape[2]} bands, expected 1, 2 (UV, green) or 3 (red, green, blue){hint}")
    rows, columns = array.shape[:2]
    if min(rows, columns) < MIN_SIDE or rows * columns > MAX_PIXELS:
        raise InputError(f"image has {rows} × {columns} pixels, expected {MIN_SIDE} × {MIN_SIDE} to {MAX_PIXELS:.0e}")
    if array.dtype in (np.uint8, np.uint16):
        return np.ascontiguousarray(array)
    check_finite("image", array)
    check_range("image", array.min(), 0.0, np.inf, slip="a difference of pictures?")
    return np.ascontiguousarray(array, np.float32)


def channel_name(picture: Picture, channels: str | None, *, one: bool) -> str:
    """The channels that a method is to use: those asked for, or the default for it.

    Raises
    ------
    InputError
        If the picture does not have them, or the method takes one channel and there would be more.
    """
    if channels is None:
        if picture.ndim == 2:
            return "mean"
        if picture.shape[2] == 2:
            channels = "uv-green"
        else:
            channels = "mean" if one else "rgb"
    check_choice("channels", channels, CHANNELS)
    if one and channels in MORE_CHANNELS:
        raise InputError(f"channels {channels} are more than one, expected one of {', '.join(ONE_CHANNEL)}")
    if picture.ndim == 2 and channels in ("mean", "grey"):
        return "mean"
    n_bands = 1 if picture.ndim == 2 else picture.shape[2]
    needed = 2 if channels == "uv-green" else 3
    if n_bands != needed and channels != "mean":
        raise InputError(
            f"channels {channels} need an image of {needed} bands, but it has {n_bands}: "
            "a grey picture, or channels of another camera?"
        )
    return channels


def one_channel(picture: Picture, channels: str) -> NDArray[Any]:
    """One channel (rows, columns): bytes where they are the picture's own, single precision in its unit otherwise."""
    from insectnav.vision.sky_histogram_kernel import weigh_bands

    if picture.ndim == 2:
        return picture if picture.dtype == np.uint8 else picture.astype(np.float32)
    weights = ONE_CHANNEL[channels]
    if weights is None:
        weights = (1.0 / picture.shape[2],) * picture.shape[2]
    if max(weights) == 1.0:
        band = np.ascontiguousarray(picture[..., int(np.argmax(weights))])
        return band if band.dtype == np.uint8 else band.astype(np.float32)
    out = np.empty(picture.shape[0] * picture.shape[1], np.float32)
    weigh_bands(picture.reshape(-1, picture.shape[2]), np.asarray(weights, np.float32), out)
    return out.reshape(picture.shape[:2])


def full_scale(picture: Picture) -> float:
    """The value of white: that of the type of whole numbers, of a picture of fractions 1 or what is brightest."""
    if picture.dtype.kind == "u":
        return float(np.iinfo(picture.dtype).max)
    return max(1.0, float(picture.max()))


def features(picture: Picture, channels: str) -> Singles:
    """Pixels as points in a space of colours (rows, columns, feature), white being 1 and CIELAB in its own unit."""
    if channels in ONE_CHANNEL:
        return (one_channel(picture, channels).astype(np.float32) / np.float32(full_scale(picture)))[..., None]
    scaled = picture.astype(np.float32) / np.float32(full_scale(picture))
    return lab(scaled)[..., 1:] if channels == "lab-ab" else scaled


def lab(rgb: ArrayLike) -> Singles:
    """CIELAB L*, a*, b* of sRGB values in 0…1, white point D65; (..., 3).

    Notes
    -----
    IEC 61966-2-1:1999 for sRGB; CIE 15:2004, section 8.2.1 for L*a*b*.
    """
    values = np.asarray(rgb, np.float32)
    check_shape("rgb", values, (..., 3))
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    to_xyz = np.array(
        [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
    )
    to_xyz /= to_xyz.sum(axis=1, keepdims=True)  # so that white is 1, 1, 1
    ratio = (linear @ to_xyz.T.astype(np.float32)).astype(np.float32)
    root = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    x, y, z = root[..., 0], root[..., 1], root[..., 2]
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1).astype(np.float32)


def uv_green(uv: ArrayLike, green: ArrayLike) -> Singles:
    """Picture of two bands, UV and green, each with white as 1, (rows, columns, 2).

    Parameters
    ----------
    uv : picture behind a UV filter; of three bands the red one is taken
    green : picture behind a green filter; of three bands their grey (ITU-R BT.601)

    Raises
    ------
    InputError
        If the two differ in size.
    """
    first, second = checked_picture(uv), checked_picture(green)
    bands = []
    for picture, channels in ((first, "red"), (second, "grey")):
        chosen = one_channel(picture, channels if picture.ndim == 3 else "mean")
        bands.append(chosen.astype(np.float32) / np.float32(full_scale(picture)))
    if bands[0].shape != bands[1].shape:
        raise InputError(f"uv has shape {bands[0].shape} and green {bands[1].shape}, expected the same: not aligned?")
    return np.stack(bands, axis=-1)
