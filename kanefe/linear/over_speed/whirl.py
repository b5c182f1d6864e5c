"""Forward and backward whirl of modes about the axis of rotation of a scene."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kanefe.frames import Vector
from kanefe.linear.modes.modes import Modes
from kanefe.linear.small_motions import SmallMotions

SPINS = 1e-9
"""Angular velocity below which nothing spins, rad/s."""

ALONG = 1e-9
"""Mean square across the axis, relative to the total, below which a mode is axial."""


def spin_axis(small: SmallMotions) -> Vector | None:
    """Return the direction in N of the fastest spin of a body, a unit vector; None if nothing spins."""
    frames = small.here.motions
    of_rotors = [body.rigid.rotor if body.rigid is not None else np.zeros(3) for body in small.model.bodies]
    for of_bodies in ([frame.w for frame in frames], of_rotors):
        spins = [frame.A_NF @ spin for frame, spin in zip(frames, of_bodies, strict=True)]
        fastest = max(spins, key=np.linalg.norm)
        size = float(np.linalg.norm(fastest))
        if size > SPINS:
            return np.asarray(fastest / size)
    return None


def whirl_of(modes: Modes) -> Vector:
    """Return the whirl of each mode relative to the spin of its scene, -1 to 1, (modes,).

    1: all points move on circles about the axis of the fastest spin, in its sense (forward whirl); -1: in the opposite
    sense (backward); 0: on straight lines, or nothing spins. In general it is the signed area of the orbits normal to
    the axis, weighted by mass, relative to that of circles with the same mean square.
    """
    small = modes.linearisation.small
    axis = spin_axis(small)
    areas, across, sizes = np.zeros((3, len(modes.eigenvalues)))
    if axis is None:
        return areas
    for mass, moved in _points(modes):
        # x = Re(z exp(i w t)) turns about the axis with the area pi Im(z x conj z) . axis / 2
        areas += mass * np.einsum("nmi,i->m", np.cross(moved, moved.conj()).imag, axis)
        size = mass * np.einsum("nmi,nmi->m", moved, moved.conj()).real
        sizes += size
        across += size - mass * (np.abs(moved @ axis) ** 2).sum(axis=0)
    return np.asarray(np.divide(areas, across, out=np.zeros_like(areas), where=across > ALONG * sizes))


def _points(modes: Modes) -> Iterator[tuple[float, np.ndarray]]:
    """Yield, for each body, the mass (kg) of each of its points, and their motion in N, (points, modes, 3)."""
    small = modes.linearisation.small
    frames = small.here.motions
    for body, frame in zip(small.model.bodies, frames, strict=True):
        if body.flexible is not None:
            moved = [modes.displacements(body.name, mode) for mode in range(len(modes.eigenvalues))]
            yield body.flexible.body.mass / len(moved[0]), np.stack(moved, axis=1)
        elif body.rigid is not None and body.rigid.mass > 0.0:
            shapes = modes.shape(body.name)
            arms = _inertia_points(body.rigid.mass, body.rigid.com, body.rigid.inertia) @ frame.A_NF.T
            yield body.rigid.mass / 6.0, shapes[:, :3] + np.cross(shapes[:, 3:], arms[:, None, :])


def _inertia_points(mass: float, com: Vector, inertia: np.ndarray) -> np.ndarray:
    """Return six points of equal mass with the mass and inertia of a rigid body, in its frame, (6, 3)."""
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    squares, axes = np.linalg.eigh(second)
    arms = axes * np.sqrt(3.0 * np.maximum(squares, 0.0) / mass)
    return np.asarray(com + np.concatenate((arms.T, -arms.T)))
