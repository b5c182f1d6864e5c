"""Build backend: setuptools, with the kernels compiled into wheels for Linux on x86-64.

They are made for the generation of processors of this machine, which is what ``pip install .`` needs; a wheel that goes
to other machines has all with the setting ``kernels=all``: ``python -m build -C kernels=all``. Editable installs have
none: their kernels are built where they are used, and again when they are edited.
"""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403  # the hooks that stay as they are

ROOT = Path(__file__).resolve().parents[1]
BUILT = ROOT / "kanefe" / "kernels" / "built"
IS_COMPILED = sys.platform == "linux" and platform.machine() == "x86_64"
KERNELS = "here", "all"
"""What the setting ``kernels`` may be: for the processor of this machine, or for all generations."""


def get_requires_for_build_wheel(config_settings: dict[str, Any] | None = None) -> list[str]:
    """Return what building a wheel needs: of the package's own requirements those that kernels import, and numba."""
    needed = list(build_meta.get_requires_for_build_wheel(config_settings))
    if IS_COMPILED:
        project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        of_kernels = [name for name in project["dependencies"] if name.startswith(("numpy", "platformdirs"))]
        needed += of_kernels + project["optional-dependencies"]["compile"]
    return needed


def build_wheel(
    wheel_directory: str, config_settings: dict[str, Any] | None = None, metadata_directory: str | None = None
) -> str:
    """Build a wheel with kernels; one serves every version of Python."""
    settings = dict(config_settings or {})
    kernels = settings.pop("kernels", "here")
    if kernels not in KERNELS:
        raise SystemExit(f"the setting kernels={kernels!r} is unknown. Remedy: one of {', '.join(KERNELS)}")
    if not IS_COMPILED:
        return build_meta.build_wheel(wheel_directory, settings, metadata_directory)  # type: ignore[no-any-return]
    # what the build was given stays: pip hands over by PYTHONPATH where numpy and numba are
    paths = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    try:
        command = [sys.executable, "-m", "kanefe.kernels.compiler.build", "--wheel", kernels]
        subprocess.run(command, cwd=ROOT, env=os.environ | {"PYTHONPATH": paths}, check=True)
        with tempfile.TemporaryDirectory(prefix="kanefe-") as folder:
            # in a folder of its own: setuptools would take along what an earlier build left
            settings["--global-option"] = ["build", "--build-base", folder]
            settings["--build-option"] = ["--plat-name", "linux_x86_64"]
            return build_meta.build_wheel(wheel_directory, settings, metadata_directory)  # type: ignore[no-any-return]
    finally:
        shutil.rmtree(BUILT, ignore_errors=True)
