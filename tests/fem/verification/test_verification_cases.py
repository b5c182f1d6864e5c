"""The plugin's verification cases pass, and none of the references is left without a case."""

import numpy as np
import pytest

from kanefe.checks.verification.runner import run_case
from kanefe.fe_model.shapes import measures
from kanefe_fem.mesh.checks import check_mesh
from kanefe_fem.mesh.simple import box_mesh, rectangle_mesh
from kanefe_fem.verification import beams, solids

LONG = {
    *("B02a", "B07", "B08a", "B13", "D01", "D04b", "G01", "G05", "G07", "G10", "G11", "G12", "G15"),
    *("SR1", "SR3", "SR4", "SR5", "SR6"),
    *("SH1", "SH2", "SH3", "SH4", "SH6", "SH7", "SH8", "SH9", "SH10", "SH11", "SH12", "SH13"),
    *("SH15", "SH16", "SH17", "SH18", "SH19", "SH20", "SH23", "SH24", "SH25", "SH26", "SH27", "SH28"),
    *("X2", "X3", "X4"),
}
"""Cases of 1 to 10 s each, which `kanefe verify` runs; cases of each kind are left: of exact and segmented beams in
motion and at rest, of rotors, of the helicopter."""


QUICK_TO_BEGIN = {"B02a", "D04b", "G01", "G05", "SR1", "SR6"}
"""Long cases of beams whose first number takes half a second at most."""


def marked(case):
    return pytest.param(case, id=case.id, marks=[pytest.mark.slow] if case.id in LONG else [])


def assert_passes(case):
    rows = list(run_case(case))
    assert rows
    assert [row for row in rows if not row.passed] == []


@pytest.mark.parametrize("case", map(marked, beams.CASES))
def test_case_of_beams_passes(case):
    assert_passes(case)


@pytest.mark.parametrize("case", [case for case in beams.CASES if case.id in QUICK_TO_BEGIN], ids=lambda case: case.id)
def test_the_first_number_of_a_long_case_is_right(case):
    """Scenes of long cases are seen to be those of their references in each run of the tests."""
    assert next(iter(run_case(case))).passed


def test_long_cases_are_there():
    assert {case.id for case in (*beams.CASES, *solids.CASES)} > LONG


@pytest.mark.fenicsx
@pytest.mark.parametrize("case", map(marked, solids.CASES))
def test_case_of_solids_passes(case):
    assert_passes(case)


@pytest.mark.parametrize("kind", ["hexahedron", "tetra"])
def test_box_is_filled_once(kind):
    """The cells' volumes add up to the box; `check_mesh` refuses gaps and inverted cells."""
    mesh = check_mesh(box_mesh((1.0, 0.2, 0.1), (3, 2, 2), kind, start=(-0.5, 0.0, 0.0)))
    volume = sum(float(measures(b.kind, mesh.nodes[b.nodes])[0].sum()) for b in mesh.cell_blocks)
    assert volume == pytest.approx(0.02, rel=1e-14)
    assert mesh.cell_count == 12 * (6 if kind == "tetra" else 1)
    np.testing.assert_allclose(mesh.nodes.min(axis=0), (-0.5, 0.0, 0.0), atol=1e-15)


def test_rectangle_has_its_ends():
    mesh = check_mesh(rectangle_mesh(2.0, 0.1, 4))
    for name, x in (("root", 0.0), ("tip", 2.0)):
        np.testing.assert_array_equal(mesh.nodes[mesh.facets[name][0].nodes.ravel(), 0], x)
