"""Meshes in PLY files, as text and binary."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from insectnav.checks import InputError, quoted
from insectnav.records import MAX_TRIANGLES
from insectnav.worlds.mesh_parts import MeshParts, fan

MAX_HEADER_BYTES = 65536
MAX_POINTS = 3 * MAX_TRIANGLES
TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


class Property(NamedTuple):
    """One property of an element; ``length`` is the type of a list's length, "" where it is no list."""

    name: str
    type: str
    length: str = ""


class Element(NamedTuple):
    """One element of the header: so many rows of these properties."""

    name: str
    n: int
    properties: list[Property]


def parse_ply(content: bytes) -> MeshParts:
    """Triangles of a PLY file; polygons are cut into fans.

    Parameters
    ----------
    content : the bytes of the file

    Raises
    ------
    InputError
        If it is no PLY file, is cut short, or a face names a corner that does not exist.

    Notes
    -----
    Turk (1994), The PLY polygon file format, Stanford University.
    """
    order, elements, body = _read_header(content)
    rows = _TextRows(body) if order == "" else _BinaryRows(body, order)
    points: Any = None
    faces: Any = None
    for element in elements:
        table = rows.read(element)
        if element.name == "vertex":
            points = np.stack([table[axis] for axis in "xyz"], axis=-1).astype(float)
        elif element.name == "face":
            lists = [table[p.name] for p in element.properties if p.name in ("vertex_indices", "vertex_index")]
            faces = _triangles(lists[0]) if lists else None
    if points is None or faces is None or not len(faces):
        raise InputError("the file has no faces, expected elements vertex (x, y, z) and face (vertex_indices)")
    if faces.min() < 0 or faces.max() >= len(points):
        raise InputError(f"a face names corner {faces.max()}, expected 0 to {len(points) - 1}")
    return MeshParts(vertices=points[faces])


def _read_header(content: bytes) -> tuple[str, list[Element], bytes]:
    end = content[:MAX_HEADER_BYTES].find(b"end_header")
    if not content.startswith(b"ply") or end < 0:
        raise InputError("the file does not start with the header of a PLY file")
    order, elements = None, []
    for line in content[:end].decode("ascii", "replace").splitlines():
        words = line.split()
        if words[:1] == ["format"]:
            order = ORDERS.get(words[1])
        elif words[:1] == ["element"]:
            n = int(words[2])
            if not 0 <= n <= MAX_POINTS:
                raise InputError(f"the file has {n} rows of {quoted(words[1])}, expected at most {MAX_POINTS}")
            elements.append(Element(words[1], n, []))
        elif words[:1] == ["property"]:
            is_list = words[1] == "list"
            kinds = [TYPES[word] for word in words[2 if is_list else 1 : -1]]
            elements[-1].properties.append(Property(words[-1], kinds[-1], kinds[0] if is_list else ""))
    if order is None:
        raise InputError("the file names no format, expected ascii, binary_little_endian or binary_big_endian")
    return order, elements, content[content.index(b"\n", end) + 1 :]


class _TextRows:
    """Rows of numbers as text, one line each."""

    def __init__(self, body: bytes) -> None:
        self.lines = [line for line in body.decode("ascii", "replace").splitlines() if line.strip()]
        self.at = 0

    def read(self, element: Element) -> dict[str, Any]:
        """Columns of an element by name; lists as lists of lists."""
        lines = self.lines[self.at : self.at + element.n]
        if len(lines) < element.n:
            raise InputError(f"the file ends within its {element.n} rows of {quoted(element.name)}")
        self.at += element.n
        table: dict[str, list[Any]] = {p.name: [] for p in element.properties}
        for line in lines:
            words, at = line.split(), 0
            for p in element.properties:
                n = int(words[at]) if p.length else 1
                values = [float(word) for word in words[at + bool(p.length) : at + bool(p.length) + n]]
                if len(values) < n:
                    raise InputError(f"a row of {quoted(element.name)} is too short")
                table[p.name].append([int(value) for value in values] if p.length else values[0])
                at += n + bool(p.length)
        return {p.name: table[p.name] if p.length else np.array(table[p.name]) for p in element.properties}


class _BinaryRows:
    """Rows of numbers as bytes."""

    def __init__(self, body: bytes, order: str) -> None:
        self.body, self.order, self.at = body, order, 0

    def read(self, element: Element) -> dict[str, Any]:
        """Columns of an element by name; lists as an array if all are of one length, else as lists."""
        counts = {p.name: self._first_count(element, p) for p in element.properties if p.length}
        fields: list[Any] = []
        for p in element.properties:
            if p.length:
                fields.append((f"{p.name} length", self.order + p.length))
            fields.append((p.name, self.order + p.type, (counts[p.name],) if p.length else ()))
        row = np.dtype(fields)
        if self.at + element.n * row.itemsize <= len(self.body) and not any(n < 0 for n in counts.values()):
            table = np.frombuffer(self.body, row, element.n, self.at)
            if all((table[f"{name} length"] == n).all() for name, n in counts.items()):
                self.at += element.n * row.itemsize
                return {p.name: table[p.name] for p in element.properties}
        return self._read_one_by_one(element)

    def _first_count(self, element: Element, wanted: Property) -> int:
        """Length of a list in the first row, if nothing but numbers and equal lists stand before it."""
        at, n = self.at, 0
        for p in element.properties:
            n = int(self._take(p.length, 1, at)[0]) if p.length and element.n else 1
            if p is wanted:
                return n if element.n else 0
            at += (np.dtype(p.length).itemsize if p.length else 0) + n * np.dtype(p.type).itemsize
        return n

    def _take(self, kind: str, n: int, at: int) -> npt.NDArray[Any]:
        dtype = np.dtype(self.order + kind)
        if n < 0 or at + n * dtype.itemsize > len(self.body):
            raise InputError("the file ends within its rows")
        return np.frombuffer(self.body, dtype, n, at)

    def _read_one_by_one(self, element: Element) -> dict[str, Any]:
        table: dict[str, list[Any]] = {p.name: [] for p in element.properties}
        for _ in range(element.n):
            for p in element.properties:
                n = 1
                if p.length:
                    n = int(self._take(p.length, 1, self.at)[0])
                    self.at += np.dtype(p.length).itemsize
                values = self._take(p.type, n, self.at)
                self.at += values.nbytes
                table[p.name].append(values.tolist() if p.length else values[0])
        return {p.name: table[p.name] if p.length else np.array(table[p.name]) for p in element.properties}


def _triangles(lists: Any) -> npt.NDArray[np.int64]:
    """Corners (triangle, 3) of polygons."""
    if isinstance(lists, np.ndarray) and lists.shape[1] == 3:
        return lists.astype(np.int64)
    found = [triangle for corners in lists for triangle in fan([int(corner) for corner in corners])]
    return np.array(found, np.int64).reshape(-1, 3)
