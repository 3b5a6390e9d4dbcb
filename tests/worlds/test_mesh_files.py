"""Meshes from files: the same house in every format, and files that are damaged or hostile."""

import io
import json
import struct
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.records import Mesh
from insectnav.worlds import read_mesh
from solid_shapes import box

HOUSE = box(1, 2, 2, 3)
POINTS, FACES = (array.reshape(-1, 3) for array in (HOUSE.reshape(-1, 3), np.arange(30)))
PLY_HEADER = "ply\nformat {}\ncomment a house\nelement vertex 30\n{}element face 10\n{}end_header\n"
XYZ = "property float x\nproperty float y\nproperty float z\n"
LIST = "property list uchar int vertex_indices\n"


def read(content: bytes | str, suffix: str, **options) -> Mesh:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"house{suffix}"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_mesh(path, **options)


def refusal(content: bytes | str, suffix: str, **options) -> str:
    with pytest.raises(InputError) as caught:
        read(content, suffix, **options)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def npz(**arrays) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


def obj() -> str:
    lines = [f"v {x} {y} {z}" for x, y, z in POINTS]
    return "\n".join([*lines, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES)])


def ply_text() -> str:
    lines = [f"{x} {y} {z}" for x, y, z in POINTS] + [f"3 {a} {b} {c}" for a, b, c in FACES]
    return PLY_HEADER.format("ascii 1.0", XYZ, LIST) + "\n".join(lines) + "\n"


def ply_binary(order: str = "<") -> bytes:
    name = {"<": "binary_little_endian 1.0", ">": "binary_big_endian 1.0"}[order]
    rows = b"".join(struct.pack(f"{order}B3i", 3, *face) for face in FACES)
    return PLY_HEADER.format(name, XYZ, LIST).encode() + POINTS.astype(f"{order}f4").tobytes() + rows


def glb(changes: dict | None = None, points: np.ndarray = POINTS, faces: np.ndarray = FACES) -> bytes:
    """A binary glTF file, by its specification."""
    corners, indices = points.astype("<f4").tobytes(), faces.astype("<u2").tobytes()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": faces.size, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(corners)},
            {"buffer": 0, "byteOffset": len(corners), "byteLength": len(indices)},
        ],
        "buffers": [{"byteLength": len(corners) + len(indices)}],
    } | (changes or {})
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = corners + indices + b"\0" * (-(len(corners) + len(indices)) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(body), 0x004E4942) + body
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


# The same house in every format.


@pytest.mark.parametrize(
    ("content", "suffix"),
    [(npz(vertices=HOUSE), ".npz"), (obj(), ".obj"), (ply_text(), ".ply"), (ply_binary(), ".ply"),
     (ply_binary(">"), ".PLY"), (glb(), ".glb")],
    ids=["npz", "obj", "ply", "ply-little", "ply-big", "glb"],
)  # fmt: skip
def test_every_format_holds_the_same_house(content, suffix):
    mesh = read(content, suffix, up="z")
    assert_array_equal(mesh.vertices, HOUSE.astype(np.float32))
    assert mesh.name == "house"


def test_units_and_the_axis_that_points_up():
    upright = HOUSE[..., [0, 2, 1]] * [1, 1, -1]  # y up, z towards the viewer
    lines = "\n".join(f"v {x} {y} {z}" for x, y, z in 100 * upright.reshape(-1, 3))
    faces = "\n".join(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES)
    mesh = read(f"{lines}\n{faces}", ".obj", up="y", metres_per_unit=0.01)
    assert_allclose(mesh.vertices, HOUSE, atol=1e-6)
    assert_allclose(read(glb(points=upright.reshape(-1, 3)), ".glb").vertices, HOUSE, atol=1e-6)  # y up by standard


def test_npz_of_an_ant_world():
    below = HOUSE * [1, 1, -1]
    mesh = read(npz(vertices=below, grey=np.full(10, 0.3)), ".npz")
    assert_array_equal(mesh.vertices, HOUSE.astype(np.float32))
    assert_array_equal(mesh.grey, np.full(10, np.float32(0.3)))
    n_below = (below[..., 2] < 0).sum()
    assert mesh.notes == (
        f"corners below the ground were mirrored to above it, as viewers of this world do: {n_below}",
    )


def test_obj_polygons_materials_and_corners_counted_from_the_end():
    text = """# a tent and its floor
        mtllib tent.mtl
        v 0 0 0
        v 2 0 0
        v 2 2 0
        v 0 2 0
        v 1 1 1.5 0.2
        usemtl cloth
        f 1/1/1 2//2 5
        f -3 -2 -1
        usemtl wood
        f 1 2 3 4
        l 1 2
        """
    mesh = read(text, ".obj")
    assert_array_equal(mesh.vertices[1], [[2, 2, 0], [0, 2, 0], [1, 1, 1.5]])
    assert_array_equal(mesh.vertices[2:], [[[0, 0, 0], [2, 0, 0], [2, 2, 0]], [[0, 0, 0], [2, 2, 0], [0, 2, 0]]])
    assert mesh.materials == ("cloth", "wood")
    assert_array_equal(mesh.material, [0, 0, 1, 1])


def test_ply_with_other_columns_and_polygons_of_all_kinds():
    header = "ply\nformat {} 1.0\nelement other 1\nproperty list uchar short n\nelement vertex 5\nproperty uchar red\n"
    header += "property double x\nproperty double y\nproperty double z\nelement face 2\nproperty uchar flag\n"
    header += "property list uchar uint vertex_index\nend_header\n"
    points = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (1, 1, 1.5)]
    text = "2 7 8\n" + "".join(f"9 {x} {y} {z}\n" for x, y, z in points) + "0 4 0 1 2 3\n0 3 0 1 4\n"
    binary = struct.pack("<Bhh", 2, 7, 8) + b"".join(struct.pack("<B3d", 9, *point) for point in points)
    binary += struct.pack("<BB4I", 0, 4, 0, 1, 2, 3) + struct.pack("<BB3I", 0, 3, 0, 1, 4)
    expected = np.array(points)[[[0, 1, 2], [0, 2, 3], [0, 1, 4]]]
    assert_array_equal(read(header.format("ascii") + text, ".ply").vertices, expected)
    assert_array_equal(read(header.format("binary_little_endian").encode() + binary, ".ply").vertices, expected)


def test_glb_nodes_move_their_meshes():
    """A quarter turn about the axis up, twice the size, 5 to the right of a parent 1 above; then as a matrix."""
    half = np.sqrt(0.5)
    child = {"mesh": 0, "translation": [5, 0, 0], "rotation": [0, half, 0, half], "scale": [2, 2, 2]}
    parent = {"translation": [0, 1, 0], "children": [1]}
    x, y, z = POINTS.T  # of the file; a quarter turn about y takes z to x and x to -z
    moved = np.stack([2 * z + 5, 2 * y + 1, -2 * x], axis=-1).reshape(-1, 3, 3)
    matrix = {"mesh": 0, "matrix": [0, 0, -2, 0, 0, 2, 0, 0, 2, 0, 0, 0, 5, 0, 0, 1]}
    for node in (child, matrix):
        mesh = read(glb({"nodes": [parent, node]}), ".glb", up="z")
        assert_allclose(mesh.vertices, moved, atol=1e-5)


def test_glb_strips_fans_unindexed_triangles_and_materials():
    primitives = [{"attributes": {"POSITION": 0}, "indices": 1, "mode": mode, "material": 0} for mode in (4, 5, 6)] + [
        {"attributes": {"POSITION": 0}},
        {"attributes": {"POSITION": 0}, "mode": 1},
    ]
    points, faces = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 1.0], [5, 5, 5], [6, 5, 5]]), np.arange(4)
    mesh = read(
        glb({"meshes": [{"primitives": primitives}], "materials": [{"name": "bark"}]}, points, faces), ".glb", up="z"
    )
    expected = [[0, 1, 2], [0, 1, 2], [1, 2, 3], [0, 1, 2], [0, 2, 3], [0, 1, 2], [3, 4, 5]]
    assert_array_equal(mesh.vertices, points[expected])
    assert mesh.materials == ("unnamed", "bark")
    assert_array_equal(mesh.material, [1, 1, 1, 1, 1, 0, 0])


# Files that are no meshes: each gives one sentence.


@pytest.mark.parametrize(
    ("content", "suffix", "words"),
    [
        (b"", ".stl", "is no mesh, expected a file that ends in .npz, .obj, .ply, .glb"),
        (b"PK", ".npz", "is damaged or no NPZ file"),
        (npz(corners=HOUSE), ".npz", "no array vertices among 'corners'"),
        (npz(vertices=np.array([{}])), ".npz", "is damaged or no NPZ file"),
        (npz(vertices=HOUSE[..., :2]), ".npz", "damaged or no NPZ"),
        (npz(vertices=1e5 * HOUSE), ".npz", "expected -4000 to 4000 m"),
        (npz(vertices=np.where(HOUSE == 3, np.nan, HOUSE)), ".npz", "vertices is nan"),
        ("v 0 0 0\n", ".obj", "the file has no faces"),
        ("v 0 0 0\nf 1 2 3\n", ".obj", "line 2 names corner 2, expected 1 to 1"),
        ("v 0 0 0\nf 0 1 1\n", ".obj", "line 2 names corner 0"),
        ("v 0 0 0\nf -2 1 1\n", ".obj", "line 2 names corner -2"),
        ("v 0 0\nv 0 0 0\nf 1 2 2\n", ".obj", "damaged or no OBJ"),
        ("v a b c\n", ".obj", "damaged or no OBJ"),
        ("solid", ".ply", "does not start with the header of a PLY file"),
        (ply_text().replace("ascii", "morse"), ".ply", "the file names no format"),
        (ply_text()[:-5], ".ply", "a row of 'face' is too short"),
        (ply_text()[:-50], ".ply", "the file ends within its 10 rows of 'face'"),
        (ply_binary()[:-5], ".ply", "the file ends within its rows"),
        (ply_text().replace("3 27 28 29", "3 27 28 30"), ".ply", "a face names corner 30, expected 0 to 29"),
        (ply_text().replace("3 27 28 29", "3 27 28 -1"), ".ply", "a face names corner"),
        (ply_text().replace("vertex 30", "vertex 99999999999"), ".ply", "the file has 99999999999 rows of 'vertex'"),
        (ply_text().replace("vertex 30", "vertex -1"), ".ply", "the file has -1 rows"),
        (ply_text().replace("float x", "float16 x"), ".ply", "damaged or no PLY"),
        (b"GLTF" + bytes(30), ".glb", "does not start as a GLB file"),
        (b"glTF" + struct.pack("<I", 1) + bytes(30), ".glb", "the file is glTF version 1, expected 2"),
        (glb()[:-40], ".glb", "the file is cut short"),
        (glb({"scenes": [{"nodes": []}]}), ".glb", "the scene has no triangles"),
        (glb({"nodes": [{"children": [0]}]}), ".glb", "nested in a circle"),
        (glb({"scenes": [{"nodes": [-1]}]}), ".glb", "'-1' stands where a number of something is expected"),
        (glb({"scenes": [{"nodes": [7]}]}), ".glb", "damaged or no GLB"),
        (glb({"buffers": [{"uri": "/etc/passwd", "byteLength": 9}]}), ".glb", "in another file"),
        (glb({"accessors": [{"componentType": 5126, "count": 3, "type": "VEC3"}] * 2}), ".glb", "compressed or sparse"),
        (glb({"bufferViews": [{"buffer": 0, "byteOffset": 9**9}] * 2}), ".glb", "reaches beyond the end of the file"),
        (glb({"bufferViews": [{"buffer": 0, "byteStride": 1}] * 2}), ".glb", "reaches beyond the end of the file"),
        (glb(faces=FACES + 1), ".glb", "a triangle names corner 30, expected 0 to 29"),
    ],
)  # fmt: skip
def test_what_is_no_mesh_is_refused_in_one_sentence(content, suffix, words):
    assert words in refusal(content, suffix)


def test_options_are_checked():
    assert "up axis 'x' is unknown" in refusal(obj(), ".obj", up="x")
    assert "metres per unit is 0" in refusal(obj(), ".obj", metres_per_unit=0)


def test_a_file_that_unpacks_to_too_much_is_not_unpacked(monkeypatch):
    monkeypatch.setattr("insectnav.worlds.mesh_files.MAX_FILE_BYTES", 2**20)
    content = npz(vertices=np.zeros((10**5, 3, 3)))
    assert len(content) < 2**20
    assert "the file unpacks to 7 MiB, expected at most 1" in refusal(content, ".npz")
    assert "the file has 7 MiB, expected at most 1" in refusal(bytes(7 * 2**20), ".npz")


def test_a_missing_file_and_a_folder(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        read_mesh(tmp_path / "house.obj")
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(InputError, match="the file cannot be read"):
        read_mesh(tmp_path / "folder.ply")


# Whatever comes, a mesh or one sentence.


def assert_mesh_or_sentence(content: bytes, suffix: str) -> None:
    try:
        assert read(content, suffix).n_triangles > 0
    except InputError as error:
        assert "\n" not in str(error)


WHOLE_FILES = [(npz(vertices=HOUSE), ".npz"), (obj().encode(), ".obj"), (ply_text().encode(), ".ply"),
               (ply_binary(), ".ply"), (glb(), ".glb")]  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(WHOLE_FILES), st.binary(max_size=60))
def test_arbitrary_bytes(file, tail):
    assert_mesh_or_sentence(tail, file[1])
    assert_mesh_or_sentence(file[0][:16] + tail, file[1])


@settings(max_examples=250, deadline=None)
@given(st.sampled_from(WHOLE_FILES), st.integers(0, 2**16), st.binary(min_size=1, max_size=3), st.booleans())
def test_whole_files_with_a_fault(file, place, fault, is_cut):
    content, suffix = file
    place %= len(content)
    content = content[:place] + fault + (b"" if is_cut else content[place + len(fault) :])
    assert_mesh_or_sentence(content, suffix)
