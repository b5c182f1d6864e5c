"""Bases of reduced bodies: free-interface, Krylov, load vectors, and columns of any quality."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import scipy.linalg

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.fe_model.load_pattern import NodalPattern
from kanefe.fe_model.statics import StaticProblem
from kanefe.reduction import flexible_body
from kanefe.reduction.basis import Basis
from kanefe.reduction.load_cases import PRODUCTS, centrifugal_forces
from kanefe.reduction.orthonormal import DEPENDENT, orthonormal_modes
from reduction_cases import problem_of, tied_modes
from scenes import lattice_model
from steel_beams import steel_beam

CLAMPED = {"root": "clamped", "tip": "rigid"}
METHODS = [
    kf.CraigBampton(modes=5),
    kf.CraigBampton(modes=5, loads=("gravity", "centrifugal")),
    kf.FreeInterface(modes=5),
    kf.Krylov(frequencies=(0.0, 20.0), order=2),
]
SUPPORTS = [CLAMPED, {"root": "clamped"}, {"tip": "rigid"}, {"root": "rigid", "tip": "rigid"}, {}]


@pytest.mark.parametrize("interfaces", SUPPORTS, ids=str)
@pytest.mark.parametrize("reduction", METHODS, ids=repr)
def test_every_basis_is_orthonormal_with_diagonal_stiffness(reduction: Any, interfaces: dict) -> None:
    body = flexible_body(steel_beam(), interfaces, reduction=reduction)
    k = body.free_count
    K, M = body.stiffness[:k, :k], body.moments.elastic_mass[:k, :k]
    # round-off of some hundred operations on eigenvectors
    assert pytest.approx(np.eye(k), abs=1e-10) == M
    assert pytest.approx(np.diag(np.diag(K)), abs=1e-10 * K.max()) == K
    json.dumps(body.provenance["reduction"])


class Given:
    """A reduction that hands over columns."""

    loads: tuple = ()
    error_up_to = None

    def __init__(self, columns: np.ndarray) -> None:
        self.columns = columns

    def basis(self, problem: object) -> Basis:
        return Basis(self.columns)


@pytest.mark.parametrize("interfaces", [{"root": "clamped"}, {}], ids=str)
def test_duplicates_zeros_and_wild_scales_do_not_matter(interfaces: dict) -> None:
    model = lattice_model(1)
    problem = problem_of(model, interfaces)
    rng = np.random.default_rng(0)
    columns = rng.standard_normal((problem.size, 4))
    columns[problem.fixed] = 0.0
    mixed = columns @ rng.standard_normal((4, 6))
    wild = np.hstack((1e150 * columns, 1e-150 * mixed, np.zeros((problem.size, 2)), columns[:, :1]))
    plain, messy = (flexible_body(model, interfaces, reduction=Given(c)) for c in (columns, wild))
    assert messy.free_count == plain.free_count == 4
    assert messy.frequencies == pytest.approx(plain.frequencies, rel=1e-9)


def test_directions_are_told_apart_beyond_the_root_of_round_off() -> None:
    # the Gram matrix of these has an eigenvalue of 1e-14, which its own round-off hides; their span has rank 2
    problem = problem_of(lattice_model(1), {"root": "clamped"})
    rng = np.random.default_rng(1)
    a, b = rng.standard_normal((2, problem.size))
    a[problem.fixed] = b[problem.fixed] = 0.0
    M, of = problem.mass, (problem.stiffness, problem.mass, problem.rigid_modes, problem.largest_masses)
    near = orthonormal_modes(np.column_stack((a, a + 1e-7 * b)), *of)
    far = orthonormal_modes(np.column_stack((a, b)), *of)
    assert near.shape[1] == 2
    # b is known to the 1e-16 / 1e-7 that the subtraction leaves of it
    angles = scipy.linalg.svdvals(far.T @ (M @ near))
    assert angles == pytest.approx(np.ones(2), abs=1e-7)
    assert orthonormal_modes(np.column_stack((a, a + 1e-12 * b)), *of).shape[1] == 1


def test_columns_that_are_not_finite_are_refused() -> None:
    model = lattice_model(0)
    columns = np.full((problem_of(model, CLAMPED).size, 1), np.nan)
    with pytest.raises(ModelError, match="columns of the reduction are not finite"):
        flexible_body(model, CLAMPED, reduction=Given(columns))


@pytest.mark.parametrize("size", [20, 100])  # LAPACK below 400 degrees of freedom, ARPACK above
@pytest.mark.parametrize("interfaces", SUPPORTS, ids=str)
def test_free_interface_modes_are_those_of_the_body_in_the_scene(interfaces: dict, size: int) -> None:
    model = steel_beam(size)
    problem = problem_of(model, interfaces)
    moving = np.setdiff1d(np.arange(problem.size), problem.fixed)
    K, M = (m[moving][:, moving].toarray() for m in (problem.stiffness, problem.mass))
    exact = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)[problem.rigid_count :][:5]) / (2 * np.pi)
    body = flexible_body(model, interfaces, reduction=kf.FreeInterface(modes=5))
    # the dense solution of a pair whose squares span 1e11 is good to some 1e-6 of the lowest, ours to more
    assert body.frequencies[:5] == pytest.approx(exact, rel=1e-5)
    assert body.free_count == 5 + len(problem.released)
    found = flexible_body(model, interfaces, reduction=kf.FreeInterface(up_to_frequency=exact[3] * 1.01))
    assert found.free_count == 4 + len(problem.released)


@pytest.mark.parametrize("interfaces", [CLAMPED, {"root": "rigid", "tip": "rigid"}], ids=str)
def test_attachment_modes_make_interface_loads_statically_exact(interfaces: dict) -> None:
    # floating: the loads are balanced by the inertia of the rigid motions (Hintz, Herting)
    problem = problem_of(lattice_model(2), interfaces)
    forces = np.zeros((problem.size, 1))
    forces[problem.released[-4:], 0] = (1.0, -2.0, 0.5, 0.3)
    exact = problem.solve(forces)
    errors = []
    for attachment in (True, False):
        modes = tied_modes(problem, kf.FreeInterface(modes=2, attachment=attachment))
        squares = np.einsum("ij,ij->j", modes, problem.stiffness @ modes)
        found = modes @ ((modes.T @ forces) / squares[:, None])
        errors.append(np.linalg.norm(found - exact) / np.linalg.norm(exact))
    assert errors[0] < 1e-9  # round-off of a solve times the condition of a soft lattice
    assert errors[1] > 1e-3


def test_a_floating_body_without_interfaces_is_solved_in_balance() -> None:
    # an independent solution: least squares over all loads and the rigid motions
    problem = problem_of(lattice_model(3), {})
    f = problem.relieved(np.random.default_rng(0).standard_normal((problem.size, 2)))
    R = problem.rigid_modes
    rows = np.vstack((problem.stiffness.toarray(), (problem.mass @ R).T))
    exact = np.linalg.lstsq(rows, np.vstack((f, np.zeros((6, 2)))), rcond=None)[0]
    assert problem.solve(f) == pytest.approx(exact, rel=1e-8, abs=1e-10 * abs(exact).max())


@pytest.mark.parametrize("interfaces", SUPPORTS, ids=str)
def test_named_loads_and_given_forces_act_statically_exact(interfaces: dict) -> None:
    model = steel_beam(8)
    given = kf.LoadCase("push", np.random.default_rng(0).standard_normal(model.size))
    problem = problem_of(model, interfaces)
    names = ("gravity", "angular acceleration", "centrifugal", given)
    modes = tied_modes(problem, kf.CraigBampton(modes=1, loads=names))
    squares = np.einsum("ij,ij->j", modes, problem.stiffness @ modes)
    T = problem.ties.transformation.T
    R = model.rigid_modes()
    moved = 0.0
    for load in (given.forces, centrifugal_forces(model), model.mass @ R):
        forces = T @ load
        forces[problem.fixed] = 0.0
        exact = problem.solve(forces)
        left = modes @ ((modes.T @ forces) / squares[:, None]) - exact
        # a part of a shape below DEPENDENT of its size, in the norm of M, is left out; ten shapes may each lack one.
        # Inertia forces move a floating body by round-off only, which is measured by what the first load moves it
        size = masses_of(problem, exact).max()
        moved = moved or size
        assert masses_of(problem, left).max() < 10.0 * DEPENDENT * max(size, 1e-4 * moved)


def masses_of(problem: StaticProblem, shapes: np.ndarray) -> np.ndarray:
    """Return the norms of shapes by M."""
    return np.sqrt(np.einsum("ij,ij->j", shapes, problem.mass @ shapes))


@pytest.mark.parametrize("nodal", [False, True])
def test_centrifugal_forces_are_those_of_a_spin(nodal: bool) -> None:
    model = lattice_model(4, nodal=nodal)
    w = np.array([0.3, -1.2, 0.7])
    products = [w[a] * w[b] for a, b in PRODUCTS]
    field = -np.cross(w, np.cross(w, model.nodes)).reshape(-1)
    assert centrifugal_forces(model) @ products == pytest.approx(model.mass @ field, rel=1e-12)


def test_load_patterns_are_loads() -> None:
    model = lattice_model(2)
    shares = np.zeros(len(model.nodes))
    shares[3:6] = 0.1
    pressure = np.outer(shares, (0.0, 0.0, -1.0))
    pattern = NodalPattern.of_nodes(model.nodes, model.components, shares, pressure)
    loaded = kf.FiniteElementModel(**{**vars(model), "load_patterns": {"top": pattern}})
    body = flexible_body(loaded, CLAMPED, reduction=kf.CraigBampton(modes=0, loads=("top",)))
    assert body.provenance["reduction"]["load_vectors"] == {"top traction": 3, "top pressure": 1}
    assert body.free_count == 6 + 3  # the pressure is a traction along -z
    k = body.free_count
    traction = np.array([1.0, 0.3, -0.4])
    exact = problem_of(model, CLAMPED)
    forces = exact.ties.transformation.T @ (pattern.traction @ traction)
    forces[exact.fixed] = 0.0
    u = exact.ties.transformation @ exact.solve(forces[:, None])[:, 0]
    elastic = body.load_pattern("top").shape_first[:, :k].T @ traction
    assert body.basis[:, :k] @ np.linalg.solve(body.stiffness[:k, :k], elastic) == pytest.approx(u, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("frequency", [0.0, 15.0])
@pytest.mark.parametrize("order", [1, 2])
def test_krylov_matches_value_and_derivatives_at_its_frequency(frequency: float, order: int) -> None:
    # work of the loads on their own response: 2 order derivatives by w^2 agree, so its error falls with that power
    problem = problem_of(steel_beam(10), CLAMPED)
    modes = tied_modes(problem, kf.Krylov(frequencies=(frequency,), order=order, loads=("tip",)))
    squares = np.einsum("ij,ij->j", modes, problem.stiffness @ modes)
    moving = np.setdiff1d(np.arange(problem.size), problem.fixed)
    K, M = (m[moving][:, moving].toarray() for m in (problem.stiffness, problem.mass))
    forces = np.zeros((problem.size, 1))
    forces[problem.released[1]] = 1.0  # y at the tip; one load, so that the count of moments shows

    def error(s: float) -> float:
        exact = float(forces[moving, 0] @ np.linalg.solve(K - s * M, forces[moving, 0]))
        p = modes.T @ forces[:, 0]
        return abs(float(p @ (p / (squares - s))) - exact) / abs(exact)

    at = (2 * np.pi * frequency) ** 2
    assert error(at) < 1e-8  # round-off of a dense solve
    # Away from the natural frequencies, which are above both, by steps between round-off (1e-11) and the distance of
    # the first (16.7 Hz). Half the distance divides the error by 4 or 16; the next powers take less than 2 from that.
    step = (2 * np.pi * (6.0 if order == 1 else 17.0)) ** 2
    assert error(at - 0.5 * step) < error(at - step) / 2 ** (2 * order - 1)


def test_krylov_at_a_resonance_gives_the_mode() -> None:
    model = steel_beam(10, planar=True)
    exact = flexible_body(model, {"root": "clamped"}).frequencies[0]
    problem = problem_of(model, {"root": "clamped"})
    modes = tied_modes(problem, kf.Krylov(frequencies=(exact * (1 + 1e-6),), order=1, loads=("gravity",)))
    assert np.einsum("ij,ij->j", modes, problem.stiffness @ modes)[0] == pytest.approx(
        (2 * np.pi * exact) ** 2, rel=1e-6
    )


def test_effective_masses_add_up() -> None:
    model = steel_beam(12)
    body = flexible_body(model, {"root": "clamped"}, reduction=kf.CraigBampton(modes=72))
    table = body.provenance["reduction"]["effective_mass"]
    modes, total = np.array(table["modes"]), np.array(table["total"])
    # all modes: the whole mass but for what moves with the node of the clamp
    T = model.mass[6:][:, 6:].toarray()
    R = model.rigid_modes()
    loads = (model.mass @ R)[6:]
    held = np.einsum("ij,ij->j", loads, np.linalg.solve(T, loads))
    assert modes.sum(axis=0) == pytest.approx(held, rel=1e-8)
    assert np.all(modes.sum(axis=0) <= total * (1 + 1e-12))
    assert table["directions"][:3] == ["x", "y", "z"]
    # of a cantilever, 61.3 % of the mass are in the first bending mode (Euler-Bernoulli; this one is 30 times as long
    # as thick and has rotary inertia)
    assert modes[:, 1].max() / total[1] == pytest.approx(0.613, abs=5e-3)
    # the clamp is at G's origin, so its components are the directions
    assert np.array(table["interfaces"]["root"]["modes"]) == pytest.approx(modes, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kf.FreeInterface(), "either modes=<number> or up_to_frequency=<Hz>"),
        (lambda: kf.FreeInterface(modes=-1), "whole number >= 0, not -1"),
        (lambda: kf.Krylov(order=0), "order of Krylov must be 1 or more"),
        (lambda: kf.Krylov(frequencies=(-1.0,)), r"at least 0 Hz and finite, not -1\.0"),
        (lambda: kf.Krylov(frequencies=()), "one frequency at least"),
        (lambda: kf.Krylov(frequencies=5.0), r"must be a sequence in Hz, such as \(0\.0, 50\.0\), not 5\.0"),
        (lambda: kf.CraigBampton(modes=1, loads="gravity"), r"loads must be a sequence .* not 'gravity'"),
        (lambda: kf.CraigBampton(modes=1, loads=(np.zeros(3),)), r"not ndarray\. Remedy: LoadCase"),
        (lambda: kf.CraigBampton(modes=1, error_up_to=0.0), r"error_up_to must be above zero Hz and finite, not 0\.0"),
        (lambda: kf.CraigBampton(modes="all"), "whole number >= 0, not 'all'"),
        (lambda: kf.CraigBampton(modes="auto", up_to_frequency=5.0, tol=0.0), r"tol must be .* not 0\.0"),
        (lambda: kf.LoadCase("push", np.array([np.nan])), "forces of load case 'push' must be finite"),
    ],
)
def test_bad_options_are_named(make: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        make()


@pytest.mark.parametrize(
    ("loads", "message"),
    [
        (("wind",), "no load called 'wind'. There are: gravity, angular acceleration, centrifugal, root, tip"),
        (("root",), "'root' does not deform the body: it acts on nothing but components fixed in G"),
        ((kf.LoadCase("push", np.ones(5)),), "'push' has forces on 5 degrees of freedom, the model has 27. Remedy: 3"),
        ((kf.LoadCase("push", np.zeros(27)),), "'push' does not deform the body"),
    ],
)
def test_bad_loads_are_named(loads: tuple, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        flexible_body(lattice_model(0), CLAMPED, reduction=kf.CraigBampton(modes=1, loads=loads))


def test_more_free_modes_than_degrees_of_freedom_are_refused() -> None:
    with pytest.raises(ModelError, match="100 modes were asked of a body"):
        flexible_body(lattice_model(0), CLAMPED, reduction=kf.FreeInterface(modes=100))


def test_options_show_what_was_chosen() -> None:
    assert repr(kf.CraigBampton(modes=3)) == "CraigBampton(modes=3)"
    forces = np.zeros(6)
    assert repr(kf.LoadCase("a", forces)) == repr(kf.LoadCase("a", forces)) != repr(kf.LoadCase("a", forces + 1.0))
