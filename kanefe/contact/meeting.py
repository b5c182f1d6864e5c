"""Where a probe and a surface meet, how fast they move past each other, and what is left of that without du."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.frames import Vector, cross

if TYPE_CHECKING:
    from kanefe.constraints.rows import MarkerMotion
    from kanefe.contact.shape import Probe, SurfaceShape


class Meeting(NamedTuple):
    """A probe near a surface; vectors in N.

    Attributes
    ----------
    gap : float
        m; below zero it is in the surface.
    place : ndarray, shape (3,)
        Of the probe's centre in axes of the surface, m.
    point : ndarray, shape (3,)
        Where they meet.
    axes : ndarray, shape (3, 3)
        Normal of the surface, and two directions along it that are fixed in it as long as the normal is: one a row.
    rates : ndarray, shape (3,)
        Of what is fixed in the probe's body at that point past the surface, along each, m/s; of a belt past it.
    remainder : ndarray, shape (3,)
        What is left of their rates without du, m/s2.
    """

    gap: float
    place: Vector
    point: Vector
    axes: np.ndarray
    rates: Vector
    remainder: Vector


def meeting(shape: SurfaceShape, probe: Probe, belt: Vector, a: MarkerMotion, b: MarkerMotion) -> Meeting:
    """Return where a probe of a frame b meets a surface of a frame a.

    With the centre c of the probe, the distance phi(c) of the surface, its gradient n and its second derivatives H:
    the gap is ``phi - radius``, its rate ``n . v`` of the material points at ``c - radius n``, and ``dn/dt = w x n +
    H dc/dt`` as seen from the surface. A ring touches with the lowest of its circle of centres, which moves in it.

    Parameters
    ----------
    shape : SurfaceShape
    probe : Probe
    belt : ndarray, shape (3,)
        Velocity of the surface in its own axes, m/s.
    a, b : MarkerMotion
    """
    spoke = b.A @ probe.point
    spoke_rate = cross(b.w, spoke)
    place = a.A.T @ (b.p + spoke - a.p)
    phi, normal = shape.distance(place)
    n = a.A @ normal
    if probe.ring > 0.0:  # on planes alone: n stays in a
        down, down_rate = _down(n, cross(a.w, n), b, probe.axis)
        spoke, spoke_rate = spoke + probe.ring * down, spoke_rate + probe.ring * down_rate
        place = a.A.T @ (b.p + spoke - a.p)
        phi, normal = shape.distance(place)
    place_rate = a.A.T @ (b.v + spoke_rate - a.v - cross(a.w, b.p + spoke - a.p))
    curved = shape.curvature(place)
    n_rate = cross(a.w, n)
    if curved is not None:
        n_rate = n_rate + a.A @ (curved @ place_rate)
    spoke, spoke_rate = spoke - probe.radius * n, spoke_rate - probe.radius * n_rate
    arm = b.p + spoke - a.p
    v = b.v + cross(b.w, spoke) - a.v - cross(a.w, arm)
    arm_rate = b.v + spoke_rate - a.v
    left = b.Z + cross(b.Y, spoke) + cross(b.w, spoke_rate) - a.Z - cross(a.Y, arm) - cross(a.w, arm_rate)
    axes = np.vstack((n, _along(normal) @ a.A.T))
    rates, remainder = axes @ v, axes @ left
    rates[1:] -= axes[1:] @ (a.A @ belt)
    remainder[0] += n_rate @ v
    # w x e . v = e . v x w
    remainder[1:] += axes[1:] @ cross(v, a.w)
    return Meeting(phi - probe.radius, place, b.p + spoke, axes, rates, remainder)


def _along(normal: Vector) -> np.ndarray:
    """Return two unit vectors across a normal, one a row."""
    first = cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first = first / np.linalg.norm(first)
    return np.vstack((first, cross(normal, first)))


def _down(n: Vector, n_rate: Vector, b: MarkerMotion, axis: Vector) -> tuple[Vector, Vector]:
    """Return the direction from the middle of a ring to its lowest point, and its rate."""
    s = b.A @ axis
    s_rate, lean = cross(b.w, s), float(s @ n)
    across = lean * s - n
    across_rate = float(s_rate @ n + s @ n_rate) * s + lean * s_rate - n_rate
    size = float(np.linalg.norm(across))
    if size == 0.0:  # it lies flat: no point is the lowest
        return np.zeros(3), np.zeros(3)
    unit = across / size
    return unit, (across_rate - (unit @ across_rate) * unit) / size
