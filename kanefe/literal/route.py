"""The literal route: every question of `kanefe.tree.route.Route` answered by the paper's equations, the oracle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.loads.base import Load
from kanefe.states.state import State, actions
from kanefe.tree.model_data import QUADRATURES, ModelData
from kanefe.tree.model_outputs import MechanicalEnergy
from kanefe.tree.route import Evaluation, Form, MethodNeeds, Obstacle, PreparedRun, WatchedEvents
from kanefe.tree.run_sweeps import RunSweeps
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.tree.contact_changes import ContactDecider
    from kanefe.tree.contact_steps import Stepped


class LiteralRoute:
    """The equations in dense matrices.

    Parameters
    ----------
    model : ModelData
    obstacles : tuple of Obstacle
        What keeps the scene from a faster route.
    """

    name = "literal"

    def __init__(self, model: ModelData, obstacles: tuple[Obstacle, ...] = ()) -> None:
        self.model, self.obstacles = model, obstacles
        self.reason = " and ".join(map(str, obstacles)) or "asked for"
        self._found: tuple[float, Vector] | None = None
        self.warns_at_start = False

    def started_otherwise(self, model: ModelData) -> Self:
        """Return the route of a model that differs in its start alone."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other.model, other._found, other.warns_at_start = model, None, False
        return other

    def lacks(self, form: Form) -> str:
        """Return why there are no sweeps and no substructures."""
        if form is Form.SWEEPS:
            lacking = " and ".join(map(str, self.obstacles)) or "what was asked for"
            return f"needs the order-n route, which does not have {lacking}. Remedy: method='auto'"
        if form is Form.SUBSTRUCTURES:
            return "has this form for unreduced bodies alone. Remedy: reduction=None"
        return ""

    def check_dense(self, what: str) -> None:
        """Nothing to refuse: all is dense."""

    def check_outputs(self, count: int) -> None:
        """Nothing to refuse: of a dense scene more fit than a run lasts."""

    @property
    def is_autonomous(self) -> bool:
        """Nothing is compiled."""
        return False

    @property
    def is_constant(self) -> bool:
        """Unknown, and so taken for not."""
        return False

    def parts(self, y: Vector) -> tuple[Vector, Vector, Vector]:
        """Return q, u and z of a state."""
        return self.model.parts(y)

    def view(self, t: float, y: Vector) -> State:
        """Return the state itself."""
        return State(self.model, t, *self.parts(y))

    def at(self, t: float, q: Vector, u: Vector | None = None, z: Vector | None = None) -> State:
        """Return a state by its parts; at rest, with the internal states of the start, if nothing else is given."""
        return State(self.model, t, q, u, z)

    def closed(self, t: float, q: Vector, u: Vector) -> tuple[Vector, Vector]:
        """Return the coordinates nearest to q that close loops, and the speeds nearest to u that keep them closed."""
        from kanefe.literal.loop_closure import project_positions, project_speeds

        q = project_positions(self.model, t, q)
        return q, project_speeds(self.model, t, q, u)

    def with_consistent_loads(self, t: float, q: Vector, u: Vector) -> Vector:
        """Return the internal states of the start with loads of joints under the friction that they make."""
        from kanefe.literal.bearing_loads import with_consistent_loads

        return with_consistent_loads(self.model, t, q, u, self.model.initial_states)

    def responses(self, state: State, F: Matrix) -> Matrix:
        """Return the accelerations of the free speeds (free, k) that forces on them (free, k) add; loops hold."""
        from kanefe.literal.impulses import unit_responses

        return unit_responses(state, F)

    def accelerations_at(self, state: State) -> Vector:
        """Return du of the free speeds at a state, (free,): see `kanefe.kane.assemble.accelerations`."""
        from kanefe.kane.assemble import accelerations

        return accelerations(state)

    def system(self, state: State) -> tuple[Matrix, Vector]:
        """Return M_sys and F_sys over the speeds that a state spans: see `kanefe.kane.assemble.equations`."""
        from kanefe.kane.assemble import equations

        return equations(state)

    def masses(self, state: State) -> Matrix:
        """Return M_sys alone, without evaluating loads."""
        from kanefe.kane.assemble import mass_matrix

        return mass_matrix(state)

    def reactions(self, state: State) -> list[Vector]:
        """Return what each joint exerts on its body at a state, (6,): see `kanefe.kane.reactions`."""
        from kanefe.kane.reactions import joint_reactions

        return joint_reactions(state, self.accelerations_at(state))

    def open_loops(self, t: float, q: Vector, z: Vector) -> tuple[float, str]:
        """Return how far the most open constraint that holds is open, relative to the scene, and the names of such."""
        from kanefe.literal.loop_closure import open_constraints, openings

        found = openings(self.model, t, q, z)
        return found.worst, open_constraints(found)

    def mass_at_start(self, t: float) -> Matrix:
        """Return M_sys over the free speeds as the scene starts at a time (s), (free, free); not to be written to."""
        from kanefe.kane.assemble import mass_at_start

        return mass_at_start(self.model, t)

    def tangents(self, state: State) -> tuple[Matrix, Matrix]:
        """Return stiffness and damping over the free speeds at a state."""
        from kanefe.states.tangents import current_tangents
        from kanefe.tree.tangents import constant_tangents

        return current_tangents(state, *constant_tangents(self.model))

    def step_over_impacts(self, t: float, y: Vector, h: float) -> Stepped:
        """Return the state after a step of h (s) of Moreau and Jean."""
        from kanefe.literal.impact_steps import stepped

        return stepped(self.model, t, y, h)

    def state(self, t: float, y: Vector) -> SceneState:
        """Return the state itself."""
        return self.view(t, y)

    def acting(self, t: float, y: Vector, du: Vector) -> tuple[State, Vector]:
        """Return the state itself."""
        return self.view(t, y), du

    def widened(self, partial: Matrix) -> Matrix:
        """Return the same partial velocities."""
        return partial

    def start(self, t: float) -> Vector:
        """Return (q, u, z) at the start: see `consistent_start`."""
        from kanefe.literal.consistent_start import consistent_start

        if self._found is None or self._found[0] != t:  # a run asks when it chooses a method, and when it begins
            found = np.concatenate((*consistent_start(self.model, t), self.model.initial_states))
            if self.model.rigid_contacts:
                found = self.projected(t, self.touched(t, found, 0.0, np.inf, 0.0))
            self._found = t, found
        return self._found[1].copy()

    def started(self, t: float, loads: Sequence[Load]) -> tuple[Load, ...]:
        """Return loads between frames as they start."""
        from kanefe.loads.checks import check_start

        model = self.model.with_loads(loads)
        state = State(model, t, model.initial_coordinates, model.initial_speeds)
        started = tuple(load.started(t, state.load_ends(i)) for i, load in enumerate(loads))
        for i, load in enumerate(started):
            check_start(load, t, state.load_ends(i))
        if model.rigid_contacts:
            from kanefe.literal.contact_forces import check_movable

            for number in range(len(model.rigid_contacts)):
                check_movable(state, model.rigid_contact(number))
        return started

    def rates(self, t: float, y: Vector) -> Vector:
        """Return dy/dt of a state without quadratures: see `evaluate`."""
        return self.evaluate(t, y).rates[: len(y)]

    def evaluate(self, t: float, y: Vector) -> Evaluation:
        """Return the rates at a state; near a singular position those of the nearest one whose loops are closed."""
        from kanefe.kane.assemble import accelerations, held_accelerations
        from kanefe.states.constraints import held_rows

        state, weakest = self.view(t, y), 1.0
        if self.model.rigid_contacts:
            from kanefe.literal.contact_forces import check_determined

            check_determined(state)
        if self.model.is_constrained and held_rows(state):
            _, _, weakest = held_accelerations(state)
            if weakest < NEAR_SINGULAR:
                state = self.view(t, self.projected(t, y))
        du = accelerations(state)
        rates = self.model.coordinate_rates(state.q, state.u), du, state_rates(state), powers(state, du)
        return Evaluation(np.concatenate(rates), weakest)

    def wrenches_of_loads(self, t: float, y: Vector) -> dict[int, Matrix]:
        """Return the wrenches of loads between frames on their ends in N."""
        rigid = set(self.model.rigid_contacts)
        return {i: one.wrenches for i, one in enumerate(actions(self.view(t, y))) if i not in rigid}

    def mass_matrix(self, t: float, y: Vector) -> Matrix:
        """Return M_sys over the free and the driven speeds at a state."""
        from kanefe.kane.assemble import mass_matrix

        return mass_matrix(self.view(t, y))

    def derivatives(self, t: float, y: Vector, directions: Matrix, reaches: Vector | None = None) -> Matrix | None:
        """None: the dense equations are not complex."""
        return None

    def calls_for_derivatives(self, t: float, y: Vector, directions: Matrix) -> int:
        """Return the number of evaluations for differences: one call in each."""
        return 2 * len(directions)

    def partial_derivatives(self, t: float, y: Vector, directions: Matrix) -> Matrix | None:
        """None either."""
        return None

    def projected(self, t: float, y: Vector, share: float = 0.0) -> Vector:
        """Return the nearest state at which loops are closed and stay closed; y itself if it is one."""
        if not self.model.is_constrained:
            return y
        from kanefe.literal.loop_closure import project
        from kanefe.tree.tangents import constant_tangents

        state = self.view(t, y)
        closed = project(state, share * constant_tangents(self.model)[0] if share > 0.0 else None)
        if closed is state:
            return y
        return np.concatenate((closed.q, closed.u, y[len(state.q) + len(state.u) :]))

    def sweeps(self, times: np.ndarray, states: Matrix) -> RunSweeps | None:
        """None: each state is evaluated by itself."""
        return None

    @property
    def watching(self) -> WatchedEvents | None:
        """None: functions of events are called from Python."""
        return None

    def energy(self, t: float, y: Vector) -> MechanicalEnergy:
        """Return the energies of a state, from one sweep."""
        from kanefe.kane.energy import elastic_energy, gravity_energy, kinetic_energy

        state = self.view(t, y)
        return MechanicalEnergy(kinetic_energy(state), elastic_energy(state), gravity_energy(state))

    def momenta(self, t: float, y: Vector) -> tuple[Vector, Vector]:
        """Return linear and angular momentum."""
        from kanefe.kane.energy import momenta

        return momenta(self.view(t, y))

    def asked_contacts(
        self, what: int, t: float, y: Vector, span: float = 0.0, stop: float = np.inf, rtol: float = 0.0
    ) -> ContactDecider:
        """Return what has decided an event of rigid contacts, or has been asked for their margins."""
        from kanefe.literal.contact_instant import LiteralInstant
        from kanefe.tree.contact_changes import decider_by

        decider = decider_by(self.model, LiteralInstant)
        decider.ask(what, t, y, span, stop, rtol)
        return decider

    def touched(self, t: float, y: Vector, span: float, stop: float, rtol: float) -> Vector:
        """Return a state with what touches in it known."""
        from kanefe.tree.contact_changes import touched

        return touched(self, t, y, span, stop, rtol)

    def powers(self, t: float, y: Vector, du: Vector) -> Vector:
        """Return the power taken and given."""
        return powers(self.view(t, y), du)

    def sweep_implicitly(
        self, t: float, vectors: np.ndarray, share_damping: float, share_stiffness: float, share_of_rates: float = 0.0
    ) -> float:
        """Refused: there are no sweeps."""
        raise TypeError("the literal route has no sweeps")

    def balance(self, run: Any) -> None:
        """Refused: there are no sweeps."""
        raise TypeError("the literal route has no sweeps")

    def compiled_run(
        self, integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, needs: MethodNeeds
    ) -> PreparedRun:
        """Refused: nothing is compiled."""
        raise TypeError("the literal route is not compiled")

    def impact_steps(self, told: Vector, too_deep: float, bends: tuple[np.ndarray, np.ndarray]) -> Any | None:
        """None: steps over impacts are those of `kanefe.literal.impact_steps`."""
        return None

    def check_functions(self, t: float, y: Vector) -> None:
        """Nothing to do: they are checked where they are called."""


def powers(state: State, du: Vector) -> Vector:
    """Return the power that dampers take and that loads and drives give, W; of scenes without them nothing is found."""
    if not state.model.has_power:
        return np.zeros(QUADRATURES)
    from kanefe.kane.energy import dissipated_power, drive_power, load_power

    found = np.array((dissipated_power(state), load_power(state) + drive_power(state, du)))
    if state.model.rigid_contacts:
        from kanefe.literal.contact_forces import friction_powers

        found += friction_powers(state)
    return found


def state_rates(state: State) -> Vector:
    """Return the rates of all internal states, (states,); those of switches are zero."""
    from kanefe.literal.bearing_loads import add_load_rates

    rates = np.zeros_like(state.z)
    for where, action in zip(state.model.load_states, actions(state), strict=True):
        if len(action.rates):
            rates[where] = action.rates
    if state.model.rigid_contacts:
        from kanefe.literal.contact_forces import contact_rates

        contact_rates(state, rates)
    add_load_rates(state, rates)
    return rates
