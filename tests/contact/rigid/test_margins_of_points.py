"""How far points of rigid contacts may be beyond their events: each by itself, and never so far that it is seen."""

from __future__ import annotations

import pytest

import kanefe as kf
from kanefe.kernels.impacts.contact_questions import Asks
from kanefe.literal import contact_instant as instant
from robustness.rocking import rocking_block

G = 9.81
NEVER = kf.Event("never", lambda t, state: 1.0)
"""Not compiled: with it the events of a run are looked for in Python."""


@pytest.mark.parametrize("events", [(), (NEVER,)], ids=["compiled", "in Python"])
def test_a_point_that_leaves_deep_lets_no_other_in(events):
    """A ball that begins 0.9 nm deep leaves slowly; another one is to bounce at once, 0.1 ms later."""
    scene = kf.System(gravity=(0.0, 0.0, 0.0))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    for name, z, speed in (("slow", -9e-10, 1e-6), ("fast", 1e-4, -1.0)):
        ball = scene.add_point(name, 1.0, joint=kf.Prismatic("z", position=z, speed=speed))
        scene.add_contact(name, ball, floor, normal=kf.Rigid(1.0))
    result = scene.simulate((0.0, 1e-3), output_step=1e-4, events=events)
    # moments are found to round-off of the span; it was let in 9 nm, and so 9 ns late
    assert result.events["fast touch"] == pytest.approx([1e-4], abs=1e-12)
    assert result.position("slow")[-1, 2] == pytest.approx(1e-9 - 9e-10, rel=1e-6)


@pytest.mark.parametrize("events", [(), (NEVER,)], ids=["compiled", "in Python"])
@pytest.mark.parametrize("seed", [91, 772])
def test_a_foot_that_nothing_presses_any_more_lifts(seed, events):
    """Its friction is used up at the moment at which its force is: that was taken for slips without end."""
    scene, end = rocking_block(seed)
    result = scene.simulate((0.0, 0.15 * end), output_step=0.05, events=events)
    assert result.status.is_finished
    assert abs(result.angular_velocity("block")[-1]).max() > 1e-3  # it rocks


def table(x: float, y: float) -> kf.System:
    """Return a table on four legs with its weight at a place."""
    scene = kf.System(gravity=(0.0, 0.0, -G))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    board = scene.add_rigid_body("table", 8.0, 1.0, com=(x, y, 0.0), joint=kf.Free(position=(0.0, 0.0, 0.75)))
    places = [(x, y, -0.75) for x in (-0.5, 0.5) for y in (-0.4, 0.4)]
    legs = scene.add_surface("legs", board, kf.shapes.Points(places))
    scene.add_contact("legs", legs, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
    return scene


@pytest.mark.parametrize("inside", [0.0, 1e-5, 1e-3])
def test_a_table_with_its_weight_above_a_leg_stands_on_it(inside):
    """There is hardly a way to share its weight: least squares of what a leg lacks of some room let one pull."""
    model = table(0.5 - inside, 0.4 - inside).freeze()
    y = model.route.touched(0.0, model.route.start(0.0), 1.0, 1.0, 1e-6)
    normals = model.route.asked_contacts(Asks.MARGINS, 0.0, y).margins[:, 1]
    # below the 1e-9 of the largest force that is round-off of forces
    assert len(normals) == 4
    assert min(normals) > -1e-9 * 8.0 * G
    assert sum(normals) == pytest.approx(8.0 * G, rel=1e-9)


def test_what_a_decision_does_not_see_is_looked_at_ten_times_further(monkeypatch):
    """A margin that is a little below zero after an event is let go on, one further below is an event at once."""
    model = table(0.0, 0.0).freeze()
    y = model.route.touched(0.0, model.route.start(0.0), 1.0, 1.0, 1e-6)
    found = instant.margins(model.literal.view(0.0, y))
    largest = max(found.normals.values())
    for share, blur in ((0.0, 1e-9), (-1e-8, 1e-7), (-1e-5, 1e-9)):
        shown = found._replace(normals={**found.normals, (0, 0): share * largest})
        monkeypatch.setattr(instant, "margins", lambda state, shown=shown: shown)
        assert model.literal.asked_contacts(Asks.BLURS, 0.0, y).blurs[1] == pytest.approx(blur * largest, rel=1e-6)
