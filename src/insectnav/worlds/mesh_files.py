"""Meshes from files: npz of the public ant worlds, OBJ, PLY and GLB."""

import io
import struct
import zipfile
import zlib
from collections.abc import Callable
from os import PathLike
from pathlib import Path

import numpy as np

from insectnav.checks import InputError, check_choice, check_range, quoted
from insectnav.records import MAX_TRIANGLES, Mesh
from insectnav.worlds.mesh_glb import parse_glb
from insectnav.worlds.mesh_parts import MeshParts, fan
from insectnav.worlds.mesh_ply import parse_ply

MAX_FILE_BYTES = 512 * 2**20
UP_AXES = ("z", "y")
# What a damaged file makes Python and NumPy say; each becomes one sentence.
DAMAGE = (
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
)


def read_mesh(path: str | PathLike[str], *, up: str | None = None, metres_per_unit: float = 1.0) -> Mesh:
    """Mesh in a file.

    Parameters
    ----------
    path : .npz with ``vertices (triangle, 3, 3)`` and perhaps ``grey (triangle,)``, or .obj, .ply, .glb
    up : the axis that points up in the file, "z" or "y"; None for "y" in GLB, as that format demands, "z" in all others
    metres_per_unit : length of the file's unit [m]

    Raises
    ------
    InputError
        One sentence that names the file and what is wrong with it.

    Notes
    -----
    Nothing but the file itself is read: materials count by name, pictures and further files are not looked for. In npz
    files, z is taken as its absolute value, as viewers of the ant worlds do (some corners of the Seville world dip
    below the ground); a note says so.
    """
    path = Path(path)
    name = quoted(path, limit=200)
    if up is not None:
        check_choice("up axis", up, UP_AXES)
    check_range("metres per unit", metres_per_unit, 1e-6, 1e6, "m")
    kind = path.suffix.lower()
    if kind not in READERS:
        raise InputError(f"{name} is no mesh, expected a file that ends in {', '.join(READERS)}")
    try:
        with np.errstate(all="ignore"):  # the Mesh says what is not finite
            parts = READERS[kind](_read_bytes(path))
            vertices = parts.vertices * metres_per_unit
        if (up or ("y" if kind == ".glb" else "z")) == "y":
            vertices = vertices[..., [0, 2, 1]] * [1, -1, 1]
        return Mesh(
            vertices=vertices,
            material=parts.material,
            materials=parts.materials,
            grey=parts.grey,
            name="".join(letter if letter.isprintable() else "?" for letter in path.stem),
            notes=parts.notes,
        )
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    except DAMAGE as error:
        raise InputError(f"{name} is damaged or no {kind[1:].upper()} file ({quoted(error, limit=80)})") from None


def _read_bytes(path: Path) -> bytes:
    try:
        size = path.stat().st_size
        if size > MAX_FILE_BYTES:
            raise InputError(f"the file has {size / 2**20:.0f} MiB, expected at most {MAX_FILE_BYTES // 2**20}")
        return path.read_bytes()
    except FileNotFoundError:
        raise InputError("there is no such file") from None
    except OSError as error:
        raise InputError(f"the file cannot be read ({error.strerror})") from None


def parse_npz(content: bytes) -> MeshParts:
    """Triangles of an npz file of a public ant world.

    Parameters
    ----------
    content : the bytes of the file

    Raises
    ------
    InputError
        If it lacks ``vertices`` or unpacks to too much.
    """
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = archive.infolist()
    unpacked = sum(member.file_size for member in members)
    if any(member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) for member in members):
        raise InputError("the file is packed in a way that NumPy does not use")
    if unpacked > MAX_FILE_BYTES:
        raise InputError(f"the file unpacks to {unpacked / 2**20:.0f} MiB, expected at most {MAX_FILE_BYTES // 2**20}")
    with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
        if "vertices" not in arrays.files:
            found = ", ".join(quoted(name) for name in arrays.files[:8])
            raise InputError(f"no array vertices among {found or 'no arrays'}, expected the corners of triangles")
        vertices = np.array(arrays["vertices"])
        grey = np.array(arrays["grey"]) if "grey" in arrays.files else None
    n_below = int((vertices[..., 2] < 0).sum())
    vertices[..., 2] = np.abs(vertices[..., 2])
    note = f"corners below the ground were mirrored to above it, as viewers of this world do: {n_below}"
    return MeshParts(vertices=vertices, grey=grey, notes=(note,) if n_below else ())


def parse_obj(content: bytes) -> MeshParts:
    """Triangles of a Wavefront OBJ file; polygons are cut into fans.

    Parameters
    ----------
    content : the bytes of the file

    Raises
    ------
    InputError
        If it has no faces, or a face names a corner that does not exist.
    """
    points: list[list[float]] = []
    faces: list[tuple[int, int, int]] = []
    material: list[int] = []
    names: dict[str, int] = {}
    current = 0
    for number, line in enumerate(content.decode("utf-8", "replace").replace("\\\n", " ").splitlines(), 1):
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            points.append([float(word) for word in words[1:4]])
        elif words[0] == "usemtl":
            current = names.setdefault(" ".join(words[1:])[:80] or "unnamed", len(names))
        elif words[0] == "f":
            corners = [_obj_index(word, len(points), number) for word in words[1:]]
            triangles = fan(corners)
            faces += triangles
            material += [current if names else names.setdefault("unnamed", 0)] * len(triangles)
        if len(faces) > MAX_TRIANGLES:
            raise InputError(f"the file has more than {MAX_TRIANGLES} triangles")
    if not faces:
        raise InputError("the file has no faces, expected some")
    return MeshParts(
        vertices=np.array(points, float)[np.array(faces)], material=np.array(material), materials=tuple(names)
    )


def _obj_index(word: str, n_points: int, number: int) -> int:
    """Index from 0 of a corner such as 7, 7/2/1 or -1, counted back from the last one read so far."""
    given = int(word.split("/")[0])
    index = given - 1 if given > 0 else n_points + given
    if not 0 <= index < n_points or given == 0:
        raise InputError(f"line {number} names corner {given}, expected 1 to {n_points}")
    return index


READERS: dict[str, Callable[[bytes], MeshParts]] = {
    ".npz": parse_npz,
    ".obj": parse_obj,
    ".ply": parse_ply,
    ".glb": parse_glb,
}
