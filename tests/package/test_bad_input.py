"""Bad input to every public function: refused in clear words, or taken where it is right.

A call that is good is spoiled in one argument at a time. The short form tries some hundreds; `pytest -m stress` ten
thousand.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import kanefe as kf
from repository import ROOT

PROGRAM = ROOT / "tests" / "shared" / "bad_input.py"
SNAPSHOT = Path(__file__).with_name("public_api.json")

RUN_IN_STEPS = """
    action advance anchor anchored anchors arms at axes_at basis bearing blown carrier changed check check_at
    check_during check_known check_over cloud coefficient coefficients completed contains coordinate_rates
    curvature damping_at dissipation distance factor fibres_of fitted force forces harmonics headings held
    input_wrenches inputs large_stretch law mass_of moved_by of_error of_face of_nodes over own partial_velocities path
    pose
    potential pressed probes projected pull rates ratio_at remainders rested resting sampled slipping slope
    slopes started state_scales status stiffness_at stiffness_of stuck table tangent tell tension value values
    wanted with_damping with_ends with_numbers
"""
"""Methods by which loads, joints, shapes and laws serve the equations, which give them checked arguments."""

MADE_BY_KANEFE = """
    Accuracy Certified
    Action Assembly AxisJoint Buckling Campbell Cells CriticalPoint End Equilibrium EquilibriumPath FiniteElementModel
    FiniteElements FlexibleBody FloquetModes FloquetModes.harmonics Frame FrequencyResponse Held Instant Joint
    Linearisation
    Link Link.given Link.sliding Link.turning Link.winding LinkKernel LoadEvent LoadKernel MassField Mesh
    MissingDependency Model Modes MotionRao NodalPattern Part PronyFit ProposedJoint RaoConvention RaoConvention.of
    Result Result.from_channels RunStatus SampledLoop SceneState ScreenedLoad ScreenedRun Sea SegmentedBody Simulation
    Simulation.drive_of StabilityLimit StabilityMap StiffnessSection StiffnessSection.of Tangent
    fatigue.Cycles fatigue.Damage fatigue.MeanStress studies.GumbelFit studies.Operability
"""
"""Constructors of what functions of kanefe return, and what authors of joints and loads hand to the equations."""

OF_A_RUN = {"Model", "SceneState", "MotionRao"}
"""Classes whose methods the equations, and functions of the user, ask in every step."""

NOT_HERE = "read_nastran" if find_spec("pyyeti") is None else "-"
"""Needs a package that is not installed."""


def covered(name: str, calls: set[str]) -> bool:
    """Return whether a public name is tried, or is none to be tried."""
    short = re.sub(r"^(kanefe_fem|kanefe)\.", "", name)
    owner, _, method = short.rpartition(".")
    inherited = {
        "RobotScene": "System",
        "Equilibrium": "Instant",
        "StabilityLimit": "Buckling",
        "CriticalPoint": "Buckling",
    }.get(owner)
    if name in calls or (inherited and f"kanefe.{inherited}.{method}" in calls):
        return True
    return (
        bool(owner and method in RUN_IN_STEPS.split())
        or owner in OF_A_RUN
        or short in (*MADE_BY_KANEFE.split(), NOT_HERE)
    )


def tried(seed: int, start: int, stop: int, *options: str) -> list[dict[str, str]]:
    """Return the faults among some cases, tried in a process of its own; a crash or an end without end is one."""
    command = [sys.executable, str(PROGRAM), str(seed), str(start), str(stop), *options]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=900, check=False)
    lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    if not lines or "tried" not in lines[-1]:
        last = done.stderr.splitlines()[-1:]
        return [{"verdict": "CRASH", "said": f"process ended with {done.returncode} at {last}"}, *lines]
    return lines[:-1]


def test_every_public_function_is_tried() -> None:
    from good_calls import CALLS

    calls = {name.split(" (")[0] for name in CALLS}
    public = json.loads(SNAPSHOT.read_text(encoding="utf-8"))
    kinds = ("function", "class ", "method", "classmethod", "staticmethod")
    wanted = [
        name
        for name, text in public.items()
        if text.startswith(kinds) and not name.startswith("$") and not re.search(r"\((self|cls)?\)$", text)
    ]
    assert [name for name in wanted if not covered(name, calls)] == []


def test_good_calls_are_good() -> None:
    from good_calls import QUICK

    for made in QUICK.values():
        function, arguments = made.good()
        function(**arguments)


def test_bad_input_is_refused_in_clear_words() -> None:
    assert tried(1, 0, 400, "quick") == []


@pytest.mark.stress
@pytest.mark.parametrize("start", range(0, 10_000, 1_000))
def test_ten_thousand_bad_inputs(start: int) -> None:
    assert tried(2, start, start + 1_000) == []


def test_a_message_that_does_not_say_what_it_means_is_noticed() -> None:
    from bad_input import Case, names_it

    case = Case("kanefe.System.add_force", "load", "huge")
    assert names_it("the force on 'rod' must be finite", kf.System.add_force, case, 1e300)
    assert names_it("1e+300 is too large", kf.System.add_force, case, 1e300)
    assert not names_it("it must be smaller. Remedy: a smaller one", kf.System.add_force, case, 1e300)
