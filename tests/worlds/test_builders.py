"""All builders: the same bits from the same seed, on any processor; names and parameters."""

import hashlib
import os
import subprocess
import sys
from dataclasses import FrozenInstanceError, fields

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.records import Mesh
from insectnav.worlds.builders import BUILDERS, build_world
from insectnav.worlds.built_world import BuiltWorld
from insectnav.worlds.materials import MATERIALS

SMALL = {
    "ant-world": {"radius": 20.0, "clearing": 3.0, "hills": 1.0},
    "shrubland": {},
    "city": {"window_range": 5.0},
    "forest-trail": {"length": 30.0},
    "suburban-street": {"length": 48.0},
}
DIGEST = """
import hashlib, json, sys
from insectnav.worlds.builders import build_world
for name, changes in json.loads(sys.argv[1]).items():
    mesh = build_world(name, 7, **changes).mesh
    print(name, hashlib.sha256(mesh.vertices.tobytes() + mesh.material.tobytes()).hexdigest())
"""


def digest(mesh: Mesh) -> str:
    return hashlib.sha256(mesh.vertices.tobytes() + mesh.material.tobytes()).hexdigest()


@pytest.mark.parametrize("name", BUILDERS)
def test_a_seed_gives_one_world_and_another_seed_another(name: str):
    first, again, other = (build_world(name, seed, **SMALL[name]) for seed in (7, 7, 8))
    assert digest(first.mesh) == digest(again.mesh)
    np.testing.assert_array_equal(first.route, again.route)
    assert digest(first.mesh) != digest(other.mesh)


def test_a_seed_gives_the_same_bits_without_the_wide_instructions_of_the_processor():
    """NumPy's sines differ in the last digit between instruction sets; the grid of the vertices hides that."""
    import json

    features = "AVX2 FMA3 AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR X86_V3 X86_V4"
    known = np.show_config(mode="dicts")["SIMD Extensions"]
    disabled = [feature for feature in features.split() if feature in known.get("found", [])]
    if not disabled:
        pytest.skip("this processor has no wide instructions to do without")
    given = {name: SMALL[name] for name in ("ant-world", "forest-trail", "suburban-street")}
    found = subprocess.run(
        [sys.executable, "-c", DIGEST, json.dumps(given)], capture_output=True, text=True, check=True,
        env=os.environ | {"NPY_DISABLE_CPU_FEATURES": " ".join(disabled)},
    ).stdout.split()  # fmt: skip
    assert dict(zip(found[::2], found[1::2], strict=True)) == {
        name: digest(build_world(name, 7, **changes).mesh) for name, changes in given.items()
    }


@pytest.mark.parametrize("name", BUILDERS)
def test_materials_are_known_and_the_record_cannot_be_changed(name: str):
    world = build_world(name, 1, **SMALL[name])
    assert isinstance(world, BuiltWorld)
    assert set(world.mesh.materials) <= set(MATERIALS)
    assert world.route.shape[1:] == (2,)
    assert world.seed == 1
    assert world.mesh.name == world.name
    with pytest.raises(FrozenInstanceError):
        world.seed = 2
    with pytest.raises(ValueError, match="read-only"):
        world.route[0] = 1.0


@pytest.mark.parametrize("name", BUILDERS)
def test_vertices_differ_in_no_bit_from_the_grid(name: str):
    vertices = build_world(name, 2, **SMALL[name]).mesh.vertices.astype(float)
    np.testing.assert_array_equal(vertices * 2**14, np.round(vertices * 2**14))


@pytest.mark.parametrize("name", BUILDERS)
def test_every_parameter_is_explained(name: str):
    parameters = BUILDERS[name].parameters
    for field in fields(parameters):
        assert field.name in type(parameters).__doc__


def test_bad_input():
    with pytest.raises(InputError, match="did you mean city"):
        build_world("citty")
    with pytest.raises(InputError, match="did you mean foliage"):
        build_world("city", folliage=0.5)
    with pytest.raises(InputError, match="seed"):
        build_world("shrubland", -3)
    with pytest.raises(InputError, match="expected real numbers"):
        build_world("shrubland", foliage="winter")
    with pytest.raises(InputError, match="of the wrong kind"):
        build_world("city", storeys=3)
