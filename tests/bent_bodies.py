"""Bodies with a made-up second-order displacement ``u_a = 1/2 eta^T (A_a + X_b B_ab) eta`` of all their points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import kanefe as kf


def second_order_field(body: kf.FlexibleBody, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return A (3, K, K) and B (3, 3, K, K), B_ab of component a and coordinate b: as strong as foreshortening."""
    rng = np.random.default_rng(seed)
    K = body.count
    length = np.ptp(body.nodes, axis=0).max()
    motion = abs(body.basis).max(axis=0)
    size = np.outer(motion, motion) / length
    A, B = rng.standard_normal((3, K, K)), rng.standard_normal((3, 3, K, K)) / length
    return size * (A + A.swapaxes(-1, -2)) / K, size * (B + B.swapaxes(-1, -2)) / K


def bent(body: kf.FlexibleBody, seed: int = 0, strength: float = 1.0) -> kf.FlexibleBody:
    """Return the body with the moments, interfaces and surfaces of such a field."""
    A, B = (strength * X for X in second_order_field(body, seed))
    rng = np.random.default_rng(seed + 1)
    generalised, _ = body.moments.leading(0).terms(np.zeros(0), np.zeros(0), np.zeros(3))
    mass, first = body.mass, body.mass * body.center_of_mass
    inertia = generalised[3:6, 3:6]
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    moments = replace(
        body.moments,
        quadratic_first=mass * A + np.einsum("b,abij->aij", first, B),
        quadratic_second=np.einsum("a,bij->abij", first, A) + np.einsum("ac,bcij->abij", second, B),
    )
    frames = []
    for frame in body.interfaces:
        turn = rng.standard_normal((3, body.count, body.count)) * np.max(abs(A)) / np.ptp(body.nodes, axis=0).max()
        moved = A + np.einsum("b,abij->aij", frame.position, B)
        frames.append(replace(frame, quadratic=np.concatenate((moved, turn + turn.swapaxes(-1, -2)))))
    patterns = tuple(
        replace(p, quadratic_first=p.measure * A + np.einsum("b,abij->aij", p.first, B)) for p in body.load_patterns
    )
    return replace(body, moments=moments, interfaces=tuple(frames), load_patterns=patterns)
