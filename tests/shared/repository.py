"""Where this repository is, for tests that read its files or start processes of their own."""

from __future__ import annotations

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ARM = ROOT / "meshes" / "arm.msh"


def surroundings(**variables: str) -> dict[str, str]:
    """Return the environment of a fresh interpreter that finds this repository's packages and the tests' helpers."""
    folders = [ROOT, ROOT / "fem", ROOT / "tests", ROOT / "tests" / "shared"]
    given = os.environ.get("PYTHONPATH")
    path = os.pathsep.join([*map(str, folders), *([given] if given else [])])
    return {**os.environ, "PYTHONPATH": path, **variables}
