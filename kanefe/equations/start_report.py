"""How a scene starts: what was given, what followed, and how well loops hold positions, speeds, accelerations."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from kanefe.errors import outside
from kanefe.frames import Vector, multiply, rotation_vector
from kanefe.states.constraints import constraint_rates, constraint_residuals, held_rows
from kanefe.states.state import State
from kanefe.tree.body_terms import BodyTerms
from kanefe.tree.model_data import ModelData
from kanefe.tree.route import Route
from kanefe.tree.scales import joint_scales, scene_length

TOLD = 1e-6
"""Change of a given start from which on it is told, relative to a radian or the scene's length, or to the fastest
joint: what is less is the rounding of numbers that were given with six digits."""

MOST_TOLD = 4
"""Largest number of changes in a warning; the report has them all."""


class StartWarning(UserWarning):
    """A given start that contradicts the loops, and was changed."""


@dataclass(frozen=True)
class StartOf:
    """One coordinate or speed of a joint at the start.

    Attributes
    ----------
    body, name : str
        The body that the joint carries, and the coordinate or speed with its unit.
    origin : "given", "follows" or "driven"
        "follows": not given, or a guess.
    before, value : float
        What was given, guessed or zero, and what it is at the start. Of rotations by Euler parameters these are the
        components of a rotation vector, rad.
    change : float
        From the first to the second.
    is_mended : bool
        Whether it was given and changed by more than rounding.
    """

    body: str
    name: str
    origin: str
    before: float
    value: float
    change: float
    is_mended: bool


@dataclass(frozen=True)
class HeldRow:
    """One row of a loop joint or coupler at the start.

    Attributes
    ----------
    constraint, row : str
        Its name, and which of its rows.
    unit : str
        m or rad, of the three values: the others are rates of it per s and s2.
    opening, rate, acceleration : float
        What is left.
    """

    constraint: str
    row: str
    unit: str
    opening: float
    rate: float
    acceleration: float


@dataclass(frozen=True)
class StrainedBody:
    """A flexible body at the start.

    Attributes
    ----------
    body : str
    strain_energy : float
        J.
    largest_coordinate, largest_speed : float
        Of its elastic coordinates.
    change : float
        Largest change of elastic coordinates or speeds that were given, relative to the largest of them; zero if none
        were.
    """

    body: str
    strain_energy: float
    largest_coordinate: float
    largest_speed: float
    change: float

    @property
    def is_mended(self) -> bool:
        """Whether what was given changed by more than rounding."""
        return self.change > TOLD


@dataclass(frozen=True)
class StartReport:
    """The start of a scene. ``print(report)`` shows it as a table.

    Attributes
    ----------
    time : float
        s.
    coordinates, speeds : tuple of StartOf
        Of the joints, in the order of the scene.
    accelerations : dict of str to float
        Rate of each free speed, by its name.
    rows : tuple of HeldRow
        Of the constraints that hold.
    bodies : tuple of StrainedBody
    kinetic_energy, elastic_energy : float
        J, of the whole scene; the elastic one with springs.
    """

    time: float
    coordinates: tuple[StartOf, ...]
    speeds: tuple[StartOf, ...]
    accelerations: dict[str, float]
    rows: tuple[HeldRow, ...]
    bodies: tuple[StrainedBody, ...]
    kinetic_energy: float
    elastic_energy: float

    @property
    def mended(self) -> tuple[StartOf | StrainedBody, ...]:
        """What was given and contradicted the loops, so that it was changed."""
        parts: list[StartOf | StrainedBody] = [*self.coordinates, *self.speeds, *self.bodies]
        return tuple(one for one in parts if one.is_mended)

    def __str__(self) -> str:
        wide = max((len(f"{one.body}: {one.name}") for one in (*self.coordinates, *self.speeds)), default=0)
        lines = [f"start at t = {self.time:.6g} s", f"{'':{wide}}  {'given':>12} {'start':>12} {'change':>10}"]
        for one in (*self.coordinates, *self.speeds):
            before = f"{one.before:.6g}" if one.origin == "given" else one.origin
            change = f"{one.change:.2g}" if one.origin != "driven" and one.change else ""
            mark = "  mended" if one.is_mended else ""
            lines.append(f"{f'{one.body}: {one.name}':{wide}}  {before:>12} {one.value:>12.6g} {change:>10}{mark}")
        for body in self.bodies:
            lines.append(
                f"{body.body}: strain energy {body.strain_energy:.3g} J, elastic coordinates up to "
                f"{body.largest_coordinate:.3g}, their speeds up to {body.largest_speed:.3g}"
                f"{f', mended by {body.change:.2g} of the largest given' if body.is_mended else ''}"
            )
        if self.rows:
            lines.append("largest residuals of the loops:")
            for what, per in (("opening", ""), ("rate", "/s"), ("acceleration", "/s2")):
                sizes = [abs(float(getattr(row, what))) for row in self.rows]
                worst = self.rows[sizes.index(max(sizes))]
                lines.append(f"  {what} {max(sizes):.2g} {worst.unit}{per} ({worst.constraint}: {worst.row})")
        lines.append(f"kinetic energy {self.kinetic_energy:.6g} J, elastic energy {self.elastic_energy:.6g} J")
        return "\n".join(lines)


def start_report(route: Route, t: float, y: Vector) -> StartReport:
    """Return the report on the start y of a scene at time t (s), by its route."""
    model = route.model
    rates = route.evaluate(t, y).rates
    du = rates[model.coordinate_count : model.coordinate_count + model.free_count]
    state, seen_du = route.acting(t, y, du)
    q, u, _ = model.parts(y)
    energy = route.energy(t, y)
    coordinates, speeds = joint_starts(model, t, q, u)
    return StartReport(
        time=t,
        coordinates=coordinates,
        speeds=speeds,
        accelerations=dict(zip(model.speed_names(), du.tolist(), strict=True)),
        rows=_rows(state, seen_du),
        bodies=tuple(_strained(body, q, u) for body in model.bodies if body.flexible is not None),
        kinetic_energy=energy.kinetic,
        elastic_energy=energy.elastic,
    )


def warn_of_mended(model: ModelData, t: float) -> None:
    """Warn of a given start that the loops did not allow, with what it became."""
    if not model.constraints:
        return
    q, u = model.initial_coordinates, model.initial_speeds
    found = joint_starts(model, t, q, u)
    mended = [one for kind in found for one in kind if one.is_mended]
    bodies = [_strained(body, q, u) for body in model.bodies if body.flexible is not None]
    bent = [f"modal coordinates or speeds of {body.body!r}" for body in bodies if body.is_mended]
    if not mended and not bent:
        return
    told = [f"{one.name} of {one.body!r} is {one.before:.6g} and starts at {one.value:.6g}" for one in mended] + bent
    more = f" and {len(told) - MOST_TOLD} more" if len(told) > MOST_TOLD else ""
    warnings.warn(
        f"loops do not close with the start that was given: {'; '.join(told[:MOST_TOLD])}{more}. Remedy: "
        "kanefe.Guess(...) for what may move, None for what follows, numbers for as many as the mechanism has degrees "
        "of freedom; scene.start_report() lists all",
        StartWarning,
        stacklevel=outside(),
    )


def joint_starts(model: ModelData, t: float, q: Vector, u: Vector) -> tuple[tuple[StartOf, ...], tuple[StartOf, ...]]:
    """Return the coordinates and the speeds of all joints at a start, beside what was given for them."""
    full = model.all_speeds(t, u)
    ranges = joint_scales(model, scene_length(model))
    joints = np.concatenate([np.zeros(0, dtype=int), *(body.free_coordinates()[1] for body in model.bodies)])
    fastest = float((np.abs(u[joints]) / ranges[joints]).max(initial=0.0))
    speed_ranges = np.multiply(ranges, fastest, out=np.full_like(ranges, np.inf), where=np.isfinite(ranges))
    coordinates: list[StartOf] = []
    speeds: list[StartOf] = []
    for body in model.bodies:
        joint = body.joint
        are_driven = body.speeds >= model.free_count
        rows = np.minimum(body.speeds, len(ranges))  # of all that are driven: one behind
        most, fast = (TOLD * np.append(sizes, np.inf)[rows] for sizes in (ranges, speed_ranges))
        places = _along_speeds(body, joint.initial_coordinates(), body.joint_coordinates(t, q))
        rates = joint.initial_speeds(), full[body.speeds], full[body.speeds] - joint.initial_speeds()
        given_places, given_rates = joint.given_start()
        for kept, names, given, values, limits in (
            (coordinates, _place_names(body), given_places, places, most),
            (speeds, joint.speed_names, given_rates, rates, fast),
        ):
            for name, is_driven, is_given, before, value, change, limit in zip(
                names, are_driven, given, *values, limits, strict=True
            ):
                origin = "driven" if is_driven else "given" if is_given else "follows"
                is_mended = origin == "given" and abs(change) > limit
                kept.append(StartOf(body.name, name, origin, float(before), float(value), float(change), is_mended))
    return tuple(coordinates), tuple(speeds)


def _place_names(body: BodyTerms) -> tuple[str, ...]:
    """Return a name for a displacement along each speed of a joint."""
    names, at = body.joint.coordinate_names, body.joint.rotation_at
    if at is None:
        return names
    return (*names[:at], *(f"rotation {axis} [rad]" for axis in "xyz"), *names[at + 4 :])


def _along_speeds(body: BodyTerms, asked: Vector, values: Vector) -> tuple[Vector, Vector, Vector]:
    """Return two sets of coordinates of a joint and their difference, one for each speed: rotations as vectors."""
    at = body.joint.rotation_at
    if at is None:
        return asked, values, values - asked
    e, f = asked[at : at + 4], values[at : at + 4]
    turn = multiply(e * np.array((1.0, -1.0, -1.0, -1.0)), f)
    vectors = (rotation_vector(one) for one in (e, f, turn))
    before, now, change = (
        np.concatenate((whole[:at], vector, whole[at + 4 :]))
        for whole, vector in zip((asked, values, values - asked), vectors, strict=True)
    )
    return before, now, change


def _rows(state: State, du: Vector) -> tuple[HeldRow, ...]:
    rows = constraint_rates(state)
    full_rates = np.concatenate((du, state.driven_rates))[: rows.J.shape[1]]
    values = (
        constraint_residuals(state),
        rows.open_rates(state.full),
        rows.J[:, : len(full_rates)] @ full_rates + rows.remainder,
    )
    return tuple(
        HeldRow(constraint.name, row.label, row.unit, *(float(value) for value in left))
        for (constraint, row), *left in zip(held_rows(state), *values, strict=True)
    )


def _strained(body: BodyTerms, q: Vector, u: Vector) -> StrainedBody:
    terms = body.flexible
    if terms is None:
        raise TypeError(f"{body.name!r} is rigid")
    k = terms.body.free_count
    eta, deta = q[terms.eta], u[terms.speeds]
    changes = [
        np.abs(now - given).max(initial=0.0) / max(np.abs(given).max(initial=0.0), np.abs(now).max(initial=1e-300))
        for now, given in ((eta, terms.given_eta), (deta, terms.given_deta))
        if given is not None
    ]
    energy = 0.5 * float(eta @ (terms.body.stiffness[:k, :k] @ eta))
    coordinate, speed = (float(np.abs(of).max(initial=0.0)) for of in (eta, deta))
    return StrainedBody(body.name, energy, coordinate, speed, float(max(changes, default=0.0)))
