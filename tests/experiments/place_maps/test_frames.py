"""Frames from folders, patterns, films and arrays: their order, names, times, positions, and which are taken."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import zarr
from numpy.testing import assert_allclose, assert_array_equal

from insectnav.checks import InputError
from insectnav.experiments.place_maps.frames import Frame, FrameSource, Thinning, open_frames, thinned
from insectnav.experiments.place_maps.whereabouts import Whereabouts, placed
from place_scenes import robot_recording, views, write_pictures


def frames_at(times=None, positions=None, n=10):
    for k in range(n):
        yield Frame(
            name=str(k),
            number=k,
            read=lambda: np.zeros(3),
            time=np.nan if times is None else times[k],
            position=np.full(3, np.nan) if positions is None else np.array([*positions[k], 0.0]),
        )


def names(frames, thinning):
    left_out: list[str] = []
    return [frame.name for frame in thinned(frames, thinning, left_out)], left_out


def test_folders_and_patterns_come_in_natural_order(tmp_path: Path):
    write_pictures(tmp_path / "a", views(12), "left{}.png")
    write_pictures(tmp_path / "a", views(3), "right{}.png")
    source = open_frames([str(tmp_path / "a" / "left*.png")])
    frames = list(source.frames)
    assert [frame.name for frame in frames] == [f"left{k}" for k in range(12)]
    assert source.total == 12
    assert_array_equal(frames[11].read(), views(12)[11])
    both = list(open_frames([tmp_path / "a"]).frames)
    assert [frame.name for frame in both][-2:] == ["right1", "right2"]
    assert [frame.number for frame in both] == list(range(15))


def test_arrays_are_read_without_running_anything(tmp_path: Path):
    values = np.random.default_rng(0).normal(size=(300, 5))
    np.save(tmp_path / "a.npy", values)
    zarr.save_array(str(tmp_path / "b.zarr"), values)
    zarr.open_group(str(tmp_path / "c.zarr"), mode="w").create_array("features", data=values)
    for name in ("a.npy", "b.zarr", "c.zarr", "c.zarr/features"):
        source = open_frames([tmp_path / name])
        assert source.is_vectors
        assert_array_equal(np.stack([frame.read() for frame in source.frames]), values)
    zarr.create_array(str(tmp_path / "old.zarr"), data=values, zarr_format=2)
    assert_array_equal(np.stack([frame.read() for frame in open_frames([tmp_path / "old.zarr"]).frames]), values)
    about = json.loads((tmp_path / "old.zarr" / ".zarray").read_text())
    (tmp_path / "old.zarr" / ".zarray").write_text(json.dumps(about | {"filters": [{"id": "pickle", "protocol": 5}]}))
    np.save(tmp_path / "objects.npy", np.array([print], object), allow_pickle=True)
    np.save(tmp_path / "cube.npy", np.zeros((2, 3, 4)))
    (tmp_path / "bad.npy").write_bytes(b"no array")
    for name, words in (
        ("objects.npy", "cannot be read as an array"),
        ("cube.npy", r"expected real numbers \(frame, feature\)"),
        ("bad.npy", "cannot be read as an array"),
        ("gone.npy", "does not exist"),
        ("old.zarr", "pickle"),
    ):
        with pytest.raises(InputError, match=words):
            open_frames([tmp_path / name])
    with pytest.raises(InputError, match="expected one alone"):
        open_frames([tmp_path / "a.npy", tmp_path / "b.zarr"])
    with pytest.raises(InputError, match="no file is called as"):
        open_frames([tmp_path / "none*.png"])


def test_thinning_by_number_distance_and_time():
    assert names(frames_at(), Thinning(step=4))[0] == ["0", "4", "8"]
    # A robot that stands for five frames and then walks 0.4 m a frame.
    places = np.stack([np.maximum(np.arange(10) - 4, 0) * 0.4, np.zeros(10)], axis=1)
    assert names(frames_at(positions=places), Thinning(every_m=0.8))[0] == ["0", "6", "8"]
    places[6] = np.nan
    assert names(frames_at(positions=places), Thinning(every_m=0.8)) == (["0", "7", "9"], ["6"])
    times = np.arange(10) * 0.1  # whose sums round
    assert names(frames_at(times=times), Thinning(every_s=0.3))[0] == ["0", "3", "6", "9"]
    assert names(frames_at(), Thinning(every_s=1.0)) == ([], [str(k) for k in range(10)])


@pytest.mark.parametrize("start", [0, 1_399_379_412])
def test_thinning_by_just_the_interval_leaves_nothing_out_whatever_the_rounding(start: int):
    times = [float(f"{start + k // 10}.{k % 10}") for k in range(400)]
    assert len(names(frames_at(times, n=400), Thinning(every_s=0.1))[0]) == 400
    assert len(names(frames_at(times, n=400), Thinning(every_s=0.101))[0]) == 200


@pytest.mark.parametrize("start", [0, 5_600_000])  # metres north of the equator
def test_thinning_by_just_the_distance_leaves_nothing_out_whatever_the_rounding(start: int):
    places = [(500_000.0, float(f"{start + k // 10}.{k % 10}")) for k in range(400)]
    assert len(names(frames_at(positions=places, n=400), Thinning(every_m=0.1))[0]) == 400
    assert len(names(frames_at(positions=places, n=400), Thinning(every_m=0.101))[0]) == 200


def test_times_and_positions_of_frames(tmp_path: Path):
    write_pictures(tmp_path / "a", views(5))
    (tmp_path / "track.csv").write_text("0,0,100\n1000,200,100\n4000,200,700\n")
    (tmp_path / "times.csv").write_text("time_s,file\n" + "".join(f"{0.5 * k},frame{k}.png\n" for k in range(4)))
    where = Whereabouts(
        times=str(tmp_path / "times.csv"),
        positions=str(tmp_path / "track.csv"),
        columns=("time_ms", "x_cm", "y_cm"),
    )
    frames = list(placed(open_frames([tmp_path / "a"]), where).source.frames)
    assert_allclose([frame.time for frame in frames], [0.0, 0.5, 1.0, 1.5, np.nan])
    assert_allclose(
        [frame.position[:2] for frame in frames], [[0, 1], [1, 1], [2, 1], [2, 2], [np.nan, np.nan]], atol=1e-12
    )
    (tmp_path / "named.csv").write_text("file,x_m,y_m\nframe3.png,7,8\n")
    named = placed(open_frames([tmp_path / "a"]), Whereabouts(positions=str(tmp_path / "named.csv")))
    assert [tuple(frame.position[:2]) for frame in named.source.frames][3] == (7.0, 8.0)
    with pytest.raises(InputError, match="expected --times to say when"):
        placed(open_frames([tmp_path / "a"]), Whereabouts(positions=str(tmp_path / "track.csv"), columns=where.columns))


def test_times_that_go_back_are_refused(tmp_path: Path):
    write_pictures(tmp_path / "a", views(4))
    (tmp_path / "times.csv").write_text("time_s,file\n0,frame0.png\n2,frame1.png\n1,frame2.png\n3,frame3.png\n")
    with pytest.raises(InputError, match="'frame2' was taken 1 s before 'frame1'"):
        placed(open_frames([tmp_path / "a"]), Whereabouts(times=str(tmp_path / "times.csv")))


def test_recordings_of_robots_have_times_and_positions(tmp_path: Path):
    path = robot_recording(tmp_path, views(5))
    source = open_frames([path])
    track = tmp_path / "track.csv"
    track.write_text("time_s,x_m,y_m\n10,0,0\n12,4,0\n")
    frames = list(placed(source, Whereabouts(positions=str(track))).source.frames)
    assert [frame.time for frame in frames] == [10.0, 11.0, 12.0, 13.0, 14.0]
    assert_allclose([frame.position[0] for frame in frames], [0, 2, 4, np.nan, np.nan])
    assert_array_equal(np.stack([frame.read() for frame in frames]), views(5))
    own = list(placed(open_frames([path]), Whereabouts(positions=str(path))).source.frames)
    assert_allclose([frame.position[1] for frame in own], [0, 3, 6, 9, 12])
    with pytest.raises(InputError, match="which has its own"):
        placed(open_frames([path]), Whereabouts(times="1"))
    later = list(placed(open_frames([path]), Whereabouts(time_offset_s=0.5)).source.frames)
    assert [frame.time for frame in later] == [10.5, 11.5, 12.5, 13.5, 14.5]


def test_recordings_on_another_clock_or_out_of_order_are_told_of(tmp_path: Path):
    path = robot_recording(tmp_path, views(5))
    track = tmp_path / "track.csv"
    track.write_text("time_s,x_m,y_m\n1399379412,0,0\n1399379417,4,0\n")
    given = placed(open_frames([path]), Whereabouts(positions=str(track)))
    assert np.isnan([frame.position for frame in given.source.frames]).all()
    (note,) = given.notes
    assert note.startswith("no frame has a position: the times of the frames run from 10 to 14 s and those of the")
    frames = frames_at([10.0, np.nan, 12.0, 11.0, 13.0], n=5)
    given = placed(FrameSource(frames=frames, total=0, kind="bag"), Whereabouts())
    assert len(list(given.source.frames)) == 5
    assert [note.partition(" ahead")[0] for note in given.notes] == ["1 frame was taken before the one"]


def matroska(path: Path) -> bytearray:
    """A film of 30 frames, ten a second, whose number its file does not say but for how long it is."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, (96, 48))
    for picture in views()[:30]:
        writer.write(np.dstack([picture] * 3))
    writer.release()
    return bytearray(path.read_bytes())


def test_films_of_unknown_length_have_times_and_positions_all_the_same(tmp_path: Path):
    film = matroska(path := tmp_path / "a.mkv")
    duration = film.index(b"\x44\x89\x88")
    film[duration : duration + 2] = b"\xec\x89"  # void, as in what browsers record
    path.write_bytes(film)
    (tmp_path / "where.csv").write_text("time_s,x_m,y_m\n" + "".join(f"{100 + k},{10 * k},0\n" for k in range(4)))
    assert open_frames([path]).total == 0
    assert_allclose(
        [frame.time for frame in placed(open_frames([path]), Whereabouts()).source.frames], np.arange(30) / 10
    )
    where = Whereabouts(positions=str(tmp_path / "where.csv"), time_offset_s=100.0)
    frames = list(placed(open_frames([path]), where).source.frames)
    assert_allclose([frame.position[0] for frame in frames], np.arange(30))
    (tmp_path / "where.csv").write_text("frame,x_m,y_m\n0,0,0\n")
    with pytest.raises(InputError, match="whose number is known"):
        placed(open_frames([path]), Whereabouts(positions=str(tmp_path / "where.csv")))


def test_films_are_cut_short_where_their_times_are(tmp_path: Path):
    """What says how long it is, and not of how many frames, is taken to have them at an even rate."""
    film = matroska(path := tmp_path / "a.mkv")
    rate = film.index(b"\x23\xe3\x83\x84") + 4
    uneven = film[:rate] + (50_000_000).to_bytes(4, "big") + film[rate + 4 :]  # [ns] of a frame, where none is left out
    for data, said, is_whole in ((film, 30, True), (uneven, 60, True), (film[: len(film) // 2], 30, False)):
        path.write_bytes(data)
        for step in (1, 7):
            source = open_frames([path], step=step)
            assert source.total == -(-said // step)
            n_read = len(list(source.frames))
            assert bool(source.remarks) is not is_whole, (said, step, n_read, source.remarks)
