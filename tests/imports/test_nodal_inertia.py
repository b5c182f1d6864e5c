"""Inertia of imported bodies whose nodes rotate: exact by M and K where they tell it, else with a part that is told."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from kanefe.bodies.mass_moments import MassMoments
from kanefe.errors import AccuracyWarning, ModelError
from kanefe.fe_model.model import FiniteElementModel
from kanefe.frames import skew
from kanefe.imports.nodal_inertia import NodalFormWarning
from kanefe.integrate.run import integrate
from kanefe.kane.assemble import accelerations
from kanefe.kane.energy import elastic_energy, kinetic_energy, momenta
from kanefe.order_n.route import OrderN
from kanefe.states.state import State
from kanefe_fem import Material, Rectangle, shell_model, straight_beam, surface_mesh
from order_n_rates import order_n
from scenes import random_state
from steel_beams import steel_beam

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)

NAMES = ("mass", "first", "second", "shape_first", "shape_second", "shape_product")


def shell() -> FiniteElementModel:
    surface = surface_mesh(lambda s, r: (s, 0.05 * np.cos(np.pi * r), -0.05 * np.sin(np.pi * r)), (4, 3))
    return shell_model(surface, STEEL, thickness=1.5e-3, offset=0.3)


MODELS = {
    "shell": shell,
    "beam": lambda: steel_beam(6),
    "thick beam": lambda: straight_beam(1.0, Rectangle(0.1, 0.2), STEEL, elements=4),
    "plane beam": lambda: straight_beam(1.0, Rectangle(0.02, 0.01), STEEL, elements=4, planar=True),
}


def imported(model: FiniteElementModel, **options: Any) -> FiniteElementModel:
    """The model from its matrices alone."""
    groups = {name: group.nodes.tolist() for name, group in model.groups.items()}
    return kf.model_from_matrices(
        model.mass, model.stiffness, model.nodes, components=model.components, groups=groups, **options
    )


def moments(model: FiniteElementModel, by: FiniteElementModel) -> MassMoments:
    """Of the first 14 motions of another one's K, rigid ones among them."""
    basis = np.linalg.eigh(by.stiffness.toarray())[1][:, :14]
    field = model.mass_field
    assert field is not None
    return MassMoments.of_points(field.points, field.mass, field.interpolation @ basis)


def differences(ours: MassMoments, theirs: MassMoments) -> dict[str, float]:
    return {
        name: float(np.abs(getattr(ours, name) - getattr(theirs, name)).max() / np.abs(getattr(theirs, name)).max())
        for name in NAMES
    }


@pytest.mark.parametrize("name", MODELS)
def test_matrices_tell_the_inertia_of_shells_and_beams(name: str) -> None:
    """All moments are those of the shape functions, which the matrices alone do not show."""
    model = MODELS[name]()
    with warnings.catch_warnings():
        warnings.simplefilter("error", NodalFormWarning)
        given = imported(model)
    assert max(differences(moments(given, model), moments(model, model)).values()) < 1e-9


def test_a_lumped_mass_with_rotary_inertia_is_a_rigid_part() -> None:
    """A node's block of a mass of 2 kg at an arm, with own inertia, is one of points that turn with it."""
    beam, arm = steel_beam(6), np.array((0.0, 0.02, 0.05))
    follow = np.hstack((np.eye(3), -skew(arm)))
    block = 2.0 * follow.T @ follow + np.diag((0, 0, 0, 1e-3, 2e-3, 2.5e-3))
    given = imported(replace(beam, mass=sp.block_diag([block] * 7, format="csr")))
    found = moments(given, beam)
    assert found.mass == pytest.approx(14.0)
    shape = np.linalg.eigh(beam.stiffness.toarray())[1][:, 7].reshape(7, 6)
    # D = sum (x + arm) (u + theta x arm) m + S theta~, S the second moments of the inertia of a part
    J = block[3:, 3:] - 2.0 * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    S = 0.5 * np.trace(J) * np.eye(3) - J
    expected = sum(
        2.0 * np.outer(x + arm, q[:3] + np.cross(q[3:], arm)) + S @ skew(q[3:]).T
        for x, q in zip(beam.nodes, shape, strict=True)
    )
    np.testing.assert_allclose(found.shape_second[:, :, 7], expected, atol=1e-12 * np.abs(expected).max())


def test_a_mass_without_rotary_inertia_says_so() -> None:
    beam = steel_beam(6)
    given = imported(replace(beam, mass=sp.diags(np.tile((1.0, 1.0, 1.0, 0.0, 0.0, 0.0), 7)).tocsr()))
    (told,) = given.provenance["told"]
    assert "no rotary inertia: bending waves of length L in sections of thickness t are 1.6 (t/L)^2 too fast" in told
    assert "told" not in imported(beam).provenance


def test_what_m_does_not_tell_is_estimated_with_exact_momenta_within_its_share(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beams whose elements are not looked for: what is told falls with the mesh, and is above the errors."""
    monkeypatch.setattr("kanefe.imports.nodal_inertia.slender_elements", lambda *_: None)
    shares = []
    for elements in (2, 4, 8):
        model = straight_beam(1.0, Rectangle(0.02, 0.01), STEEL, elements=elements)
        with pytest.warns(NodalFormWarning, match=r"[\d.e-]+ is estimated"):
            given = imported(model)
        assert given.mass_field is not None
        assert abs(given.mass_field.mass_matrix() - model.mass).max() < 1e-13 * abs(model.mass).max()
        shares.append(given.provenance["estimated_inertia"])
        ours, theirs = moments(given, model), moments(model, model)
        found = differences(ours, theirs)
        assert max(found["mass"], found["first"], found["second"], found["shape_first"]) < 1e-10
        turning = ours.shape_second - np.swapaxes(ours.shape_second, 0, 1)
        exact = theirs.shape_second - np.swapaxes(theirs.shape_second, 0, 1)
        np.testing.assert_allclose(turning, exact, atol=1e-10 * np.abs(theirs.shape_second).max())
        assert max(found.values()) < shares[-1]
    assert shares[0] > 2.5 * shares[1] > 6.0 * shares[2]


@pytest.mark.parametrize("exact", [True, False])
def test_free_flight_keeps_momenta_and_energy_in_order_n(exact: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where a part is estimated; accelerations are those of the literal route, by the points of the field."""
    if not exact:
        monkeypatch.setattr("kanefe.imports.nodal_inertia.slender_elements", lambda *_: None)
    with warnings.catch_warnings():
        warnings.simplefilter("error" if exact else "ignore", NodalFormWarning)
        given = imported(steel_beam(6))
    body = kf.flexible_body(given, {}, reduction=kf.CraigBampton(modes=4))
    scene = kf.System()
    scene.add_flexible_body("beam", body, joint=kf.Free())
    model = scene.freeze()
    q, u = random_state(model, 1, amplitude=0.02, speed=0.5)
    compare(model, q, u)
    run = integrate(
        replace(model, initial_coordinates=q, initial_speeds=u),
        (0.0, 0.05),
        rtol=1e-11,
        method="dop853",
        output_step=0.025,
    )
    assert isinstance(model.route, OrderN)
    kept = []
    for at, speeds in zip(run.coordinates, run.speeds, strict=True):
        state = State(model, 0.0, at, speeds)
        kept.append(np.concatenate(([kinetic_energy(state) + elastic_energy(state)], *momenta(state))))
    np.testing.assert_allclose(kept, np.tile(kept[0], (len(kept), 1)), rtol=1e-8, atol=1e-9 * np.abs(kept[0]).max())


def compare(model: kf.Model, q: np.ndarray, u: np.ndarray) -> None:
    """Order n against the literal route, to round-off of a stiff body."""
    du = accelerations(State(model, 0.0, q, u))
    rates = order_n(model).held_rates(0.0, np.concatenate((q, u, np.zeros(2))))[0][len(q) : len(q) + len(u)]
    np.testing.assert_allclose(rates, du, rtol=0, atol=1e-9 * np.abs(du).max())


def test_elements_that_resist_a_rigid_turn_are_told_with_their_size() -> None:
    """A node that is a little off its element, as a warped quadrangle's corner."""
    beam = steel_beam(6)
    nodes = beam.nodes.copy()
    nodes[3, 1] += 4e-5
    with pytest.warns(AccuracyWarning, match=r"resisted by [\d.]+ N m, and translations are free.*make up [\d.e-]+ of"):
        kf.model_from_matrices(beam.mass, beam.stiffness, nodes, components=beam.components)
    nodes[3, 1] += 2e-2
    with pytest.raises(ModelError, match=r"[\d.e-]+ of the first squared frequency is of warped quadrangles"):
        kf.model_from_matrices(beam.mass, beam.stiffness, nodes, components=beam.components)
