"""What the cameras record: the lens, skies, and frames that do not depend on how they are divided."""

from dataclasses import replace

import numpy as np
import pytest

from insectnav.experiments.stone2016_places.frames import (
    FULL_SIZE,
    Section,
    camera_of,
    keep,
    record,
    sky_grid,
    sky_masks,
)
from insectnav.experiments.stone2016_places.passages import SITE_SEEDS

SECTION = Section(
    site="City", site_seed=SITE_SEEDS["City"], time_s=0.0, passage=0, first=40, n_frames=3, of_frames=520,
    size=64, supersampling=1,
)  # fmt: skip


@pytest.fixture(scope="module")
def recorded():
    return record(SECTION, 0)


def test_the_lens_is_that_of_the_paper():
    # 1.19 mm, in a picture of 270 rows of a sensor 4.55 mm high (1/2.3 inch), equidistant: r = f θ.
    assert camera_of(FULL_SIZE).focal_length[0] == pytest.approx(1.19 / 4.55 * 270, rel=0.005)
    edge = camera_of(FULL_SIZE).look([[FULL_SIZE / 2, 0.0]])[0]
    np.testing.assert_allclose(np.rad2deg(np.arccos(edge[2])), 92.5, atol=1e-6)
    assert edge[1] > 0.99  # ahead is at the top


def test_sky_is_found_in_the_ultraviolet(recorded):
    seen = camera_of(SECTION.size).pixels_seen()
    masks = sky_masks(recorded.uv, camera_of(SECTION.size))
    assert (masks == recorded.sky)[:, seen].mean() > 0.95
    assert not masks[:, ~seen].any()
    assert 0.1 < masks[:, seen].mean() < 0.9


def test_frames_are_the_same_however_they_are_divided(recorded):
    last = record(replace(SECTION, first=42, n_frames=1), 0)
    np.testing.assert_array_equal(last.uv[0], recorded.uv[2])
    np.testing.assert_array_equal(last.visible[0], recorded.visible[2])


def test_what_is_kept_fits_together(recorded):
    arrays = {name: (values[0], np.asarray(values[1])) for name, values in keep(SECTION, 0, with_pictures=True).items()}
    for name, (dimensions, values) in arrays.items():
        assert len(dimensions) == values.ndim, name
        assert dimensions[0] != "frame" or len(values) == SECTION.n_frames, name
    bits = np.unpackbits(arrays["sky"][1], axis=-1, count=sky_grid().n_directions).astype(bool)
    weights = sky_grid().weights
    # The amplitude of degree 0 is the solid angle of the sky over √(4π).
    area = (bits * weights).sum(axis=1) / np.sqrt(4.0 * np.pi)
    np.testing.assert_allclose(arrays["amplitudes"][1][:, 0], area, rtol=0.02)
    np.testing.assert_allclose(arrays["point_amplitudes"][1][:, 0], area, rtol=0.02)
    np.testing.assert_array_equal(arrays["pictures"][1], recorded.grey)
    below = sky_grid().directions[:, 2] < -0.06
    assert not bits[:, below].any()  # not seen, and so ground


def test_tilt_moves_the_sky_back_in_the_picture():
    still = replace(SECTION, n_frames=1)
    # Passages 0 and 7 are tilted by −30° and 30°: nose down brings the street ahead into view, at the top.
    down, up = (record(replace(still, passage=number), 0).sky[0] for number in (0, 7))
    rows = np.arange(SECTION.size)[:, None]
    assert (rows * down).sum() / down.sum() > (rows * up).sum() / up.sum() + 8


def test_without_flare_the_picture_has_the_same_noise_and_no_veil(recorded):
    assert recorded.plain_uv.shape == recorded.uv.shape
    dark = ~recorded.sky & camera_of(SECTION.size).pixels_seen()
    # Of the light that falls on the lens a veil goes over what is dark; exposure is metered anew for each.
    assert recorded.plain_uv[dark].astype(float).mean() < recorded.uv[dark].astype(float).mean()
    assert recorded.is_sunlit.shape == (SECTION.n_frames,)


def test_masks_by_the_watershed_and_without_flare_are_kept_for_the_car(recorded):
    kept = keep(SECTION, 0, with_pictures=True)
    seen = camera_of(SECTION.size).pixels_seen()
    masks = sky_masks(recorded.uv, camera_of(SECTION.size), "watershed-islands")
    np.testing.assert_allclose(
        kept["watershed_accuracy"][1], 100.0 * (masks == recorded.sky)[:, seen].mean(axis=1), atol=1e-9
    )
    assert not {"plain_amplitudes", "watershed_amplitudes"} & set(keep(SECTION, 0, with_pictures=False))
