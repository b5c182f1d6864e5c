"""Bodies with a made-up second-order displacement ``u_a = 1/2 eta^T (A_a + X_b B_ab) eta`` of all their points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import kanefe as kf


def second_order_field(body: kf.FlexibleBody, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return A (3, K, K) and B (3, 3, K, K), B_ab of component a and coordinate b: as strong as foreshortening.

    They are products of displacements of nodes over the length of the body, the same whatever its coordinates are.
    """
    rng = np.random.default_rng(seed)
    length = np.ptp(body.nodes, axis=0).max()
    rows = body.basis[rng.choice(len(body.basis), 8)]

    def products(*shape: int) -> np.ndarray:
        weights = rng.standard_normal((*shape, 8, 8)) / len(rows)
        return np.asarray(rows.T @ (weights + weights.swapaxes(-1, -2)) @ rows / length)

    return products(3), products(3, 3) / length


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
        moved = A + np.einsum("b,abij->aij", frame.position, B)
        turned = np.einsum("ab,bij->aij", rng.standard_normal((3, 3)), A) / np.ptp(body.nodes, axis=0).max()
        quadratic = np.concatenate((moved, turned))
        # what is fixed in G stays where it is, as in bodies with stiffening="full"
        along = np.kron(np.eye(2), frame.axes)
        own = np.tensordot(along.T, quadratic, axes=1)
        own[list(frame.fixed_components)] = 0.0
        frames.append(replace(frame, quadratic=np.tensordot(along, own, axes=1)))
    patterns = tuple(
        replace(p, quadratic_first=p.measure * A + np.einsum("b,abij->aij", p.first, B)) for p in body.load_patterns
    )
    return replace(body, moments=moments, interfaces=tuple(frames), load_patterns=patterns)
