"""What is varied to see how far the accuracies of Table I depend on it, each within the range of its sources."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from insectnav.experiments.stone2014_sky_segmentation.photographs import FullSpectrum
from insectnav.vision.lens_flare import NO_FLARE, LensFlare
from insectnav.worlds.lit_world import Grain, LitWorld
from insectnav.worlds.materials import MATERIALS, Material

UNCOATED = LensFlare(veiling_glare=0.06, halo=0.05)  # glare assumed; halo of telescopes: King 1971, doi 10.1086/129100
# Albedo in 315–400 nm of soils 0.05 to 0.08 and of sand 0.14 to 0.24 in its parts: Feister & Grewe 1995, about their
# middles, 0.065 and 0.19; taken for all materials.
LESS, MORE = 0.75, 1.25
CLEAR_AIR, HAZE = 2.0, 6.0  # turbidity: Preetham et al. 1999, doi 10.1145/311535.311545


@dataclass(frozen=True, kw_only=True)
class Variation:
    """One change to what Table I is made with.

    Parameters
    ----------
    name : what is changed
    uv, visible : factors on the diffuse reflectance of all materials, at 350 nm and in the other bands
    mirrors : factor on what bare metal mirrors
    turbidity : of the air; NaN is that of the scene
    cloud_depth : factor on the optical depth of clouds
    contrast : of the texture of surfaces; NaN is as it is
    camera : changes to `FullSpectrum`
    """

    name: str
    uv: float = 1.0
    visible: float = 1.0
    mirrors: float = 1.0
    turbidity: float = float("nan")
    cloud_depth: float = 1.0
    contrast: float = float("nan")
    camera: Mapping[str, Any] = field(default_factory=dict)

    @property
    def is_of_the_light(self) -> bool:
        """Whether the scene must be rendered anew."""
        return not self.camera and self.name != AS_SET

    def world(self, lit: LitWorld) -> LitWorld:
        """The lit scene with the change."""
        sky, grain = lit.sky, lit.grain
        if np.isfinite(self.turbidity):
            sky = replace(sky, turbidity=self.turbidity)
        if self.cloud_depth != 1.0 and sky.clouds is not None:
            clouds = replace(sky.clouds, optical_depth=self.cloud_depth * sky.clouds.optical_depth)
            sky = replace(sky, clouds=clouds)
        if np.isfinite(self.contrast):
            grain = Grain(contrast=self.contrast, seed=grain.seed)
        materials = {name: self._material(one) for name, one in MATERIALS.items()}
        return replace(lit, sky=sky, grain=grain, materials=materials)

    def _material(self, one: Material) -> Material:
        mirror = one.metal_mirror * self.mirrors
        return replace(one, diffuse=self._scaled(one.diffuse), through=self._scaled(one.through), metal_mirror=mirror)

    def _scaled(self, shares: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
        uv, blue, green, red = shares
        return uv * self.uv, blue * self.visible, green * self.visible, red * self.visible


AS_SET = "as set"
VARIATIONS = (
    Variation(name=AS_SET),
    Variation(name="UV reflectance −25 %", uv=LESS),
    Variation(name="UV reflectance +25 %", uv=MORE),
    Variation(name="visible reflectance −25 %", visible=LESS),
    Variation(name="visible reflectance +25 %", visible=MORE),
    Variation(name="metal mirrors nothing", mirrors=0.0),
    Variation(name="turbidity 2", turbidity=CLEAR_AIR),
    Variation(name="turbidity 6", turbidity=HAZE),
    Variation(name="clouds half as thick", cloud_depth=0.5),
    Variation(name="clouds twice as thick", cloud_depth=2.0),
    Variation(name="flat surfaces", contrast=0.0),
    Variation(name="texture of 40 %", contrast=0.4),
    Variation(name="exposure −3 stops", camera={"exposure": 0.125}),
    Variation(name="exposure +1 stop", camera={"exposure": 2.0}),
    Variation(name="no noise", camera={"n_raw": 0}),
    Variation(name="noise of single pixels", camera={"n_raw": 1}),
    Variation(name="no lens flare", camera={"flare": NO_FLARE}),
    Variation(name="lens flare of bare glass", camera={"flare": UNCOATED}),
    Variation(name="numbers encoded (sRGB)", camera={"is_encoded": True}),
    Variation(name="white balance of the scene", camera={"balances_each": True}),
)


def varied_camera(how: FullSpectrum, variation: Variation) -> FullSpectrum:
    """The camera with the change."""
    return replace(how, **variation.camera)
