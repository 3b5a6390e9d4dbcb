"""What tests of several folders share."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

REPOSITORY = Path(__file__).resolve().parents[1]
GOLDEN = Path(os.environ.get("INSECTNAV_GOLDEN", REPOSITORY.parent / "shared" / "golden"))

# Properties see the same examples each time, and fail for what is wrong, never for what is slow. Other examples:
# pytest --hypothesis-profile=random --hypothesis-seed=1 tests/...
UNHURRIED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
settings.register_profile("random", UNHURRIED)
settings.register_profile("repeatable", UNHURRIED, derandomize=True, database=None)
settings.load_profile("repeatable")


def pytest_configure(config: pytest.Config) -> None:
    """Look for fonts once, before tests that run at the same time all do so; matplotlib speaks up if it takes 5 s."""
    if not hasattr(config, "workerinput"):
        import matplotlib.font_manager  # noqa: F401


GENERATORS: dict[ModuleType, list[tuple[np.random.Generator, Mapping]]] = {}  # of each module, as it was imported


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Note where the random numbers of each module of tests begin."""
    for module in {item.module for item in items}:
        found = [value for value in vars(module).values() if isinstance(value, np.random.Generator)]
        GENERATORS.setdefault(module, [(generator, generator.bit_generator.state) for generator in found])


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Let them begin anew with each test, whichever have run before in this process: each has numbers of its own."""
    for generator, state in GENERATORS[item.module]:
        generator.bit_generator.state = state


@pytest.fixture(scope="session")
def golden() -> Callable[[str], dict[str, np.ndarray]]:
    """Arrays of an outside result by the name of its file; skips the test where it is missing (mark it `data`)."""

    def load(name: str) -> dict[str, np.ndarray]:
        path = GOLDEN / f"{name}.npz"
        if not path.exists():
            pytest.skip(f"{path} is missing")
        with np.load(path) as arrays:
            return dict(arrays)

    return load
