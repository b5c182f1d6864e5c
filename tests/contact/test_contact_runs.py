"""Runs of contacts: forces that jump at a touch, laws that remember an impact."""

from __future__ import annotations

import math

import numpy as np
import pytest

import kanefe as kf
from kanefe.checks.verification.contact import shaken_slope
from kanefe.integrate.events.event_search import EventWatch
from kanefe.integrate.methods.kernel_stepper import KernelStepper
from kanefe.integrate.stepper import StepFailure
from kanefe.kernels.events.event_search import root_in
from screening_scenes import block_on_deck, deck_motion


def arrives(law: kf.contact.normal_laws.NormalLaw, method: str, rtol: float) -> kf.Result:
    """Return the run of a mass of 1 kg that meets a wall at 1 m/s, from 1 mm before it, and leaves it."""
    scene = kf.System()
    wall = scene.add_surface("wall", scene.ground, kf.shapes.Plane("z"))
    mass = scene.add_point("mass", 1.0, joint=kf.Prismatic("z", position=1e-3, speed=-1.0))
    scene.add_contact("impact", mass, wall, normal=law)
    return scene.simulate((0.0, 0.1), rtol=rtol, method=method)


@pytest.mark.parametrize("rtol", [1e-6, 1e-10, 1e-12])
@pytest.mark.parametrize("method", ["radau5", "dop853", "vern9"])
def test_a_force_that_jumps_at_a_touch_holds_no_method_up(method, rtol):
    """The power of a damper of 10 N s/m jumps by 10 W, in a scene that its size says has 1e-6 J."""
    ratio = 0.05
    root = math.sqrt(1.0 - ratio**2)
    left = math.exp(-2.0 * ratio / root * math.atan(root / ratio))
    run = arrives(kf.KelvinVoigt(1e4, damping=2.0 * ratio * 100.0), method, rtol)
    assert run.status.is_finished
    assert run.velocity("mass")[-1, 2] == pytest.approx(left, rel=max(10.0 * rtol, 1e-9))


def test_flights_between_impacts_keep_their_energy():
    """A Jacobian of the contact, kept as steps grow a million times in the flight behind it, cost up to 9e-7 J."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_point("ball", 1.0, joint=kf.Prismatic("z", position=1.0))
    scene.add_contact("c", ball, floor, normal=kf.Restitution(1e7, 0.8))
    run = scene.simulate((0.0, 4.5), rtol=1e-10, method="radau5")
    flights = zip(run.events["c lift"][:10], run.events["c touch"][1:11], strict=True)
    energies = [run.energy.total[(run.times > lift) & (run.times < touch)] for lift, touch in flights]
    # of 10 J: a few steps of rtol
    assert max(np.ptp(energy) for energy in energies) < 1e-9


@pytest.mark.parametrize("seed", [5, 8, 72, 125, 153])
def test_slips_and_sticks_take_turns(seed):
    """Both are ways through one zero: round-off about it, 1e-11 N, was told as a slip at the moment of a stick."""
    rest = kf.equilibrium(block_on_deck(None)).state
    events = block_on_deck(deck_motion(seed, 20.0)).simulate((0.0, 20.0), start=rest, output_step=1.0).events
    for foot in range(4):
        slips, sticks = (events[f"foot {foot} {way}"] for way in ("slip", "stick"))
        order = np.argsort(np.concatenate((slips, sticks)))
        np.testing.assert_array_equal(order >= len(slips), np.arange(len(order)) % 2 == 1)


@pytest.mark.parametrize("method", ["radau5", "dop853"])
def test_a_law_that_remembers_an_impact_needs_no_friction(method):
    """Its state stays between events: the implicit method does not solve for it, and has a row for it all the same."""
    run = arrives(kf.Restitution(1e4, 0.8), method, 1e-8)
    assert run.velocity("mass")[-1, 2] == pytest.approx(0.8, rel=1e-6)


@pytest.mark.parametrize("e", [0.001, 0.02, 0.03, 0.5])
def test_all_restitutions_have_an_impact_they_follow_from(e):
    run = arrives(kf.Restitution(1e4, e), "radau5", 1e-8)
    assert run.velocity("mass")[-1, 2] == pytest.approx(e, rel=1e-4)


def test_a_function_that_stays_at_zero_holds_no_search_up():
    looked_at = []

    def late(t: float) -> float:
        looked_at.append(t)
        assert len(looked_at) < 200
        return -1.0 if t < 0.3 else 0.0 if t < 0.9 else 1.0

    assert late(root_in(lambda of, t: of(t), late, 0.0, 1.0, 1.0, True)) > 0.0


def test_events_that_a_run_has_not_are_named_with_those_it_has():
    run = arrives(kf.KelvinVoigt(1e4), "radau5", 1e-6)
    with pytest.raises(kf.ModelError, match=r"no event called 'impact slip'\. It has: impact touch, impact lift"):
        run.events["impact slip"]
    assert "impact slip" not in run.events


@pytest.mark.parametrize("rtol", [1e-2, 1e-3])
def test_a_loose_run_does_not_shake_loose_what_sticks(rtol):
    """At 96 % of the cone; absolute errors of a scene of 1 m would be larger than what the contact yields by."""
    result = shaken_slope(0.112).simulate((0.0, 21.0), rtol=rtol, output_step=0.1)
    assert result.contact("block on slope").slip[-1] == 0.0


def thrown(seed: int, is_looped: bool = False) -> kf.System:
    """Return a ball that is thrown spinning on a floor, on which it bounces, slips and rolls."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    start = kf.Free(
        position=(0, 0, 0.15), velocity=rng.standard_normal(3), angular_velocity=10 * rng.standard_normal(3)
    )
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=start)
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    friction = kf.Coulomb(0.3, static=0.4) if seed % 2 else kf.Coulomb(0.3)
    scene.add_contact("drop", skin, floor, normal=kf.HuntCrossley(1e5, 0.3), friction=friction)
    if is_looped:
        bob = scene.add_rigid_body("bob", 0.1, 1e-4, joint=kf.Free(position=(0.5, 0, 0.15)))
        scene.add_distance("string", ball, bob, 0.5)
    return scene


@pytest.mark.parametrize("method", ["radau5", "dop853"])
@pytest.mark.parametrize("seed", range(4))
def test_a_run_that_passes_over_quiet_steps_is_the_same_run(seed, method, monkeypatch):
    """To what rtol allows, beside one in which each step is scanned, and none ends before a foreseen event.

    The latter may miss an event that friction leaves undecided; both are compared with a run of a tight tolerance.
    """
    scans = []
    monkeypatch.setattr(EventWatch, "scan", lambda *given, scan=EventWatch.scan: scans.append(0) or scan(*given))
    scene = thrown(seed)
    quick = scene.simulate((0.0, 0.4), method=method, rtol=1e-6)
    of_quick, events = len(scans), sum(map(len, quick.events.values()))
    monkeypatch.setattr(KernelStepper, "can_look_out", False)
    scanned = scene.copy().simulate((0.0, 0.4), method=method, rtol=1e-6)
    assert events > 3
    # and once more each step that goes across a touch or a lift, before it is taken again up to there
    again = len(scans) - of_quick - scanned.statistics["steps"]
    assert of_quick <= 4 * events < scanned.statistics["steps"]
    assert 0 < again <= events
    exact = scene.copy().simulate((0.0, 0.4), method="dop853", rtol=1e-10)
    for run in (quick, scanned):
        np.testing.assert_allclose(run.position("ball"), exact.position("ball"), rtol=0.0, atol=1e-6)
    for name, times in exact.events.items():
        np.testing.assert_allclose(quick.events[name], times, rtol=0.0, atol=1e-6)


def test_events_before_a_failure_in_compiled_code_are_kept(monkeypatch):
    run_on = KernelStepper.integrate_over_events

    def fails_later(stepper, times, states, passed, most_steps, watched):
        found = run_on(stepper, times, states, passed, most_steps, watched)
        if watched.counts[0] > 0:
            raise StepFailure("it breaks", "mend it")
        return found

    whole = thrown(0).simulate((0.0, 0.4), method="dop853", rtol=1e-6)
    monkeypatch.setattr(KernelStepper, "integrate_over_events", fails_later)
    with pytest.warns(kf.SimulationWarning, match="it breaks"):
        broken = thrown(0).simulate((0.0, 0.4), method="dop853", rtol=1e-6)
    for name, times in whole.events.items():
        np.testing.assert_array_equal(broken.events[name], times[times <= broken.times[-1]])
    assert sum(map(len, broken.events.values())) > 0


def test_quiet_steps_are_passed_over_in_closed_loops_too(monkeypatch):
    scene = thrown(0, is_looped=True)
    quick = scene.simulate((0.0, 0.4), rtol=1e-6)
    monkeypatch.setattr(KernelStepper, "can_look_out", False)
    scanned = scene.copy().simulate((0.0, 0.4), rtol=1e-6)
    for name, times in scanned.events.items():
        np.testing.assert_allclose(quick.events[name], times, rtol=0.0, atol=1e-6)


def test_what_is_only_told_is_told_once_of_a_moment():
    """A touch ends the step, and what slips from there on did so before the end of it."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=kf.Free(position=(0, 0, 0.12), velocity=(1.0, 0, 0)))
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("drop", skin, floor, normal=kf.HuntCrossley(1e4, 0.3), friction=kf.Coulomb(0.3))
    slips = scene.simulate((0.0, 0.3), rtol=1e-4).events["drop slip"]
    assert len(slips) > 1
    assert np.diff(slips).min() > 1e-9


@pytest.mark.parametrize("rtol", [1e-9, 1e-12])
def test_a_step_after_a_touch_begins_within_the_surface(rtol):
    """Slip jumps to 12 m/s at the touch: rates that change sides in a step have no solution, however short."""
    start = kf.Free(position=(0, 0, 0.12), velocity=(1.0, 0, 0), angular_velocity=(0, -100.0, 0))
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=start)
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("drop", skin, floor, normal=kf.HuntCrossley(1e6), friction=kf.Coulomb(0.3))
    result = scene.simulate((0.0, 0.15), rtol=rtol)
    result.raise_for_status()
    touch = result.events["drop touch"][0]
    assert touch == pytest.approx(math.sqrt(2.0 * 0.02 / 9.81), abs=1e-9)
    impulse = 0.3 * 2.0 * 9.81 * touch  # mu times that of the normal force, but for the weight while it lasts
    assert result.velocity("ball")[-1, 0] == pytest.approx(1.0 - impulse, abs=2e-2)
    # 50 and 57, 63 by another compiler; a step without a solution halves until the run fails
    assert result.statistics["rejected"] < 100


def test_what_slides_from_the_start_does_so_by_the_kinetic_coefficient():
    """Where friction remembers whether it slips, a run that begins sliding has no event that would say so."""
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    start = kf.Free(position=(0, 0, -9.81e-6), velocity=(1.0, 0, 0))
    block = scene.add_rigid_body("block", 1.0, 0.01, joint=start)
    scene.add_contact("c", block, floor, normal=kf.HuntCrossley(1e6, 0.3), friction=kf.Coulomb(0.3, static=0.6))
    result = scene.simulate((0.0, 0.5), rtol=1e-6)
    assert result.events["c stick"] == pytest.approx([1.0 / (0.3 * 9.81)], abs=1e-4)
    assert result.contact("c").tangential[1] == pytest.approx(0.3 * 9.81, rel=1e-6)


def test_a_run_goes_on_to_the_bit_from_a_checkpoint_within_a_stick(tmp_path):
    """The anchor's stretch, and that it holds, are part of what is kept."""
    scene, path = shaken_slope(0.112), tmp_path / "run.ckpt"
    options = {"rtol": 1e-6, "output_step": 0.05}
    whole = scene.copy().simulate((0.0, 3.0), **options)
    first = scene.copy().simulate((0.0, 3.0), checkpoint=path, most_steps=whole.statistics["steps"] // 2, **options)
    assert first.status.kind == "stopped"
    assert first.contact("block on slope").status[-1] == "sticks"
    rest = scene.copy().simulate((0.0, 3.0), resume=path, **options)
    np.testing.assert_array_equal(rest.position("block"), whole.position("block"))
    np.testing.assert_array_equal(rest.contact("block on slope").force, whole.contact("block on slope").force)
    for name, times in whole.events.items():
        np.testing.assert_array_equal(rest.events[name], times)
