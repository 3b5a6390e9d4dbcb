"""Frames of one moment: what the camera sees, what the lens adds, and the pictures that are written."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from insectnav.experiments.rendering.pictures import (
    PICTURES,
    label_picture,
    layers_of,
    light_picture,
    metered,
    radiance_of,
    triangle_labels,
    white_sheet,
)
from insectnav.experiments.rendering.plan import Plan, numbered_as
from insectnav.experiments.rendering.scenes import Scene, scene_at
from insectnav.vision.lens_flare import LensFlare, add_lens_flare
from insectnav.vision.sphere import rotation_matrix, to_eye
from insectnav.worlds import render

N_METERED = 5  # frames, evenly along a traverse, that set its exposure

Values = npt.NDArray[Any]


class Frames:
    """Frames of one moment as they were rendered.

    Parameters
    ----------
    plan : Plan
    scene : Scene
        At that moment.
    indices : numbers of the frames
    supersampling : 1, 2, 4 or 8
    workers : threads, or None
    """

    def __init__(
        self, plan: Plan, scene: Scene, indices: Sequence[int], supersampling: int, workers: int | None
    ) -> None:
        self.plan, self.scene, self.indices = plan, scene, indices
        self.seen = plan.camera.pixels_seen()
        poses, chosen = plan.poses, np.asarray(indices)
        self._pose = poses.position[chosen], poses.heading[chosen], poses.pitch[chosen], poses.roll[chosen]
        with numbered_as(indices):
            self.layers = render(
                scene.world,
                *self._pose,
                camera=plan.camera,
                layers=layers_of(plan.names),
                supersampling=supersampling,
                workers=workers,
            )
        self._spread = self._sun_for_the_lens() if plan.params.pictures.flare and plan.lit else None
        self._sheets = sheets_of(plan)
        mesh = scene.place.mesh
        self._labels = triangle_labels(mesh.materials, mesh.material) if "material" in plan.names else np.zeros(0)

    def radiance(self, name: str, row: int) -> Values:
        """Radiance (row, column, band) of a picture of light of one of the frames, with the lens's stray light."""
        light = radiance_of({layer: values[row] for layer, values in self.layers.items()}, name)
        if self._spread is None or self.scene.sky is None:
            return light
        sun, share = self._spread
        return add_lens_flare(
            light,
            self.plan.camera,
            sun[row],
            self.scene.sky.sun_irradiance(PICTURES[name]),
            LensFlare(),
            visible_share=share[row],
            sun_diameter=self.scene.sky.sun_diameter,
            has_bands=True,
        )

    def pictures(self, row: int, whites: Mapping[str, float]) -> tuple[dict[str, Values], dict[str, Any]]:
        """Pictures of one of the frames by name, and what is known of it: the share of sky and each white.

        Parameters
        ----------
        row : place of the frame among the indices
        whites : picture of light → radiance of green light that is white; empty if each frame has its own
        """
        plan, index = self.plan, self.indices[row]
        settings = plan.params.pictures
        layers = {layer: values[row] for layer, values in self.layers.items()}
        found: dict[str, Values] = {}
        known: dict[str, Any] = {"sky_share": round(float(layers["sky"][self.seen].mean(dtype=np.float64)), 6)}
        for name in plan.names:
            if name not in plan.lit:
                found[name] = label_picture(layers, name, self.seen, self._labels, settings.bits)
                continue
            light = self.radiance(name, row)
            if settings.bits == 32:
                found[name] = light_picture(light, name, None, index, settings)
                continue
            white = whites.get(name) or metered(light[None], self._sheets[name], self.seen, settings.meter)
            known[f"white_{name}"] = white
            found[name] = light_picture(light, name, white * self._sheets[name], index, settings)
        return found, known

    def _sun_for_the_lens(self) -> tuple[Values, Values]:
        """Unit vectors (frame, 3) to the sun in the frame of the eye, and whether it shines on the lens (frame,)."""
        position, *angles = self._pose
        assert self.scene.sky is not None
        sun = self.scene.sky.sun
        share = render(self.scene.world, position, np.zeros(len(position)), directions=sun[None], layers=("sky",))
        return to_eye(np.broadcast_to(sun, position.shape), rotation_matrix(*angles)), share["sky"][:, 0]


def whites_of(plan: Plan, first: Scene, workers: int | None) -> dict[str, float]:
    """Radiance of green light that is white, by picture of light; empty where each frame has its own, or none.

    Parameters
    ----------
    plan : Plan
    first : Scene
        At the first moment; cars and people stay where they are in it.
    workers : threads, or None
    """
    setting = plan.params.pictures.exposure
    if not plan.lit or setting == "frame" or plan.params.pictures.bits == 32:
        return {}
    if not isinstance(setting, str):
        return dict.fromkeys(plan.lit, float(setting))
    chosen = np.unique(np.linspace(0, len(plan.poses) - 1, N_METERED).round().astype(int)).tolist()
    radiance: dict[str, list[Values]] = {name: [] for name in plan.lit}
    scene, seen = first, plan.camera.pixels_seen()
    for part in plan.parts:
        if within := [index for index in chosen if part.first <= index < part.last]:
            scene = scene_at(plan.params.place, plan.params.light, part.seconds, scene, keeps_traffic=True)
            frames = Frames(plan, scene, within, 1, workers)
            for name in plan.lit:
                radiance[name] += [frames.radiance(name, row) for row in range(len(within))]
    meter, sheets = plan.params.pictures.meter, sheets_of(plan)
    return {name: metered(np.stack(values), sheets[name], seen, meter) for name, values in radiance.items()}


def sheets_of(plan: Plan) -> dict[str, Values]:
    """White sheets that the colours of each picture of light are relative to, as of `white_sheet`."""
    if not plan.lit:
        return {}
    sky = plan.params.light.sky(plan.parts[0].seconds)
    return {name: white_sheet(name, sky, plan.params.pictures.balance) for name in plan.lit}
