"""Coupling forces of a run: the force on a flexible body at an interface, in total and by source (Eq. 30)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from kanefe.frames import Matrix, Vector, cross, rotation_matrix
from kanefe.kane.coupling import unit_wrenches
from kanefe.kane.reactions import held_wrenches
from kanefe.kane.state import State
from kanefe.tree.neighbours import BODY, FORCE, LOAD, LOOP, Source, sources_of
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame
    from kanefe.tree.body_terms import BodyTerms
    from kanefe.tree.model_data import ModelData

QUANTITY = "coupling_force"

Places = dict[Source, tuple[int, str, str]]
"""Number of the body, name of the interface, and name of the part, for each source."""


class Acting(NamedTuple):
    """A wrench at a state: force and moment (6,) about a point in N, in components of N."""

    source: Source
    point: Vector
    wrench: Vector


class RunStates(Protocol):
    """Requirements on a run in memory: `kanefe.results.channels.RunChannels`."""

    @property
    def model(self) -> ModelData: ...  # noqa: D102
    @property
    def times(self) -> Vector: ...  # noqa: D102
    @property
    def residual_forces(self) -> Matrix: ...  # noqa: D102
    def read(self, quantity: str, body: str = "", interface: str = "", of: str = "") -> Matrix: ...  # noqa: D102
    def placed(self, rows: Sequence[int]) -> Iterator[SceneState]: ...  # noqa: D102
    def acting_states(self) -> Iterator[tuple[State, Vector]]: ...  # noqa: D102


def coupling_forces(run: RunStates, body: str, interface: str, of: str) -> dict[tuple[str, ...], Matrix]:
    """Return a part of the coupling force at an interface (Eq. 30), (T, 6), and parts found with it; "" is the total.

    About the deformed position of the interface, in axes of G: see `kanefe.results.reader.Reader.coupling_force`.
    """
    sources = sources_of(run.model)[run.model.index(body), interface]
    parts = sources.neighbours.parts(of, f"{interface!r} of {body!r}")
    key = (QUANTITY, body, interface, of) if of else (QUANTITY, body, interface)
    if parts != (of,):
        return {key: sum((run.read(QUANTITY, body, interface, part) for part in parts), np.zeros((len(run.times), 6)))}
    first = sources.named[of][0]
    if first.kind != BODY:
        return _of_loads_and_loops(run)
    return {key: _of_carrier(run, body, interface) if first.end == 0 else _of_carried(run, body, interface, first.name)}


def _of_carrier(run: RunStates, body: str, interface: str) -> Matrix:
    """Return F_u of the components fixed in G, along the axes that they hold: see `unit_wrenches`."""
    terms = run.model.flexible_terms(body)
    frame = terms.body.interface(interface)
    components, forces = frame.fixed_components, run.residual_forces[:, _fixed_columns(run, body, frame)]
    slopes = run.read("deflection", body, interface)[:, 3:]
    if not slopes.any() or max(components) < 3:  # the axes of its moments do not turn with released slopes
        return np.asarray(forces @ unit_wrenches(components, np.eye(3), frame.axes).T)
    tangent = run.model.slopes.tangent
    wrenches = (unit_wrenches(components, tangent(theta), frame.axes) for theta in slopes)
    return np.array([wrench @ force for wrench, force in zip(wrenches, forces, strict=True)])


def _fixed_columns(run: RunStates, body: str, frame: InterfaceFrame) -> list[int]:
    terms = run.model.flexible_terms(body)
    first = terms.fixed.start - terms.body.free_count - run.model.free_count
    return [first + column for column in frame.fixed_columns]


def _of_carried(run: RunStates, body: str, interface: str, child: str) -> Matrix:
    """Return the reversed joint reaction of a body attached to an interface, about the interface."""
    reaction = -run.read("joint_reaction", child)
    axes, own = (np.array([rotation_matrix(e) for e in run.read("rotation", name)]) for name in (child, body))
    force, moment = ((axes @ part[:, :, None])[:, :, 0] for part in (reaction[:, :3], reaction[:, 3:]))
    arm = run.read("position", child) - run.read("position", body, interface)
    moment = moment + cross(arm, force)
    return np.hstack([(part[:, None, :] @ own)[:, 0] for part in (force, moment)])


def _of_loads_and_loops(run: RunStates) -> dict[tuple[str, ...], Matrix]:
    """Return the forces of loops, contacts, loads and given forces at all interfaces, found from the same states."""
    model = run.model
    places: Places = {}
    kept: dict[tuple[str, ...], Matrix] = {}
    for (number, interface), sources in sources_of(model).items():
        for part, ends in sources.named.items():
            if ends[0].kind != BODY:
                kept[QUANTITY, model.bodies[number].name, interface, part] = np.zeros((len(run.times), 6))
                places |= dict.fromkeys(ends, (number, interface, part))
    rigid = {model.loads[i].name for i in model.rigid_contacts}
    is_held = any(source.kind == LOOP or (source.kind == LOAD and source.name in rigid) for source in places)
    for row, state in enumerate(_states(run, is_held)):
        for one in (*_known(state, places), *(_held(state) if is_held and isinstance(state, State) else ())):
            if one.source not in places:
                continue
            number, interface, part = places[one.source]
            terms, A_NG = state.model.bodies[number], state.frames[number].A_NF
            arm = one.point - state.placed(number, _interface(terms, interface)).p_NoFo_N
            moment = one.wrench[3:] + cross(arm, one.wrench[:3])
            own = np.concatenate((one.wrench[:3] @ A_NG, moment @ A_NG))
            kept[QUANTITY, terms.name, interface, part][row] += own
    return kept


def _states(run: RunStates, is_held: bool) -> Iterator[SceneState]:
    """Return the states: forces of constraints need partial velocities, loads only positions, which are cheaper."""
    if is_held:
        return (state for state, _ in run.acting_states())
    return run.placed(range(len(run.times)))


def _interface(body: BodyTerms, name: str) -> InterfaceFrame:
    return next(n for n in body.interfaces if n.name == name)


def _known(state: SceneState, places: Places) -> Iterator[Acting]:
    """Yield the forces of loads between frames and given forces at interfaces; loads elsewhere are not evaluated."""
    for number, load in enumerate(state.model.loads):
        ends = [i for i in range(len(load.ends)) if Source(LOAD, load.name, i) in places]
        if ends:
            own = state.load_ends(number)
            action = load.action(state.time, own, state.load_states(number))
            for i in ends:
                yield Acting(Source(LOAD, load.name, i), own[i].p, action.wrenches[i])
    for source, (number, _, _) in places.items():
        if source.kind == FORCE:
            given, frame = state.model.bodies[number].loads[source.end]
            at = state.placed(number, frame)
            force, moment = given.wrench(state.time, at, state)
            yield Acting(source, at.p_NoFo_N, np.concatenate((at.A_NF @ force, at.A_NF @ moment)))


def _held(state: State) -> Iterator[Acting]:
    """Yield the forces of loops and rigid contacts at their ends."""
    loops = {id(constraint) for constraint in state.model.constraints}
    for one in held_wrenches(state):
        end = next(i for i, marker in enumerate(one.constraint.ends) if marker is one.marker)
        A = one.frame.A_NF
        wrench = np.concatenate((A @ one.wrench[:3], A @ one.wrench[3:]))
        source = Source(LOOP if id(one.constraint) in loops else LOAD, one.constraint.name, end)
        yield Acting(source, one.frame.p_NoFo_N, wrench)
