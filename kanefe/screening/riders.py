"""The bodies on a carrier: conversion of their states to motions relative to the carrier at rest, and back.

A motion is described by tangents xi, one for each free speed, from a configuration q0 on the carrier at rest:
displacements, angles, modal coordinates, and rotation vectors of free joints. ``q = q0 (+) xi``, ``u = T(xi) dxi/dt``,
both then displaced with the carrier.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector, euler_parameters_from_matrices, multiply, rotation_matrix
from kanefe.screening.carrier import Carrier, Displacement
from kanefe.tree.body_terms import BodyTerms

OUT_OF_PLANE = 1e-9
"""Largest component of a carrier's axes, dimensionless, outside the plane of a planar joint on the ground."""


class Motions(NamedTuple):
    """Tangents and their rates at some times, (T, free) each."""

    xi: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray

    def __add__(self, other: Motions) -> Motions:  # type: ignore[override]
        return Motions(*(a + b for a, b in zip(self, other, strict=True)))


class Riders:
    """All bodies but the carrier.

    Parameters
    ----------
    model : Model
    carrier : Carrier

    Raises
    ------
    ModelError
        If a body is connected to the ground by a constraining joint, so that it is not carried.
    """

    def __init__(self, model: Model, carrier: Carrier) -> None:
        self.count = model.free_count
        self.roots = [body for body in model.bodies if body.parent == -1 and body is not carrier.body]
        for body in self.roots:
            if not body.joint.holds_floating or body.is_driven:
                raise ModelError(
                    f"{body.name!r} is connected to the ground by a {body.joint.kind} joint, and does not move with "
                    f"{carrier.body.name!r}. Remedy: connect it to {carrier.body.name!r}, or give it a free joint, or "
                    "a planar one in its plane; else kf.System.simulate"
                )
        # place of each tangent in q; -1: rotation by Euler parameters
        self.places = np.full(self.count, -1)
        self.turning: list[BodyTerms] = []
        for body in model.bodies:
            if body.flexible is not None:
                terms = body.flexible
                self.places[terms.speeds] = np.arange(terms.eta.start, terms.eta.stop)
            at, speeds = body.free_coordinates()
            first = body.joint.rotation_at
            if first is not None and len(at):
                self.turning.append(body)
                at, speeds = np.delete(at, range(first, first + 4)), np.delete(speeds, range(first, first + 3))
            self.places[speeds] = at

    def absolute(
        self, moved: Displacement, q0: Vector, motions: Motions
    ) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
        """Return q (T, coordinates) and u (T, free) of motions from q0 on the carrier, and rotations of free bodies."""
        q = np.repeat(q0[None], len(moved.x), axis=0)
        is_plain = self.places >= 0
        q[:, self.places[is_plain]] += motions.xi[:, is_plain]
        u, turns = motions.rate.copy(), {}
        for body in self.turning:
            at, s = _rotation(body)
            q[:, at] = multiply(q0[at][None], _parameters(motions.xi[:, s]))
            u[:, s] = _spun(motions.xi[:, s], motions.rate[:, s])
            turns[body.name] = _matrices(q[:, at])
        for body in self.roots:
            at, s = body.coordinates, body.speeds
            seen = moved.seen_from(body.p_PoFo_P, body.A_PF)
            place, rate = np.zeros((len(q), 3)), np.zeros((len(q), 3))
            axes = _axes(body)
            place[:, :axes], rate[:, :axes] = q[:, at[:axes]], u[:, s[:axes]]
            carried = seen.x + np.einsum("tij,tj->ti", seen.R, place)
            going = seen.v + np.einsum("tij,tj->ti", seen.R, np.cross(seen.w, place) + rate)
            q[:, at[:axes]], u[:, s[:axes]] = carried[:, :axes], going[:, :axes]
            if axes == 3:
                q[:, at[3:]] = multiply(_euler(seen.R), q[:, at[3:]])
                u[:, s[3:]] += np.einsum("tji,tj->ti", turns[body.name], seen.w)
            else:
                self._check_plane(body, seen)
                q[:, at[2]] += np.unwrap(np.arctan2(seen.R[:, 1, 0], seen.R[:, 0, 0]))
                u[:, s[2]] += seen.w[:, 2]
        return q, u, turns

    def accelerations(
        self, moved: Displacement, q0: Vector, motions: Motions, turns: dict[str, np.ndarray], du: np.ndarray
    ) -> np.ndarray:
        """Convert accelerations du of the scene to those of the tangents, (T, free)."""
        found = du.copy()
        for body in self.roots:
            at, s = body.coordinates, body.speeds
            seen = moved.seen_from(body.p_PoFo_P, body.A_PF)
            axes = _axes(body)
            place, rate, gone = (np.zeros((len(du), 3)) for _ in range(3))
            place[:, :axes] = q0[at[:axes]] + motions.xi[:, s[:axes]]
            rate[:, :axes], gone[:, :axes] = motions.rate[:, s[:axes]], du[:, s[:axes]]
            gone = np.einsum("tji,tj->ti", seen.R, gone - seen.a)
            gone -= np.cross(seen.dw, place) + np.cross(seen.w, np.cross(seen.w, place)) + 2.0 * np.cross(seen.w, rate)
            found[:, s[:axes]] = gone[:, :axes]
            if axes == 2:
                found[:, s[2]] -= seen.dw[:, 2]
                continue
            w, dw = (np.einsum("tji,tj->ti", turns[body.name], item) for item in (seen.w, seen.dw))
            found[:, s[3:]] += np.cross(_spun(motions.xi[:, s[3:]], motions.rate[:, s[3:]]), w) - dw
        for body in self.turning:
            _, s = _rotation(body)
            theta, rate = motions.xi[:, s], motions.rate[:, s]
            # u = T(theta) dtheta/dt: the rate of T along it by a central difference, exact to 1e-9 of a small term
            step = 1e-4
            changing = (_spun(theta + step * rate, rate) - _spun(theta - step * rate, rate)) / (2.0 * step)
            T = np.stack([_spun(theta, np.broadcast_to(axis, theta.shape)) for axis in np.eye(3)], axis=2)
            found[:, s] = np.linalg.solve(T, (found[:, s] - changing)[:, :, None])[:, :, 0]
        return found

    def relative(self, moved: Displacement, q: Vector, u: Vector) -> tuple[Vector, Vector]:
        """Return the state relative to the carrier at rest for a state with one displacement of the carrier."""
        q, u = q.copy(), u.copy()
        for body in self.roots:
            at, s = body.coordinates, body.speeds
            seen = moved.seen_from(body.p_PoFo_P, body.A_PF)
            R, w = seen.R[0], seen.w[0]
            axes = _axes(body)
            place, rate = np.zeros(3), np.zeros(3)
            place[:axes], rate[:axes] = q[at[:axes]], u[s[:axes]]
            place = R.T @ (place - seen.x[0])
            rate = R.T @ (rate - seen.v[0]) - np.cross(w, place)
            q[at[:axes]], u[s[:axes]] = place[:axes], rate[:axes]
            if axes == 3:
                back = _euler(R.T[None])[0]
                q[at[3:]] = multiply(back, q[at[3:]])
                u[s[3:]] -= rotation_matrix(q[at[3:]]).T @ w
            else:
                self._check_plane(body, seen)
                q[at[2]] -= np.arctan2(R[1, 0], R[0, 0])
                u[s[2]] -= w[2]
        return q, u

    @staticmethod
    def _check_plane(body: BodyTerms, seen: Displacement) -> None:
        out = max(np.abs(seen.R[:, :2, 2]).max(), np.abs(seen.x[:, 2]).max())
        if out > OUT_OF_PLANE:
            raise ModelError(
                f"the frame that carries {body.name!r} leaves the plane of its joint, by {out:.2g}. Remedy: a free "
                "joint"
            )


def _rotation(body: BodyTerms) -> tuple[np.ndarray, np.ndarray]:
    """Return the places of the Euler parameters of a body's joint in q, and of their speeds in u."""
    first = body.joint.rotation_at
    if first is None:
        raise TypeError("the joint has no Euler parameters")
    return body.coordinates[first : first + 4], body.speeds[first : first + 3]


def _axes(body: BodyTerms) -> int:
    """Return the number of axes along which a free body moves; with two it rotates about the third only."""
    return 2 if body.joint.rotation_at is None else 3


def _euler(R: np.ndarray) -> np.ndarray:
    """Return Euler parameters of rotation matrices (T, 3, 3), (T, 4)."""
    scalar = 0.5 * np.sqrt(np.maximum(1.0 + np.trace(R, axis1=1, axis2=2), 0.0))
    if scalar.min(initial=1.0) < 0.1:  # a rotation of nearly half a turn
        return euler_parameters_from_matrices(R)
    vector = np.array((R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1])) / (4.0 * scalar)
    return np.vstack((scalar, vector)).T


def _spun(theta: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Return the angular velocity in the moving frame of rotation vectors theta (T, 3) that change at a rate."""
    angle = np.linalg.norm(theta, axis=1, keepdims=True)
    small = angle < 1e-3
    safe = np.where(small, 1.0, angle)
    one = np.where(small, 0.5 - angle**2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    two = np.where(small, 1.0 / 6.0 - angle**2 / 120.0, (safe - np.sin(safe)) / safe**3)
    across = np.cross(theta, rate)
    return np.asarray(rate - one * across + two * np.cross(theta, across))


def _parameters(theta: np.ndarray) -> np.ndarray:
    """Return the Euler parameters of rotation vectors (T, 3), (T, 4)."""
    angle = np.linalg.norm(theta, axis=1, keepdims=True)
    half_sinc = 0.5 * np.sinc(angle / (2.0 * np.pi))
    return np.hstack((np.cos(0.5 * angle), half_sinc * theta))


def _matrices(e: np.ndarray) -> np.ndarray:
    """Return the rotation matrices of Euler parameters (T, 4), (T, 3, 3)."""
    a, b, c, d = e.T
    return np.array(
        (
            (a * a + b * b - c * c - d * d, 2.0 * (b * c - a * d), 2.0 * (b * d + a * c)),
            (2.0 * (b * c + a * d), a * a - b * b + c * c - d * d, 2.0 * (c * d - a * b)),
            (2.0 * (b * d - a * c), 2.0 * (c * d + a * b), a * a - b * b - c * c + d * d),
        )
    ).transpose(2, 0, 1)
