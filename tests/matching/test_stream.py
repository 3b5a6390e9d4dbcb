import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.matching import (
    OPENSEQSLAM_V1,
    SeqSlamParams,
    begin_stream,
    difference_matrix,
    locate_next,
    seqslam,
)

RNG = np.random.default_rng(0)
REFERENCES = np.cumsum(RNG.normal(size=(120, 24)), axis=0)
QUERIES = REFERENCES[30:75] + 0.1 * RNG.normal(size=(45, 24))


def run(stream, descriptors, times=None):
    found = []
    for i, descriptor in enumerate(descriptors):
        stream, match = locate_next(stream, descriptor, None if times is None else times[i])
        found.append(match)
    return stream, found


@pytest.mark.parametrize("metric", ["cosine", "euclidean", "absolute"])
@pytest.mark.parametrize("ds", [1, 4, 10])
def test_answers_are_those_of_the_batch(metric, ds):
    params = SeqSlamParams(sequence_length=ds)
    half = params.n_steps // 2
    expected = seqslam(difference_matrix(REFERENCES, QUERIES, metric), params)
    _, found = run(begin_stream(REFERENCES, metric, params), QUERIES)
    assert [match.query for match in found] == [max(i - half, -1) for i in range(45)]
    assert all(match.reference == -1 and np.isnan(match.score) for match in found[: 2 * half])
    inner = slice(half, 45 - half)
    assert_array_equal([match.reference for match in found[2 * half :]], expected.reference[inner])
    assert_allclose([match.score for match in found[2 * half :]], expected.score[inner], rtol=1e-4)
    assert_array_equal([match.speed for match in found[2 * half :]], expected.speed[inner])


def test_it_says_where_the_robot_is_now_and_how_old_the_match_is():
    times = 0.5 * np.arange(45) ** 1.1
    _, found = run(begin_stream(REFERENCES, "euclidean"), QUERIES, times)
    newest = np.arange(10, 45)
    now = np.array([match.reference_now for match in found[10:]])
    assert np.abs(now - (30 + newest)).max() <= 1
    assert {match.latency_frames for match in found} == {5}
    assert_allclose([match.latency for match in found[10:]], times[10:] - times[5:-5])
    assert np.isnan(run(begin_stream(REFERENCES), QUERIES[:12])[1][-1].latency)


def test_bits_and_bytes_stream_too():
    bits = REFERENCES > 0
    expected = seqslam(difference_matrix(bits, bits[20:50], "hamming"))
    _, found = run(begin_stream(bits, "hamming"), bits[20:50])
    assert_array_equal([match.reference for match in found[10:]], expected.reference[5:-5])


def test_a_stream_stays_as_it_was():
    stream, _ = run(begin_stream(REFERENCES), QUERIES[:20])
    (_, first), (_, again) = (locate_next(stream, QUERIES[20]) for _ in range(2))
    assert first[:5] == again[:5]
    assert stream.n_frames == 20


def test_missing_frames_are_bridged_as_in_the_batch():
    queries = QUERIES.copy()
    queries[[14, 15, 30]] = np.nan
    expected = seqslam(difference_matrix(REFERENCES, queries))
    frames = [None if np.isnan(query).any() else query for query in queries]
    _, found = run(begin_stream(REFERENCES), frames)
    assert_array_equal([match.reference for match in found[10:]], expected.reference[5:-5])
    assert_allclose([match.score for match in found[10:]], expected.score[5:-5], rtol=1e-4)
    _, lost = run(begin_stream(REFERENCES), [None] * 12)
    assert (lost[-1].reference, lost[-1].reference_now) == (-1, -1)


def first_frames(times):
    return run(begin_stream(REFERENCES), QUERIES[: len(times)], times)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: begin_stream(REFERENCES, params=OPENSEQSLAM_V1), "baseline is 'observed', expected 'bound'"),
        (lambda: begin_stream(REFERENCES[:10]), "there are 10 references, expected at least 11"),
        (lambda: locate_next(begin_stream(REFERENCES), QUERIES), r"descriptor has shape \(45, 24\), expected"),
        (lambda: locate_next(begin_stream(REFERENCES), QUERIES[0, :9]), "references have 24 features and queries 9"),
        (lambda: locate_next(begin_stream(REFERENCES), QUERIES[0], np.nan), "time is nan"),
        (lambda: first_frames([0.0, 1.0, 1.0]), "frame 2 was taken at 1 s, expected later than the one before at 1 s"),
        (lambda: first_frames([0.0, 2.0, 1.0]), "frame 2 was taken at 1 s, .*: out of order, or twice the same"),
        (lambda: first_frames([0.0, None]), "frame 1 has no time, expected one"),
        (lambda: first_frames([None, 1.0]), "frame 1 has a time, expected none"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        call()
