"""Fixtures of the tests of meshes: gmsh sources, and a gmsh session of the user's."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from kanefe_fem.solids import problem as solid_problem

GEO_BOX = """
SetFactory("Built-in");
h = {h};
Point(1) = {{0, 0, 0, h}}; Point(2) = {{0.3, 0, 0, h}}; Point(3) = {{0.3, 0.1, 0, h}}; Point(4) = {{0, 0.1, 0, h}};
Line(1) = {{1, 2}}; Line(2) = {{2, 3}}; Line(3) = {{3, 4}}; Line(4) = {{4, 1}};
Line Loop(1) = {{1, 2, 3, 4}}; Plane Surface(1) = {{1}};
Transfinite Line {{1, 3}} = 4; Transfinite Line {{2, 4}} = 3; Transfinite Surface {{1}};
{recombine}
out[] = Extrude {{0, 0, 0.08}} {{ Surface{{1}}; Layers{{2}}; {recombine_volume} }};
{groups}
{options}
"""
GEO_GROUPS = (
    'Physical Volume("bar") = {out[1]}; Physical Surface("root") = {out[5]}; Physical Surface("tip") = {out[3]};'
)


@pytest.fixture
def geo(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes a gmsh source of a box of 0.3 x 0.1 x 0.08 m."""

    def write(
        name: str = "box.geo", *, hexes: bool = False, prisms: bool = False, groups: str = GEO_GROUPS, options: str = ""
    ) -> Path:
        path = tmp_path / name
        text = GEO_BOX.format(
            h=0.05,
            recombine="Recombine Surface {1};" if hexes else "",
            recombine_volume="Recombine;" if hexes or prisms else "",
            groups=groups,
            options=options,
        )
        path.write_text(text)
        return path

    return write


@pytest.fixture
def gmsh_session() -> Any:
    """Yield an initialised, quiet gmsh, as a user would have; finalise it after the test."""
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize(["test"], readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    yield gmsh
    gmsh.finalize()


@pytest.fixture
def no_assembly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make any call of the assembler fail the test: bad input must be found before."""

    def fail(*args: Any, **kwargs: Any) -> None:
        pytest.fail("the assembler was called with bad input")

    monkeypatch.setattr(solid_problem, "assemble", fail)
