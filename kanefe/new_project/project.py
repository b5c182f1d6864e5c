"""A new project: the files of the template, with the name of the project, in a new folder."""

from __future__ import annotations

import os
import re
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from kanefe.errors import FileError, ModelError

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")
WORD = "PROJECT"
"""Placeholder of the name in the files of the template, whose own names end in ``.txt``."""


def new_project(where: str) -> list[Path]:
    """Create the folder of a new project and return its files.

    Parameters
    ----------
    where : str
        The folder; its last part is the name of the project.

    Raises
    ------
    ModelError
        If the name is not valid for a project, or hides an installed package.
    FileError
        If a file or folder of that name exists, or it cannot be written.
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
