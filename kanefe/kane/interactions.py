"""Forces of springs and bushings between two markers, on the partial velocities of both ends (Eq. 11)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.errors import SimulationError
from kanefe.frames import Matrix, Vector, cross, skew
from kanefe.kane.constraints import marker_frame
from kanefe.kane.kinematics import FrameMotion
from kanefe.loads.bushing import Bushing
from kanefe.loads.spring import SpringDamper
from kanefe.tree.model_data import ModelData


class Ends(NamedTuple):
    """Motions of the two markers of an interaction, each in its own axes."""

    a: FrameMotion
    b: FrameMotion


class Line(NamedTuple):
    """The line of a spring: its ends, length (m) and rate (m/s), and its direction from a to b in N."""

    ends: Ends
    length: float
    rate: float
    direction: Vector


class Offset(NamedTuple):
    """A bushing's b seen from a, in a's axes: ends, A_ab, d (3,) in m, and dd and w_ab (6,) in m/s and rad/s."""

    ends: Ends
    A_ab: Matrix
    d: Vector
    rates: Vector


class MarkerWrench(NamedTuple):
    """Force and moment (6,) on a marker about its origin, in its axes, with its motion."""

    marker: Marker
    frame: FrameMotion
    wrench: Vector


def marker_ends(
    model: ModelData, item: SpringDamper | Bushing, motions: Sequence[FrameMotion], q: Vector, u: Vector, columns: int
) -> Ends:
    """Return the motions of both markers of a spring or bushing."""
    return Ends(*(marker_frame(model, marker, motions, q, u, columns) for marker in (item.a, item.b)))


def spring_line(spring: SpringDamper, t: float, ends: Ends) -> Line:
    """Return length, rate and direction of a spring."""
    a, b = ends
    r = b.p_NoFo_N - a.p_NoFo_N
    length = float(np.linalg.norm(r))
    if length == 0.0:
        raise SimulationError(
            f"spring {spring.name!r} has no length at t = {t:.6g} s, and so no direction. Remedy: a bushing"
        )
    e = r / length
    return Line(ends, length, float(e @ (b.A_NF @ b.v - a.A_NF @ a.v)), e)


def bushing_offset(ends: Ends) -> Offset:
    """Return where b is seen from a, and how it moves."""
    a, b = ends
    A_ab = a.A_NF.T @ b.A_NF
    d = a.A_NF.T @ (b.p_NoFo_N - a.p_NoFo_N)
    return Offset(ends, A_ab, d, np.concatenate((A_ab @ b.v - a.v - cross(a.w, d), A_ab @ b.w - a.w)))


def lines(
    model: ModelData, motions: Sequence[FrameMotion], t: float, q: Vector, u: Vector, columns: int
) -> Iterator[tuple[SpringDamper, Line]]:
    """Yield each spring with its line."""
    for spring in model.springs:
        yield spring, spring_line(spring, t, marker_ends(model, spring, motions, q, u, columns))


def offsets(
    model: ModelData, motions: Sequence[FrameMotion], q: Vector, u: Vector, columns: int
) -> Iterator[tuple[Bushing, Offset]]:
    """Yield each bushing with its offset."""
    for bushing in model.bushings:
        yield bushing, bushing_offset(marker_ends(model, bushing, motions, q, u, columns))


def interaction_wrenches(
    model: ModelData, motions: Sequence[FrameMotion], t: float, q: Vector, u: Vector, columns: int
) -> Iterator[MarkerWrench]:
    """Yield the wrenches of all springs and bushings on their two markers.

    Parameters
    ----------
    model : ModelData
    motions : sequence of FrameMotion
        The outward sweep.
    t : float
        s.
    q, u : ndarray
        Coordinates, and all speeds.
    columns : int
        How many speeds the partial velocities span.
    """
    none = np.zeros(3)
    for spring, line in lines(model, motions, t, q, u, columns):
        pull = spring.tension(t, line.length, line.rate) * line.direction
        a, b = line.ends
        yield MarkerWrench(spring.a, a, np.concatenate((a.A_NF.T @ pull, none)))
        yield MarkerWrench(spring.b, b, np.concatenate((b.A_NF.T @ -pull, none)))
    for bushing, offset in offsets(model, motions, q, u, columns):
        wrench = bushing.wrench(t, offset.A_ab, offset.d, offset.rates)
        force, moment = wrench[:3], wrench[3:]
        a, b = offset.ends
        yield MarkerWrench(bushing.b, b, np.concatenate((offset.A_ab.T @ force, offset.A_ab.T @ moment)))
        yield MarkerWrench(bushing.a, a, -np.concatenate((force, moment + cross(offset.d, force))))


def add_interactions(
    model: ModelData, motions: Sequence[FrameMotion], t: float, q: Vector, u: Vector, F: Vector
) -> None:
    """Add the generalised forces of all springs and bushings to F: ``V^T R + W^T T`` of both ends (Eq. 11)."""
    for _, frame, wrench in interaction_wrenches(model, motions, t, q, u, len(F)):
        F += frame.V.T @ wrench[:3] + frame.W.T @ wrench[3:]


def interaction_energy(model: ModelData, motions: Sequence[FrameMotion], t: float, q: Vector, u: Vector) -> float:
    """Return the energy in linear springs and bushings, J."""
    columns = model.free_count + model.driven_count
    total = sum(spring.potential(line.length) for spring, line in lines(model, motions, t, q, u, columns))
    return total + sum(b.potential(o.A_ab, o.d) for b, o in offsets(model, motions, q, u, columns))


def interaction_powers(
    model: ModelData, motions: Sequence[FrameMotion], t: float, q: Vector, u: Vector
) -> tuple[float, float]:
    """Return the power that dampers take, and the power that tables and laws of the user give, W."""
    columns = model.free_count + model.driven_count
    taken = given = 0.0
    for spring, line in lines(model, motions, t, q, u, columns):
        taken += spring.dissipation(line.rate)
        given -= spring.given(t, line.length, line.rate) * line.rate
    for bushing, offset in offsets(model, motions, q, u, columns):
        taken += bushing.dissipation(offset.rates)
        given += float(bushing.given(t, offset.A_ab, offset.d, offset.rates) @ offset.rates)
    return taken, given


def add_interaction_slopes(
    model: ModelData, motions: Sequence[FrameMotion], t: float, q: Vector, u: Vector, K: Matrix, C: Matrix
) -> None:
    """Add stiffness and damping of springs and bushings at a state to K and C over the free speeds.

    Those along the spring or the axes of a, without what turning them does under load: for iterations, not exact.
    """
    n, columns = len(K), model.free_count + model.driven_count
    for spring, line in lines(model, motions, t, q, u, columns):
        a, b = line.ends
        row = (line.direction @ (b.A_NF @ b.V - a.A_NF @ a.V))[:n]
        K += spring.slope(line.length) * np.outer(row, row)
        C += spring.damping * np.outer(row, row)
    for bushing, offset in offsets(model, motions, q, u, columns):
        a, b = offset.ends
        D = np.vstack((offset.A_ab @ b.V - a.V + skew(offset.d) @ a.W, offset.A_ab @ b.W - a.W))[:, :n]
        K += D.T @ (bushing.stiffness[:, None] * D)
        C += D.T @ (bushing.damping[:, None] * D)
