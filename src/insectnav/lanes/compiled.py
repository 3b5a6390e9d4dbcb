"""How kernels are compiled: once per machine and per version of their sources, then read from disk."""

import hashlib
import os
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import platformdirs

PACKAGE = Path(__file__).parents[1]


def _sources_digest() -> str:
    """A name for this exact state of numba and of all that kernels are compiled from.

    A kernel takes in constants and functions of its neighbours, so every file of a folder with a kernel in it counts.
    """
    sources = {path: path.read_bytes() for path in sorted(PACKAGE.rglob("*.py"))}
    folders = {path.parent for path, text in sources.items() if b"lanes.compiled import" in text} | {PACKAGE / "lanes"}
    digest = hashlib.sha256(numba.__version__.encode())
    for path, text in sources.items():
        if path.parent in folders:
            digest.update(path.relative_to(PACKAGE).as_posix().encode() + b"\0" + text)
    return digest.hexdigest()[:16]


def _cache_folder() -> str:
    base = os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_path("insectnav") / "kernels"
    return str(Path(base) / _sources_digest())


CACHE_FOLDER = _cache_folder()


def _can_keep_code() -> bool:
    """Whether there is a folder for compiled code; where none can be made, each process compiles anew."""
    try:
        os.makedirs(CACHE_FOLDER, exist_ok=True)
    except OSError:
        return False
    return os.access(CACHE_FOLDER, os.W_OK)


def kernel(function: Callable) -> Any:
    """Compile ``function`` on first call, without the interpreter lock, and keep the machine code on disk.

    Notes
    -----
    Numba alone keeps compiled code for as long as the file of the outermost function is unchanged; a change to a
    function that it calls in another file would go unseen and yesterday's circuit would run. Hence the folder named
    after the text of all kernel sources.
    """
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = CACHE_FOLDER
    try:
        compiled = numba.njit(cache=_can_keep_code(), nogil=True, error_model="numpy")(function)
    finally:
        numba.config.CACHE_DIR = before
    _name_code_once(compiled)
    return compiled


def _name_code_once(compiled: Any) -> None:
    """Let each piece of machine code have a file that no other process writes.

    Numba alone counts: processes that compile a function for different types at once give both pieces the same name,
    and the list says from then on that one is the other. So one of them may be missing in the list, and is compiled
    again.
    """
    kept = getattr(compiled, "_cache", None)  # none of plain Python, which NUMBA_DISABLE_JIT leaves
    files = getattr(kept, "_cache_file", None)  # none where no code is kept
    if files is not None:
        files._data_name = lambda number: f"{compiled.py_func.__name__}.{uuid.uuid4().hex}.nbc"


def lane_function(function: Callable) -> Any:
    """A piece of a kernel: compiled into whatever calls it."""
    return numba.njit(error_model="numpy", forceinline=True)(function)
