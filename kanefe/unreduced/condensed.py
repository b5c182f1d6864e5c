"""The condensed scene: a small twin of a scene, in which unreduced bodies have only the frames that they carry.

The rest of the scene depends on the coordinates eta of an unreduced body only through the motion of a few frames:
interfaces and nodes with bodies, loads, springs and loops. In the twin the body has the coordinates ``d = Q eta``, one
for each independent component of those frames, without mass and stiffness. The literal route evaluates the twin like
any scene; the contributions of the bodies are added to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.bodies.marker import Marker
from kanefe.bodies.unreduced import UnreducedBody
from kanefe.constraints.rows import Constraint, CouplerRow
from kanefe.frames import Matrix, Vector
from kanefe.kane.inertia import flexible_inertia
from kanefe.states.state import State
from kanefe.storage.scipy_later import scipy, sp
from kanefe.tree.body_terms import BodyTerms, FlexibleTerms
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.loads.field_load import FieldLoad
    from kanefe.states.kinematics import FrameMotion


class FrozenMoments:
    """Moments of a body of the twin: inertia and forces at one state, returned for any arguments.

    Parameters
    ----------
    generalised : ndarray, shape (6 + p, 6 + p)
        Inertia of (translation of G, rotation of G, coordinates).
    bias : ndarray, shape (6 + p,)
        Inertia forces without accelerations.
    """

    def __init__(self, generalised: Matrix, bias: Vector) -> None:
        self._generalised, self._bias = generalised, bias

    @classmethod
    def none(cls, count: int) -> FrozenMoments:
        """Return the moments of a body without mass."""
        return cls(np.zeros((6 + count, 6 + count)), np.zeros(6 + count))

    @property
    def mass(self) -> np.ndarray:
        """Mass in kg, shape ()."""
        return np.asarray(self._generalised[0, 0])

    @property
    def elastic_mass(self) -> np.ndarray:
        """Block of the coordinates, shape (p, p)."""
        return self._generalised[6:, 6:]

    def terms(self, eta: Vector, deta: Vector, w: Vector) -> tuple[Matrix, Vector]:
        """Return the leading part of the frozen terms, as `kanefe.bodies.mass_moments.MassMoments.terms`."""
        size = 6 + len(eta)
        return self._generalised[:size, :size], self._bias[:size]

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the numbers by name."""
        return {"generalised": self._generalised, "bias": self._bias}


NOTHING = np.zeros((1, 1)), np.zeros(1)
"""Contribution of a massless body to M and F, of any size."""


def condensed_inertia(
    terms: FlexibleTerms, G: FrameMotion, gravity_G: Vector, eta: Vector, deta: Vector
) -> tuple[Matrix, Vector]:
    """Return M and F of a body of the condensed scene, without computation if it has no mass."""
    if isinstance(terms.free_moments, FrozenMoments):
        return NOTHING
    return flexible_inertia(terms, G, gravity_G, eta, deta)


@dataclass(frozen=True, eq=False)
class Substructure:
    """An unreduced body of a scene.

    Attributes
    ----------
    number : int
        Number of the body.
    body : UnreducedBody
    eta, speeds : slice
        Indices of its coordinates in q and of its speeds in the free ones of the full scene.
    carried : csr_matrix, shape (p, k)
        Q: coordinates of the frames it carries, ``d = Q eta``.
    d, rates : slice
        Indices of d in the coordinates, and of its rates in the speeds of the condensed scene.
    field_loads : tuple of FieldLoad
    has_gravity : bool
    """

    number: int
    body: UnreducedBody
    eta: slice
    speeds: slice
    carried: sp.csr_matrix
    d: slice
    rates: slice
    field_loads: tuple[FieldLoad, ...]
    has_gravity: bool

    @property
    def carried_count(self) -> int:
        """Number p of coordinates in the condensed scene."""
        return int(self.carried.shape[0])


class Condensed:
    """A scene with unreduced bodies, its condensed twin, and the conversion of states.

    Parameters
    ----------
    model : ModelData
    is_complete : bool
        Whether the twin has the frames of all interfaces, not only of those with something attached, and the
        components that are fixed in G.

    Attributes
    ----------
    model, small : ModelData
        The scene and its twin.
    substructures : tuple of Substructure
    plain_coordinates, plain_speeds : ndarray of int
        Coordinates and free speeds of the scene outside unreduced bodies.
    plain_places, plain_rates : ndarray of int
        Their indices in the twin.
    """

    def __init__(self, model: ModelData, is_complete: bool = False) -> None:
        self.model, self.is_complete = model, is_complete
        self._frames: dict[int, InterfaceFrame] = {}
        self._markers: dict[int, Marker] = {}
        self._is_asked = is_complete or _takes_state(model)
        attached = _attached_frames(model)
        bases = []
        for number, body in enumerate(model.bodies):
            frames = list(attached[number].values())
            if is_unreduced(body):
                if self._is_asked and body.flexible is not None:
                    frames += [n for n in body.flexible.body.interfaces if id(n) not in attached[number]]
                bases.append(self._independent(frames, body))
            else:
                bases.append(None)
        self._number(model, bases)
        self.small = self._twin(model, bases)

    def _independent(self, frames: list[InterfaceFrame], body: BodyTerms) -> sp.csr_matrix:
        """Return Q, independent rows of the motions of frames, and store the frames in terms of them."""
        terms = body.flexible
        k = terms.body.free_count if terms else 0
        if not frames:
            return sp.csr_matrix((0, k))
        rows = sp.csr_matrix(np.vstack([frame.motion[:, :k] for frame in frames]))
        gram = (rows @ rows.T).toarray()
        size = np.sqrt(np.diag(gram))
        scale = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0)
        scaled = gram * np.outer(scale, scale)
        _, R, pivots = scipy.linalg.qr(scaled, pivoting=True)
        # the Gram matrix has squares of differences between rows: below this limit rows are dependent
        rank = int(np.count_nonzero(np.abs(np.diag(R)) > 1e-10))
        kept = np.sort(pivots[:rank])
        share = np.linalg.solve(gram[np.ix_(kept, kept)], gram[kept]).T
        share[np.abs(share) < 1e-12] = 0.0
        for i, frame in enumerate(frames):
            motion = share[6 * i : 6 * i + 6]
            if self.is_complete:
                columns = tuple(rank + column - k for column in frame.fixed_columns)
                held = frame.motion[:, k:]
                self._frames[id(frame)] = replace(frame, motion=np.hstack((motion, held)), fixed_columns=columns)
            else:
                self._frames[id(frame)] = replace(frame, motion=motion, fixed_components=(), fixed_columns=())
        return rows[kept]

    def _number(self, model: ModelData, bases: list[sp.csr_matrix | None]) -> None:
        """Number coordinates and speeds of the twin: those of the scene, with d in the place of eta."""
        coordinates = np.full(model.coordinate_count + 1, -1)  # the last one is that of driven coordinates, index -1
        speeds = np.full(model.free_count + model.driven_count, -1)
        q = u = 0
        substructures, self._slices = [], dict[int, tuple[slice, slice]]()
        for number, (body, Q) in enumerate(zip(model.bodies, bases, strict=True)):
            at, free = body.free_coordinates()
            coordinates[at] = q + np.arange(len(at))
            speeds[free] = u + np.arange(len(free))
            q, u = q + len(at), u + len(free)
            terms = body.flexible
            if terms is None:
                continue
            count = terms.body.free_count if Q is None else Q.shape[0]
            self._slices[number] = slice(q, q + count), slice(u, u + count)
            q, u = q + count, u + count
            if Q is None:
                coordinates[terms.eta], speeds[terms.speeds] = np.arange(q - count, q), np.arange(u - count, u)
            elif isinstance(terms.body, UnreducedBody):
                substructures.append(
                    Substructure(
                        number,
                        terms.body,
                        terms.eta,
                        terms.speeds,
                        Q,
                        *self._slices[number],
                        body.field_loads,
                        body.has_gravity,
                    )
                )
        speeds[model.free_count :] = u + np.arange(model.driven_count)
        self.substructures = tuple(substructures)
        self._coordinates, self._speeds, self._sizes = coordinates, speeds, (q, u)
        self.plain_coordinates = np.flatnonzero(coordinates[:-1] >= 0)
        self.plain_speeds = np.flatnonzero(speeds[: model.free_count] >= 0)
        self.plain_places = coordinates[self.plain_coordinates]
        self.plain_rates = speeds[self.plain_speeds]

    def _twin(self, model: ModelData, bases: list[sp.csr_matrix | None]) -> ModelData:
        q, u = self._sizes
        substructures = {substructure.number: substructure for substructure in self.substructures}
        fixed = u + model.driven_count
        bodies = []
        for number, body in enumerate(model.bodies):
            changes: dict[str, Any] = {
                "coordinates": self._coordinates[body.coordinates],
                "speeds": self._speeds[body.speeds],
                "loads": tuple((load, self.frame(interface)) for load, interface in body.loads),
                "parent_interface": self.frame(body.parent_interface),
            }
            if number in substructures:
                twin = self._massless(substructures[number], fixed)
                fixed = twin.fixed.stop if twin is not None else fixed
                changes["flexible"], changes["field_loads"] = twin, ()
            elif body.flexible is not None:
                eta, rates = self._slices[number]
                held = slice(fixed, fixed + body.flexible.body.fixed_count)
                changes["flexible"] = replace(body.flexible, eta=eta, speeds=rates, fixed=held)
                fixed = held.stop
            bodies.append(replace(body, **changes))
        return replace(
            model,
            bodies=tuple(bodies),
            coordinate_count=q,
            free_count=u,
            fixed_count=fixed - u - model.driven_count,
            initial_coordinates=self.coordinates(model.initial_coordinates),
            initial_speeds=self.speeds(model.initial_speeds),
            constraints=tuple(self._constraint(c) for c in model.constraints),
            loads=tuple(load.with_ends(tuple(map(self.marker, load.ends))) for load in model.loads),
        )

    def _massless(self, substructure: Substructure, fixed: int) -> FlexibleTerms | None:
        """Return the terms of a body in the twin, which has only frames; None if they are not needed."""
        body, p = substructure.body, substructure.carried_count
        if not p and not self._is_asked:
            return None
        full = self.model.bodies[substructure.number].flexible
        if full is None:
            raise TypeError("a substructure is flexible")
        held = body.fixed_count if self.is_complete else 0
        count = p + held
        none: Any = FrozenMoments.none(count)
        shape = FlexibleBody(
            nodes=body.nodes,
            components=(),
            basis=np.zeros((0, count)),
            free_count=p,
            stiffness=np.zeros((count, count)),
            damping=np.zeros((p, p)),
            moments=none,
            interfaces=tuple(self._frames[id(n)] for n in body.interfaces if id(n) in self._frames),
            inertia_points=np.zeros((0, 3)),
            inertia_mass=sp.csr_matrix((0, 0)),
            inertia_basis=np.zeros((0, count)),
        )
        # the static part of the coordinates does no work, since their equations are satisfied
        elastic = np.zeros((count, held))
        elastic[p:] = full.fixed_elastic[:held, :held]
        return FlexibleTerms(
            body=shape,
            free_moments=none,
            all_moments=none,
            damping=None,
            eta=substructure.d,
            speeds=substructure.rates,
            fixed=slice(fixed, fixed + held),
            fixed_rigid=full.fixed_rigid[:, :held],
            fixed_elastic=elastic,
        )

    def with_moments(self, moments: Sequence[FrozenMoments]) -> ModelData:
        """Return the twin with other moments of its unreduced bodies."""
        bodies = list(self.small.bodies)
        for substructure, own in zip(self.substructures, moments, strict=True):
            terms = bodies[substructure.number].flexible
            if terms is not None:
                frozen: Any = own
                bodies[substructure.number] = replace(
                    bodies[substructure.number], flexible=replace(terms, free_moments=frozen, all_moments=frozen)
                )
        return replace(self.small, bodies=tuple(bodies))

    def frame(self, frame: InterfaceFrame | None) -> InterfaceFrame | None:
        """Return a frame in the twin; unchanged if it is not on an unreduced body."""
        return None if frame is None else self._frames.get(id(frame), frame)

    def marker(self, marker: Marker) -> Marker:
        """Return a marker in the twin; equal markers share one object."""
        if id(marker) not in self._markers:
            self._markers[id(marker)] = replace(marker, interface=self.frame(marker.interface))
        return self._markers[id(marker)]

    def _constraint(self, constraint: Constraint) -> Constraint:
        rows = tuple(
            row if isinstance(row, CouplerRow) else replace(row, a=self.marker(row.a), b=self.marker(row.b))
            for row in constraint.rows
        )
        if constraint.a is None or constraint.b is None:
            return replace(constraint, rows=rows)
        return replace(constraint, rows=rows, a=self.marker(constraint.a), b=self.marker(constraint.b))

    def coordinates(self, q: Vector) -> Vector:
        """Return the coordinates of the twin from those of the scene."""
        small = np.empty(self._sizes[0])
        small[self.plain_places] = q[self.plain_coordinates]
        for substructure in self.substructures:
            if substructure.carried_count:
                small[substructure.d] = substructure.carried @ q[substructure.eta]
        return small

    def state(self, t: float, q: Vector, u: Vector, z: Vector | None = None) -> State:
        """Return the state of the twin from one of the scene."""
        return State(self.small, t, self.coordinates(q), self.speeds(u), z)

    def speeds(self, u: Vector) -> Vector:
        """Return the free speeds of the twin, or their rates, from those of the scene."""
        small = np.empty(self._sizes[1])
        small[self.plain_rates] = u[self.plain_speeds]
        for substructure in self.substructures:
            if substructure.carried_count:
                small[substructure.rates] = substructure.carried @ u[substructure.speeds]
        return small

    def expanded(self, wide: Matrix) -> Matrix:
        """Return partial velocities over the free speeds of the scene from those over the twin's, (rows, free)."""
        whole = np.empty((len(wide), self.model.free_count))
        whole[:, self.plain_speeds] = wide[:, self.plain_rates]
        for substructure in self.substructures:
            whole[:, substructure.speeds] = wide[:, substructure.rates] @ substructure.carried
        return whole

    def joined(self, z: Vector, parts: Sequence[Vector]) -> Vector:
        """Return a vector over the free speeds of the scene from one of the twin and those of the substructures."""
        whole = np.empty(self.model.free_count)
        whole[self.plain_speeds] = z[self.plain_rates]
        for substructure, part in zip(self.substructures, parts, strict=True):
            whole[substructure.speeds] = part
        return whole


def is_unreduced(body: BodyTerms) -> bool:
    """Return whether a body has all degrees of freedom of its mesh."""
    return body.flexible is not None and isinstance(body.flexible.body, UnreducedBody)


def _attached_frames(model: ModelData) -> list[dict[int, InterfaceFrame]]:
    """Return for each body the frames at which something is attached, by identity."""
    found: list[dict[int, InterfaceFrame]] = [{} for _ in model.bodies]
    for number, body in enumerate(model.bodies):
        if body.parent_interface is not None:
            found[body.parent][id(body.parent_interface)] = body.parent_interface
        for _, frame in body.loads:
            if frame is not None:
                found[number][id(frame)] = frame
    for marker in model.markers():
        if marker.interface is not None:
            found[marker.body][id(marker.interface)] = marker.interface
    return found


def _takes_state(model: ModelData) -> bool:
    """Return whether a function of the user depends on the state and so may use any interface."""
    loads = [load for body in model.bodies for load, _ in body.loads]
    others = [load for body in model.bodies for load in (*body.joint_loads, *body.field_loads)]
    return any(getattr(load, "takes_state", False) for load in (*loads, *others))
