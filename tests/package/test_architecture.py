"""ARCHITECTURE.md is true: each room is named once, in the order of the layers; files and words are where it says."""

from __future__ import annotations

import re
import tomllib

import pytest

from repository import ROOT

MAP = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
PACKAGES = {"kanefe": "kanefe/", "kanefe_fem": "fem/kanefe_fem/"}
CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]


def named_rooms(package: str) -> list[str]:
    """Return the first column of the table of a package, without slash and ending."""
    table = MAP.split(f"| `{PACKAGES[package]}` | |\n|---|---|\n")[1].split("\n\n")[0]
    return [re.match(r"\| `([\w/]+?)(/|\.py)` \|", line)[1] for line in table.splitlines()]


def rooms(package: str) -> list[str]:
    folder = ROOT / PACKAGES[package]
    return [path.parent.relative_to(folder).as_posix() for path in sorted(folder.glob("*/**/__init__.py"))]


def floors(package: str) -> dict[str, int]:
    """Return the layer of each room and file, from the ground up."""
    (layers,) = (c["layers"] for c in CONTRACTS if c["type"] == "layers" and c["containers"] == [package])
    return {name: floor for floor, line in enumerate(reversed(layers)) for name in line.split(" | ")}


@pytest.mark.parametrize("package", PACKAGES)
def test_every_room_is_named_once(package: str) -> None:
    named = named_rooms(package)
    assert sorted(set(named)) == sorted(named)
    assert sorted(rooms(package)) == sorted(name for name in named if name in rooms(package))
    for name in named:
        assert name in rooms(package) or (ROOT / PACKAGES[package] / f"{name}.py").is_file(), name


@pytest.mark.parametrize("package", PACKAGES)
def test_rooms_stand_in_the_order_of_the_layers(package: str) -> None:
    level = floors(package)
    order = [level[name.partition("/")[0]] for name in named_rooms(package)]
    assert order == sorted(order)


def test_every_name_of_a_file_is_one_of_a_folder_in_its_line() -> None:
    for line in MAP.splitlines():
        folders = [path for path in re.findall(r"`([\w./]+/[\w./]*)`", line) if "/" in path]
        for name in re.findall(r"`(\w+\.py)`", line):
            places = [ROOT / path if path.endswith("/") else (ROOT / path).parent for path in folders]
            assert line.startswith(f"| `{name}`") or any((place / name).is_file() for place in places), line


def test_every_word_stands_where_it_is_said_to() -> None:
    rows = re.findall(r"\| ([\w, ]+) \| (`\S+`[^|]*) \| [^|]+ \|\n", MAP.split("## Words of the house")[1])
    assert 0 < len(rows) <= 8  # every other word is one of the field
    for words, places in rows:
        for path in re.findall(r"`(\S+)`", places):
            text = (ROOT / path).read_text(encoding="utf-8")
            for word in words.split(", "):
                assert re.search(word.split()[0], text, re.IGNORECASE), f"{word} is not in {path}"
