"""Columns of tables against NumPy and closed forms."""

import numpy as np
import pytest

from insectnav.experiments.stone2017_path_integration.columns import (
    circular_columns,
    mean_columns,
    median_columns,
    share_columns,
)

VALUES = np.array([3.0, np.nan, 1.0, 2.0, 6.0])


def test_mean_and_its_error():
    columns = mean_columns("a", VALUES)
    assert columns == {"a": pytest.approx(3.0), "a_error": pytest.approx(np.std([3, 1, 2, 6], ddof=1) / 2.0)}


def test_median_and_its_error():
    columns = median_columns("a", VALUES)
    assert columns["a"] == pytest.approx(2.5)
    assert 0.0 < columns["a_error"] < 3.0
    # The median of n normal values has the standard error 1.2533 σ / √n; 400 resamples know theirs to some 10 %.
    normal = np.random.default_rng(1).normal(0.0, 2.0, 4000)
    assert median_columns("a", normal)["a_error"] == pytest.approx(1.2533 * 2.0 / np.sqrt(4000), rel=0.3)


def test_circular_mean_crosses_south():
    columns = circular_columns("a", [170.0, -170.0, np.nan, 180.0])
    assert abs(columns["a_deg"]) == pytest.approx(180.0)
    length = (1.0 + 2.0 * np.cos(np.radians(10.0))) / 3.0
    assert columns["a_sd_deg"] == pytest.approx(np.degrees(np.sqrt(-2.0 * np.log(length))))
    assert columns["a_error_deg"] == pytest.approx(columns["a_sd_deg"] / np.sqrt(3.0))


def test_share_and_its_error():
    columns = share_columns("a", [True, False, False, False])
    assert columns == {"a": 0.25, "a_error": pytest.approx(np.sqrt(0.25 * 0.75 / 4.0))}


@pytest.mark.parametrize("make", [mean_columns, median_columns, circular_columns])
def test_nothing_gives_nothing(make):
    assert all(np.isnan(value) for value in make("a", [np.nan]).values())
