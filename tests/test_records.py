from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.records import Track

PI = np.pi


def a_track(**changes) -> Track:
    """Three samples: 1 m east, then 2 m north."""
    fields = {
        "time": [1.0, 2.0, 4.0],
        "position": [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]],
        "heading": [PI / 2, PI / 2, 0.0],
        "length_unit": "m",
        "time_unit": "s",
        "name": "trip",
    }
    return Track(**(fields | changes))


def test_a_track_counts_and_lasts():
    track = a_track()
    assert (track.n_samples, track.duration) == (3, 3.0)
    assert (track.n_interpolated, track.notes) == (0, ())


def test_a_track_may_lack_headings():
    assert a_track(heading=None).heading is None


def test_headings_are_stored_wrapped():
    assert_allclose(a_track(heading=[2 * PI - 0.1, PI, -PI - 0.1]).heading, [-0.1, -PI, PI - 0.1], atol=1e-15)


def test_arrays_are_copies_that_cannot_be_written():
    time = np.array([1.0, 2.0, 4.0])
    track = a_track(time=time)
    time[0] = -9
    assert track.time[0] == 1
    for array in (track.time, track.position, track.heading):
        assert array.dtype == np.float64
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(FrozenInstanceError):
        track.name = "other"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"time": [1.0, 2.0, 2.0]}, "time goes from 2 to 2 at index 2, expected it to increase"),
        ({"time": [1.0, 2.0, 1.5]}, "time goes from 2 to 1.5 at index 2"),
        ({"time": [1.0, np.nan, 2.0]}, "time is nan at index 1"),
        ({"time": [[1.0, 2.0, 3.0]]}, "time has shape (1, 3), expected (n,)"),
        ({"time": [], "position": np.empty((0, 2)), "heading": None}, "time is empty"),
        ({"time": ["a", "b", "c"]}, "expected real numbers"),
        ({"time": [1.0, 2.0]}, "position has shape (3, 2), expected (2, 2)"),
        ({"position": np.zeros((2, 3))}, "position has shape (2, 3), expected (3, 2): transposed?"),
        ({"position": [[0, 0], [1, 0], [1, np.inf]]}, "position is inf at index 2, 1"),
        ({"heading": [0.0, 1.0]}, "heading has shape (2,), expected (3,)"),
        ({"heading": [0.0, 90.0, 1.0]}, "heading reaches 90, expected radians within ±2π: degrees?"),
        ({"heading": [0.0, np.nan, 1.0]}, "heading is nan at index 1"),
        ({"length_unit": "km"}, "length_unit 'km' is unknown: expected one of m, cm, mm, unit"),
        ({"time_unit": "ms"}, "time_unit 'ms' is unknown: expected one of s, frame"),
        ({"n_interpolated": -1}, "n_interpolated is -1, expected a whole number of at least 0"),
    ],
)
def test_what_is_no_track_is_refused(changes, words):
    with pytest.raises(InputError) as caught:
        a_track(**changes)
    assert words in str(caught.value)


def test_a_track_flown_backwards():
    track = a_track(notes=("a note",), n_interpolated=1).reversed()
    assert_array_equal(track.time, [0.0, 2.0, 3.0])
    assert_array_equal(track.position, [[1.0, 2.0], [1.0, 0.0], [0.0, 0.0]])
    assert_allclose(track.heading, [-PI, -PI / 2, -PI / 2], atol=1e-15)
    assert (track.length_unit, track.time_unit, track.name, track.n_interpolated) == ("m", "s", "trip, reversed", 1)
    assert track.notes[0] == "a note"
    assert "backwards" in track.notes[1]
    assert "180°" in track.notes[1]


def test_without_headings_nothing_is_said_of_them():
    track = a_track(heading=None).reversed()
    assert track.heading is None
    assert track.notes == ("flown backwards",)


def test_backwards_twice_is_forwards_from_time_0():
    track = a_track()
    twice = track.reversed().reversed()
    assert_array_equal(twice.time, track.time - 1)
    assert_array_equal(twice.position, track.position)
    assert_allclose(twice.heading, track.heading, atol=1e-15)
