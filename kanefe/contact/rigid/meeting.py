"""Positions where contact points meet a surface, their relative velocities, and the bias accelerations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.frames import Vector, across, cross

if TYPE_CHECKING:
    from kanefe.constraints.rows import MarkerMotion
    from kanefe.contact.geometry.shape import Probe, SurfaceShape


class Meeting(NamedTuple):
    """A contact point near a surface; vectors in N.

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


def meetings_with(
    shape: SurfaceShape, probes: Sequence[Probe], belt: Vector, a: MarkerMotion, b: MarkerMotion
) -> list[Meeting]:
    """Return where contact points meet a surface of a frame a, all at once.

    With the centre c of a probe, the distance phi(c) of the surface, its gradient n and its second derivatives H:
    the gap is ``phi - radius``, its rate ``n . v`` of the material points at ``c - radius n``, and ``dn/dt = w x n +
    H dc/dt`` as seen from the surface. A ring touches with the lowest of its circle of centres, which moves in it.

    Parameters
    ----------
    shape : SurfaceShape
    probes : sequence of Probe
    belt : ndarray, shape (3,)
        Velocity of the surface in its own axes, m/s.
    a : MarkerMotion
    b : MarkerMotion
        Of the frame of each probe: arrays with one of them a row.
    """
    radii = np.array([[probe.radius] for probe in probes])
    spokes = turned(b.A, np.array([probe.point for probe in probes]))
    spoke_rates = cross(b.w, spokes)
    rings = [i for i, probe in enumerate(probes) if probe.ring > 0.0]
    if rings:  # on planes alone: n stays in a
        n = a.A @ shape.distance(np.zeros(3))[1]
        n_rate = cross(a.w, n)
        for i in rings:
            down, down_rate = _down(n, n_rate, b.A[i] @ probes[i].axis, b.w[i])
            spokes[i] += probes[i].ring * down
            spoke_rates[i] += probes[i].ring * down_rate
    arms = b.p + spokes - a.p
    places = turned(a.A.T, arms)
    found = [shape.distance(place) for place in places]
    axes = _axes([normal for _, normal in found], a.A)
    n = axes[:, 0]
    n_rates = cross(a.w, n)
    curved = [shape.curvature(place) for place in places]
    if any(H is not None for H in curved):
        place_rates = turned(a.A.T, b.v + spoke_rates - a.v - cross(a.w, arms))
        for i, H in enumerate(curved):
            if H is not None:
                n_rates[i] += a.A @ (H @ place_rates[i])
    spokes, spoke_rates = spokes - radii * n, spoke_rates - radii * n_rates
    arms = b.p + spokes - a.p
    v = b.v + cross(b.w, spokes) - a.v - cross(a.w, arms)
    arm_rates = b.v + spoke_rates - a.v
    left = b.Z + cross(b.Y, spokes) + cross(b.w, spoke_rates) - a.Z - cross(a.Y, arms) - cross(a.w, arm_rates)
    rates, remainders = turned(axes, v), turned(axes, left)
    rates[:, 1:] -= axes[:, 1:] @ (a.A @ belt)
    remainders[:, 0] += (n_rates * v).sum(axis=1)
    # w x e . v = e . v x w
    remainders[:, 1:] += turned(axes[:, 1:], cross(v, a.w))
    gaps = [float(phi - probe.radius) for (phi, _), probe in zip(found, probes, strict=True)]
    return list(map(Meeting, gaps, places, b.p + spokes, axes, rates, remainders))


def turned(A: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return ``A x`` of each row of x (n, 3); A is one matrix, or one for each."""
    return np.matmul(A, np.ascontiguousarray(x)[:, :, None])[:, :, 0]


def _axes(normals: Sequence[Vector], A: np.ndarray) -> np.ndarray:
    """Return the unit vectors along and across normals of a surface turned by A, (n, 3, 3): see `Meeting`."""
    found = np.empty((len(normals), 3, 3))
    for i, normal in enumerate(normals):
        if i and normal is normals[0]:  # of a plane
            found[i] = found[0]
        else:
            found[i, 0], found[i, 1:] = A @ normal, np.vstack(across(normal)) @ A.T
    return found


def _down(n: Vector, n_rate: Vector, s: Vector, w: Vector) -> tuple[Vector, Vector]:
    """Return the direction from the middle of a ring of axis s, which turns by w, to its lowest point, and its rate."""
    s_rate, lean = cross(w, s), float(s @ n)
    across = lean * s - n
    across_rate = float(s_rate @ n + s @ n_rate) * s + lean * s_rate - n_rate
    size = float(np.linalg.norm(across))
    if size == 0.0:  # it lies flat: no point is the lowest
        return np.zeros(3), np.zeros(3)
    unit = across / size
    return unit, (across_rate - (unit @ across_rate) * unit) / size
