"""Outputs whose derivatives are known, against differences of the whole scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kanefe as kf
from kanefe.linear.inputs import inputs_of
from kanefe.linear.linearisation import input_directions
from kanefe.linear.outputs import output_rows, outputs_of
from kanefe.linear.small_motions import SmallMotions
from kanefe.states import state as states
from loop_scenes import four_bars, spatial_loop
from scenes import flexible_scene, floating_scene, random_state

DIFFERENCES = 1e-10
"""Of fourth-order differences, over the largest entry: 1e-16 over a step of 1e-3, and the fourth power of the step."""


def small_of(scene: kf.System, drives: str | None = None) -> SmallMotions:
    """Return the small motions about a random state, about the start where loops hold; with some drives."""
    model = scene.freeze()
    q, u = model.initial_coordinates, model.initial_speeds
    if not model.constraints:
        q, u = random_state(model, 3, amplitude=0.05, speed=0.5)
        q = model.advance(q, np.zeros(model.free_count))
    given = inputs_of(model, 0.0, q, u, drives) if drives else ()
    return SmallMotions(model, 0.0, q, u, [item.drive for item in given if item.drive is not None])


@pytest.mark.parametrize(
    ("make", "drives", "elastic"),
    [
        (lambda: spatial_loop(1), "drive crank", "arm"),
        (lambda: flexible_scene(2), None, None),
        (lambda: floating_scene(3), None, None),
    ],
    ids=["loops, driven", "flexible", "floating"],
)
def test_known_derivatives_are_those_of_differences(make, drives, elastic):
    small = small_of(make(), drives)
    bodies = small.model.bodies
    named = [f"{what} {body.name}" for body in bodies for what in ("position", "rotation")]
    for body in bodies:
        if body.joint.rotation_at is None and any(motion is None for motion in body.joint.motions):
            named += [f"{what} {body.name}" for what in ("joint_coordinates", "joint_speeds")]
        if body.flexible is not None:
            named += [f"{what} {body.name}" for what in ("modal_coordinates", "modal_speeds")]
            named += [f"{what} {body.name}/{f.name}" for f in body.interfaces for what in ("deflection", "position")]
    assert elastic is None or f"deflection {elastic}/tip" in named
    outputs = outputs_of(small, named)
    assert all(output.tangent is not None for output in outputs)
    differed = [replace(output, tangent=None) for output in outputs]
    directions = [small.along_positions, small.along_speeds]
    if drives:
        directions.append(input_directions(small, inputs_of(small.model, 0.0, small.q, small.u, drives)))
    for along in directions:
        exact, found = (output_rows(small, some, along) for some in (outputs, differed))
        np.testing.assert_allclose(exact, found, rtol=0, atol=DIFFERENCES * max(1.0, np.abs(found).max()))
    assert np.abs(output_rows(small, outputs, directions[0])).max() > 0.1


def test_velocities_are_still_differentiated_by_the_whole_scene():
    small = small_of(floating_scene(3))
    body = small.model.bodies[-1].name
    (output, *_) = outputs_of(small, f"velocity {body}")
    assert output.tangent is None
    found = output_rows(small, [output], small.along_positions)
    assert np.abs(found).max() > 0.0


@pytest.mark.filterwarnings("ignore::kanefe.linear.unsettled.UnsettledWarning")
def test_the_default_outputs_displace_no_state(monkeypatch: pytest.MonkeyPatch) -> None:
    displaced = []
    moved = SmallMotions.moved
    monkeypatch.setattr(SmallMotions, "moved", lambda *args: displaced.append(1) or moved(*args))
    model = four_bars(3, "apart").freeze()
    kf.linearise(model)
    assert not displaced
    kf.linearise(model, outputs="velocity coupler 0 x")
    assert displaced


@pytest.mark.filterwarnings("ignore::kanefe.linear.unsettled.UnsettledWarning")
def test_the_number_of_sweeps_is_that_of_any_number_of_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    swept = []
    sweep = states.sweep_outward
    monkeypatch.setattr(states, "sweep_outward", lambda *args: swept.append(1) or sweep(*args))
    counts = []
    for number in (3, 12):
        model = four_bars(number, "apart").freeze()
        swept.clear()
        kf.linearise(model)
        counts.append(len(swept))
    assert counts[0] == counts[1] <= 6
