"""NMEA: sentences joined by their moment, dates that roll over, damage that is noticed."""

from datetime import UTC, date, datetime
from functools import reduce

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from insectnav.checks import InputError
from insectnav.datasets.gps_track import GpsTrack
from insectnav.datasets.nmea_logs import parse_nmea

# From a research ship (NOAA, ATOMIC 2020, raw file gps02001420_raw.txt), with what its logger puts before a sentence.
SHIP = """01/14/2020 20:00 VS100/PN803-3015-000 (SN: 82171170008)
0000011 $GPHDT,74.20,T*34
0000030 $GPGGA,195959.00,1541.31258893,N,05130.51204125,W,2,06,1.5,9.2,M,-37.6,M,4.0,0138*7E
0000072 $GPGLL,1541.31258893,N,05130.51204125,W,195959.00,A,D*7B
0000109 $GPVTG,147.44,T,164.31,M,0.26,N,0.49,K,D*2C
0000128 $GPZDA,195959.00,14,01,2020,00,00*6A
0000155 $GPRMC,195959.00,A,1541.31258893,N,05130.51204125,W,0.26,147.44,140120,16.9,W,D*0B
0001028 $GPGGA,200000.00,1541.31248595,N,05130.51199976,W,2,06,1.5,8.8,M,-37.6,M,5.0,0138*7D
0001154 $GPRMC,200000.00,A,1541.31248595,N,05130.51199976,W,0.59,154.37,140120,16.9,W,D*0C
0002026 $GPGGA,200001.00,1541.31235466,N,05130.51197862,W,2,06,1.5,8.9,M,-37.6,M,6.0,0138*73
"""
# From a u-blox receiver, as quoted in issue 162 of pynmea2, which calls it invalid for its last field.
UBLOX = "$GNRMC,200728.50,A,2829.34783,N,08122.21257,W,0.057,,301223,,,A,V*0F\n"
NO_FIX = "$GPRMC,,V,,,,,,,,,,N*53\n$GPGGA,,,,,,0,00,99.99,,,,,,*48\n"  # u-blox NEO-6M indoors


def sentence(words: str) -> str:
    return f"${words}*{reduce(lambda total, letter: total ^ ord(letter), words, 0):02X}\r\n"


def rmc(clock: str, day: str = "140120", latitude: str = "5100.0000,N", status: str = "A", mode: str = "A") -> str:
    return sentence(f"GPRMC,{clock},{status},{latitude},00100.0000,W,0.1,,{day},,,{mode}")


def gga(clock: str, height: str = "30.5", quality: str = "1", latitude: str = "5100.0000,N") -> str:
    return sentence(f"GPGGA,{clock},{latitude},00100.0000,W,{quality},08,1.0,{height},M,46.0,M,,")


def seconds(*moment: int) -> float:
    return datetime(*moment, tzinfo=UTC).timestamp()


def test_ship_has_date_place_and_height_of_the_same_moment():
    track = parse_nmea(SHIP)
    np.testing.assert_array_equal(track.time, seconds(2020, 1, 14, 19, 59, 59) + np.arange(3))
    np.testing.assert_allclose(track.latitude_deg, 15 + np.array([41.31258893, 41.31248595, 41.31235466]) / 60)
    np.testing.assert_allclose(track.longitude_deg, -51 - np.array([30.51204125, 30.51199976, 30.51197862]) / 60)
    np.testing.assert_array_equal(track.height, [9.2, 8.8, 8.9])
    assert track.notes == ()


def test_a_fix_at_the_same_time_of_each_day_is_of_that_day():
    """As of a collar that wakes once a day, over a leap day."""
    days, latitudes = ("280220", "290220", "010320"), ("5100.0000,N", "5106.0000,N", "5112.0000,N")
    track = parse_nmea("".join(rmc("120000.00", *day) for day in zip(days, latitudes, strict=True)))
    np.testing.assert_array_equal(track.time, seconds(2020, 2, 28, 12) + 86_400 * np.arange(3))
    np.testing.assert_allclose(track.latitude_deg, [51.0, 51.1, 51.2])


def test_status_of_integrity_that_is_not_stated_is_no_lack_of_a_fix():
    track = parse_nmea(UBLOX)
    assert track.time == seconds(2023, 12, 30, 20, 7, 28) + 0.5
    assert track.latitude_deg == pytest.approx(28 + 29.34783 / 60)
    assert np.isnan(track.height[0])


def test_sentences_without_a_fix_are_left_out_and_counted():
    invalid = (
        rmc("200729", status="V") + rmc("200730", mode="N") + gga("200731", quality="0") + gga("200732", quality="8")
    )
    track = parse_nmea(NO_FIX + UBLOX + invalid)
    assert track.time.size == 1
    assert track.notes == ("sentences left out, no fix: 6",)


@pytest.mark.parametrize("day", ["060180", "", "010100", "220899"])
def test_date_and_time_that_a_receiver_starts_with_are_not_taken(day: str):
    """As of one that counts from its epoch until it has found its satellites; its fixes here come without a date."""
    start = rmc("235943", day, status="V") + gga("235943", quality="0")
    log = start + gga("100000") + gga("100001") + rmc("100002") + rmc("235944", day, status="V") + gga("100003")
    np.testing.assert_array_equal(parse_nmea(log).time, seconds(2020, 1, 14, 10) + np.arange(4))
    assert np.isnan(parse_nmea(start + gga("100000")).time).all()
    assert "no date" in parse_nmea(start + gga("100000")).notes[-1]


def test_a_date_of_zda_is_not_taken_in_a_moment_without_a_fix():
    start = rmc("000012", "060180", status="V") + sentence("GPZDA,000012,06,01,1980,00,00") + gga("000012", quality="0")
    assert np.isnan(parse_nmea(start + gga("100000")).time).all()
    assert parse_nmea(start + gga("100000") + rmc("100001")).time[0] == seconds(2020, 1, 14, 10)


def test_a_place_of_a_sentence_that_is_void_is_not_taken():
    """Some receivers repeat the last place that they knew."""
    track = parse_nmea(rmc("100000") + rmc("100001", latitude="5200.0000,N", status="V") + rmc("100002"))
    np.testing.assert_array_equal(track.latitude_deg, [51.0, 51.0])
    np.testing.assert_array_equal(track.time, seconds(2020, 1, 14, 10) + np.array([0, 2]))


@pytest.mark.parametrize("day", ["060180", "", "140120"])
def test_a_log_without_any_fix_is_refused_in_a_sentence(day: str):
    log = NO_FIX + rmc("100000", day, status="V") + rmc("100001", day, mode="N") + gga("100001", quality="0")
    with pytest.raises(InputError, match=r"^in all of 5 sentences RMC and GGA the receiver says that it has no fix"):
        parse_nmea(log)


def test_order_within_a_moment_does_not_matter():
    one, other = parse_nmea(gga("120000.00") + rmc("120000.00")), parse_nmea(rmc("120000.00") + gga("120000.00"))
    for track in (one, other):
        assert (track.time, track.height) == (seconds(2020, 1, 14, 12), 30.5)


def test_sentence_that_comes_late_joins_its_moment():
    log = gga("120001", "1") + rmc("120000") + gga("120002", "2") + rmc("120001") + gga("120003", "3") + rmc("120002")
    track = parse_nmea(log)
    heights = dict(zip(track.time - seconds(2020, 1, 14, 12), track.height, strict=True))
    assert (heights[1], heights[2], heights[3]) == (1, 2, 3)
    assert np.isnan(heights[0])


@pytest.mark.parametrize(
    "log",
    [
        rmc("235958") + gga("235959") + gga("000000") + gga("000001"),  # forwards from a date
        gga("235958") + gga("235959") + gga("000000") + rmc("000001", "150120"),  # backwards from a date
        rmc("235958") + rmc("235959") + rmc("000000", "150120") + rmc("000001", "150120"),
        gga("235958") + sentence("GPZDA,235959,14,01,2020,00,00") + gga("235959") + gga("000000") + gga("000001"),
    ],
)
def test_days_roll_over(log: str):
    np.testing.assert_array_equal(parse_nmea(log).time, seconds(2020, 1, 14, 23, 59, 58) + np.arange(4))


def test_a_time_that_falls_back_by_a_second_is_of_the_same_day():
    track = parse_nmea(rmc("120001") + gga("120000"))
    np.testing.assert_array_equal(track.time, seconds(2020, 1, 14, 12) + np.array([1, 0]))
    np.testing.assert_array_equal(track.segment, [0, 1])


def test_two_midnights_without_a_date_between_them():
    clocks = [f"{hour % 24:02d}0000" for hour in range(20, 75, 3)]
    track = parse_nmea(rmc(clocks[0]) + "".join(map(gga, clocks[1:])))
    np.testing.assert_array_equal(track.time - seconds(2020, 1, 14, 20), 3 * 3600 * np.arange(len(clocks)))


def test_log_without_dates_has_no_times_unless_a_day_is_given():
    log = gga("235959") + gga("000000")
    track = parse_nmea(log)
    assert np.isnan(track.time).all() and "no date" in track.notes[0]
    track = parse_nmea(log, date(2016, 2, 28))
    np.testing.assert_array_equal(track.time, seconds(2016, 2, 28, 23, 59, 59) + np.arange(2))
    assert track.notes == ()


def test_log_after_another_is_a_segment_of_its_own():
    track = parse_nmea(rmc("120000") + rmc("120001") + rmc("110000") + rmc("110001"))
    np.testing.assert_array_equal(track.segment, [0, 0, 1, 1])


def test_wrong_checksums_and_missing_ones_are_left_out_and_counted():
    good = gga("120000") + rmc("120000")
    wrong = rmc("120001").replace("5100", "5200")
    cut_short = rmc("120002")[:40] + "\n"
    track = parse_nmea(good + wrong + cut_short)
    assert track.time.size == 1
    assert track.notes == ("sentences left out, wrong checksum, or none: 2",)


def test_log_without_any_checksum_is_read_with_a_warning():
    track = parse_nmea(rmc("120000").split("*")[0] + "\n")
    assert track.latitude_deg == 51
    assert "damage goes unnoticed" in track.notes[0]


@pytest.mark.parametrize(
    ("latitude", "expected"),
    [
        ("5130.0000,S", -51.5),
        ("5130,N", 51.5),
        ("0000.0000,N", 0.0),
        ("5160.0000,N", None),  # 60 minutes
        ("9000.0001,N", None),
        ("5130.0000,", None),  # which pynmea2 would place at the equator
        (",N", None),
        ("51.5000,E", None),
    ],
)
def test_places(latitude: str, expected: float | None):
    log = rmc("115959") + gga("120000", latitude=latitude)
    assert parse_nmea(log).latitude_deg.tolist() == ([51.0] if expected is None else [51.0, expected])


@pytest.mark.parametrize("clock", ["240000", "126000", "120060", "12:00", "noon", "１２００００"])
def test_impossible_times_of_day_are_left_out(clock: str):
    track = parse_nmea(rmc("120000") + gga(clock))
    assert track.time.size == 1
    assert "without time or place: 1" in track.notes[0]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "no sentence at all"),
        ("$GPGSV,1,1,00*79\n$GPVTG,,,,,,,,,N*30\n", "among GSV, VTG"),
        (NO_FIX, "in all of 2 sentences RMC and GGA the receiver says that it has no fix"),
        (rmc("120000").replace("5100", "5101"), "1 wrong checksum"),
    ],
)
def test_log_without_a_fix_is_refused_with_the_reason(text: str, says: str):
    with pytest.raises(InputError, match=says):
        parse_nmea(text)


LOG = SHIP + UBLOX + NO_FIX


@settings(max_examples=200, deadline=None)
@given(st.integers(0, len(LOG) - 1), st.characters())
def test_one_wrong_letter_never_moves_a_fix(index: int, letter: str):
    known = parse_nmea(LOG)
    track = parse_nmea(LOG[:index] + letter + LOG[index + 1 :])
    fixes = [set(zip(one.time, one.latitude_deg, one.longitude_deg, strict=True)) for one in (track, known)]
    assert fixes[0] <= fixes[1]


@settings(max_examples=200, deadline=None)
@given(st.integers(0, len(LOG)), st.integers(0, len(LOG)), st.text(max_size=8))
def test_damaged_log_is_read_or_refused_but_never_fails_otherwise(start: int, stop: int, other: str):
    try:
        assert isinstance(parse_nmea(LOG[: min(start, stop)] + other + LOG[max(start, stop) :]), GpsTrack)
    except InputError as error:
        assert "\n" not in str(error)
