"""Blocks on plates that are shaken: stick and slip where an exact solution by pieces has them, and nothing unseen."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import kanefe as kf
from kanefe.contact.rigid.rigid_contact import STICKS
from kanefe.integrate.methods.table import METHODS, own_methods
from kanefe.integrate.run_checks.contact_check import of_contacts
from kanefe.literal.contact_forces import probe_forces
from robustness.shaken_blocks import DEFAULT_RTOL, compared, exact, random_block

G = 9.81


def shaken(skin: bool = False) -> kf.System:
    """Return the block of finding A1: stroke 50 mm, 2 Hz, mu 0.5; it begins with the plate."""
    stroke, w = 0.05, 4.0 * math.pi
    scene = kf.System(gravity=(0, 0, -G))
    motion = kf.Motion(
        lambda t: stroke * math.sin(w * t),
        lambda t: stroke * w * math.cos(w * t),
        lambda t: -stroke * w * w * math.sin(w * t),
    )
    plate = scene.add_rigid_body("plate", 2.0, 1.0, joint=kf.Prismatic("x", motion=motion))
    top = scene.add_surface("top", plate, kf.shapes.Plane("z"))
    start = kf.Free(position=(0, 0, 0.05 if skin else 0.0), velocity=(stroke * w, 0, 0))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=start)
    probe = scene.add_surface("skin", block, kf.shapes.Box((0.2, 0.2, 0.1))) if skin else block
    scene.add_contact("c", probe, top, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    return scene


def check(block, drift: float = 1e-6, allowance: float = 1.0) -> None:
    found = compared(block)
    assert found.instants <= (1e-4 if block.rtol == DEFAULT_RTOL else 1e-6) * allowance
    assert found.drift <= drift * allowance
    assert found.friction <= 1e-6


def test_a_block_slips_and_sticks_where_the_exact_solution_does():
    check(random_block(94))


def test_a_slip_in_two_directions_that_begins_by_little_has_no_noise():
    """By 1.015 mu N, at rtol 1e-7: noise of the first step, which friction turns, once moved it by 7e-7 m."""
    check(replace(random_block(1027), span=0.06, output_step=0.02), drift=1e-8)


@pytest.mark.stress
@pytest.mark.parametrize("seed", [*range(1000), 1013])  # 41, 1013: noise along slips that begin was taken for sticks
def test_a_thousand_random_blocks(seed):
    check(random_block(seed), allowance=3.0)  # of a thousand four are beyond what a hundred keep, the worst by 2.2


@pytest.mark.stress
def test_the_oracle_agrees_with_itself_in_one_and_two_directions():
    """In two directions with a stroke of nearly zero along y: DOP853 comes to the closed form."""
    block = random_block(8)
    along = exact(block)
    across = exact(replace(block, strokes=(block.strokes[0], 1e-12)))
    np.testing.assert_allclose(across.slips, along.slips, atol=1e-9)  # s; a stroke of 1e-12 m
    np.testing.assert_allclose(across.sticks, along.sticks, atol=1e-8)  # s; LATE over the acceleration
    np.testing.assert_allclose(across.moved, along.moved, atol=1e-9)


def test_an_onset_of_slip_does_not_end_in_a_stick_at_the_same_instant():
    """The second slip lasts: before, it ended at once, and friction went up to 1.61 mu N."""
    result = shaken().simulate((0.0, 0.5), output_times=np.arange(0.0, 0.51, 0.05))
    assert len(result.events["c slip"]) == 2
    assert len(result.events["c stick"]) == 1
    history = result.contact("c")
    assert np.max(np.array(history.tangential) / np.array(history.normal)) <= 0.5 * (1.0 + 1e-9)


def test_an_acceleration_that_jumps_decides_by_what_follows():
    """Held by friction to one side, then jerked to the other: it slips there, at once."""
    scene = kf.System(gravity=(0, 0, -G))
    jerk = kf.Motion(
        lambda t: -1.0 * t * t if t < 0.1 else -0.01 - 0.2 * (t - 0.1) + 4.0 * (t - 0.1) ** 2,
        lambda t: -2.0 * t if t < 0.1 else -0.2 + 8.0 * (t - 0.1),
        lambda t: -2.0 if t < 0.1 else 8.0,
    )
    plate = scene.add_rigid_body("plate", 2.0, 1.0, joint=kf.Prismatic("x", motion=jerk))
    top = scene.add_surface("top", plate, kf.shapes.Plane("z"))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=kf.Free())
    scene.add_contact("c", block, top, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    result = scene.simulate((0.0, 0.15), output_step=0.05)
    assert result.events["c slip"] == pytest.approx([0.1], abs=1e-9)
    off = (result.position("block") - result.position("plate"))[-1, 0]
    assert off == pytest.approx(0.5 * (0.5 * G - 8.0) * 0.05**2, abs=1e-9)


def test_corners_share_friction_so_that_none_holds_more_than_it_can():
    """A box whose load moves to its front corners sticks as long as all of them together can hold it."""
    scene = shaken(skin=True)
    model = scene.freeze()
    y = model.route.start(0.0)
    # at 0.05 s the plate is at 4.64 m/s2 of mu g = 4.905: by forces of least norm the corners behind would slip
    t = 0.05
    y[0], y[7] = 0.05 * math.sin(4 * math.pi * t), 0.2 * math.pi * math.cos(4 * math.pi * t)
    forces = probe_forces(model.literal.view(t, y))
    assert [force.status for force in forces] == [STICKS] * 4
    for force in forces:
        assert float(np.linalg.norm(force.friction)) < 0.5 * force.normal
    assert sum(force.friction[0] for force in forces) == pytest.approx(
        -0.05 * (4 * math.pi) ** 2 * math.sin(0.2 * math.pi)
    )


def test_what_breaks_a_law_is_an_error_of_the_run():
    """States with friction of 1.6 mu N, in a stick that should have ended, and within the plate."""
    model = shaken().freeze()
    y = np.concatenate((model.route.start(0.0), np.zeros(2)))
    assert of_contacts(model, np.array([0.0]), y[None], "dop853", 100, 1e-6) is None
    late = of_contacts(model, np.array([0.0, 0.125]), np.vstack((y, y)), "dop853", 100, 1e-6)
    assert late.kind == "failed"
    assert late.time == 0.125
    assert "friction of rigid contact 'c' holds 7.89568 N, more than mu N = 4.905 N" in late.reason
    model = shaken().freeze()
    y = np.concatenate((model.initial_state, np.zeros(2)))
    y[2] = -1e-3
    assert "'c' is penetrated by 0.001 m" in of_contacts(model, np.array([0.0]), y[None], "dop853", 100, 1e-6).reason


@pytest.mark.parametrize("is_long", [False, pytest.param(True, marks=pytest.mark.stress)])
def test_no_method_breaks_a_law_unseen(monkeypatch, is_long):
    """Without events a stick goes on, by up to 1.6 mu N: whatever method runs or steps the scene."""
    monkeypatch.setattr("kanefe.integrate.set_up.changes_of_contacts", lambda *arguments: ())
    told = "friction of rigid contact 'c' holds .* N, more than mu N = 4.905 N"
    scene = shaken()
    methods = [name for name in own_methods() if not METHODS[name].refuses(scene.freeze())]
    assert {"dop853", "radau5", "rk4"} <= set(methods)
    for method in methods if is_long else ("dop853", "rk4"):
        options = {} if METHODS[method].has_error_control else {"step": 0.02}
        with pytest.warns(kf.SimulationWarning, match=told):
            result = scene.copy().simulate((0.0, 0.12), output_step=0.04, method=method, **options)
        assert (result.status.kind, result.status.time) == ("failed", pytest.approx(0.08))
    stepped = scene.start(method="dop853")
    stepped.step(0.04)
    with pytest.raises(kf.SimulationError, match=told):
        stepped.step(0.04)


def pushed() -> kf.System:
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=kf.Free())
    scene.add_contact("c", block, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    return scene


def test_a_force_that_jumps_between_steps_or_at_samples_lets_go_what_it_cannot_hold():
    """At once: before, it was found in a look at the next step, 8 ms late."""
    sim = pushed().start(inputs="force block x")
    for push in (4.0, 10.0):
        sim.step(0.1, {"force block x": push})
    assert sim.events["c slip"] == pytest.approx([0.1], abs=1e-12)
    exact = 0.5 * (10.0 - 0.5 * G) * 0.1**2
    assert sim.state.position("block")[0] == pytest.approx(exact, rel=1e-9)
    scene = pushed()
    scene.add_controller(
        "push",
        lambda t, reads, memory: 10.0 if t > 0.09 else 4.0,
        every=0.1,
        reads="position block x",
        drives="force block x",
    )
    result = scene.simulate((0.0, 0.2), output_step=0.1)
    assert result.status.is_finished  # the output at 0.1 s is of what slips, too
    assert result.events["c slip"] == pytest.approx([0.1], abs=1e-12)
    assert result.position("block")[-1, 0] == pytest.approx(exact, rel=1e-9)
