"""Options of gmsh and units of STEP hold for the source that sets them, also in a session of the user's."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kanefe_fem import read_mesh

pytestmark = pytest.mark.gmsh

BOX = """
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, [1]), 'body')
    gmsh.option.setNumber('Mesh.CharacteristicLengthMax', 0.8)
"""

GEO = """SetFactory("OpenCASCADE");
Mesh.ElementOrder = 2;
Mesh.CharacteristicLengthMax = 0.8;
Box(1) = {0, 0, 0, 1, 1, 1};
Physical Volume("body") = {1};
"""


NAMED = """
    gmsh.model.occ.synchronize()
    gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, [t for _, t in s]), 'body')
    gmsh.option.setNumber('Mesh.CharacteristicLengthMax', 0.05)
"""

IN_METRES = """def build(gmsh):
    gmsh.option.setString('Geometry.OCCTargetUnit', 'M')
    s = gmsh.model.occ.importShapes({!r}){}"""


@contextmanager
def session() -> Iterator[Any]:
    import gmsh

    gmsh.initialize(["test"], False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        yield gmsh
    finally:
        gmsh.finalize()


@pytest.mark.parametrize("source", ["quadratic.py", "quadratic.geo"])
def test_options_of_a_source_end_with_it(source: str, tmp_path: Path) -> None:
    (tmp_path / "plain.py").write_text(f"def build(gmsh):{BOX}")
    (tmp_path / "quadratic.py").write_text(f"def build(gmsh):\n    gmsh.option.setNumber('Mesh.ElementOrder', 2){BOX}")
    (tmp_path / "quadratic.geo").write_text(GEO)
    with session() as gmsh:
        setter, largest = gmsh.option.setNumber, gmsh.option.getNumber("Mesh.CharacteristicLengthMax")
        assert read_mesh(tmp_path / source).kind == "tetra10"
        assert read_mesh(tmp_path / "plain.py").kind == "tetra"
        assert gmsh.option.getNumber("Mesh.ElementOrder") == 1
        assert gmsh.option.getNumber("Mesh.CharacteristicLengthMax") == largest
        assert gmsh.option.setNumber is setter


def plate(folder: Path) -> str:
    """The path of a plate in mm."""
    with session() as gmsh:
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        gmsh.model.occ.addBox(0, 0, 0, 100, 60, 10)
        gmsh.model.occ.synchronize()
        gmsh.write(str(folder / "plate.step"))
    return str(folder / "plate.step")


@pytest.mark.parametrize("unit", ["MM", "CM"])
@pytest.mark.parametrize("is_session_of_user", [True, False])
def test_geometry_is_written_in_the_unit_that_was_in_force_before(
    unit: str, is_session_of_user: bool, tmp_path: Path
) -> None:
    """OpenCASCADE keeps the last unit, whatever gmsh's empty option says, from one session to the next."""
    (tmp_path / "metres.py").write_text(IN_METRES.format(plate(tmp_path), NAMED))

    def written(gmsh: Any) -> float:
        gmsh.model.add("user's")
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.write(str(tmp_path / "box.step"))
        points = re.findall(r"CARTESIAN_POINT\('',\(([^)]*)\)\)", (tmp_path / "box.step").read_text())
        return max(float(x) for point in points for x in point.split(","))

    try:
        with session() as gmsh:
            gmsh.option.setString("Geometry.OCCTargetUnit", unit)
            before = written(gmsh)
            gmsh.option.setString("Geometry.OCCTargetUnit", "")
            if is_session_of_user:
                read_mesh(tmp_path / "metres.py")
                assert gmsh.option.getString("Geometry.OCCTargetUnit") == ""
                assert written(gmsh) == before == {"MM": 1.0, "CM": 10.0}[unit]
        if not is_session_of_user:
            read_mesh(tmp_path / "metres.py")
            with session() as gmsh:
                assert written(gmsh) == before
    finally:
        plate(tmp_path)  # mm again


def test_units_of_step_are_not_those_of_an_earlier_source(tmp_path: Path) -> None:
    step = plate(tmp_path)
    (tmp_path / "metres.py").write_text(IN_METRES.format(step, NAMED))
    (tmp_path / "scaled.py").write_text(
        f"def build(gmsh):\n    s = gmsh.model.occ.importShapes({step!r})\n"
        f"    gmsh.model.occ.dilate(s, 0, 0, 0, 1e-3, 1e-3, 1e-3){NAMED}"
    )
    for name in ("scaled.py", "metres.py", "scaled.py"):
        assert np.ptp(read_mesh(tmp_path / name).nodes, axis=0) == pytest.approx((0.1, 0.06, 0.01), rel=1e-6), name
