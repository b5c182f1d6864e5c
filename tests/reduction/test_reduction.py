"""Craig-Bampton reduction: what is kept, what it costs, what is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.fe_model.model import NodeGroup
from kanefe.fe_model.ties import tie_interfaces
from kanefe.reduction import flexible_body, splu_factorise
from scenes import lattice_body, lattice_model
from steel_beams import steel_beam

CLAMPED = {"root": "clamped", "tip": "rigid"}


def exact_frequencies(model: kf.FiniteElementModel, interfaces: dict, held: str) -> np.ndarray:
    """Return frequencies in Hz of all tied coordinates but those of the interfaces named in `held` (all components)."""
    ties = tie_interfaces(model, interfaces)
    K, M = ties.project(model.stiffness).toarray(), ties.project(model.mass).toarray()
    rows = [r for tie in ties.ties if tie.name in held.split() for r in tie.rows]
    kept = np.setdiff1d(np.arange(len(K)), rows)
    squares = scipy.linalg.eigh(K[np.ix_(kept, kept)], M[np.ix_(kept, kept)], eigvals_only=True)
    return np.sqrt(np.maximum(squares, 0)) / (2 * np.pi)


def test_modes_are_orthonormal_and_stiffness_is_diagonal() -> None:
    body = flexible_body(steel_beam(), CLAMPED, reduction=kf.CraigBampton(modes=8))
    k = body.free_count
    assert k == 8 + 6  # fixed-interface modes and the constraint modes of the tip
    K, M = body.stiffness[:k, :k], body.moments.elastic_mass[:k, :k]
    # eigenvectors of a pair whose squares span 1e7: M-orthonormal to 1e-16 times some hundred operations
    assert pytest.approx(np.eye(k), abs=1e-10) == M
    assert pytest.approx(np.diag(np.diag(K)), abs=1e-10 * K.max()) == K
    assert np.sqrt(np.diag(K)) / (2 * np.pi) == pytest.approx(body.frequencies, rel=1e-8)


def test_lowest_frequencies_are_those_of_the_whole_model() -> None:
    model = steel_beam()
    body = flexible_body(model, CLAMPED, reduction=kf.CraigBampton(modes=12))
    exact = exact_frequencies(model, CLAMPED, "root")
    # Craig-Bampton is Rayleigh-Ritz: never below, and the low half of the modes is good to some 1e-4
    assert np.all(body.frequencies >= exact[: body.free_count] * (1 - 1e-9))
    assert body.frequencies[:6] == pytest.approx(exact[:6], rel=1e-3)


def test_frequencies_fall_to_the_exact_ones_with_the_number_of_modes() -> None:
    model = steel_beam()
    exact = exact_frequencies(model, CLAMPED, "root")[:4]
    errors = [
        abs(flexible_body(model, CLAMPED, reduction=kf.CraigBampton(modes=n)).frequencies[:4] / exact - 1).max()
        for n in (0, 4, 8, 16)
    ]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 1e-3
    assert errors[-1] < 1e-4


def test_all_modes_keep_the_whole_model() -> None:
    model = lattice_model(1)
    full = flexible_body(model, CLAMPED)
    interior = tie_interfaces(model, CLAMPED).interior_count
    reduced = flexible_body(model, CLAMPED, reduction=kf.CraigBampton(modes=interior))
    assert reduced.free_count == full.free_count
    # the same space in another basis
    assert reduced.frequencies == pytest.approx(full.frequencies, rel=1e-10)


def test_static_deflection_under_interface_loads_is_exact_without_any_mode() -> None:
    # Constraint modes are static shapes: loads on the interface bend the body exactly.
    model = lattice_model(2)
    force = np.array([1.0, -2.0, 0.5, 0.1, 0.3, -0.2])
    motions = []
    for reduction in (None, kf.CraigBampton(modes=0)):
        body = flexible_body(model, CLAMPED, reduction=reduction)
        k = body.free_count
        tip = body.interface("tip").motion[:, :k]
        motions.append(tip @ np.linalg.solve(body.stiffness[:k, :k], tip.T @ force))
    assert motions[1] == pytest.approx(motions[0], rel=1e-10)


@pytest.mark.parametrize("size", [5, 80])  # LAPACK below 400 interior degrees of freedom, ARPACK above
@pytest.mark.parametrize("limit", [30.0, 500.0, 5000.0])
def test_modes_up_to_a_frequency(limit: float, size: int) -> None:
    model = steel_beam(size)
    body = flexible_body(model, CLAMPED, reduction=kf.CraigBampton(up_to_frequency=limit))
    held = exact_frequencies(model, CLAMPED, "root tip")
    assert body.free_count - 6 == np.sum(held <= limit)


def test_no_mode_below_the_frequency_leaves_the_constraint_modes() -> None:
    body = flexible_body(steel_beam(), CLAMPED, reduction=kf.CraigBampton(up_to_frequency=1e-3))
    assert body.free_count == 6


@pytest.mark.parametrize(
    "reduction",
    [kf.CraigBampton(modes=5), kf.CraigBampton(modes=40), kf.CraigBampton(up_to_frequency=20000.0)],
    ids=repr,
)
@pytest.mark.parametrize(
    "interfaces", [CLAMPED, {}, {"tip": "rigid"}], ids=["clamped", "floating", "floating with a tip"]
)
def test_one_factorisation_serves_everything(reduction: kf.CraigBampton, interfaces: dict) -> None:
    calls: list[tuple[int, int]] = []

    def counted(matrix: sp.csc_matrix) -> Any:
        calls.append(matrix.shape)
        return splu_factorise(matrix)

    flexible_body(steel_beam(100), interfaces, reduction=reduction, factorise=counted)
    assert len(calls) == 1


def test_nothing_is_factored_without_reduction() -> None:
    def never(matrix: sp.csc_matrix) -> Any:
        raise AssertionError("an unreduced body needs no factorisation")

    assert flexible_body(steel_beam(3), CLAMPED, factorise=never).free_count == 3 * 6


@pytest.mark.parametrize("reduction", [None, kf.CraigBampton(modes=6)], ids=str)
@pytest.mark.parametrize(("planar", "rigid"), [(False, 6), (True, 3)])
def test_floating_bodies_lose_exactly_their_rigid_modes(planar: bool, rigid: int, reduction: Any) -> None:
    model = lattice_model(3, planar=planar)
    body = flexible_body(model, {}, reduction=reduction)
    exact = exact_frequencies(model, {}, "")[rigid:]
    assert body.is_floating
    assert body.free_count == (model.size - rigid if reduction is None else 6)
    # of a free body the normal modes are exact, however few
    assert body.frequencies == pytest.approx(exact[: body.free_count], rel=1e-9)
    # and carry neither momentum nor moment of momentum: G follows the mean motion
    assert body.moments.shape_first == pytest.approx(np.zeros((3, body.free_count)), abs=1e-10)


def test_floating_body_with_interfaces_loses_the_rigid_part_of_its_constraint_modes() -> None:
    model = lattice_model(3)
    body = flexible_body(model, {"tip": "rigid", "root": "rigid"}, reduction=kf.CraigBampton(modes=4))
    assert body.free_count == 12 + 4 - 6
    assert body.frequencies[0] > 0.1
    assert body.frequencies[0] == pytest.approx(
        exact_frequencies(model, {"tip": "rigid", "root": "rigid"}, "")[6], rel=0.05
    )


def test_the_same_model_gives_the_same_body() -> None:
    # ARPACK's start vector is fixed
    one, two = (flexible_body(steel_beam(80), CLAMPED, reduction=kf.CraigBampton(modes=6)) for _ in range(2))
    assert np.array_equal(one.basis, two.basis)


def test_hinged_body_turns_about_its_point() -> None:
    # A hinge at the root and a rigid tip: the rotation is no mode of the structure, so it must be refused; with a
    # second hinge off the first and a third off their line nothing is left free.
    with pytest.raises(ModelError, match=r"interfaces fixed in G \(root\) leave 3 rigid motion"):
        lattice_body(0, {"root": "hinged", "tip": "rigid"})
    with pytest.raises(ModelError, match=r"leave 1 rigid motion.*Remedy: make one of them 'clamped'"):
        lattice_body(0, {"root": "hinged", "tip": "hinged"})
    body = lattice_body(0, {"root": "hinged", "tip": "hinged", "middle": "hinged"}, reduction=kf.CraigBampton(modes=1))
    assert body.fixed_count == 9
    assert body.free_count == 3 + 3 + 1  # the two frames that can turn, and a mode


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kf.CraigBampton(modes=3, up_to_frequency=10.0), "modes=<number> or up_to_frequency=<Hz>, one of them"),
        (lambda: lattice_body(0, reduction="auto!"), "reduction must be \"auto\", CraigBampton.* not 'auto!'"),
        (lambda: kf.CraigBampton(modes=-1), "whole number >= 0, not -1"),
        (lambda: kf.CraigBampton(modes=2.5), r"whole number >= 0, not 2\.5"),
        (lambda: kf.CraigBampton(up_to_frequency=-3.0), r"above zero Hz and finite, not -3\.0"),
        (lambda: kf.CraigBampton(up_to_frequency=np.inf), "above zero Hz and finite, not inf"),
        (
            lambda: lattice_body(0, reduction=kf.CraigBampton(modes=100)),
            "100 modes were asked of a body whose interior has 9 degrees of freedom. Remedy: fewer modes",
        ),
        (
            lambda: lattice_body(0, {}, reduction=kf.CraigBampton(modes=0)),
            r"nothing of the body is left once its 6 rigid motions are taken out: it floats\. Remedy: more modes",
        ),
        (
            lambda: lattice_body(
                0, {"root": "clamped", "tip": "clamped"}, interior=0, reduction=kf.CraigBampton(modes=1)
            ),
            "fixed in G: nothing is left to deform. Remedy: refine the mesh, or let an interface move",
        ),
    ],
)
def test_bad_input_is_named(make: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        make()


@pytest.mark.parametrize("interfaces", [CLAMPED, {"root": "rigid", "tip": "rigid"}], ids=["clamped", "floating"])
@pytest.mark.parametrize(
    "reduction",
    [kf.CraigBampton(modes=0), kf.CraigBampton(modes=3), kf.CraigBampton(modes="auto", up_to_frequency=1.0)],
    ids=str,
)
def test_a_body_that_is_all_interfaces_is_their_constraint_modes(interfaces: dict, reduction: kf.CraigBampton) -> None:
    """Nothing is reduced: the frequencies are those of the whole matrices, to round-off of the eigenvalues."""
    body, whole = (lattice_body(0, interfaces, interior=0, reduction=r) for r in (reduction, None))
    assert body.free_count == whole.free_count
    np.testing.assert_allclose(body.frequencies, whole.frequencies, rtol=1e-9)


@pytest.mark.parametrize("interfaces", [CLAMPED, {}], ids=["clamped", "floating"])
def test_a_loose_node_is_found(interfaces: dict) -> None:
    model = lattice_model(0)
    # one more node in the air, with mass but no spring
    nodes = np.vstack((model.nodes, [[0.4, 0.3, 0.3]]))
    K, M = (
        sp.block_diag((m, sp.csr_matrix(x * np.eye(3)))).tocsr() for m, x in ((model.stiffness, 0.0), (model.mass, 0.1))
    )
    loose = replace(model, nodes=nodes, stiffness=K, mass=M, mass_field=None)
    with pytest.raises(
        ModelError, match=r"Remedy: check the (mesh for loose parts|order of the nodes and the mesh for loose)"
    ):
        flexible_body(loose, interfaces, reduction=kf.CraigBampton(modes=1))


@pytest.mark.parametrize("reduction", [None, kf.CraigBampton(modes=3)], ids=str)
def test_a_floating_body_must_be_free(reduction: Any) -> None:
    model = lattice_model(0)
    wrong_order = replace(model, nodes=model.nodes[::-1].copy())
    grounded = replace(model, stiffness=model.stiffness + 0.5 * sp.identity(model.size, format="csr"))
    for wrong in (wrong_order, grounded):
        with pytest.raises(
            ModelError, match=r"K resists rigid motions of the nodes .* Remedy: check the order of the nodes"
        ):
            flexible_body(wrong, {}, reduction=reduction)


def test_a_body_of_massless_motions_is_refused() -> None:
    model = steel_beam(5)
    M = model.mass.toarray()
    M[3::6] = M[:, 3::6] = 0.0  # torsion carries no mass
    twisted = {"root": "clamped", "tip": kf.Interface(("x", "y", "z", "ry", "rz"), kind="node")}
    with pytest.raises(ModelError, match="no motion that the reduction keeps has mass"):
        flexible_body(replace(model, mass=sp.csr_matrix(M)), twisted, reduction=kf.CraigBampton(modes=0))


def test_provenance_says_what_was_done() -> None:
    body = lattice_body(0, reduction=kf.CraigBampton(modes=2), damping=kf.ModalDamping(0.02))
    assert body.provenance["reduction"]["method"] == "CraigBampton(modes=2)"
    assert body.provenance["damping"] == "ModalDamping(ratio=0.02)"
    assert body.provenance["reduction_seconds"] > 0


def test_arrays_are_frozen() -> None:
    body = lattice_body(0)
    for array in (body.nodes, body.basis, body.stiffness, body.moments.first, body.interface("tip").motion):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


def test_the_model_stays_writable_and_unchanged() -> None:
    model = lattice_model(0)
    before = model.stiffness.copy(), model.mass.copy(), model.nodes.copy()
    flexible_body(model, CLAMPED, reduction=kf.CraigBampton(modes=2))
    model.nodes[0, 0] += 0.0
    model.mass.data[0] += 0.0
    model.mass_field.mass.data[0] += 0.0
    model.mass_field.points[0] += 0.0
    model.groups["root"].position[0] += 0.0
    assert abs(model.stiffness - before[0]).max() == 0.0
    assert abs(model.mass - before[1]).max() == 0.0
    assert np.array_equal(model.nodes, before[2])


def test_groups_may_overlap_as_long_as_interfaces_do_not() -> None:
    model = lattice_model(0)
    groups = {**model.groups, "other": NodeGroup(model.groups["tip"].nodes, np.zeros(3))}
    body = flexible_body(replace(model, groups=groups), CLAMPED)
    assert [f.name for f in body.interfaces] == ["root", "tip"]
