"""The balls of the benchmark: what their closed form and their description say of them."""

from __future__ import annotations

import pytest

from benchmarks.goals import Goal
from benchmarks.peer_process import NoPeers
from benchmarks.work_precision import contacts
from benchmarks.work_precision.balls import BOUNCING, ROLLING, bouncing_ball, rolled_way, rolling_ball
from benchmarks.work_precision.curves import Limits
from benchmarks.work_precision.machine import Machine
from benchmarks.work_precision.scene import Setting
from kanefe.integrate.run import integrate
from kanefe.result import Result


def test_the_way_of_the_ball_that_rolls_is_that_of_a_stiff_slope():
    errors = []
    for stiffness in (1e6, 1e7):
        model = rolling_ball(stiffness).model()
        found = integrate(model, (0.0, ROLLING), rtol=1e-8, output_step=ROLLING, progress=False)
        errors.append(abs(found.coordinates[-1, 0] - rolled_way()))
    assert errors[0] < 1e-6
    assert errors[1] == pytest.approx(0.1 * errors[0], rel=0.1)


def test_the_ball_that_bounces_slips_all_the_time():
    model = bouncing_ball().model()
    run = Result(model, integrate(model, (0.0, BOUNCING), rtol=1e-8, progress=False))
    assert len(run.events["contact touch"]) == 2
    assert len(run.events["contact stick"]) == 0
    assert len(run.events["contact slip"]) == 2  # as it touches


def trial(name: str, errors: dict[float, float], seconds: float) -> contacts._Trial:
    """Return a program whose error is known by step or tolerance."""

    def place(setting: Setting) -> list[float]:
        size = setting.step if setting.rtol is None else setting.rtol
        found = [error for least, error in errors.items() if size >= least]
        if not found:
            raise NoPeers("fails")
        return [found[-1], 0.0]

    return contacts._Trial(name, place, lambda setting: seconds)


def test_figures_of_balls_are_of_the_fastest_that_are_near_enough():
    machine = Machine(None, "", Limits(quick=True))
    good, slow = trial("good", {0.0: 1e-7}, 1e-3), trial("slow", {0.0: 1e-8}, 1.0)
    bad, other = trial("bad", {0.0: 1.0}, 1e-9), trial("other", {0.0: 1e-7}, 1e-2)
    goals = {1e-6: Goal("ratio", 0.2), 1e-12: Goal("none", 0.2)}
    ratio, none = contacts._raced(machine, [slow, good, bad], [bad, other], lambda place: place[0], goals)
    assert ratio.value == pytest.approx(0.1)
    assert ratio.met
    assert "good" in ratio.remark
    assert "skipped" in str(none.value)
    assert not none.met
