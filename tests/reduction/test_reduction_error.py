"""Choice of modes and error estimates, against bodies with all their degrees of freedom."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.linalg

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.reduction import flexible_body
from kanefe.reduction.load_cases import some_groups
from reduction_cases import crank_rod, exact_errors, hinged_bar, pendulum_beam, problem_of, tied_modes
from scenes import lattice_model
from steel_beams import steel_beam


def floating_bar() -> tuple[kf.FiniteElementModel, dict, float]:
    return pendulum_beam()[0], {"tip": "rigid"}, 60.0


def free_bar() -> tuple[kf.FiniteElementModel, dict, float]:
    return pendulum_beam()[0], {}, 60.0


BODIES = [pendulum_beam, crank_rod, hinged_bar, floating_bar, free_bar]


def reductions(f: float) -> list[Any]:
    return [
        kf.CraigBampton(modes=2, error_up_to=f),
        kf.CraigBampton(modes=5, error_up_to=f),
        kf.CraigBampton(modes=3, error_up_to=f, loads=("centrifugal",)),
        kf.FreeInterface(modes=3, error_up_to=f),
        kf.Krylov(order=1, error_up_to=f),
        kf.CraigBampton(modes="auto", up_to_frequency=f),
        kf.CraigBampton(modes="auto", up_to_frequency=f, tol=1e-2),
        kf.CraigBampton(modes="auto", up_to_frequency=f, loads=("centrifugal",), error_up_to=f),
    ]


@pytest.mark.parametrize("case", BODIES, ids=lambda case: case.__name__)
def test_the_estimate_bounds_the_error_within_a_factor_of_five(case: Callable) -> None:
    model, interfaces, f = case()
    problem = problem_of(model, interfaces)
    for reduction in reductions(f):
        record = flexible_body(model, interfaces, reduction=reduction).provenance["reduction"]
        estimate = record["error_estimate"]
        groups = some_groups(problem, reduction.loads)
        exact = exact_errors(problem, tied_modes(problem, reduction), groups, f)
        # It is twice the error but for what the richer basis misses, and for errors that are round-off (1e-9).
        assert exact
        for (load, motion), error in exact.items():
            if error > 1e-9:
                assert error <= estimate["loads"][load][motion] <= 5.0 * error, (reduction, load, motion)
        assert max(exact.values()) <= estimate["value"] <= 5.0 * max(exact.values()), reduction
        assert json.loads(json.dumps(record)) == record


@pytest.mark.parametrize("case", BODIES, ids=lambda case: case.__name__)
@pytest.mark.parametrize("tol", [1e-1, 1e-2, 1e-3])
def test_auto_keeps_the_tolerance_and_little_more(case: Callable, tol: float) -> None:
    model, interfaces, f = case()
    problem = problem_of(model, interfaces)
    reduction = kf.CraigBampton(modes="auto", up_to_frequency=f, tol=tol)
    body = flexible_body(model, interfaces, reduction=reduction)
    exact = exact_errors(problem, tied_modes(problem, reduction), some_groups(problem, ()), f)
    record = body.provenance["reduction"]
    assert max(exact.values()) < tol
    kept = [mode["number"] for mode in record["modes"] if mode["kept"]]
    assert len(kept) == record["choice"]["kept_modes"]
    assert body.free_count == record["choice"]["kept_columns"]
    assert record["error_estimate"]["value"] <= tol
    # one mode less, the one of the smallest share, and the tolerance is missed, or effective mass asks for it
    columns = reduction.basis(problem).columns
    if kept:
        listed = {mode["number"]: mode for mode in record["modes"]}
        least = min(kept, key=lambda n: listed[n]["share"])
        if "effective mass" not in listed[least]["why"]:
            fewer = np.delete(columns, columns.shape[1] - len(kept) + kept.index(least), axis=1)
            errors = exact_errors(problem, tied_modes(problem, Given(fewer)), some_groups(problem, ()), f)
            assert 2.0 * max(errors.values()) > 0.99 * tol


class Given:
    """A reduction that hands over columns."""

    def __init__(self, columns: np.ndarray) -> None:
        self.columns = columns

    def basis(self, problem: object) -> Given:
        return self


def test_a_smaller_tolerance_keeps_more() -> None:
    model, interfaces, f = pendulum_beam()
    counts = [
        flexible_body(model, interfaces, reduction=kf.CraigBampton(modes="auto", up_to_frequency=f, tol=tol)).free_count
        for tol in (1e-1, 1e-3, 1e-5)
    ]
    assert counts == sorted(counts)
    assert counts[0] < counts[-1]


def test_modes_that_the_loads_do_not_excite_are_left_out() -> None:
    # a straight beam in space: gravity across it bends it in one plane; it neither twists nor bends in the other
    model = steel_beam(10)
    push = kf.LoadCase("sag", model.mass @ model.rigid_modes()[:, 2])
    reduction = kf.CraigBampton(modes="auto", up_to_frequency=5.0, tol=1e-4, loads=(push,))
    record = flexible_body(model, {"root": "clamped"}, reduction=reduction).provenance["reduction"]
    T = problem_of(model, {"root": "clamped"}).ties.transformation
    assert 1 <= record["choice"]["kept_columns"] <= 3
    shapes = T @ reduction.basis(problem_of(model, {"root": "clamped"})).columns
    motion = abs(shapes.reshape(len(model.nodes), 6, -1)).max(axis=(0, 2))
    assert motion[[0, 1, 3, 5]] == pytest.approx(np.zeros(4), abs=1e-6 * motion.max())
    assert all("sag" in mode["why"] for mode in record["modes"] if mode["kept"])


def test_modes_in_range_with_effective_mass_are_kept_whatever_the_loads() -> None:
    model, interfaces, _ = pendulum_beam()
    pull = kf.LoadCase("pull", model.mass @ model.rigid_modes()[:, 0])
    reduction = kf.CraigBampton(modes="auto", up_to_frequency=30.0, loads=(pull,))
    record = flexible_body(model, interfaces, reduction=reduction).provenance["reduction"]
    kept = [mode for mode in record["modes"] if mode["kept"]]
    # both bending modes below 30 Hz, at 4.1 and 25.8 Hz: the acceleration of the root excites them
    assert [round(mode["frequency"], 1) for mode in kept[:2]] == [4.1, 25.8]
    assert all("effective mass at root" in mode["why"] for mode in kept[:2])


@pytest.mark.parametrize("case", [pendulum_beam, hinged_bar], ids=lambda case: case.__name__)
@pytest.mark.parametrize("load", ["gravity", "centrifugal"])
def test_shares_of_modes_are_those_of_the_exact_response(case: Callable, load: str) -> None:
    model, interfaces, f = case()
    problem = problem_of(model, interfaces)
    reduction = kf.CraigBampton(modes="auto", up_to_frequency=f, loads=(load,))
    record = flexible_body(model, interfaces, reduction=reduction).provenance["reduction"]
    moving = np.setdiff1d(np.arange(problem.size), problem.fixed)
    inside = problem.interior
    K, M = (m[moving][:, moving].toarray() for m in (problem.stiffness, problem.mass))
    _, shapes = scipy.linalg.eigh(problem.interior_stiffness.toarray(), problem.interior_mass.toarray())
    forces = some_groups(problem, (load,))[0].forces
    static, shares = problem.solve(forces), 0.0
    for s in 0.4 * np.pi * f + 2j * np.pi * f * np.linspace(0.0, 1.0, 9):
        u = np.zeros(forces.shape, dtype=complex)
        u[moving] = np.linalg.solve(K + s * s * M, forces[moving])
        size = np.sqrt(np.einsum("ij,ij->j", u.conj(), problem.mass @ u).real).max()
        # what the mode has to add to the static shapes, the motion of the interfaces being given
        inner = (u - static) - problem.constraint_modes @ (u - static)[problem.boundary]
        amplitude = shapes.T @ (problem.interior_mass @ inner[inside])
        shares = np.maximum(shares, abs(amplitude).max(axis=1) / size)
    listed = np.array([mode["share"] for mode in record["modes"]])
    # the richest basis at hand has errors of 1e-4 of a mode's own share; round-off is 1e-10 of the response
    assert listed == pytest.approx(shares[: len(listed)], rel=1e-3, abs=1e-9)


def test_dropped_modes_tell_what_they_cost() -> None:
    model, interfaces, f = pendulum_beam()
    reduction = kf.CraigBampton(modes="auto", up_to_frequency=f, tol=1e-2)
    record = flexible_body(model, interfaces, reduction=reduction).provenance["reduction"]
    dropped = [mode for mode in record["modes"] if not mode["kept"]]
    assert dropped
    assert all(mode["share"] < 1e-2 and "of the response to" in mode["why"] for mode in dropped)
    assert record["choice"]["error_without_modes"] > 1e-2 > record["choice"]["error_of_all_candidates"]


def test_loads_that_need_too_many_modes_are_refused() -> None:
    model = steel_beam(200, planar=True)
    push = np.zeros(model.size)
    push[30::3] = np.random.default_rng(0).standard_normal(191)  # a load of every wave length
    reduction = kf.CraigBampton(modes="auto", up_to_frequency=2e4, tol=1e-9, loads=(kf.LoadCase("noise", push),))
    with pytest.raises(ModelError, match=r"leave an error of .* against tol=1e-09 .* Remedy: loads="):
        flexible_body(model, {"root": "clamped"}, reduction=reduction)


@pytest.mark.parametrize(
    "reduction",
    [
        kf.CraigBampton(modes="auto", up_to_frequency=5.0, loads=("gravity",)),
        kf.CraigBampton(modes=2, error_up_to=5.0, loads=("gravity",)),
        kf.Krylov(loads=("gravity",)),
    ],
    ids=repr,
)
def test_a_body_in_free_fall_has_no_error_under_gravity(reduction: Any) -> None:
    with pytest.raises(ModelError, match="none of the loads deforms the body: one that floats falls"):
        flexible_body(lattice_model(0), {}, reduction=reduction)


def test_estimates_cost_one_factorisation_and_few_solves() -> None:
    model, interfaces, f = hinged_bar()
    calls: list[int] = []

    class Counted:
        def __init__(self, factors: Any) -> None:
            self.factors = factors

        def solve(self, b: np.ndarray) -> np.ndarray:
            calls.append(b.shape[1] if b.ndim == 2 else 1)
            return self.factors.solve(b)

    def factorise(matrix: Any) -> Counted:
        calls.append(0)
        return Counted(kf.reduction.splu_factorise(matrix))

    counts = []
    for limit in (None, f):
        calls.clear()
        reduction = kf.CraigBampton(modes=4, error_up_to=limit)
        body = flexible_body(model, interfaces, reduction=reduction, factorise=factorise)
        assert calls.count(0) == 1
        counts.append(sum(calls))
    # one for each mode and each load: 3 + 3 at the tip, 3 + 3 accelerations, 6 products (two are the same bending)
    assert body.free_count < counts[1] - counts[0] <= body.free_count + 18


def pendulum(reduction: Any) -> np.ndarray:
    """C01 to 10 ms: released from the horizontal."""
    model, interfaces, _ = pendulum_beam(4)
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    body = flexible_body(model, interfaces, reduction=reduction)
    scene.add_flexible_body("body", body, joint=kf.Revolute("z"))
    return displacements(scene, 0.01)


def slider_crank(reduction: Any) -> np.ndarray:
    """C06 to 0.5 ms: a rod driven at 150 rad/s."""
    model, interfaces, _ = crank_rod(4)
    scene = kf.System()
    crank = scene.add_rigid_body("crank", 0.1, 1e-4, joint=kf.Revolute("z", motion=kf.Motion.steady(150.0)))
    body = flexible_body(model, interfaces, reduction=reduction)
    hinge = kf.Revolute("z", speed=-225.0)
    rod = scene.add_flexible_body("body", body, parent=crank, at=(0.15, 0.0, 0.0), joint=hinge)
    slider = scene.add_rigid_body("slider", 0.075552, at=(0.45, 0.0, 0.0), joint=kf.Prismatic("x"))
    scene.add_loop_joint("pin", kf.Spherical(), rod.interface("tip"), slider)
    return displacements(scene, 0.0005)


def swinging_bar(reduction: Any) -> np.ndarray:
    """S3 to 2 ms: a bar hinged at its root, released under gravity."""
    model, interfaces, _ = hinged_bar(3)
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    body = flexible_body(model, interfaces, reduction=reduction)
    scene.add_flexible_body("body", body, joint=kf.Revolute("y"))
    return displacements(scene, 0.002)


def displacements(scene: kf.System, end: float) -> np.ndarray:
    return scene.simulate((0.0, end), method="dop853", rtol=1e-7, output_step=end / 50).nodal_displacements("body")


@pytest.mark.parametrize("scene", [pendulum, slider_crank, swinging_bar], ids=lambda scene: scene.__name__)
def test_twice_the_modes_and_statics_tell_the_error_of_a_scene(scene: Callable) -> None:
    exact = scene(None)
    for modes in (2, 4):
        reduction = kf.CraigBampton(modes=modes)
        loads = ("gravity", "angular acceleration", "centrifugal")
        found, richer = scene(reduction), scene(kf.CraigBampton(modes=2 * modes, loads=loads))
        true = abs(found - exact).max()
        # relative steps of 1e-7 are far below errors of reduction of 1e-3 and more
        assert true > 1e-4 * abs(exact).max()
        assert true / 1.5 < abs(found - richer).max() < 1.5 * true
