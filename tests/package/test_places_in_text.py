"""What pages and docstrings name is there: files of the repository, and modules and names of the packages."""

from __future__ import annotations

import re
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from repository import ROOT

PAGES = ("*.md", "Makefile", "pyproject.toml", ".ci/*", "kanefe/*.md", "meshes/*.md")
FOLDERS = ("kanefe", "fem", "tests", "examples", "meshes")
GROUPS = {"kanefe.commands", "kanefe.verification"}
"""Of entry points: they look like modules."""


@cache
def found(name: str) -> bool:
    """Return whether a dotted name is a module, or a name in one."""
    module, _, rest = name, "", ""
    while not is_module(module):
        module, _, last = module.rpartition(".")
        rest = f"{last}.{rest}" if rest else last
    thing: Any = import_module(module)
    for word in rest.split(".") if rest else ():
        if word in getattr(thing, "__annotations__", {}):
            return True  # a field without a default
        if not hasattr(thing, word):
            return False
        thing = getattr(thing, word)
    return True


def is_module(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ModuleNotFoundError:
        return False


def missing(path: Path) -> list[str]:
    """Return what a text names that is not there."""
    text = path.read_text(encoding="utf-8")
    paths = {path.rstrip(".") for path in re.findall(rf"\b(?<![./-])(?:{'|'.join(FOLDERS)})/[\w./]+", text)}
    names = set(re.findall(r"`(kanefe(?:_fem)?(?:\.\w+)+)", text)) - GROUPS
    here = path.relative_to(ROOT).as_posix()
    return [
        *(f"{here}: {name}" for name in sorted(paths) if not (ROOT / name).exists()),
        *(f"{here}: {name}" for name in sorted(names) if not found(name)),
    ]


@pytest.mark.parametrize("pattern", [*PAGES, *(f"{folder}/**/*.py" for folder in FOLDERS)])
def test_what_is_named_is_there(pattern: str) -> None:
    files = [path for path in ROOT.glob(pattern) if path.is_file()]
    assert files
    assert [name for path in files for name in missing(path)] == []


def test_names_are_looked_up() -> None:
    assert found("kanefe.joints.base.Joint.links")
    assert not found("kanefe.joints.base.Joint.chains")
    assert not found("kanefe.cellar.wine")
