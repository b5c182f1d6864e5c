"""Every example runs as the user runs it and ends in one checked number; `make docs` checks the long ones too."""

import runpy
import sys
from importlib.util import find_spec
from shutil import which

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
    "32_crank_from_cad",
    "36_constrained_layer",
    "37_fan_blade_of_sheet",
    "38_stiffened_panel_that_slews",
    "39_folded_bracket",
    "40_composite_flexure",
}
LONG = {
    "10_rotating_blade",
    "11_bracket_stress",
    "14_campbell_diagram",
    "19_beam_on_stops",
    "21_helicopter_on_a_deck",
    "22_helicopter_in_a_trap",
    "25_stress_of_skids",
    "26_stress_of_a_solid_gear",
    "27_flying_noodle",
    "28_blade_cut_in_twelve",
    "29_drop_of_a_compliant_gear",
    "31_cable_car",
    "32_crank_from_cad",
    "33_elements_of_scikit_fem",
    "34_ring_of_ngsolve",
    "36_constrained_layer",
    "37_fan_blade_of_sheet",
    "38_stiffened_panel_that_slews",
    "39_folded_bracket",
    "40_composite_flexure",
}
"""Of more than a second."""
NEED_OTHERS = {
    "33_elements_of_scikit_fem": find_spec("skfem"),
    "34_ring_of_ngsolve": find_spec("ngsolve"),
    "35_box_of_calculix": which("ccx"),
}
"""Programs of others that examples need, where they are installed."""


def marked(path):
    marks = [pytest.mark.fenicsx] if path.stem in NEED_MESH else []
    if NEED_OTHERS.get(path.stem, True) is None:
        marks.append(pytest.mark.skip(reason="needs a program that is not installed"))
    return pytest.param(path, id=path.stem, marks=[*marks, pytest.mark.slow] if path.stem in LONG else marks)


def test_the_sets_name_examples():
    assert {path.stem for path in EXAMPLES} > NEED_MESH | LONG | set(NEED_OTHERS)


@pytest.mark.parametrize("path", map(marked, EXAMPLES))
def test_example_ends_in_its_number(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    value, reference, tolerance = runpy.run_path(str(path))["checked"]
    assert abs(value - reference) <= tolerance


@pytest.mark.parametrize("stem", sorted(NEED_OTHERS))
def test_an_example_says_in_a_line_what_it_needs(stem, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", "")
    for name in ("skfem", "ngsolve"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(SystemExit, match=r"^this example needs \w+(-\w+)?: (pip|sudo apt-get) install \S+$"):
        runpy.run_path(str(ROOT / "examples" / f"{stem}.py"))
