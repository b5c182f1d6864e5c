"""Skips tests whose heavy package is absent, unless the run promises that it is there."""

import importlib.util
import os
import sys

import pytest

# marker -> the module that its tests import
NEEDS = {
    "fenicsx": "dolfinx",
    "gmsh": "gmsh",
    "dask": "distributed",
    "urdf": "yourdfpy",
    "mjcf": "mujoco",
    "collision": "coal" if sys.version_info >= (3, 12) else "hppfcl",
}

# Set by `make test` and `make test-latest`, whose set-up brings these packages: a skip would hide a broken set-up.
REQUIRED = os.environ.get("KANEFE_TEST_REQUIRE", "").split()

# Where the surroundings forbid files of bytecode, each worker and each process that a test starts would compile anew
# what it imports, and pytest what it rewrites: a tenth of the run.
if sys.dont_write_bytecode:
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for marker, module in NEEDS.items():
        if marker in REQUIRED or importlib.util.find_spec(module) is not None:
            continue
        skip = pytest.mark.skip(reason=f"{module} is not installed; `make test` brings it")
        for item in items:
            if item.get_closest_marker(marker):
                item.add_marker(skip)


@pytest.fixture(autouse=True)
def _no_cached_bodies(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make every body anew; the tests of the cache turn it on, in a folder of their own."""
    monkeypatch.setenv("KANEFE_CACHE", "0")
