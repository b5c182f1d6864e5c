"""Unreduced bodies with coordinates without mass, such as rotations about the normals of shells."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
import kanefe.reduction.build as reduction_body
from kanefe.bodies.unreduced import UnreducedBody
from kanefe.fe_model.model import FiniteElementModel
from kanefe.reduction import flexible_body
from kanefe.unreduced.mass_solver import mass_solver
from kanefe_fem import Material, shell_model, surface_mesh

pytestmark = pytest.mark.fenicsx

INTERFACES = {"root": "clamped", "tip": "average"}


def shell() -> FiniteElementModel:
    """Return a curved strip: normals are along no axis."""
    mesh = surface_mesh(lambda s, r: (0.5 * s, 0.2 * np.sin(1.2 * (r - 0.5)), 0.2 * np.cos(1.2 * (r - 0.5))), (3, 2))
    return shell_model(mesh, Material(E=210e9, nu=0.3, rho=7850.0), 2e-3)


def test_a_shell_without_reduction_is_that_with_all_modes(monkeypatch):
    model, damping = shell(), kf.RayleighDamping(stiffness=2e-5)
    bodies = []
    for limit in (0, 10**6):
        monkeypatch.setattr(reduction_body, "LARGEST_DENSE", limit)
        bodies.append(flexible_body(model, INTERFACES, damping=damping))
    sparse, dense = bodies
    assert isinstance(sparse, UnreducedBody)
    assert len(sparse.massless) == sparse.free_count - dense.free_count > 20
    np.testing.assert_allclose(sparse.frequencies[:6], dense.frequencies[:6], rtol=1e-7)
    ends = []
    for body in bodies:
        scene = kf.System(gravity=(0.0, 0.0, 0.0))  # a smooth start
        hub = scene.add_rigid_body("hub", 2.0, 0.01, joint=kf.Revolute("z"))
        scene.add_flexible_body("sheet", body, parent=hub, at=(0.1, 0.0, 0.0))
        scene.add_torque(hub, lambda t: 10.0 * np.sin(20.0 * np.pi * t) ** 2)
        result = scene.simulate((0.0, 0.02), method="generalised-alpha", rtol=1e-7)
        ends.append(np.concatenate((result.position("sheet", "tip")[-1], result.coupling_force("sheet", "root")[-1])))
    np.testing.assert_allclose(ends[0][:3], ends[1][:3], atol=1e-6)  # of its own steps
    np.testing.assert_allclose(ends[0][3:], ends[1][3:], atol=2e-3 * abs(ends[1][3:]).max())


def test_what_has_no_mass_is_moved_statically(monkeypatch):
    """Accelerations are those of Guyan's condensation, which is exact where there is no mass."""
    monkeypatch.setattr(reduction_body, "LARGEST_DENSE", 0)
    body = flexible_body(shell(), INTERFACES)
    force = np.random.default_rng(1).standard_normal(body.free_count)
    found = mass_solver(body).solve(force)
    none = body.massless
    has = np.setdiff1d(np.arange(body.free_count), none)
    K, M = body.free_stiffness.toarray(), body.free_mass.toarray()
    T = np.zeros((body.free_count, len(has)))
    T[has, range(len(has))] = 1.0
    T[none] = -np.linalg.solve(K[np.ix_(none, none)], K[np.ix_(none, has)])
    expected = T @ np.linalg.solve(T.T @ M @ T, T.T @ force)
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-9 * abs(expected).max())
    assert not M[none].any()
