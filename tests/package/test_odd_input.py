"""Drawn odd input, one or two arguments of a call, with what a user does next: see `odd_input`."""

from __future__ import annotations

import json
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest

import kanefe as kf
from good_call import file
from good_calls import CALLS
from kanefe.storage.hdf5 import encode
from repository import ROOT

PROGRAM = ROOT / "tests" / "shared" / "odd_input.py"


FOUND = {
    "a table of times that overflow": (lambda: kf.Motion.table([0, 1, 2, 1e200], [0, 1, 0, 1]), "have steps of 1 to"),
    "poses": (lambda: kf.PoseTable([0, 1, 2, 1e200], np.zeros((4, 3))), "have steps of 1 to"),
    "a wind that makes no waves": (lambda: kf.Sea.pierson_moskowitz(1e-300), "a wind of 1e-300 m/s"),
    "a gravity in text": (lambda: kf.Sea.pierson_moskowitz(10.0, gravity="x"), "gravity of a sea must be"),
    "frequencies that overflow": (
        lambda: kf.Sea.measured([0.3, 0.5, 1e108], [0.0, 1.0, 1.0], duration=60.0, seed=1),
        "have no mean period",
    ),
    "an axis that is an array": (
        lambda: kf.Bearing("b", (ENDS, ENDS), stiffness=np.eye(2), axis=np.array(["x", "y"])),
        "axis of bearing 'b'",
    ),
    "events in a mapping": (lambda: kf.Record("position a", at={"a": "b"}), "at of a record"),
    "a way of keeping that is an array": (lambda: kf.Record("position a", keep=np.array(["a", "b"])), "keep of a"),
    "records in an array": (
        lambda: kf.System().simulate((0, 1), record=np.zeros(2)),
        "record must be channels|empty|no bod",
    ),
    "a scale of zero": (lambda: kf.shapes.Mesh.from_stl(file("solid.stl"), scale=0.0), "scale of a file"),
    "the scale of a hull": (lambda: kf.shapes.Convex.from_stl(file("solid.stl"), scale=-1.0), "scale of a file"),
    "no path": (lambda: kf.load_result(""), "it is a folder"),
    "a beam without end": (lambda: call_of("kanefe_fem.exact_beam", length=1e200), "is not finite"),
    "nodes without end": (lambda: call_of("kanefe.model_from_matrices", nodes=FAR), "overflow"),
    "a friction that is a fraction": (lambda: kf.LuGre(1e5, 300.0, 0.4, Fraction("0.5"), 0.1, 0.1), "coulomb = 0.5"),
    "names of events in a set": (lambda: kf.Record("position a", at={"a"}), "at of a record"),
    "spans without end": (lambda: kf.BSpline(2, 10**400), "10000 at most"),
    "nothing to sample": (lambda: kf.Study.sampled(call_of, (), 4, length=3.0), "none of the parameters 'length'"),
    "coordinates that are not used": (
        lambda: call_of("kanefe.FlexibleBody.node_velocities", eta=np.zeros(3)),
        "eta of the free coordinates",
    ),
    "a class for a torque": (
        lambda: call_of("kanefe.System.add_torque", torque=kf.Wind),
        "the function of the torque on 'one'",
    ),
    "a branch of three": (lambda: call_of("kanefe.equilibrium_path (scene)", branch=(1, 2, 3)), "branch must be"),
}
"""Bare errors of Python and numpy that draws found, and what is said instead."""

ENDS = kf.System().ground
FAR = np.array([[0.0, 0, 0], [0.5, 0, 0], [1e200, 0, 0]])


def call_of(name: str, **changed: object) -> object:
    """Return the result of a good call with other arguments."""
    function, arguments = CALLS[name].good()
    return function(**{**arguments, **changed})


@pytest.mark.parametrize("what", FOUND)
def test_what_was_found_is_refused_in_clear_words(what: str) -> None:
    bad, words = FOUND[what]
    with pytest.raises(kf.KanefeError, match=words):
        bad()


def test_other_forms_are_taken() -> None:
    table = np.array(([0.0, 1.0], [2.0, 1.0]))
    assert kf.Rope("r", (ENDS, ENDS.frame((1, 0, 0))), 1e4, length=table).length[1].tolist() == [2.0, 1.0]
    assert kf.Winch("w", (ENDS, ENDS.frame((1, 0, 0))), tension=table, stiffness=1e4, speed=1.0, damping=1.0)
    assert kf.Sea.bretschneider(2.0, np.longdouble(9.0), spreading=np.array(2.0)).kept(0) > 0.5
    beam = call_of("kanefe.flexible_body", reduction=kf.Krylov(error_up_to=1e300))
    assert beam.free_count > 0
    assert type(kf.Sea.bretschneider(2.0, 9.0, depth=np.array(50.0)).depth) is float
    assert call_of("kanefe.Krylov", frequencies=np.zeros(1, np.longdouble)).frequencies == (0.0,)


def test_numbers_of_extended_precision_are_stored() -> None:
    assert bytes(encode({"a": [np.longdouble(0.5)]}, {})).count(b"[0.5]") == 1


def faults(seed: int, start: int, stop: int) -> list[str]:
    """Return the faults among some draws, tried in a process of its own; a crash or an end without end is one."""
    command = [sys.executable, str(PROGRAM), *map(str, (seed, start, stop))]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=1500, check=False)
    found = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if not found or "counts" not in json.loads(found[-1]):
        return [f"process ended with {done.returncode} at {done.stderr.splitlines()[-1:]}", *found]
    return found[:-1]


def test_odd_input_is_refused_in_clear_words_or_right() -> None:
    assert faults(2, 0, 30) == []


@pytest.mark.stress
@pytest.mark.parametrize("start", range(0, 10_000, 1_000))
def test_ten_thousand_odd_inputs(start: int) -> None:
    assert faults(2, start, start + 1_000) == []
