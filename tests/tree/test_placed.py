"""Frames that move in frames that move: their velocities are the rates of where they are."""

from __future__ import annotations

import numpy as np

from kanefe.frames import rotation_about, rotation_matrix
from kanefe.tree.placed import Placed, moving_in

STEP = 1e-4


def vector(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(3)


def turned(w: np.ndarray, t: float) -> np.ndarray:
    return rotation_matrix(rotation_about(w, float(np.linalg.norm(w)) * t))


def test_velocities_in_a_moving_frame_are_rates_of_places() -> None:
    """Both frames turn about axes that stay, so that all is known in closed form at any time."""
    p_F, v_F, w_F, p, v, w = (vector(seed) for seed in range(6))

    def at(t: float) -> Placed:
        A = turned(w_F, t)
        F = Placed(A, p_F + t * v_F, A.T @ v_F, A.T @ w_F)
        return moving_in(F, p + t * v, turned(w, t), v, w)

    before, now, after = (at(t) for t in (0.3 - STEP, 0.3, 0.3 + STEP))
    # differences of order 2 of motions whose third derivatives are about 100
    rate = (after.p_NoFo_N - before.p_NoFo_N) / (2.0 * STEP)
    np.testing.assert_allclose(now.A_NF @ now.v, rate, rtol=0, atol=1e-6)
    spin = now.A_NF.T @ (after.A_NF - before.A_NF) / (2.0 * STEP)
    np.testing.assert_allclose((spin[2, 1], spin[0, 2], spin[1, 0]), now.w, rtol=0, atol=1e-6)
