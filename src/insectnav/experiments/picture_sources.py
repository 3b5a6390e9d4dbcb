"""Pictures to be worked through: photographs and frames of videos, one after the other, each read when it is needed."""

from collections import Counter, deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from numpy.typing import NDArray

from insectnav.checks import InputError
from insectnav.datasets.image_folder import VIDEOS, FoundImages, read_image
from insectnav.datasets.video import timed_video_frames, video_facts
from insectnav.workers import Threads

Item = TypeVar("Item")
Result = TypeVar("Result")


@dataclass(frozen=True, kw_only=True)
class Source:
    """One picture to come: what to call its results, the file, whether it is a frame, what reads it, and its time.

    The time of a frame is in seconds after the first of its video; that of a picture is NaN.
    """

    name: str
    file: Path
    is_frame: bool
    read: Callable[[], NDArray[Any]]
    time: float = float("nan")


def sources(found: FoundImages, step: int) -> Iterator[Source]:
    """Pictures in their order, every `step`-th frame of videos among them; names that occur twice are numbered.

    What cannot be read raises InputError when it is read, so that the others go on.
    """
    total = Counter(path.stem for path in found.files)
    seen: Counter[str] = Counter()
    for path in found.files:
        seen[path.stem] += 1
        name = path.stem if total[path.stem] == 1 else f"{path.stem}-{seen[path.stem]}"
        if path.suffix.lower() not in VIDEOS:
            yield Source(name=name, file=path, is_frame=False, read=partial(read_image, path))
            continue
        try:
            for number, time, picture in timed_video_frames(path, step):
                read = partial(given, picture)
                yield Source(name=f"{name}_{number:06d}", file=path, is_frame=True, read=read, time=time)
        except InputError as error:
            yield Source(name=name, file=path, is_frame=True, read=partial(given, error))


def given(value: Any) -> Any:
    """What was read before; raises it if it is an InputError."""
    if isinstance(value, InputError):
        raise value
    return value


def count_pictures(found: FoundImages, step: int) -> int:
    """How many pictures are to come, as far as the files say."""
    return sum(count_frames_of(path, step) for path in found.files)


def count_frames_of(path: Path, step: int) -> int:
    """How many pictures are to come from a file, as far as it says: one, or every `step`-th frame."""
    if path.suffix.lower() not in VIDEOS:
        return 1
    try:
        return -(-video_facts(path).n_frames // step)
    except InputError:
        return 1


def in_order(
    function: Callable[[Item], Result], items: Iterable[Item], n_threads: int
) -> Generator[Result, None, None]:
    """Results in the order of the items, which several threads work on; few items are held at a time.

    When it is closed, what the threads are at is finished, and nothing more is begun.
    """
    waiting: deque[Future[Result]] = deque()
    pool = Threads(n_threads)
    try:
        for item in items:
            waiting.append(pool.submit(function, item))
            if len(waiting) > 2 * n_threads:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)
