"""All forces of states of a run from one compiled call: see `kanefe.kernels.evaluation.forces`."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.frames import Matrix, Vector, moved_to
from kanefe.kernels.contact.output_places import CONTACT_OUTPUTS, POINT_OUTPUTS
from kanefe.kernels.force_elements.places import WRENCH
from kanefe.order_n.evaluated import Evaluated
from kanefe.tree.neighbours import LOAD, parts_of
from kanefe.tree.run_sweeps import FrameMotions

if TYPE_CHECKING:
    from kanefe.literal.run_forces import LiteralForces
    from kanefe.order_n.held_forces import HeldForces


class CompiledForces:
    """Forces of T states of a scene: see `kanefe.tree.run_sweeps.RunForces`.

    Parameters
    ----------
    route : Evaluated
    times : ndarray, shape (T,)
        s.
    drives : ndarray, shape (T, driven, 3)
    states : ndarray, shape (T, state)
    rates : ndarray, shape (T or 0, state and quadratures)
        Known ones, of scenes without constraints; without rows they are computed.
    motion : callable
        Returns the motion of a body's frame with accelerations, by the number of the body.
    """

    def __init__(
        self,
        route: Evaluated,
        times: Vector,
        drives: np.ndarray,
        states: Matrix,
        rates: Matrix,
        motion: Callable[[int], FrameMotions],
    ) -> None:
        self._route, self._times, self._drives, self._states, self._rates = route, times, drives, states, rates
        self._motion = motion
        self._held: dict[int, tuple[HeldForces, Matrix]] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        return CompiledForces, (self._route, self._times, self._drives, self._states, self._rates, self._motion)

    @cached_property
    def _found(self) -> tuple[Matrix, Vector]:
        """What the kernel tells of each state, and the numbers of the states of which the literal route has to."""
        route = self._route
        values = route.values_over(self._times, self._states)
        call, found, is_told = route.force_kernel.prepared(self._times, self._drives, values, self._states, self._rates)
        call()
        return found, np.flatnonzero(is_told == 0)

    def _literally(self, rows: Vector) -> LiteralForces:
        from kanefe.literal.run_forces import LiteralForces

        return LiteralForces.of_states(self._route, self._times[rows], self._states[rows])

    @cached_property
    def _of_rest(self) -> LiteralForces:
        """The forces of the states that the kernel leaves."""
        return self._literally(self._found[1])

    @cached_property
    def _of_all(self) -> LiteralForces:
        return self._literally(np.arange(len(self._times)))

    def _with_rest(self, found: np.ndarray, tell: Callable[[LiteralForces], np.ndarray]) -> np.ndarray:
        """Return what the kernel tells, (T, ...), with what the literal route tells of the states that it leaves."""
        if len(rest := self._found[1]):
            found[rest] = tell(self._of_rest)
        return found

    def _block(self, forces: str) -> Matrix:
        return self._route.force_kernel.told.block(self._found[0], forces)

    @cached_property
    def reactions(self) -> np.ndarray:
        """Wrench of each joint on its body, (T, bodies, 6)."""
        found = self._block("reactions").reshape(len(self._times), -1, WRENCH)
        return self._with_rest(found, lambda rest: rest.reactions)

    @cached_property
    def driving(self) -> Matrix:
        """Forces on the driven coordinates, (T, driven)."""
        found = self._block("driving")
        return self._with_rest(found, lambda rest: rest.driving)

    @cached_property
    def loops(self) -> np.ndarray:
        """Wrench of each constraint with two ends on its end b, (T, loops, 6)."""
        found = self._block("loops").reshape(len(self._times), -1, WRENCH)
        return self._with_rest(found, lambda rest: rest.loops)

    @cached_property
    def gears(self) -> Matrix:
        """Force of each gear on each coordinate that it couples, (T, coordinates of all gears)."""
        return self._with_rest(self._block("gears"), lambda rest: rest.gears)

    def part(self, number: int) -> Matrix:
        """Return a part of the force at an interface, by its number among `parts_of`, (T, 6)."""
        told = self._route.force_kernel.told
        if number in told.by_reaction:
            body, place = told.by_reaction[number]
            return moved_to(place, self.reactions[:, body])
        found = self._told_part(number)
        if number in told.undetermined:
            from kanefe.order_n.held_forces import are_served

            if not are_served(self._route.model, parts_of(self._route.model)[number].body):
                return self._of_all.part(number)
            found += self._of_carrier(number)
        return self._with_rest(found, lambda rest: rest.part(number))

    def _told_part(self, number: int) -> Matrix:
        return self._block("parts")[:, WRENCH * number : WRENCH * (number + 1)].copy()

    def _of_carrier(self, number: int) -> Matrix:
        """Return what holds an interface among others that share forces, (T, 6)."""
        from kanefe.order_n.held_forces import HeldForces

        model = self._route.model
        place = parts_of(model)[number]
        if place.body not in self._held:
            n, name = model.coordinate_count, model.bodies[place.body].name
            told, rigid = self._route.force_kernel.told, {model.loads[i].name for i in model.rigid_contacts}

            def at_interface(interface: str) -> Matrix:
                found = np.zeros((len(self._times), WRENCH))
                for i in told.numbers_of_parts(name, interface):
                    kind, source, _ = parts_of(model)[i].sources[0]  # all of a part are of one
                    if kind != LOAD or source in rigid:
                        found += self._told_part(i)
                return found

            held = HeldForces(
                model,
                place.body,
                self._states,
                self._found[0][:, n : n + model.free_count],
                self._motion(place.body),
                self._block("reactions")[:, WRENCH * place.body : WRENCH * (place.body + 1)],
                at_interface,
                self._told_end,
            )
            self._held[place.body] = held, held.forces()
        held, forces = self._held[place.body]
        frame = model.flexible_terms(model.bodies[place.body].name).body.interface(place.interface)
        return held.on_body(frame, forces)

    def on_end(self, number: int, end: int) -> Matrix:
        """Return the wrench of a load between frames on one of its ends, in N, (T, 6)."""
        return self._with_rest(self._told_end(number, end), lambda rest: rest.on_end(number, end))

    def _told_end(self, number: int, end: int) -> Matrix:
        first = WRENCH * (self._route.force_kernel.told.first_ends[number] + end)
        return self._block("ends")[:, first : first + WRENCH].copy()

    def contact(self, number: int) -> Matrix:
        """Return the outputs of a rigid contact, by its number among these, (T, 12)."""
        found = self._block("contacts")[:, CONTACT_OUTPUTS * number : CONTACT_OUTPUTS * (number + 1)].copy()
        return self._with_rest(found, lambda rest: rest.contact(number))

    def contact_points(self, number: int) -> np.ndarray:
        """Return those of its points, (T, points, 12)."""
        told = self._route.force_kernel.told
        first, last = told.first_points[number], told.first_points[number + 1]
        found = self._block("points").reshape(len(self._times), -1, POINT_OUTPUTS)[:, first:last].copy()
        return self._with_rest(found, lambda rest: rest.contact_points(number))
