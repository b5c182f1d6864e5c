"""Good calls of public functions, listed by their names, and the files that they read."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import scipy.io
import scipy.stats

import kanefe as kf
from repository import ROOT
from steel_beams import steel_beam

Good = tuple[Callable[..., Any], dict[str, Any]]


class Call:
    """How a good call is made, each time anew."""

    def __init__(self, good: Callable[[], Good]) -> None:
        self.good = good


CALLS: dict[str, Call] = {}

FILES = Path(tempfile.mkdtemp(prefix="kanefe-good-calls-"))
atexit.register(shutil.rmtree, FILES, ignore_errors=True)


CORNERS = ("0 0 0", "1 0 0", "0 1 0", "0 0 1")
STL = (
    "solid s\n"
    + "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {CORNERS[i]}\n" for i in face) + "endloop\nendfacet\n"
        for face in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
    )
    + "endsolid s\n"
)
MJCF = """<mujoco><worldbody><body name="rod"><joint name="hinge" type="hinge" axis="0 1 0"/>
<geom type="box" size="0.1 0.1 0.5" mass="1"/></body></worldbody></mujoco>"""
EXAMPLE_RAO = next((ROOT / "kanefe" / "environment" / "data").glob("*.csv"))
WRITERS: dict[str, Callable[[Path], object]] = {
    "model.npz": lambda path: kf.write_matrices(steel_beam(2), path),
    "solid.stl": lambda path: path.write_text(STL),
    "robot.xml": lambda path: path.write_text(MJCF),
    "mass.mtx": lambda path: scipy.io.mmwrite(path, steel_beam(2).mass),
    "stiffness.mtx": lambda path: scipy.io.mmwrite(path, steel_beam(2).stiffness),
    "map.csv": lambda path: path.write_text("0, 0, 0, 1\n1, 0, 0, 2\n0, 1, 0, 3\n"),
    "seas.csv": lambda path: path.write_text(EXAMPLE_RAO.read_text()),
}
"""Of files, by their names."""


@cache
def file(name: str) -> Path:
    """Return a file, written when it is first asked for."""
    path = FILES / name
    WRITERS[name](path)
    return path


def call(name: str, function: Callable[..., Any], /, **arguments: Any) -> None:
    """Add a call of a function; arguments that are themselves made anew each time are `Made`."""
    CALLS[name] = Call(lambda: (function, arguments))


def on(name: str, thing: Callable[[], Any], /, **arguments: Any) -> None:
    """Add a call of a method of what a function returns."""
    CALLS[name] = Call(lambda: (getattr(thing(), name.rpartition(".")[2]), arguments))


def files(name: str, function: Callable[..., Any], /, **arguments: Any) -> None:
    """Add a call of a function that reads files, which are named by what is written into them."""
    names = {"path", "store", "stiffness", "mass"}
    CALLS[name] = Call(lambda: (function, {k: file(v) if k in names else v for k, v in arguments.items()}))


def first(name: str, function: Callable[..., Any], thing: Callable[[], Any], /, **arguments: Any) -> None:
    """Add a call of a function whose first argument is what another returns, and is not spoiled."""
    CALLS[name] = Call(lambda: (partial(function, thing()), arguments))
