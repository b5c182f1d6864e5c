"""The stiffest rate of large scenes: from a few products, as near as it has to be."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

import kanefe as kf
from kanefe.integrate.auto import stiffest_rate as rates
from kanefe.integrate.auto.largest_eigenvalue import CLOSE, ROUNDS, largest_eigenvalue
from kanefe.kane import assemble
from kanefe.literal.route import LiteralRoute
from kanefe.tree.tangents import constant_tangents


def trees(count: int, spring: bool) -> kf.System:
    """Return free bodies with a chain of ten links each, whose joints are damped and maybe sprung."""
    scene, rng = kf.System(gravity=(0, 0, -9.81)), np.random.default_rng(4)
    for i in range(count):
        body = scene.add_rigid_body(f"t{i}", 5.0, (0.1, 0.1, 0.05), joint=kf.Free(position=(float(i), 0, 1)))
        for j in range(10):
            given = kf.CoordinateForce(rng.uniform(1.0, 100.0) if spring else 0.0, damping=rng.uniform(0.1, 0.3))
            joint = kf.Revolute("xyz"[j % 3], position=0.1, forces=given)
            mass = rng.uniform(0.2, 1.0)
            body = scene.add_rigid_body(
                f"b{i}.{j}", mass, (0.01, 0.01, 0.005), com=(0, 0, -0.1), parent=body, at=(0.1, 0, -0.2), joint=joint
            )
    return scene


@pytest.mark.parametrize("spring", [False, True], ids=["dampers", "springs"])
def test_rate_by_sweeps_is_that_of_matrices(spring, monkeypatch):
    model = trees(4, spring).freeze()
    assert model.free_count > ROUNDS
    M = assemble.mass_at_start(model, 0.0)
    squares, decays = (scipy.linalg.eigh(X, M, eigvals_only=True)[-1] for X in constant_tangents(model))
    exact = max(np.sqrt(max(squares, 0.0)), decays)
    monkeypatch.setattr(LiteralRoute, "mass_at_start", None)  # no dense matrix is made
    assert exact * (1.0 - 3.0 * CLOSE) <= rates.stiffest_rate(model, 0.0) <= exact * (1.0 + 1e-9)


def test_rate_of_matrices_too_large_to_be_solved_at_once():
    model = trees(4, True).freeze()
    M, (K, C) = assemble.mass_at_start(model, 0.0), constant_tangents(model)
    exact = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)[-1])
    assert rates.highest_rate(model, 0.0, K, 0.0 * C) == pytest.approx(exact, rel=3.0 * CLOSE)


@pytest.mark.parametrize("rank", [1, 3, 200])
def test_largest_eigenvalue(rank):
    """One of few directions is found at once; one at the edge of a dense spectrum from below."""
    rng = np.random.default_rng(rank)
    A, B = rng.standard_normal((200, rank)), rng.standard_normal((200, 200))
    X, M = A @ A.T, B @ B.T + np.eye(200)
    exact = scipy.linalg.eigh(X, M, eigvals_only=True)[-1]
    found = largest_eigenvalue(lambda x: np.linalg.solve(M, X @ x), X.__matmul__, 200)
    assert exact * (1.0 - 3.0 * CLOSE) <= found <= exact * (1.0 + 1e-6)
    assert largest_eigenvalue(np.zeros_like, np.zeros_like, 200) == 0.0
