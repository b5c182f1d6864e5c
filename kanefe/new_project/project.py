"""A new project: the files of the template, with the name of the project, in a new folder."""

from __future__ import annotations

import os
import re
import shutil
from importlib.metadata import entry_points
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from kanefe.errors import FileError, MissingDependency, ModelError

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")
WORD = "PROJECT"
"""Placeholder of the name in the files of the template, whose own names end in ``.txt``."""


PROJECTS = "kanefe.projects"
"""Group of entry points whose functions write the files of a project to a folder."""


def new_project(where: str, step: str | None = None) -> list[Path]:
    """Create the folder of a new project and return its files.

    Parameters
    ----------
    where : str
        The folder; its last part is the name of the project.
    step : str, optional
        A STEP file of an assembly, for which a plugin writes the project; default: that of the template.

    Raises
    ------
    ModelError
        If the name is not valid for a project, or hides an installed package.
    FileError
        If a file or folder of that name exists, or it cannot be written, or if the STEP file cannot be read.
    MissingDependency
        If no plugin reads STEP files.
    """
    folder = Path(where)
    if NAME.fullmatch(folder.name) is None:
        raise ModelError(
            f"{folder.name!r} is not a name of a project. Remedy: letters, digits, '_', '-' and '.', a letter or "
            "digit first"
        )
    if os.path.lexists(folder):
        raise FileError(f"there is a {'folder' if folder.is_dir() else 'file'} {folder} already. Remedy: another name")
    if folder.name.isidentifier() and find_spec(folder.name) is not None:
        raise ModelError(
            f"a folder called {folder.name!r} would hide the Python package of that name from scripts beside it. "
            "Remedy: another name"
        )
    try:
        folder.mkdir()
        if step is not None:
            return _from_step(folder, step)
        written = []
        for source in sorted(files("kanefe.new_project").joinpath("template").iterdir(), key=lambda file: file.name):
            target = folder / source.name.removesuffix(".txt")
            target.write_text(source.read_text(encoding="utf-8").replace(WORD, folder.name), encoding="utf-8")
            written.append(target)
    except OSError as error:
        if not folder.parent.exists():
            raise FileError(
                f"there is no folder {folder.parent} to make {folder.name!r} in. Remedy: make it first"
            ) from error
        # in system folders such as /proc the error is that the new folder does not exist
        reason = "nothing can be made there" if isinstance(error, FileNotFoundError) else error.strerror
        raise FileError(f"cannot make {folder}: {reason}. Remedy: another place") from error
    return written


def _from_step(folder: Path, step: str) -> list[Path]:
    """Let the plugin write the project of an assembly; the folder does not stay if it cannot."""
    try:
        plugin = next(iter(entry_points(group=PROJECTS, name="step")), None)
        if plugin is None:
            raise MissingDependency("kanefe_fem", "kanefe new --step", "install kanefe again, with its plugin")
        written: list[Path] = plugin.load()(folder, step)
    except BaseException:
        shutil.rmtree(folder)
        raise
    return written
