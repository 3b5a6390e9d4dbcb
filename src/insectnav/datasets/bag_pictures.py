"""The picture in a message of a camera's driver (ROS, sensor_msgs/Image and CompressedImage)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.checks import InputError, quoted
from insectnav.datasets.image_folder import MAX_PIXELS, decoded_image

# Encoding → bytes of a number, and the order of the bands; after sensor_msgs/image_encodings.hpp.
ENCODINGS = {
    "mono8": (1, ""),
    "8UC1": (1, ""),
    "mono16": (2, ""),
    "16UC1": (2, ""),
    "rgb8": (1, "rgb"),
    "bgr8": (1, "bgr"),
    "rgba8": (1, "rgba"),
    "bgra8": (1, "bgra"),
}
# Encodings of which the source of ROS says that they are in colour; `isColor` of that file.
COLOURS = frozenset(f"{order}{bits}" for order in ("rgb", "bgr", "rgba", "bgra") for bits in (8, 16))


def picture_of(message: Any, name: str) -> NDArray[Any]:
    """Picture of a message, (rows, columns) or (rows, columns, 3) red, green, blue; uint8 or uint16.

    Parameters
    ----------
    message : with `encoding`, `height`, `width`, `step` and `data`, or with `format` and `data`
    name : what to call it in a sentence

    Raises
    ------
    InputError
        If the encoding is none of those that are read, or the data do not fit to it.
    """
    if not hasattr(message, "encoding"):
        picture = decoded_image(bytes(message.data), name)
        if picture.ndim == 2:  # else they were demosaiced before
            _refuse_raw(message.format, name)
        elif is_exchanged(message):
            return np.ascontiguousarray(picture[..., ::-1])
        return picture
    encoding = message.encoding
    _refuse_raw(encoding, name)
    if encoding not in ENCODINGS:
        raise InputError(f"{name} has the encoding {quoted(encoding)}, expected one of {', '.join(ENCODINGS)}")
    n_bytes, bands = ENCODINGS[encoding]
    rows, columns, step = int(message.height), int(message.width), int(message.step)
    width = columns * n_bytes * max(1, len(bands))  # a row may be longer than its pixels
    data = np.asarray(message.data, np.uint8)
    if not 0 < rows * columns <= MAX_PIXELS:
        raise InputError(f"{name} has {rows} × {columns} pixels, expected 1 to {MAX_PIXELS:.0e}")
    if step < width or data.size != rows * step:
        raise InputError(
            f"{name} has {data.size} bytes in rows of {step}, expected {rows} rows of at least {width} for {encoding}"
        )
    lines = np.ascontiguousarray(data.reshape(rows, step)[:, :width])
    if n_bytes == 2:
        return lines.view(">u2" if message.is_bigendian else "<u2").astype(np.uint16)
    if not bands:
        return lines
    return np.ascontiguousarray(lines.reshape(rows, columns, len(bands))[..., [bands.index(band) for band in "rgb"]])


def is_exchanged(message: Any) -> bool:
    """Whether red and blue have changed places in the JPEG or PNG of a message.

    Parameters
    ----------
    message : CompressedImage or Image

    Notes
    -----
    After the source of compressed_image_transport (ros-perception/image_transport_plugins), compressed_subscriber.cpp:
    ``format`` is the encoding before it was compressed, then, after a semicolon, what it was compressed from. Where
    this names no ``compressed bgr``, red came first in what was handed to OpenCV's encoder, which takes blue to be
    first. So it was up to version 1.8.4 (2012, "fixing compressed color format to comply with opencv api" in its
    CHANGELOG for 1.8.5). A format without a semicolon says nothing of an order, and is the usual one.
    """
    encoding, semicolon, compressed = getattr(message, "format", "").partition(";")
    return bool(semicolon) and encoding.strip() in COLOURS and "compressed bgr" not in compressed


def _refuse_raw(encoding: str, name: str) -> None:
    if encoding.startswith("bayer"):
        raise InputError(
            f"{name} is raw data of a colour sensor ({quoted(encoding)}), expected a picture: record the topic after "
            "image_proc, or demosaic it first?"
        )
