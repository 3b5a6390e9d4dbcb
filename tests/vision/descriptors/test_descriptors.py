import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.matching import METRICS, difference_matrix
from insectnav.vision.descriptors import DESCRIPTORS, frequency_strip, retinotopic
from insectnav.vision.descriptors.brightness import brightness

RNG = np.random.default_rng(0)
VIEWS = RNG.integers(0, 256, (2, 3, 35, 120), np.uint8)
AZIMUTH = (np.arange(120) + 0.5) * np.pi / 60 - np.pi


@pytest.mark.parametrize("name", DESCRIPTORS)
def test_every_descriptor_maps_views_to_finite_vectors(name):
    descriptor = DESCRIPTORS[name]
    features = descriptor(VIEWS)
    assert descriptor.name == name
    assert features.shape[:2] == (2, 3)
    assert features.ndim == 3
    assert np.isfinite(features).all()
    assert "doi 10." in descriptor.source
    alone = descriptor(VIEWS[1, 1])
    assert_allclose(features[1, 1], alone, rtol=0, atol=1e-12 * np.abs(alone).max())


@pytest.mark.parametrize("name", DESCRIPTORS)
def test_a_turn_leaves_those_that_say_so(name):
    descriptor = DESCRIPTORS[name]
    still, turned = descriptor(VIEWS), descriptor(np.roll(VIEWS, 30, axis=-1))
    is_same = np.allclose(still, turned, rtol=0, atol=1e-12 * np.abs(still).max())
    assert is_same == descriptor.is_heading_free


def test_retinotopic_distance_is_the_root_mean_square_difference():
    a, b = retinotopic(VIEWS[0, 0] / 255), retinotopic(VIEWS[0, 1] / 255)
    expected = np.sqrt(np.mean((VIEWS[0, 0] / 255 - VIEWS[0, 1] / 255) ** 2))
    assert_allclose(np.linalg.norm(a - b), expected, rtol=1e-13)


def test_a_wave_along_the_horizon_has_one_amplitude():
    view = np.tile(0.5 + 0.3 * np.cos(4 * AZIMUTH - 1), (105, 1))
    expected = np.zeros(11)
    expected[[0, 4]] = 0.5, 0.3 / np.sqrt(2)
    assert_allclose(frequency_strip(view, 10), expected, rtol=0, atol=1e-15)


def test_only_the_strip_counts():
    view = np.zeros((105, 120))  # 1° a row from +90° to −15°: row 75 is the first below 15°
    view[74] = 1.0
    assert_array_equal(frequency_strip(view), 0.0)
    view[75] = 1.0
    assert_allclose(frequency_strip(view)[0], 1 / 30, rtol=1e-14)
    assert_allclose(frequency_strip(view, strip_deg=(14.0, 16.0))[0], 1.0, rtol=1e-14)


def test_with_phase_the_distance_is_that_of_the_low_pass_strips():
    strips = RNG.random((2, 1, 120))
    codes = frequency_strip(strips, 9, strip_deg=(-90, 90), elevation_deg=(-1, 1), keep_phase=True)
    waves = np.fft.rfft(strips[:, 0])
    waves[:, 10:] = 0
    low = np.fft.irfft(waves, 120)
    expected = np.sqrt(np.mean((low[0] - low[1]) ** 2))  # by Parseval
    assert codes.shape == (2, 19)
    assert_allclose(np.linalg.norm(codes[0] - codes[1]), expected, rtol=1e-12)
    without = frequency_strip(strips, 9, strip_deg=(-90, 90), elevation_deg=(-1, 1))
    assert np.linalg.norm(without[0] - without[1]) <= expected
    assert_allclose(without[:, 0], codes[:, 0], rtol=1e-14)
    assert_allclose(without[:, 1:], np.hypot(codes[:, 1:10], codes[:, 10:]), rtol=1e-13)


@pytest.mark.parametrize(
    ("pixels", "expected"),
    [
        (np.array([[0, 255]], np.uint8), [[0.0, 1.0]]),
        (np.array([[0, 65535]], np.uint16), [[0.0, 1.0]]),
        (np.array([[False, True]]), [[0.0, 1.0]]),
        (np.array([[-0.5, 2.5]]), [[-0.5, 2.5]]),
        (np.array([[-0.5, 2.5]], np.float32), [[-0.5, 2.5]]),
    ],
)
def test_brightness_of_every_type(pixels, expected):
    found = brightness(pixels)
    assert_array_equal(found, expected)
    assert found.dtype == (np.float64 if pixels.dtype == np.float64 else np.float32)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (
            lambda: brightness(np.array([[1, 2]])),
            "views hold int64 values, expected floats, or integers of 8 or 16 bits",
        ),
        (lambda: brightness(np.array([["a"]])), "views hold str"),
        (lambda: retinotopic(np.array([[np.inf]])), "views is inf at index 0, 0"),
        (lambda: frequency_strip(VIEWS, 60), "n_frequencies is 60, expected less than half of the 120 columns"),
        (lambda: frequency_strip(VIEWS, -1), "n_frequencies is -1, expected a whole number of at least 0"),
        (lambda: frequency_strip(VIEWS, strip_deg=(95, 99)), "strip_deg is 95 to 99, expected some rows of views from"),
        (lambda: frequency_strip(VIEWS, elevation_deg=(np.nan, 9)), "elevation_deg is nan at index 0"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()


@pytest.mark.parametrize("name", DESCRIPTORS)
def test_every_descriptor_names_a_metric_that_takes_its_features(name):
    describe = DESCRIPTORS[name]
    features = describe(VIEWS[0])
    assert describe.metric in METRICS
    assert features.dtype.kind == "f"  # bytes and bits would wrap when subtracted
    for form in (features, describe.describe(VIEWS[0])):
        difference = difference_matrix(form, form, describe.metric)
        assert_array_equal(np.diag(difference), 0)
        assert (difference[~np.eye(3, dtype=bool)] > 0).all()
