"""Meshes in GLB files, the binary form of glTF 2.0."""

import json
import struct
from typing import Any

import numpy as np
import numpy.typing as npt

from insectnav.checks import InputError, quoted
from insectnav.records import MAX_TRIANGLES
from insectnav.worlds.mesh_parts import MeshParts

JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
INDEX_TYPES = {5121: "<u1", 5123: "<u2", 5125: "<u4"}
FLOAT = 5126
TRIANGLES, STRIP, FAN = 4, 5, 6
MAX_DEPTH, MAX_NODES = 64, 100_000


def parse_glb(content: bytes) -> MeshParts:
    """Triangles of all nodes of the scene, each moved by its transform; materials by name.

    Parameters
    ----------
    content : the bytes of the file

    Raises
    ------
    InputError
        If it is no GLB file, needs other files, or is compressed.

    Notes
    -----
    Khronos Group (2021), glTF 2.0 Specification, sections 3.6 (buffers), 3.7 (geometry) and 4.4 (GLB).
    """
    document, binary = _read_chunks(content)
    reader = _Reader(document, binary)
    scenes = document.get("scenes")
    roots = scenes[document.get("scene", 0)].get("nodes", []) if scenes else range(len(document.get("nodes", [])))
    for root in roots:
        reader.visit(root, np.eye(4), 0)
    if not reader.vertices:
        raise InputError("the scene has no triangles, expected some")
    names = [str(m.get("name", "unnamed"))[:80] for m in document.get("materials", [])]
    return MeshParts(
        vertices=np.concatenate(reader.vertices),
        material=np.concatenate(reader.material),
        materials=("unnamed", *names),
    )


def _read_chunks(content: bytes) -> tuple[dict[str, Any], bytes]:
    """The JSON document and the binary buffer."""
    if len(content) < 20 or content[:4] != b"glTF":
        raise InputError("the file does not start as a GLB file")
    version = struct.unpack_from("<I", content, 4)[0]
    if version != 2:
        raise InputError(f"the file is glTF version {version}, expected 2")
    at, document, binary = 12, None, b""
    while at + 8 <= len(content):
        length, kind = struct.unpack_from("<II", content, at)
        chunk = content[at + 8 : at + 8 + length]
        if len(chunk) < length:
            raise InputError("the file is cut short")
        if kind == JSON_CHUNK and document is None:
            try:
                document = json.loads(chunk)
            except RecursionError:
                raise InputError("its JSON is nested too deeply") from None
        elif kind == BINARY_CHUNK and not binary:
            binary = chunk
        at += 8 + length
    if not isinstance(document, dict):
        raise InputError("the file holds no JSON document")
    return document, binary


class _Reader:
    """Collects the triangles of a scene."""

    def __init__(self, document: dict[str, Any], binary: bytes) -> None:
        self.document, self.binary = document, binary
        self.vertices: list[npt.NDArray[np.float64]] = []
        self.material: list[npt.NDArray[np.int64]] = []
        self.n_triangles = self.n_nodes = 0

    def visit(self, index: int, parent: npt.NDArray[np.float64], depth: int) -> None:
        """Add the mesh of a node, and those of its children."""
        self.n_nodes += 1
        if depth > MAX_DEPTH or self.n_nodes > MAX_NODES:
            raise InputError("its nodes are nested in a circle, or there are too many")
        node = self.document["nodes"][_index(index)]
        transform = parent @ _node_transform(node)
        if "mesh" in node:
            for primitive in self.document["meshes"][_index(node["mesh"])]["primitives"]:
                self.add(primitive, transform)
        for child in node.get("children", []):
            self.visit(child, transform, depth + 1)

    def add(self, primitive: dict[str, Any], transform: npt.NDArray[np.float64]) -> None:
        """Add the triangles of one primitive; lines and points have none."""
        mode = primitive.get("mode", TRIANGLES)
        if mode not in (TRIANGLES, STRIP, FAN):
            return
        points = self.accessor(primitive["attributes"]["POSITION"])
        corners = self.accessor(primitive["indices"])[:, 0] if "indices" in primitive else np.arange(len(points))
        triangles = _triangles(corners.astype(np.int64), mode)
        if triangles.size and triangles.max() >= len(points):
            raise InputError(f"a triangle names corner {triangles.max()}, expected 0 to {len(points) - 1}")
        self.n_triangles += len(triangles)
        if self.n_triangles > MAX_TRIANGLES:
            raise InputError(f"the file has more than {MAX_TRIANGLES} triangles")
        moved = points.astype(float) @ transform[:3, :3].T + transform[:3, 3]
        self.vertices.append(moved[triangles])
        self.material.append(np.full(len(triangles), _index(primitive.get("material", -1), least=-1) + 1))

    def accessor(self, index: int) -> npt.NDArray[Any]:
        """Rows of an accessor: positions (n, 3) or indices (n, 1)."""
        accessor = self.document["accessors"][_index(index)]
        if "bufferView" not in accessor or "sparse" in accessor:
            raise InputError("its geometry is compressed or sparse, expected plain buffers: export it uncompressed")
        view = self.document["bufferViews"][_index(accessor["bufferView"])]
        buffer = view["buffer"]
        if buffer != 0 or "uri" in self.document["buffers"][0]:
            raise InputError("its geometry is in another file, expected all in one: export it as a single GLB")
        kind, count = accessor["componentType"], _index(accessor["count"])
        if (accessor["type"], kind) == ("VEC3", FLOAT):
            dtype, width = np.dtype("<f4"), 3
        elif accessor["type"] == "SCALAR" and kind in INDEX_TYPES:
            dtype, width = np.dtype(INDEX_TYPES[kind]), 1
        else:
            raise InputError(
                f"an array is {quoted(accessor['type'])} of type {quoted(kind)}, expected floats or indices"
            )
        stride = _index(view.get("byteStride", width * dtype.itemsize))
        start = _index(view.get("byteOffset", 0)) + _index(accessor.get("byteOffset", 0))
        if stride < width * dtype.itemsize or start + stride * (count - 1) + width * dtype.itemsize > len(self.binary):
            raise InputError("an array reaches beyond the end of the file")
        return np.ndarray((count, width), dtype, self.binary, start, (stride, dtype.itemsize))


def _index(value: Any, least: int = 0) -> int:
    """A whole number that may count something; Python would take a negative one from the end."""
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        raise InputError(f"{quoted(value)} stands where a number of something is expected")
    return value


def _node_transform(node: dict[str, Any]) -> npt.NDArray[np.float64]:
    """Matrix (4, 4) of a node: given as such, column by column, or as scale, rotation and translation in this order."""
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = (float(value) for value in node.get("rotation", (0, 0, 0, 1)))
    rotation = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    transform = np.eye(4)
    transform[:3, :3] = rotation * np.array(node.get("scale", (1, 1, 1)), float)
    transform[:3, 3] = np.array(node.get("translation", (0, 0, 0)), float)
    return transform


def _triangles(corners: npt.NDArray[np.int64], mode: int) -> npt.NDArray[np.int64]:
    if mode == TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    first = corners[:-2] if mode == STRIP else np.full(max(len(corners) - 2, 0), corners[0] if len(corners) else 0)
    return np.stack([first, corners[1:-1], corners[2:]], axis=-1)
