"""GrowCut against the automaton of the paper, run cell by cell and step by step."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from growcut_oracle import MOORE, VON_NEUMANN, array_automaton, exact_automaton, published_automaton
from insectnav.checks import InputError
from insectnav.vision.growcut import StrokeGrower, grow_cut

OFFSETS = {"moore": MOORE, "von-neumann": VON_NEUMANN}
ALIKE = 1e-9  # relative; strengths that differ by less may be equal but for rounding


@st.composite
def painted_images(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """A small image with few or many grey levels, grey or with bands, and strokes of up to three labels."""
    rows, columns = draw(st.integers(1, 7)), draw(st.integers(1, 7))
    shape = draw(st.sampled_from([(rows, columns), (rows, columns, 1), (rows, columns, 3)]))
    levels = st.sampled_from([st.integers(0, 1), st.integers(1, 4), st.integers(0, 255)])
    image = draw(arrays(np.uint8, shape, elements=draw(levels)))
    strokes = draw(arrays(np.uint8, (rows, columns), elements=st.sampled_from([0] * 7 + [1, 2, 3])))
    strokes[draw(st.integers(0, rows - 1)), draw(st.integers(0, columns - 1))] = 1
    return image, strokes


def strengths_alone(image: np.ndarray, strokes: np.ndarray, neighbourhood: str) -> np.ndarray:
    """What each label would reach if it were alone, (label, rows, columns), by the package itself."""
    alone = [np.where(strokes == label, strokes, 0) for label in np.unique(strokes[strokes > 0])]
    return np.array([grow_cut(image, one, neighbourhood=neighbourhood).strength for one in alone])


@pytest.mark.parametrize("neighbourhood", OFFSETS)
@settings(max_examples=150, deadline=None)
@given(painted=painted_images())
def test_automaton_in_exact_arithmetic_gives_the_same_everywhere(neighbourhood: str, painted: tuple):
    image, strokes = painted
    grown = grow_cut(image, strokes, neighbourhood=neighbourhood)
    labels, length = exact_automaton(image, strokes, OFFSETS[neighbourhood])
    np.testing.assert_array_equal(grown.labels, labels)
    strength = np.where(labels > 0, np.exp(-length.astype(float) / 2.0**36), 0.0)
    np.testing.assert_allclose(grown.strength, strength, rtol=1e-12)


@pytest.mark.parametrize("neighbourhood", OFFSETS)
@settings(max_examples=150, deadline=None)
@given(painted=painted_images())
def test_published_automaton_gives_the_same_but_where_labels_are_equally_strong(neighbourhood: str, painted: tuple):
    image, strokes = painted
    grown = grow_cut(image, strokes, neighbourhood=neighbourhood)
    labels, strength = published_automaton(image, strokes, OFFSETS[neighbourhood])
    np.testing.assert_allclose(grown.strength, strength, rtol=ALIKE)
    alone = np.sort(strengths_alone(image, strokes, neighbourhood), axis=0)
    second = alone[-2] if len(alone) > 1 else np.zeros(strokes.shape)
    is_decided = alone[-1] > second * (1.0 + ALIKE)
    np.testing.assert_array_equal(grown.labels[is_decided], labels[is_decided])
    np.testing.assert_array_equal(grown.labels == 0, labels == 0)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.int32, np.float32, np.float64])
def test_a_larger_picture_of_any_type(dtype: type):
    rng = np.random.default_rng(3)
    levels = rng.integers(0, 200, (60, 80, 3)) + np.where(np.arange(80) < 37, 0, 50)[:, None]
    image = (levels * (257 if dtype == np.uint16 else 1)).astype(dtype)
    strokes = np.zeros((60, 80), np.int16)
    strokes[5, 3:20], strokes[50, 60:70], strokes[30:33, 40] = 1, 2, 7
    labels, strength, _ = array_automaton(image, strokes)
    grown = grow_cut(image, strokes)
    assert grown.labels.dtype == np.int16
    np.testing.assert_allclose(grown.strength, strength, rtol=ALIKE)
    assert (grown.labels != labels).mean() < 1e-3  # no more than what is equally strong
    assert set(np.unique(grown.labels)) == {1, 2, 7}


def test_two_flat_halves_are_parted_at_their_edge():
    image = np.where(np.arange(20) < 8, 30, 200)[None, :].repeat(15, axis=0).astype(np.uint8)
    strokes = np.zeros((15, 20), np.uint8)
    strokes[14, 0], strokes[0, 19] = 1, 2
    grown = grow_cut(image, strokes)
    np.testing.assert_array_equal(grown.labels, np.where(np.arange(20) < 8, 1, 2)[None, :].repeat(15, axis=0))
    assert (grown.strength == 1.0).all()


def test_strength_is_the_product_along_a_row():
    image = np.array([[10.0, 8.0, 9.0, 4.0]])
    grown = grow_cut(image, np.array([[5, 0, 0, 0]]))
    np.testing.assert_allclose(grown.strength, [[1.0, 0.8, 0.8 * 0.9, 0.8 * 0.9 * 0.5]], rtol=1e-10)


def test_black_against_the_brightest_pixel_is_never_crossed():
    grown = grow_cut(np.array([[255, 0, 0]], np.uint8), np.array([[1, 0, 0]]))
    assert grown.labels.tolist() == [[1, 0, 0]]
    assert grown.strength.tolist() == [[1.0, 0.0, 0.0]]
    with_bands = grow_cut(np.array([[[1.0, 0.0], [-1.0, 0.0]]]), np.array([[1, 0]]))  # g would be −1
    assert with_bands.labels.tolist() == [[1, 0]]


def test_flat_picture_goes_to_the_nearest_stroke_and_midway_to_the_lower_label():
    for flat in (np.zeros((1, 7)), np.full((1, 7), 3, np.uint8)):
        assert grow_cut(flat, np.array([[2, 0, 0, 0, 0, 0, 1]])).labels.tolist() == [[2, 2, 2, 1, 1, 1, 1]]


def test_soft_stroke_gives_way_to_a_stronger_neighbour():
    image, strokes = np.array([[100, 100, 90]], np.uint8), np.array([[1, 2, 0]])
    soft = np.array([[1.0, 0.5, 1.0]])
    assert grow_cut(image, strokes, seed_strength=soft).labels.tolist() == [[1, 1, 1]]
    assert grow_cut(image, strokes).labels.tolist() == [[1, 2, 2]]
    labels, strength = published_automaton(image, strokes, seed_strength=0.5)
    grown = grow_cut(image, strokes, seed_strength=0.5)
    np.testing.assert_array_equal(grown.labels, labels)
    np.testing.assert_allclose(grown.strength, strength, rtol=1e-10)


@settings(max_examples=60, deadline=None)
@given(painted=painted_images(), turns=st.integers(1, 3), gain=st.sampled_from([2, 0.5, 257]))
def test_turning_the_picture_turns_the_labels_and_exposure_changes_nothing(painted: tuple, turns: int, gain: float):
    image, strokes = painted
    expected = np.rot90(grow_cut(image, strokes).labels, turns)
    np.testing.assert_array_equal(
        grow_cut(np.rot90(image * float(gain), turns), np.rot90(strokes, turns)).labels, expected
    )


@settings(max_examples=100, deadline=None)
@given(painted=painted_images(), seed=st.integers(0, 1000))
def test_painting_on_gives_what_painting_anew_gives(painted: tuple, seed: int):
    """Strokes are added in three parts, then one is taken away."""
    image, strokes = painted
    part = np.random.default_rng(seed).integers(0, 3, strokes.shape)
    part[tuple(np.argwhere(strokes > 0)[0])] = 0
    grower = StrokeGrower(image)
    for shown in (part == 0, part <= 1, part <= 2, part != 1):
        some = np.where(shown, strokes, 0)
        grown, anew = grower.grow(some), grow_cut(image, some)
        np.testing.assert_array_equal(grown.labels, anew.labels)
        np.testing.assert_array_equal(grown.strength, anew.strength)


def test_what_was_returned_stays_and_what_was_given_too():
    rng = np.random.default_rng(0)
    image, strokes = rng.integers(0, 255, (9, 9), np.uint8), np.zeros((9, 9), np.uint8)
    strokes[0, 0] = 1
    before = image.copy()
    grower = StrokeGrower(image)
    first = grower.grow(strokes)
    kept = first.labels.copy(), first.strength.copy()
    strokes[8, 8] = 2
    grower.grow(strokes)
    np.testing.assert_array_equal(first.labels, kept[0])
    np.testing.assert_array_equal(first.strength, kept[1])
    np.testing.assert_array_equal(image, before)


@pytest.mark.parametrize(
    ("image", "strokes", "options", "sentence"),
    [
        (np.zeros((3, 4)), np.zeros((4, 3), int), {}, "strokes have shape (4, 3), the image has (3, 4) pixels: st"),
        (np.zeros((3, 4)), np.zeros((3, 4), int), {}, "strokes are 0 everywhere, expected at least one painted pixel"),
        (np.zeros((3, 4)), np.ones((3, 4)), {}, "strokes hold float64 values, expected whole numbers"),
        (np.zeros((3, 4)), np.full((3, 4), -1), {}, "strokes reaches -1, expected 0 to"),
        (np.zeros((3, 4), bool), np.ones((3, 4), int), {}, "image holds bool values, expected real numbers"),
        (np.full((3, 4), np.nan), np.ones((3, 4), int), {}, "image is nan at index 0, 0"),
        (np.zeros(4), np.ones(4, int), {}, "image has shape (4,), expected (rows, columns) or"),
        (np.zeros((0, 4)), np.ones((0, 4), int), {}, "image has shape (0, 4), expected"),
        (np.zeros((2, 2)), np.ones((2, 2), int), {"neighbourhood": "more"}, "(did you mean moore?)"),
        (np.zeros((2, 2)), np.ones((2, 2), int), {"seed_strength": 0.0}, "seed strength reaches 0, expected 1e-09"),
        (np.zeros((2, 2)), np.ones((2, 2), int), {"seed_strength": [1.0]}, "seed strength has shape (1,), expected"),
    ],
)  # fmt: skip
def test_bad_input_is_told_in_a_sentence(image: np.ndarray, strokes: np.ndarray, options: dict, sentence: str):
    with pytest.raises(InputError) as refused:
        grow_cut(image, strokes, **options)
    assert sentence in str(refused.value)
    assert "\n" not in str(refused.value)
