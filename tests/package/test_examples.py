"""Every example runs as the user runs it and ends in one checked number."""

import runpy

import pytest

from repository import ROOT

EXAMPLES = sorted((ROOT / "examples").glob("[0-9]*.py"))
NEED_MESH = {
    "01_hub_arm_tip",
    "10_rotating_blade",
    "11_bracket_stress",
    "18_gripper",
    "19_beam_on_stops",
    "28_blade_cut_in_twelve",
}


@pytest.mark.parametrize(
    "path",
    [pytest.param(p, id=p.stem, marks=pytest.mark.fenicsx if p.stem in NEED_MESH else ()) for p in EXAMPLES],
)
def test_example_ends_in_its_number(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    value, reference, tolerance = runpy.run_path(str(path))["checked"]
    assert abs(value - reference) <= tolerance
