"""Where dolfinx's compiled forms are kept: only the user can write there, and what is imported is what was compiled.

Beside the library of a form lies its size and digest, written once it is whole. A library that has changed since is
removed, so that dolfinx compiles it anew.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import stat
import sys
import sysconfig
import tempfile
import warnings
from functools import cache, partial
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import BinaryIO

from kanefe.errors import FileError, outside
from kanefe.storage.files import make_folder, write_whole
from kanefe.storage.kept_code import OTHERS_WRITE, check_entry, check_folder

VARIABLE = "XDG_CACHE_HOME"
"""Of the environment: the folder of caches, by default ~/.cache."""

OPTIONS = ("dolfinx_jit_options.json", "dolfinx_jit_parameters.json", "ffcx_options.json", "ffcx_parameters.json")
"""Files of the working directory from which dolfinx takes what the compiler is told, and where libraries lie."""

READY = ".c.cached"
"""What the name of a file ends in that FFCx writes when the library is whole."""

_sound: set[Path] = set()
"""Files of `READY` whose libraries this process has compared."""


def refuse_options() -> None:
    """Refuse options of the compiler in the working directory, which may have come with other files.

    Raises
    ------
    FileError
        Names the file, and the remedy.
    """
    for name in OPTIONS:
        if os.path.lexists(name):
            package = name.partition("_")[0]
            raise FileError(
                f"dolfinx would take options from {Path.cwd() / name}, which can have its compiler run any program. "
                f"Remedy: start in another folder; options of your own go to ~/.config/{package}/{name}"
            )


@cache
def forms_folder() -> Path:
    """Return the folder of compiled forms of this Python, which can be written; else one of this process alone."""
    caches = Path(os.environ.get(VARIABLE) or Path("~/.cache").expanduser())
    folder = caches / "kanefe" / "forms" / str(sysconfig.get_config_var("SOABI"))
    try:
        make_folder(folder, is_own=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as problem:
        spare = tempfile.mkdtemp(prefix="kanefe-forms-")  # nobody can foresee its name, and lay anything in it
        atexit.register(shutil.rmtree, spare, ignore_errors=True)
        warnings.warn(
            f"the cache of compiled forms {folder} cannot be written ({problem}); this process compiles its own. "
            f"Set {VARIABLE} to a folder of yours to keep them",
            UserWarning,
            stacklevel=outside(),
        )
        return Path(spare)


def check_forms(folder: Path) -> None:
    """Remove the forms of a folder that are damaged.

    Raises
    ------
    FileError
        If others than the user could have put code into it; names the remedy.
    """
    if not folder.is_dir():
        return
    check_folder(folder, VARIABLE)
    for entry in folder.iterdir():
        check_entry(entry, VARIABLE)
    keep_digests(folder)


def keep_digests(folder: Path) -> None:
    """Write the size and digest of each library that has none yet; remove those that have changed since."""
    for ready in folder.glob(f"*{READY}"):
        name = ready.name.removesuffix(READY)
        if ready in _sound:
            continue
        note, found = folder / f"{name}.digest", _digest(folder, name)
        if found and not note.exists():
            write_whole(note, partial(_write, found))
            for file in folder.glob(f"{name}.*"):  # a umask may have left them open
                file.chmod(stat.S_IMODE(file.stat().st_mode) & ~OTHERS_WRITE)
        if found and found == note.read_bytes():
            _sound.add(ready)
            continue
        print(f"kanefe: {folder / name} is damaged: it is compiled anew", file=sys.stderr, flush=True)
        for file in folder.glob(f"{name}.*"):
            file.unlink(missing_ok=True)


def _digest(folder: Path, name: str) -> bytes:
    """Return the size and digest of the library of a form, nothing if there is none."""
    for suffix in EXTENSION_SUFFIXES:
        if (folder / f"{name}{suffix}").is_file():
            content = (folder / f"{name}{suffix}").read_bytes()
            return f"{len(content)} {hashlib.sha256(content).hexdigest()}\n".encode()
    return b""


def _write(content: bytes, file: BinaryIO) -> None:
    file.write(content)
