"""One sky for the figures of section 4.1: a photograph's mask where the recording is at hand, else a rendered one."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from insectnav.experiments.recordings.files import FOLDER, sky_masks
from insectnav.vision import fisheye
from insectnav.worlds import flat_world, render
from insectnav.worlds.builders import build_world

CAMERA = fisheye((320, 320), np.pi)
PHOTOGRAPH, RENDERED = "photograph", "rendered"
NUMBER = 63  # of the photograph that is drawn: houses and few trees


def source() -> str:
    """Where the sky is from on this machine."""
    return PHOTOGRAPH if len(sky_masks()) else RENDERED


def one_sky(wanted: str, number: int = NUMBER) -> NDArray[np.bool_]:
    """The sky above, (320, 320), as a camera takes it that looks up; of rendered ones there is one."""
    return np.asarray(sky_masks()[number]) if wanted == PHOTOGRAPH else _rendered()


@lru_cache(maxsize=1)
def _rendered() -> NDArray[np.bool_]:
    world = build_world("city", seed=1)
    place = world.route[len(world.route) // 3]
    eye: Any = np.array([[*place, 2.0]])
    layers = render(flat_world(world.mesh), eye, 0.0, camera=CAMERA, layers=("sky",), supersampling=1)
    return np.asarray(layers["sky"][0] >= 0.5)


def sky_text(wanted: str) -> str:
    """What the sky is, for a caption."""
    if wanted == PHOTOGRAPH:
        return "The sky was marked by hand in a photograph through a fisheye of 180°, not one of the thesis."
    return f"The sky is rendered, above a made-up city: no photographs were found (set {FOLDER} to their folder)."
