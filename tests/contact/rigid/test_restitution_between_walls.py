"""Impacts that cannot be Newton's: they are Poisson's, and that is told."""

from __future__ import annotations

import warnings

import pytest

import kanefe as kf
from kanefe import shapes
from kanefe.integrate.events.contact_changes import ChangeReports
from kanefe.kernels.impacts.contact_questions import REPORTED, Reported


def between_walls(impact: str) -> kf.Model:
    """Return a plate that fits exactly between two walls, and moves towards one of them."""
    scene = kf.System(gravity=(0.0, 0.0, 0.0))
    plate = scene.add_rigid_body("plate", 1.0, 0.01, joint=kf.Prismatic("x", speed=1.0))
    for name, side, axis in (("left", -0.1, "x"), ("right", 0.1, "-x")):
        wall = scene.add_surface(f"{name} wall", scene.ground.frame(at=(side, 0.0, 0.0)), shapes.Plane(axis))
        scene.add_contact(name, [plate.frame(at=(side, 0.0, 0.0))], wall, normal=kf.Rigid(0.5, impact=impact))
    return scene.freeze()


@pytest.mark.parametrize("route", ["order n", "literal"])
def test_what_cannot_part_by_newtons_law_is_told(route):
    """By Newton's law it would leave one wall with half its speed, into the other."""
    model = between_walls("newton")
    one = model.route if route == "order n" else model.literal
    with pytest.warns(kf.SimulationWarning, match="by Poisson's law.*'left' 1, 'right' 1; the first at t = 0 s"):
        one.start(0.0)


@pytest.mark.parametrize("route", ["order n", "literal"])
def test_poissons_law_that_is_asked_for_is_not_told(route):
    """The same impulses are what is asked for."""
    model = between_walls("poisson")
    one = model.route if route == "order n" else model.literal
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        one.start(0.0)


def test_impacts_of_a_run_by_poissons_law_are_counted_for_its_end():
    """Compiled code tells them as it tells touches; they are no events of the result."""
    model, times = between_walls("poisson"), {"right touch": []}
    reports = ChangeReports(times, 1.0)
    touches, by_poisson = REPORTED + Reported.TOUCHES, REPORTED + Reported.BY_POISSON
    for t, code in ((0.5, touches), (0.5, by_poisson), (0.25, by_poisson)):
        reports.take_code(model, t, code)
    assert times == {"right touch": [0.5]}
    assert reports.impacts.by_poisson == {"right": [0.5, 0.25]}
    assert len(reports.impacts.warnings) == 1
    assert "'right' 2; the first at t = 0.25 s" in reports.impacts.warnings[0]
    assert ChangeReports({}, 1.0).impacts.warnings == []
