from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from insectnav.checks import InputError
from insectnav.vision.sensor import (
    HIGHLIGHTS,
    MID_GREY,
    Meter,
    Sensor,
    auto_exposure,
    expose,
    ideal_sensor,
    srgb_encoded,
    white_balance,
)

SENSOR = Sensor(saturation_radiance=0.4, bits=12)
SCENE = np.random.default_rng(0).uniform(0.0, 0.5, (6, 20, 30)).astype(np.float32)


def flat(share: float, n: int = 40_000, sensor: Sensor = SENSOR) -> np.ndarray:
    """A picture of n pixels that all see this share of what saturates."""
    return np.full((n // 200, 200), share * sensor.saturation_radiance)


@pytest.mark.parametrize("sensor", [
    replace(SENSOR, bits=16),
    SENSOR,
    replace(SENSOR, read_noise=30.0, dark_signal=400.0),
    replace(SENSOR, full_well=1000.0, read_noise=2.0, bits=10),
    replace(SENSOR, full_well=500.0, bits=8),
])  # fmt: skip
@pytest.mark.parametrize("share", [0.0, 0.02, 0.2, 0.5, 0.8])
def test_mean_and_variance_are_those_of_emva_1288(sensor: Sensor, share: float):
    # μ = μ_dark + K μ_e and σ² = K² σ_d² + σ_q² + K (μ - μ_dark), with K from the definition of the range.
    numbers = expose(flat(share, sensor=sensor), sensor, seed=3).astype(float)
    top = 2**sensor.bits - 1
    gain = top * (1 - sensor.black_level) / sensor.full_well
    mean = top * sensor.black_level + gain * share * sensor.full_well
    dark_variance = sensor.read_noise**2 + sensor.dark_signal
    variance = gain**2 * dark_variance + 1 / 12 + gain * (mean - top * sensor.black_level)
    assert sensor.gain == pytest.approx(gain)
    # Standard errors of n values: σ / √n of the mean, and about σ² √(2 / n) of the variance; 4.5 of them.
    assert abs(numbers.mean() - mean) < 4.5 * np.sqrt(variance / numbers.size)
    assert abs(numbers.var() / variance - 1) < 4.5 * np.sqrt(2 / numbers.size)


def test_photon_transfer_gives_back_the_gain():
    # As a camera is measured: variance of the difference of two pictures over their mean, at many exposures.
    shares = np.linspace(0.05, 0.8, 12)
    means, variances = [], []
    for k, share in enumerate(shares):
        first, second = (expose(flat(share), SENSOR, seed=seed).astype(float) for seed in (2 * k, 2 * k + 1))
        means.append((first.mean() + second.mean()) / 2)
        variances.append((first - second).var() / 2)
    slope, _ = np.polyfit(means, variances, 1)
    # Each variance has the relative error √(2 / 80 000) = 0.5 %; 12 of them over this range give the slope to 0.3 %.
    assert slope == pytest.approx(SENSOR.gain, rel=0.012)


def test_pixels_are_independent_and_skewed_as_photons_are():
    few = replace(SENSOR, full_well=50.0, read_noise=0.0, bits=16)
    numbers = expose(flat(0.2, sensor=few), few, seed=1).astype(float)
    electrons = np.rint((numbers - few.black_level * few.largest_number) / few.gain)
    # Poisson: P(n) for a mean of 10, against counts with their own standard error.
    for n, probability in ((5, 0.0378333), (10, 0.1251100), (15, 0.0347181)):
        error = np.sqrt(probability / electrons.size)
        assert abs((electrons == n).mean() - probability) < 4.5 * error
    centred = numbers - numbers.mean()
    for shift in ((0, 1), (1, 0)):
        correlation = (centred * np.roll(centred, shift, (0, 1))).mean() / centred.var()
        assert abs(correlation) < 4.5 / np.sqrt(numbers.size)


def test_ideal_sensor_only_clips_and_rounds():
    radiance = np.array([[0.0, 0.1, 0.2, 0.399999, 0.4, 7e4]])
    for bits in (8, 12, 16):
        numbers = expose(radiance, ideal_sensor(0.4, bits=bits), seed=0)
        assert numbers.dtype == (np.uint8 if bits == 8 else np.uint16)
        top = 2**bits - 1
        np.testing.assert_array_equal(numbers[0], np.minimum(np.rint(radiance[0] / 0.4 * top), top))
    np.testing.assert_array_equal(expose(SCENE, ideal_sensor(0.4), seed=1), expose(SCENE, ideal_sensor(0.4), seed=2))


def test_far_too_much_light_saturates_and_darkness_is_the_black_level():
    assert (expose(flat(1e9), SENSOR, seed=0) == 4095).all()
    dark = replace(SENSOR, read_noise=0.0)
    assert (expose(flat(0.0), dark, seed=0) == round(4095 * 60 / 1023)).all()


def test_an_image_has_its_own_stream():
    whole = expose(SCENE, SENSOR, seed=5)
    np.testing.assert_array_equal(whole, expose(SCENE, SENSOR, seed=5, workers=1))
    np.testing.assert_array_equal(whole, expose(SCENE, SENSOR, seed=5, workers=3))
    np.testing.assert_array_equal(whole[:2], expose(SCENE[:2], SENSOR, seed=5))
    np.testing.assert_array_equal(whole[4:], expose(SCENE[4:], SENSOR, seed=5, first_image=4))
    np.testing.assert_array_equal(whole[3], expose(SCENE[3], SENSOR, seed=5, first_image=3))
    np.testing.assert_array_equal(whole.reshape(2, 3, 20, 30), expose(SCENE.reshape(2, 3, 20, 30), SENSOR, seed=5))
    assert (whole != expose(SCENE, SENSOR, seed=6)).mean() > 0.5
    assert expose(SCENE[:0], SENSOR, seed=5).shape == (0, 20, 30)


def test_noise_of_images_and_channels_is_independent():
    same = np.broadcast_to(flat(0.5), (2, 200, 200))
    first, second = expose(same, SENSOR, seed=1).astype(float)
    other = expose(same[0], SENSOR, seed=1, channel="uv").astype(float)
    for one in (second, other):
        assert abs(np.corrcoef(first.ravel(), one.ravel())[0, 1]) < 4.5 / np.sqrt(first.size)


def test_bands_and_exposures_of_each():
    bands = np.stack([SCENE, 2 * SCENE, 3 * SCENE], axis=-1)
    sensor = ideal_sensor(1.0)
    got = expose(bands, sensor, seed=0, has_bands=True, saturation_radiance=[1.0, 2.0, 3.0])
    for band in range(3):
        np.testing.assert_allclose(got[..., band], expose(SCENE, sensor, seed=0), atol=1)
    exposures = np.linspace(0.5, 1.0, 6)
    got = expose(SCENE, sensor, seed=0, saturation_radiance=exposures)
    for k, exposure in enumerate(exposures):
        np.testing.assert_array_equal(got[k], expose(SCENE[k], ideal_sensor(exposure), seed=0))
    assert expose(bands, SENSOR, seed=0, has_bands=True).shape == bands.shape


@pytest.mark.parametrize(("linear", "byte"), [(0.0, 0), (0.0031308, 10), (0.18, 118), (0.214, 127), (1.0, 255)])
def test_srgb_is_that_of_the_standard(linear: float, byte: int):
    # 0.5 encoded is 0.2140 linear; the two branches meet at 0.04045.
    assert 255 * srgb_encoded(linear) == pytest.approx(byte, abs=0.55)
    picture = expose(np.full((1, 1), linear), ideal_sensor(1.0, bits=8, response="srgb"), seed=0)
    assert abs(int(picture[0, 0]) - byte) <= 1


def test_srgb_branches_meet_and_invert():
    assert srgb_encoded(0.0031308) == pytest.approx(0.04045, abs=1e-5)
    encoded = srgb_encoded(np.linspace(0.0, 1.0, 1001))
    decoded = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(decoded, np.linspace(0.0, 1.0, 1001), atol=2e-7)


def test_srgb_pictures_have_no_black_level_and_keep_the_noise():
    screen = replace(SENSOR, response="srgb", bits=16)
    assert np.median(expose(flat(0.0), screen, seed=0)) == pytest.approx(0.0, abs=2.0 * 65535 * 1e-3)
    numbers = expose(flat(0.5), screen, seed=0) / 65535
    linear = ((numbers + 0.055) / 1.055) ** 2.4
    expected = np.sqrt(0.5 * SENSOR.full_well + SENSOR.read_noise**2) / SENSOR.full_well
    assert linear.std() == pytest.approx(expected, rel=4.5 * np.sqrt(1 / (2 * linear.size)))


radiances = st.lists(st.floats(1e-3, 1e5), min_size=4, max_size=40)


@given(radiances, st.floats(0.05, 0.9))
def test_mean_exposure_solves_its_equation(values: list[float], level: float):
    picture = np.array([values])
    found = float(auto_exposure(picture, Meter(level=level)))
    expected = brentq(lambda s: np.minimum(picture, s).mean() - level * s, 1e-4, picture.sum() / level + 1, rtol=1e-13)
    assert found == pytest.approx(expected, rel=1e-6)


@given(st.floats(1e-3, 1e3))
def test_exposure_goes_with_the_light(factor: float):
    for meter in (MID_GREY, HIGHLIGHTS):
        np.testing.assert_allclose(
            auto_exposure(factor * SCENE.astype(float), meter), factor * auto_exposure(SCENE, meter), rtol=1e-6
        )


def test_metered_picture_has_what_the_meter_wants():
    exposures = auto_exposure(SCENE)
    assert exposures.shape == (6,)
    numbers = expose(SCENE, ideal_sensor(1.0), seed=0, saturation_radiance=exposures)
    np.testing.assert_allclose(numbers.mean(axis=(1, 2)) / 65535, 0.18, atol=1e-4)
    numbers = expose(SCENE, ideal_sensor(1.0), seed=0, saturation_radiance=auto_exposure(SCENE, HIGHLIGHTS))
    np.testing.assert_allclose((numbers == 65535).mean(axis=(1, 2)), 0.01, atol=1 / 600)


def test_one_exposure_for_all_and_a_mask():
    whole = auto_exposure(SCENE, per_image=False)
    assert whole.shape == ()
    assert whole == pytest.approx(SCENE.mean() / 0.18, rel=1e-6)
    mask = np.zeros((20, 30), dtype=bool)
    mask[:, :10] = True
    masked = np.where(mask, SCENE, 1e6)
    np.testing.assert_allclose(auto_exposure(masked, mask=mask), auto_exposure(SCENE[:, :, :10]))
    np.testing.assert_allclose(
        auto_exposure(masked, HIGHLIGHTS, per_image=False, mask=mask),
        auto_exposure(SCENE[:, :, :10], HIGHLIGHTS, per_image=False),
    )


def test_the_disc_of_the_sun_hardly_darkens_a_metered_picture():
    with_sun = SCENE[0].astype(float)
    before = auto_exposure(with_sun)
    with_sun[0, 0] = 2e4
    # One pixel of 600 that counts as saturated, instead of less than half of it: 1 / (600 · 0.18) at most.
    assert before < auto_exposure(with_sun) < before * (1 + 1.01 / (600 * 0.18 - 1))


def test_white_sheet_is_white_and_colours_keep_their_ratios():
    white = np.array([0.3, 0.4, 0.5])
    picture = white * np.random.default_rng(1).uniform(0.0, 1.0, (4, 5, 1))
    balanced = white_balance(picture, white)
    np.testing.assert_allclose(balanced, balanced[..., :1] * np.ones(3))
    sensor = ideal_sensor(1.0, bits=8, response="srgb")
    assert (expose(white_balance(white, white)[None, None], sensor, seed=0, has_bands=True) == 255).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Sensor(saturation_radiance=0.0), "saturation_radiance is 0"),
        (lambda: Sensor(saturation_radiance=np.nan), "saturation_radiance is nan"),
        (lambda: replace(SENSOR, bits=7), "bits is 7"),
        (lambda: replace(SENSOR, bits=24), "bits is 24, expected 8 to 16"),
        (lambda: replace(SENSOR, black_level=64), "black_level is 64.*digital numbers"),
        (lambda: replace(SENSOR, response="gamma"), "response 'gamma' is unknown"),
        (lambda: replace(SENSOR, read_noise=-1.0), "read_noise is -1"),
        (lambda: expose(SCENE[0, 0], SENSOR, seed=0), "radiance has shape"),
        (lambda: expose(-SCENE, SENSOR, seed=0), "radiance reaches -0.4"),
        (lambda: expose(np.full((2, 2), np.nan), SENSOR, seed=0), "radiance is nan"),
        (lambda: expose(SCENE, SENSOR, seed=-1), "seed is -1"),
        (lambda: expose(SCENE, SENSOR, seed=0, saturation_radiance=np.ones(5)), "saturation_radiance has shape"),
        (lambda: expose(SCENE, SENSOR, seed=0, saturation_radiance=np.zeros(6)), "saturation_radiance reaches 0"),
        (lambda: expose(SCENE, SENSOR, seed=0, first_image=-1), "first_image is -1"),
        (lambda: srgb_encoded(255.0), "linear is 255"),
        (lambda: Meter(rule="spot"), "rule 'spot' is unknown"),
        (lambda: Meter(level=18), "level is 18"),
        (lambda: auto_exposure(0 * SCENE), "dark where the mean"),
        (lambda: auto_exposure(0 * SCENE, HIGHLIGHTS), "dark where the percentile"),
        (lambda: auto_exposure(SCENE, mask=np.zeros((20, 30), dtype=bool)), "mask leaves no pixel"),
        (lambda: auto_exposure(SCENE, mask=np.ones((20, 30))), "mask holds float64"),
        (lambda: auto_exposure(SCENE, mask=np.ones((20, 31), dtype=bool)), "mask has shape"),
        (lambda: white_balance(SCENE, [1.0, 1.0, 1.0]), "radiance has shape"),
        (lambda: white_balance(np.ones((2, 2, 3)), [1.0, 1.0, 0.0]), "white reaches 0"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(call, message: str):
    with pytest.raises(InputError, match=message) as caught:
        call()
    assert "\n" not in str(caught.value)
