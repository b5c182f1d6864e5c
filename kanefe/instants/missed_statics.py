"""The part of the deformation of flexible bodies that their modes cannot represent.

A body in a scene carries inertia, that of its own vibration too, gravity and tractions. `kanefe.reduction.left_out` has
recorded which part of the static response to them the basis leaves out; its ratio to what the modes do represent shows
whether they are enough.
Forces at interfaces, which constraint modes (Craig and Bampton's) represent exactly, and loads at other nodes are not
considered.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.errors import AccuracyWarning, outside
from kanefe.fe_model.model import INERTIA_OF_MODES, PRODUCTS
from kanefe.frames import Vector, rotation_matrix
from kanefe.instants.instant import Instant
from kanefe.tree.body_terms import BodyTerms
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import largest_extent

if TYPE_CHECKING:
    from kanefe.fe_model.load_pattern import LoadPattern

REPORTED = 0.05
"""Fraction of the deformation, as the root of its strain energy, above which a warning is issued."""

FELT = 1e-6
"""Displacement relative to the size of the body below which no warning is issued: that of a hanging steel bar."""


class Missed(NamedTuple):
    """The deformation that the modes of a body miss.

    Attributes
    ----------
    body : str
    share : float
        Relative to its deformation, by the root of the strain energy.
    load : str
        The load that contributes most, by the name that ``loads=`` of a reduction takes.
    """

    body: str
    share: float
    load: str

    def __str__(self) -> str:
        remedy = f"reduction=...(..., loads=({self.load!r},)), or more modes"
        if self.load == INERTIA_OF_MODES:
            remedy = "more modes, as by reduction=kf.CraigBampton(up_to_frequency=<Hz>)"
        return (
            f"the modes of {self.body!r} miss {100 * self.share:.2g} % of its deformation, most of it due to "
            f"{self.load} (root of the strain energy). Remedy: {remedy}"
        )


def is_known(model: ModelData) -> bool:
    """Return whether a basis has a record of what it leaves out, without which `missed_statics` finds nothing."""
    return any(_record(body) is not None for body in model.bodies)


def missed_statics(instants: Sequence[Instant]) -> list[Missed]:
    """Return the bodies whose modes miss more than `REPORTED` of their deformation, at the worst of some instants."""
    found = []
    for number, body in enumerate(instants[0].model.bodies):
        record = _record(body)
        if record is None or body.flexible is None:
            continue
        loads = [(str(name), int(component)) for name, component in record["loads"]]
        energy, displacement = np.array(record["energy"]), np.array(record["displacement"])
        carried = [_carried(instant, number, loads) for instant in instants]
        missed = np.array([f @ energy @ f for f in carried])
        worst = int(missed.argmax())
        moved = np.sqrt(max(float(carried[worst] @ displacement @ carried[worst]), 0.0))
        if moved <= FELT * largest_extent(body.flexible.body):
            continue
        others = _together(instants[0].model, body)
        taken = max(sum(_energy(other, instant) for other in others) for instant in instants)
        share = float(np.sqrt(missed[worst] / (missed[worst] + taken)))
        if share > REPORTED:
            found.append(Missed(body.name, share, _largest(loads, carried[worst], energy)))
    return found


def _together(model: ModelData, body: BodyTerms) -> list[BodyTerms]:
    """Return the body, or all segments of a segmented body, whose deformation counts as that of one body."""
    if not _is_segment(body):
        return [body]
    stem = body.name.rpartition(" ")[0]
    return [other for other in model.bodies if _is_segment(other) and other.name.rpartition(" ")[0] == stem]


def _is_segment(body: BodyTerms) -> bool:
    return body.flexible is not None and "segment" in body.flexible.body.provenance


def _energy(body: BodyTerms, instant: Instant) -> float:
    """Return twice the strain energy of a flexible body, J."""
    if body.flexible is None:
        return 0.0
    k, eta = body.flexible.body.free_count, instant.q[body.flexible.eta]
    return float(eta @ body.flexible.body.stiffness[:k, :k] @ eta)


def warn_of_missed(instant: Instant, what: str) -> None:
    """Warn of bodies whose modes miss much of their deformation at an instant; `what` names the analysis."""
    for missed in missed_statics([instant]):
        warnings.warn(f"{what}: {missed}", AccuracyWarning, stacklevel=outside())


def _record(body: BodyTerms) -> dict[str, Any] | None:
    """Return the record of what the basis of a body leaves out; None if it is empty or missing."""
    if body.flexible is None or not isinstance(body.flexible.body, FlexibleBody):
        return None
    reduction = body.flexible.body.provenance.get("reduction")
    record = reduction.get("left_out") if isinstance(reduction, dict) else None
    return record if record and record["loads"] else None


def _carried(instant: Instant, number: int, loads: Sequence[tuple[str, int]]) -> Vector:
    """Return the loads on a body at an instant, in components of G, in the order of `loads`."""
    model = instant.model
    body = model.bodies[number]
    A_NG = rotation_matrix(instant.rotation(body.name))
    gravity = model.gravity if body.has_gravity else np.zeros(3)
    w = instant.angular_velocity(body.name)
    values: dict[str, Vector] = {
        INERTIA_OF_MODES: -_own_accelerations(instant, body),
        "gravity": A_NG.T @ (gravity - instant.acceleration(body.name)),
        "angular acceleration": -instant.angular_acceleration(body.name),
        "centrifugal": np.array([w[a] * w[b] for a, b in PRODUCTS]),
    }
    state = model.literal.at(instant.time, instant.q, instant.u, instant.z)
    for load in body.field_loads:
        value = np.atleast_1d(load.value(instant.time, state))
        pattern: LoadPattern = load.pattern
        name = f"{pattern.name} {'pressure' if load.is_pressure else 'traction'}"
        if not load.is_pressure and not load.follows:
            value = A_NG.T @ value
        values[name] = values.get(name, np.zeros(len(value))) + value
    return np.array([values[name][component] if name in values else 0.0 for name, component in loads])


def _own_accelerations(instant: Instant, body: BodyTerms) -> Vector:
    """Return the accelerations of the free coordinates of a flexible body, (k,)."""
    if body.flexible is None or instant.run is None:
        return np.zeros(0)
    return np.asarray(instant.run.accelerations()[0, body.flexible.speeds])


def _largest(loads: Sequence[tuple[str, int]], carried: Vector, energy: np.ndarray) -> str:
    """Return the load whose own response is missed most, by its name in reductions."""
    parts: dict[str, float] = {}
    for name in dict(loads):
        own = np.where([other == name for other, _ in loads], carried, 0.0)
        parts[name] = float(own @ energy @ own)
    return max(parts, key=lambda name: parts[name]).removesuffix(" traction").removesuffix(" pressure")
