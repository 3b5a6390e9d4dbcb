"""Compiled code is kept in a folder named after all that it was made from."""

import ast
import shutil
from pathlib import Path

import numba
import pytest

from insectnav.lanes import compiled

PACKAGE = compiled.PACKAGE
KERNEL_SOURCES = sorted(
    path.relative_to(PACKAGE).as_posix()
    for pattern in ("lanes/*.py", "*/*_kernel.py")
    for path in PACKAGE.glob(pattern)
)


def sources_of_constants() -> list[str]:
    """Other files of the package that kernel sources import values from; numba compiles those values in."""
    found = set()
    for source in KERNEL_SOURCES:
        for node in ast.walk(ast.parse((PACKAGE / source).read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("insectnav."):
                path = PACKAGE.joinpath(*str(node.module).split(".")[1:])
                path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
                found.add(path.relative_to(PACKAGE).as_posix())
    found.add("central_complex/connectivity.py")  # the order of projections, by way of packing
    return sorted(found - set(KERNEL_SOURCES))


@pytest.fixture
def copied_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the package that the digest is made from instead."""
    copy = tmp_path / "insectnav"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(compiled, "PACKAGE", copy)
    monkeypatch.setattr(compiled, "__file__", str(copy / "lanes" / "compiled.py"))
    return copy


def test_kernels_and_lanes_are_among_the_sources() -> None:
    for source in ("lanes/functions.py", "lanes/vector.py", "agents/trial_kernel.py", "central_complex/step_kernel.py"):
        assert source in KERNEL_SOURCES
    assert "central_complex/layers.py" in sources_of_constants()


@pytest.mark.parametrize("source", KERNEL_SOURCES)
def test_change_of_a_kernel_source_changes_the_folder(source: str, copied_package: Path) -> None:
    before = compiled._cache_folder()
    path = copied_package / source
    path.write_text(path.read_text(encoding="utf-8") + "\n# changed\n", encoding="utf-8")
    assert compiled._cache_folder() != before


@pytest.mark.parametrize("source", sources_of_constants())
def test_change_of_a_compiled_in_constant_changes_the_folder(source: str, copied_package: Path) -> None:
    before = compiled._cache_folder()
    path = copied_package / source
    path.write_text(path.read_text(encoding="utf-8") + "\n# changed\n", encoding="utf-8")
    assert compiled._cache_folder() != before


def test_new_or_renamed_kernel_source_changes_the_folder(copied_package: Path) -> None:
    before = compiled._cache_folder()
    (copied_package / "agents" / "motion_kernel.py").rename(copied_package / "agents" / "moving_kernel.py")
    renamed = compiled._cache_folder()
    shutil.copy(copied_package / "agents" / "moving_kernel.py", copied_package / "agents" / "motion_kernel.py")
    assert len({before, renamed, compiled._cache_folder()}) == 3


def test_another_numba_gets_another_folder(copied_package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = compiled._cache_folder()
    monkeypatch.setattr(numba, "__version__", "999.0")
    assert compiled._cache_folder() != before


def test_same_sources_get_the_same_folder_wherever_they_lie(copied_package: Path) -> None:
    before = compiled._cache_folder()
    assert Path(before).name == Path(compiled.CACHE_FOLDER).name
    assert compiled._cache_folder() == before


def test_folder_is_where_the_environment_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "elsewhere"))
    folder = Path(compiled._cache_folder())
    assert folder.parent == tmp_path / "elsewhere"
    assert not folder.exists()


@pytest.mark.parametrize("setting", [None, ""])
def test_folder_is_the_users_own_by_default(setting: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    if setting is not None:
        monkeypatch.setenv("NUMBA_CACHE_DIR", setting)
    folder = Path(compiled._cache_folder())
    assert folder.is_absolute()
    assert "insectnav" in folder.parts


def test_kernel_runs_where_no_code_can_be_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setattr(compiled, "CACHE_FOLDER", str(tmp_path / "file" / "kernels"))

    @compiled.kernel
    def treble(x):
        return 3 * x

    assert treble(2) == 6
    assert list(tmp_path.iterdir()) == [tmp_path / "file"]


def test_kernel_is_written_to_that_folder_on_its_first_call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "CACHE_FOLDER", str(tmp_path / "kernels"))

    @compiled.kernel
    def double(x):
        return 2 * x

    assert not list(tmp_path.rglob("*.nbc"))
    assert double(21) == 42
    assert len(list((tmp_path / "kernels").rglob("*.nbc"))) == 1


def test_processes_that_compile_at_once_do_not_take_each_others_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The second looks at the list of what there is before the first has written it, and is done before the first is.

    Numba alone gives both pieces of code one name, and floats are doubled by the code for whole numbers ever after.
    """
    from numba.core.caching import IndexDataCacheFile

    monkeypatch.setattr(compiled, "CACHE_FOLDER", str(tmp_path / "kernels"))

    def double(x):
        return 2 * x

    save = IndexDataCacheFile._save_data

    def second_in_between(self: IndexDataCacheFile, *given: object) -> None:
        monkeypatch.setattr(IndexDataCacheFile, "_save_data", save)
        with monkeypatch.context() as patch:
            patch.setattr(IndexDataCacheFile, "_load_index", lambda self: {})
            assert compiled.kernel(double)(2.5) == 5.0
        save(self, *given)

    monkeypatch.setattr(IndexDataCacheFile, "_save_data", second_in_between)
    assert compiled.kernel(double)(21) == 42
    read = compiled.kernel(double)
    assert (read(2.5), read(21)) == (5.0, 42)
    assert sum(read.stats.cache_hits.values()) == 1


def test_kernel_is_plain_python_where_the_compiler_is_turned_off(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "DISABLE_JIT", True)  # as NUMBA_DISABLE_JIT=1 does, to look into a kernel

    def double(x):
        return 2 * x

    assert compiled.kernel(double) is double


def test_setting_of_numba_is_put_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", "somebody's")
    monkeypatch.setattr(compiled, "CACHE_FOLDER", str(tmp_path))

    @compiled.kernel
    def increment(x):
        return x + 1

    assert numba.config.CACHE_DIR == "somebody's"
    assert increment(1) == 2
    with pytest.raises(Exception):  # noqa: B017 (whatever numba says of something that is no function)
        compiled.kernel(3)
    assert numba.config.CACHE_DIR == "somebody's"
