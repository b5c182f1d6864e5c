"""Forces of some states by the literal route, state by state: the reference of the compiled ones, see `RunForces`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from kanefe.frames import Matrix, Vector, cross, moved_to
from kanefe.kane.coupling import recovered_forces
from kanefe.kane.reactions import gear_forces, held_wrenches, joint_reactions, loop_forces
from kanefe.states.interactions import unit_wrenches
from kanefe.states.state import State
from kanefe.tree.model_data import ModelData
from kanefe.tree.neighbours import BODY, FORCE, LOAD, LOOP, InterfacePart, Source, parts_of

if TYPE_CHECKING:
    from kanefe.tree.route import Evaluates


class LiteralForces:
    """Forces of T states, computed when they are first asked for.

    Parameters
    ----------
    model : ModelData
        Of the run: names and numbers are its own.
    acting : callable
        Returns the states and their accelerations.
    """

    def __init__(self, model: ModelData, acting: Callable[[], Iterable[tuple[State, Vector]]]) -> None:
        self._model, self._acting = model, acting
        self._on_ends: dict[int, np.ndarray] = {}

    @classmethod
    def of_states(cls, route: Evaluates, times: Vector, states: Matrix) -> Self:
        """Return the forces of states (q, u, z), (T, state), at times (T,), whose accelerations a route gives."""
        n, m = route.model.coordinate_count, route.model.free_count

        def acting() -> Iterator[tuple[State, Vector]]:
            for t, y in zip(times.tolist(), states, strict=True):
                yield route.acting(t, y, route.evaluate(t, y).rates[n : n + m])

        return cls(route.model, acting)

    @cached_property
    def reactions(self) -> np.ndarray:
        """Wrench of each joint on its body, (T, bodies, 6)."""
        found = [joint_reactions(state, du) for state, du in self._acting()]
        return np.array(found).reshape(-1, len(self._model.bodies), 6)

    @cached_property
    def driving(self) -> Matrix:
        """Forces on the driven coordinates, (T, driven)."""
        return np.array([recovered_forces(state, du)[0] for state, du in self._acting()])

    @cached_property
    def loops(self) -> np.ndarray:
        """Wrench of each constraint with two ends on its end b, (T, loops, 6)."""
        found = [list(loop_forces(state).values()) for state, _ in self._acting()]
        return np.array(found).reshape(len(found), -1, 6)

    @cached_property
    def gears(self) -> Matrix:
        """Force of each gear on each coordinate that it couples, (T, coordinates of all gears)."""
        return np.array([gear_forces(state) for state, _ in self._acting()])

    def part(self, number: int) -> Matrix:
        """Return a part of the force at an interface, by its number among `parts_of`, (T, 6)."""
        return self._parts[:, number]

    @cached_property
    def _parts(self) -> np.ndarray:
        parts = parts_of(self._model)
        found = [part_forces(parts, state, du) for state, du in self._acting()]
        return np.array(found).reshape(-1, len(parts), 6)

    def on_end(self, number: int, end: int) -> Matrix:
        """Return the wrench of a load between frames on one of its ends, in N, (T, 6)."""
        if number not in self._on_ends:
            self._on_ends[number] = np.array([state.action(number).wrenches for state, _ in self._acting()])
        return self._on_ends[number][:, end]

    def contact(self, number: int) -> Matrix:
        """Return the outputs of a rigid contact, by its number among these, (T, 12)."""
        return np.array([contacts[number] for contacts, _ in self._contacts])

    def contact_points(self, number: int) -> np.ndarray:
        """Return those of its points, (T, points, 12)."""
        return np.array([points[number] for _, points in self._contacts])

    @cached_property
    def _contacts(self) -> list[tuple[list[Vector], list[Matrix]]]:
        """Outputs of all rigid contacts, and of their points."""
        from kanefe.literal.contact_forces import rigid_point_outputs, told

        numbers = range(len(self._model.rigid_contacts))
        return [
            ([told(state, k) for k in numbers], [rigid_point_outputs(state, k) for k in numbers])
            for state, _ in self._acting()
        ]


class _Acting(NamedTuple):
    """Force and moment (6,) about a point in N, in components of N."""

    source: Source
    point: Vector
    wrench: Vector


def part_forces(parts: tuple[InterfacePart, ...], state: State, du: Vector) -> Matrix:
    """Return parts of the forces at interfaces, about their deformed positions, in axes of G, (parts, 6) (Eq. 30)."""
    acting = {one.source: one for one in (*_known(state, parts), *_held(state))}
    has_bodies = any(source.kind == BODY for part in parts for source in part.sources)
    reactions = joint_reactions(state, du) if has_bodies else []
    coupling = recovered_forces(state, du)[1] if state.model.fixed_count else np.zeros(0)
    numbers = {body.name: number for number, body in enumerate(state.model.bodies)}
    found = np.zeros((len(parts), 6))
    for part, own in zip(parts, found, strict=True):
        G = state.motions[part.body]
        frame = state.model.flexible_terms(state.model.bodies[part.body].name).body.interface(part.interface)
        place = state.placed(part.body, frame).p_NoFo_N
        for source in part.sources:
            if source.kind == BODY and source.end == 0:
                if frame.fixed_components:
                    own += _of_carrier(state, part, coupling)
                else:
                    own += moved_to(frame.position, reactions[part.body])
                continue
            if source.kind == BODY:
                child = state.motions[numbers[source.name]]
                force, moment = (-child.A_NF @ x for x in np.split(reactions[numbers[source.name]], 2))
                arm = child.p_NoFo_N - place
            elif source in acting:
                force, moment = np.split(acting[source].wrench, 2)
                arm = acting[source].point - place
            else:
                continue
            own += np.concatenate((force @ G.A_NF, (moment + cross(arm, force)) @ G.A_NF))
    return found


def _of_carrier(state: State, part: InterfacePart, coupling: Vector) -> Vector:
    """Return F_u of the components fixed in G, along the axes that they hold: see `unit_wrenches`."""
    model = state.model
    terms = model.flexible_terms(model.bodies[part.body].name)
    frame = terms.body.interface(part.interface)
    first = terms.fixed.start - model.free_count - model.driven_count - terms.body.free_count
    tangent = model.slopes.tangent(frame.moved(state.q[terms.eta])[0][3:])
    forces = coupling[[first + column for column in frame.fixed_columns]]
    return np.asarray(unit_wrenches(frame.fixed_components, tangent, frame.axes) @ forces)


def _known(state: State, parts: tuple[InterfacePart, ...]) -> Iterator[_Acting]:
    """Yield the forces of loads between frames and given forces at interfaces; loads elsewhere are not evaluated."""
    wanted = {(source, part.body) for part in parts for source in part.sources}
    for source, number in wanted:
        if source.kind == LOAD:
            of = next(i for i, load in enumerate(state.model.loads) if load.name == source.name)
            if of not in state.model.rigid_contacts:
                own = state.load_ends(of)
                yield _Acting(source, own[source.end].p, state.action(of).wrenches[source.end])
        elif source.kind == FORCE:
            given, frame = state.model.bodies[number].loads[source.end]
            at = state.placed(number, frame)
            force, moment = given.wrench(state.time, at, state)
            yield _Acting(source, at.p_NoFo_N, np.concatenate((at.A_NF @ force, at.A_NF @ moment)))


def _held(state: State) -> Iterator[_Acting]:
    """Yield the forces of loops and rigid contacts at their ends."""
    loops = {id(constraint) for constraint in state.model.constraints}
    for one in held_wrenches(state):
        end = next(i for i, marker in enumerate(one.constraint.ends) if marker is one.marker)
        A = one.frame.A_NF
        wrench = np.concatenate((A @ one.wrench[:3], A @ one.wrench[3:]))
        source = Source(LOOP if id(one.constraint) in loops else LOAD, one.constraint.name, end)
        yield _Acting(source, one.frame.p_NoFo_N, wrench)
