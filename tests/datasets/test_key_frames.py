"""Tables of frames that a person has matched."""

from pathlib import Path

import numpy as np
import pytest

from insectnav.checks import InputError
from insectnav.datasets.key_frames import read_key_frames
from insectnav.metrics.place_truth import true_matches_by_frames


def test_table_of_key_frames(tmp_path: Path):
    path = tmp_path / "keys.csv"
    path.write_text("reference,note,query\n0,gate,10\n,detour,20\n30,barn,40\n")
    keys = read_key_frames(path)
    np.testing.assert_array_equal(keys, [(10, 0), (20, np.nan), (40, 30)])
    np.testing.assert_array_equal(true_matches_by_frames(keys, [10, 15, 40]).reference, [0, np.nan, 30])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("query,place\n1,2\n", "no columns query and reference among 'query', 'place'"),
        ("1,2\n3,4\n", "does the table lack its header?"),
        ("query,reference\n1,2\n,4\n", "row 3: the query is missing"),
        ("query,reference\n1,two\n", "row 2"),
    ],
)
def test_other_tables_are_refused(text: str, says: str, tmp_path: Path):
    path = tmp_path / "keys.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=says) as error:
        read_key_frames(path)
    assert "keys.csv" in str(error.value)
