"""Lumped mass matrices leave rotations without mass: reduction takes them, and the inertia is exact."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import AccuracyWarning, ModelError, SimulationError
from kanefe.frames import skew
from kanefe.imports.nodal_inertia import NodalFormWarning
from steel_beams import steel_beam


def lumped(elements: int, about_axis: float = 0.0) -> kf.FiniteElementModel:
    beam = steel_beam(elements)
    shares = np.ones(elements + 1)
    shares[[0, -1]] = 0.5
    mass = sp.diags(np.kron(shares * 4.71 / elements, (1, 1, 1, about_axis, 0, 0)))
    ends = {"root": 0, "tip": elements}
    return kf.model_from_matrices(mass, beam.stiffness, beam.nodes, components=beam.components, groups=ends)


def condensed_frequencies(model: kf.FiniteElementModel, held: int) -> np.ndarray:
    """Oracle: the massless rotations by static condensation, dense."""
    K, M = model.stiffness.toarray()[held:, held:], model.mass.diagonal()[held:]
    heavy, light = M > 0, M == 0
    coupling = K[np.ix_(heavy, light)]
    S = K[np.ix_(heavy, heavy)] - coupling @ np.linalg.solve(K[np.ix_(light, light)], coupling.T)
    squares = scipy.linalg.eigh(S, np.diag(M[heavy]), eigvals_only=True)
    return np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)


# from 400 rows on the modes come from a Krylov space
@pytest.mark.parametrize("elements", [8, 80])
def test_modes_of_a_clamped_and_of_a_floating_bar(elements: int) -> None:
    model = lumped(elements)
    held = kf.flexible_body(model, {"root": "clamped"}, reduction=kf.CraigBampton(modes=5))
    assert held.is_exact
    # K of 80 elements has a condition of 1e9
    assert held.frequencies == pytest.approx(condensed_frequencies(model, 6)[:5], rel=1e-6)
    turning = lumped(elements, about_axis=1e-4)
    free = kf.flexible_body(turning, {}, reduction=kf.CraigBampton(modes=5))
    assert free.frequencies == pytest.approx(condensed_frequencies(turning, 0)[6:11], rel=1e-4)


SPUN = "has no inertia about .1.0, 0.0, 0.0. through .0.5, 0.0, 0.0. m: some joint or loop must hold this turn"


@pytest.mark.parametrize("elements", [8, 80])
def test_a_floating_bar_without_inertia_about_its_axis_has_its_elastic_modes(elements: int) -> None:
    model = lumped(elements)
    with pytest.warns(AccuracyWarning, match=SPUN):
        body = kf.flexible_body(model, {}, reduction=kf.CraigBampton(modes=5))
    # the turn of the whole is held at one node, where nothing turns it
    K, M = model.stiffness.toarray(), model.mass.toarray()
    K[3, 3] *= 2
    one = replace(model, stiffness=sp.csr_matrix(K), mass=sp.csr_matrix(M))
    assert body.frequencies == pytest.approx(condensed_frequencies(one, 0)[5:10], rel=1e-4)
    scene = kf.System()
    scene.add_flexible_body("bar", body, joint=kf.Free())
    with pytest.raises(SimulationError, match="nothing has inertia along bar: wx"):
        scene.simulate((0.0, 0.1))


REDUCTIONS = [None, kf.CraigBampton(modes=5), kf.FreeInterface(modes=5), kf.Krylov(), kf.Krylov(loads=("gravity",))]


@pytest.mark.parametrize("reduction", REDUCTIONS, ids=repr)
def test_what_a_massless_twist_loses_is_named(reduction: Any) -> None:
    model = lumped(8)
    with pytest.warns(AccuracyWarning) as told:
        body = kf.flexible_body(model, {"root": "clamped", "tip": "node"}, reduction=reduction)
    assert any("tip rx (100 %)" in str(one.message) for one in told)
    assert body.provenance["reduction"]["without_mass"]["tip rx"] == pytest.approx(1.0)
    # all shapes hold the first modes of bending; those of five columns to a few per cent
    assert body.frequencies[:2] == pytest.approx(condensed_frequencies(model, 6)[:2], rel=0.01)


def test_all_freedoms_are_condensed() -> None:
    model = lumped(8)
    with pytest.warns(AccuracyWarning, match="a joint there that turns or slides has no inertia of its own"):
        body = kf.flexible_body(model, {"root": "clamped"})
    # round-off of K over its lowest eigenvalue
    assert body.frequencies == pytest.approx(condensed_frequencies(model, 6), rel=1e-8)
    assert body.free_count == 24


def test_masses_beside_their_nodes_have_massless_turns_too() -> None:
    """The mass of offset nodes couples turns and displacements: no row of M is empty, and yet M is singular."""
    beam, arm = steel_beam(6), np.array((0.0, 0.02, 0.05))
    follow = np.hstack((np.eye(3), -skew(arm)))
    mass = sp.block_diag([0.5 * follow.T @ follow] * 7, format="csr")
    model = kf.model_from_matrices(mass, beam.stiffness, beam.nodes, components=beam.components, groups={"root": 0})
    body = kf.flexible_body(model, {"root": "clamped"})
    inverse = scipy.linalg.eigvalsh(mass.toarray()[6:, 6:], model.stiffness.toarray()[6:, 6:])[::-1][:18]
    assert body.frequencies == pytest.approx(1 / np.sqrt(inverse) / (2 * np.pi), rel=1e-7)


@pytest.mark.parametrize("interfaces", [{}, {"root": "clamped", "tip": "node"}], ids=["floating", "held"])
def test_a_superelement_without_rotary_inertia(interfaces: dict[str, str]) -> None:
    model = lumped(10)
    K, M = model.stiffness.toarray(), model.mass.toarray()
    ends, rest = np.r_[:6, 60:66], np.arange(6, 60)
    shapes = np.zeros((66, 16))
    shapes[ends, range(12)] = 1.0
    shapes[rest, :12] = -np.linalg.solve(K[np.ix_(rest, rest)], K[np.ix_(rest, ends)])
    held = kf.flexible_body(model, {"root": "clamped", "tip": kf.Interface("all", kind="node")})
    shapes[:, 12:] = held.basis[:, :4]
    with pytest.warns(NodalFormWarning):
        reduced = kf.model_from_matrices(
            shapes.T @ M @ shapes,
            shapes.T @ K @ shapes,
            model.nodes[[0, 10]],
            components=model.components,
            generalised=4,
            groups={"root": 0, "tip": 1},
        )
    with pytest.warns(AccuracyWarning, match=r"tip rx \(100 %\)" if interfaces else SPUN):
        body = kf.flexible_body(reduced, interfaces)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)
        whole = kf.flexible_body(model, interfaces, reduction=kf.CraigBampton(modes=6)).frequencies[:2]
    assert body.frequencies[:2] == pytest.approx(whole, rel=0.01)  # four modes inside beside the static shapes


def test_more_modes_than_masses_are_refused() -> None:
    with pytest.raises(ModelError, match=r"only 24 degrees of freedom have mass|fewer modes"):
        kf.flexible_body(lumped(8), {"root": "clamped"}, reduction=kf.CraigBampton(modes=30))


@pytest.mark.parametrize("ends", [{}, {"root": "clamped", "tip": "rigid"}], ids=["floating", "clamped"])
@pytest.mark.parametrize("about_axis", [0.0, 1e-4])
@pytest.mark.filterwarnings("ignore::kanefe.errors.AccuracyWarning", "ignore::kanefe.errors.UnitWarning")
def test_what_has_mass_does_not_depend_on_the_size_of_a_body(ends: dict[str, str], about_axis: float) -> None:
    beam = lumped(8, about_axis)

    def frequencies(size: float) -> np.ndarray:
        """With lengths times the size, and moduli times its square."""
        scale = sp.diags(np.tile(np.repeat((1.0, size), 3), len(beam.nodes)) * size**1.5).tocsr()
        mass, stiffness = scale @ beam.mass @ scale, scale @ beam.stiffness @ scale
        groups = {"root": 0, "tip": 8}
        one = kf.model_from_matrices(mass, stiffness, size * beam.nodes, components=beam.components, groups=groups)
        return kf.flexible_body(one, ends, reduction=kf.CraigBampton(modes=5)).frequencies

    # K has a condition of 1e6
    assert frequencies(1e-6) == pytest.approx(frequencies(1.0), rel=1e-8)
