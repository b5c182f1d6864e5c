"""`CraigBampton()`: modes and static shapes that follow from the body alone, and what a run says of them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.instants.missed_statics import missed_statics
from kanefe.reduction import flexible_body, mode_choice
from kanefe.reduction.load_cases import some_groups
from reduction_cases import exact_errors, hinged_bar, pendulum_beam, problem_of, tied_modes
from steel_beams import steel_beam


def held_bar() -> tuple[kf.FiniteElementModel, dict]:
    return hinged_bar(20)[:2]


def floating_bar() -> tuple[kf.FiniteElementModel, dict]:
    return hinged_bar(20)[0], {"tip": "rigid"}


def planar_beam() -> tuple[kf.FiniteElementModel, dict]:
    return pendulum_beam(20)[:2]


@pytest.mark.parametrize("case", [held_bar, floating_bar, planar_beam])
def test_all_is_right_up_to_ten_times_the_first_frequency(case: Callable) -> None:
    """Frequencies to 0.1 %, statics exact, and responses within the hundredth that is told, by whole matrices."""
    model, interfaces = case()
    body = flexible_body(model, interfaces, reduction="auto")
    estimate = body.provenance["reduction"]["error_estimate"]
    whole = flexible_body(model, interfaces).frequencies
    assert 10.0 * whole[0] <= estimate["up_to_frequency"] < 10.5 * whole[0]  # the first of its static shapes
    within = whole[whole < estimate["up_to_frequency"]]
    assert body.frequencies[: len(within)] == pytest.approx(within, rel=1e-3)
    problem = problem_of(model, interfaces)
    modes, groups = tied_modes(problem, kf.CraigBampton()), some_groups(problem, ())
    assert max(exact_errors(problem, modes, groups, estimate["up_to_frequency"]).values()) < 0.01
    slow = 0.01 * estimate["up_to_frequency"]
    assert max(exact_errors(problem, modes, groups, slow).values()) < 1e-6
    assert body.free_count < 45


def test_load_patterns_are_complete_too_and_are_told() -> None:
    model, interfaces = held_bar()
    told = str(flexible_body(model, interfaces, reduction=kf.CraigBampton()))
    assert "reduced to" in told
    exact = told.partition("statically exact: ")[2].partition("\n")[0]
    assert {"gravity", "centrifugal", "span traction", "tip force", "tip moment"} <= set(exact.split(", "))
    assert "told" not in flexible_body(model, interfaces, reduction=kf.CraigBampton(modes=4)).provenance


def test_where_too_many_modes_are_needed_the_range_ends_sooner(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mode_choice, "CANDIDATES", 2)
    monkeypatch.setattr(mode_choice, "MOST_UNASKED", 2)
    model, interfaces = held_bar()
    body = flexible_body(model, interfaces, reduction="auto")
    found = body.provenance["reduction"]
    first = float(body.frequencies[0])
    assert 0.1 * first < found["error_estimate"]["up_to_frequency"] < 9.0 * first
    assert found["error_estimate"]["value"] <= 0.01
    assert found["choice"]["candidates"] == 2


def swing(body: kf.FlexibleBody, lasts: float) -> kf.Result:
    scene = kf.System()
    member = scene.add_flexible_body("beam", body, joint=kf.Revolute("y"))
    scene.add_torque(member, lambda t: 300.0 * np.sin(np.pi * t / lasts) ** 2 if t < lasts else 0.0)
    return scene.simulate((0.0, lasts), rtol=1e-7, output_step=lasts / 40)


def test_a_push_that_is_too_fast_for_the_modes_is_told() -> None:
    """Of a push of half a period of the first mode nothing is missed; of a short one as much as is told."""
    model = steel_beam(40)
    interfaces = {"root": "clamped"}
    few = flexible_body(model, interfaces, reduction=kf.CraigBampton(modes=1, loads=("angular acceleration",)))
    slow, fast = (swing(few, part / float(few.frequencies[0])) for part in (0.5, 0.02))
    assert "miss" not in str(slow)
    assert "inertia of modes" in str(fast)
    assert "up_to_frequency" in str(fast)
    many = swing(flexible_body(model, interfaces, reduction=kf.CraigBampton(modes=30)), fast.times[-1])
    (told,) = missed_statics([fast.at(t) for t in fast.times])
    missed = fast.nodal_displacements("beam") - many.nodal_displacements("beam")
    moved = many.nodal_displacements("beam")
    share = np.linalg.norm(missed, axis=(1, 2)).max() / np.linalg.norm(moved, axis=(1, 2)).max()
    # energies weigh short waves more than displacements do, and one mode beside a static shape is far off
    assert 0.2 * told.share < share < 2.0 * told.share
