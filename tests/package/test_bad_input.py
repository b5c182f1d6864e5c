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

from repository import ROOT

PROGRAM = ROOT / "tests" / "shared" / "bad_input.py"
SNAPSHOT = Path(__file__).with_name("public_api.json")

RUN_IN_STEPS = (
    "action|check_at|check_during|anchors|anchored|inputs|input_wrenches|rested|resting|started|state_scales|tangent|tell|with_ends|path|pull|rates|tension|forces|blown|own|"
    "coefficients|potential|dissipation|force|slopes|advance|bearing|coordinate_rates|held|partial_velocities|pose|remainders|distance|"
    "curvature|probes|pressed|slope|slipping|law|arms|anchor|coefficient|completed|large_stretch|stuck|with_damping|with_numbers|damping_at|basis|carrier|check|changed|status|value|check_known|check_over|at|over|"
    "contains|harmonics|wanted|projected|stiffness_of|mass_of|fibres_of|stiffness_at|cloud|table|ratio_at|factor|fitted|headings|values|"
    "of_nodes|of_error|sampled|slipping|stuck"
)
"""Methods by which loads, joints, shapes and laws serve the equations, which give them checked arguments."""

MADE_BY_KANEFE = (
    "Action|Buckling|Campbell|CriticalPoint|End|Equilibrium|EquilibriumPath|FiniteElementModel|FlexibleBody|FloquetModes|FloquetModes.harmonics|Frame|FrequencyResponse|"
    "Held|Instant|Joint|Linearisation|Link|Link.given|Link.sliding|Link.turning|Link.winding|LinkKernel|LoadEvent|"
    "LoadKernel|Model|Modes|MotionRao|NodalPattern|RaoConvention|RaoConvention.of|Result|Result.from_channels|RunStatus|SceneState|"
    "ScreenedRun|SegmentedBody|Simulation|Simulation.drive_of|StabilityLimit|Tangent|fatigue.Cycles|fatigue.Damage|fatigue.MeanStress|studies.GumbelFit|studies.Operability|Mesh|StiffnessSection|"
    "StiffnessSection.of|AxisJoint|Sea|MissingDependency|SampledLoop|StabilityMap"
)
"""Constructors of what functions of kanefe return, and what authors of joints and loads hand to the equations."""

OF_A_RUN = r"Model\.\w+|SceneState\.\w+|MotionRao\.\w+"
"""Asked by the equations and by functions of the user in every step."""

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
    if owner and re.fullmatch(RUN_IN_STEPS, method):
        return True
    return any(re.fullmatch(pattern, short) for pattern in (MADE_BY_KANEFE, OF_A_RUN, NOT_HERE))


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
