"""Bodies, loads, events, status and statistics of a run, and any of its quantities by name."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.integrate.sampling import ControllerLog
from kanefe.integrate.status import RunStatus
from kanefe.results.body_shape import BodyShape
from kanefe.results.channels import Channels, RunChannels
from kanefe.results.contact_history import is_contact
from kanefe.results.contact_points import point_columns
from kanefe.results.quantities import (
    CENTRES,
    DRIVES,
    GEARS,
    INTERFACES,
    LOADS,
    LOOPS,
    MODES,
    MOTIONS,
    OF_CONNECTIONS,
    OF_SCENE,
    POINTS,
    QUANTITIES,
    resolved_parts,
)
from kanefe.results.recorded import Recorded
from kanefe.results.surface_outline import SurfaceOutline
from kanefe.results.wholes import whole_motion, whole_shape, wholes_of


class EventTimes(dict[str, np.ndarray]):
    """Times at which events happened, by name."""

    def __missing__(self, name: str) -> np.ndarray:
        """Raise a ModelError that lists the events."""
        raise ModelError(
            f"the run has no event called {name!r}. It has: {', '.join(self) or 'none'}. Remedy: one of these; slack "
            f"and taut events of ropes and events of single contact points are reported on request, "
            f"simulate(events=[{name!r}])"
        )


class QuantityReader:
    """The names and quantities of `Reader`.

    Parameters
    ----------
    channels : Channels
        Of a run in memory, or of a file.
    """

    def __init__(self, channels: Channels) -> None:
        self._channels = channels

    @cached_property
    def _shapes(self) -> dict[str, BodyShape]:
        return {shape.name: shape for shape in self._channels.bodies}

    @cached_property
    def _wholes(self) -> dict[str, tuple[str, ...]]:
        return wholes_of(self._shapes)

    @cached_property
    def _whole_shapes(self) -> dict[str, BodyShape]:
        return {name: whole_shape(name, [self._shapes[n] for n in parts]) for name, parts in self._wholes.items()}

    @property
    def segmented(self) -> dict[str, tuple[str, ...]]:
        """Names of the segments of each segmented body, by its name, which other methods take too."""
        return dict(self._wholes)

    @property
    def run(self) -> RunChannels | None:
        """Model and trajectory of a run in memory; None of a result from a file."""
        return self._channels if isinstance(self._channels, RunChannels) else None

    @property
    def times(self) -> np.ndarray:
        """Output times, shape (T,), in s."""
        return self._channels.times

    @property
    def statistics(self) -> dict[str, Any]:
        """Method, reason and cost of the run; ``print(result)`` shows them in a few lines.

        "method" and the "reason" why it was chosen, its "rtol" or "step"; "route" of the equations and "route_reason"
        likewise; how many "steps", "rejected" steps, "evaluations" of the equations, "factorisations" and "jacobians"
        there were; "seconds" in total, and "seconds_by_part": set-up, compiling (or reading compiled kernels), steps,
        outputs, events, checkpoints. The time for forces and other quantities computed on request is not included.
        """
        return self._channels.statistics

    @property
    def records(self) -> Mapping[str, Recorded]:
        """What was recorded beside the output times, by name of column: see ``record=`` of `kanefe.System.simulate`.

        A saved result has those that were in memory; those of a file stay there.
        """
        return self._channels.records

    @property
    def status(self) -> RunStatus:
        """How the run ended: finished, stopped by an event or a limit, or failed, with a remedy."""
        return self._channels.status

    @property
    def events(self) -> dict[str, np.ndarray]:
        """Times at which each event happened, by name, s; see `kanefe.Event`."""
        return EventTimes(self._channels.events)

    @property
    def controllers(self) -> dict[str, ControllerLog]:
        """Samples of each controller, by name: ``times`` (K,), ``reads`` and ``drives`` (K, n), with their names."""
        return dict(self._channels.controllers)

    @property
    def has_forces(self) -> bool:
        """Whether accelerations, reactions and coupling forces are available; they can be left out of a file."""
        return self._channels.has_forces

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies, parents before children."""
        return tuple(self._shapes)

    @property
    def loops(self) -> tuple[str, ...]:
        """Names of the loop joints, distances and rolling contacts."""
        return self._channels.loops

    @property
    def gears(self) -> dict[str, tuple[str, ...]]:
        """Names of gears, racks and other couplers, and of the coordinates that each couples: see `gear_force`."""
        return dict(self._channels.gears)

    @property
    def loads(self) -> dict[str, tuple[str, ...]]:
        """Names of the loads between frames, and of their columns, with units in brackets: see `load`."""
        return dict(self._channels.loads)

    @property
    def surfaces(self) -> tuple[SurfaceOutline, ...]:
        """Outlines of the surfaces of contacts, and the bodies that carry them."""
        return self._channels.surfaces

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the contacts."""
        return tuple(name for name, columns in self.loads.items() if is_contact(columns))

    @property
    def point_counts(self) -> dict[str, int]:
        """Number of points of each contact."""
        return dict(self._channels.points)

    @checked
    def body(self, name: str) -> BodyShape:
        """Return mass, mesh and modes of a body; raise a ModelError that lists the names if there is none."""
        if name in self._wholes:
            return self._whole_shapes[name]
        if name not in self._shapes:
            raise ModelError(f"the run has no body called {name!r}. It has: {', '.join(self.bodies)}")
        return self._shapes[name]

    @checked
    def interfaces(self, name: str) -> tuple[str, ...]:
        """Return the names of the interfaces of a body; none for a rigid one."""
        return self.body(name).interfaces

    @checked
    def units(self, quantity: str, name: str | None = None) -> str:
        """Return the unit of a quantity; with the name of a body if the unit depends on its joint.

        ``result.units("coupling_force")`` is "N, N m"; ``result.units("joint_coordinates", "hub")`` is "rad". A
        ModelError lists the quantities if there is no such one.
        """
        if quantity in ("times", "nodal_displacements", "nodal_positions", "energy"):
            return {"times": "s", "energy": "J"}.get(quantity, "m")
        if quantity == "momentum":
            return "kg m/s, kg m2/s"
        if quantity not in QUANTITIES:
            raise ModelError(f"there is no quantity {quantity!r}. There are: {', '.join(QUANTITIES)}")
        if name is None:
            return QUANTITIES[quantity].units
        return ", ".join(unit for _, unit, _ in self.parts(quantity, name)) or "1"

    @checked
    def parts(self, quantity: str, name: str = "") -> tuple[tuple[str, str, tuple[str, ...]], ...]:
        """Return label, unit and column names of a quantity of a body, columns of one unit together."""
        if quantity not in QUANTITIES:
            raise ModelError(f"there is no quantity {quantity!r}. There are: {', '.join(QUANTITIES)}")
        if not name or quantity in LOOPS:
            return resolved_parts(quantity)
        if quantity in GEARS:
            return resolved_parts(quantity, self._gear(name))
        if quantity in LOADS:
            return resolved_parts(quantity, self.loads[name])
        if quantity in POINTS:
            return resolved_parts(quantity, point_columns(self._channels.points[self._contact(name)]))
        shape = self.body(name)
        names = {"joint_coordinates": shape.coordinate_names, "driving_force": shape.driven_names}
        return resolved_parts(
            quantity, names.get(quantity, shape.speed_names), shape.basis.shape[1], shape.is_orthonormal
        )

    def _check_connection(self, quantity: str, name: str, interface: str | None) -> None:
        """Raise a ModelError unless a loop, gear, load or contact has a quantity."""
        if quantity in LOOPS and (name not in self.loops or interface is not None):
            there = ", ".join(self.loops) or "none"
            of_gear = f". {name!r} is a gear or rack: its force is gear_force({name!r})" if name in self.gears else ""
            raise ModelError(f"the run has no loop joint called {name!r}. It has: {there}{of_gear}")
        if quantity in LOADS and (name not in self.loads or interface is not None):
            there = ", ".join(self.loads) or "none"
            raise ModelError(f"the run has no load between frames called {name!r}. It has: {there}")
        if interface is not None:
            taken = "gear" if quantity in GEARS else "contact"
            raise ModelError(f"{quantity} takes a {taken} and no interface, {interface!r} was given")
        if quantity in GEARS:
            self._gear(name)
        if quantity in POINTS:
            self._contact(name)

    @checked("quantity", "name", "interface")
    def read(self, quantity: str, name: str = "", interface: str | None = None, of: str | None = None) -> np.ndarray:
        """Return any quantity of `kanefe.results.quantities` by its name; the methods of `Reader` are easier to read.

        `of` is a part of a coupling force: see `coupling_force`.

        Raises
        ------
        ModelError
            If there is no such quantity, body or interface, or the body does not have the quantity; the message lists
            what there is.
        """
        if quantity not in QUANTITIES:
            raise ModelError(f"there is no quantity {quantity!r}. There are: {', '.join(QUANTITIES)}")
        if of is not None and quantity != "coupling_force":
            raise ModelError(f"of={of!r}: {quantity} has no parts. Remedy: leave it out")
        if quantity in OF_SCENE or (quantity in CENTRES and not name):
            return self._channels.read(quantity)
        if quantity in OF_CONNECTIONS:
            self._check_connection(quantity, name, interface)
            return self._channels.read(quantity, name)
        shape = self.body(name)
        if quantity in MODES or quantity in INTERFACES:
            self._flexible(name)
        if quantity in DRIVES and not shape.is_driven:
            driven = ", ".join(s.name for s in self._shapes.values() if s.is_driven) or "none"
            raise ModelError(f"the joint of body {name!r} is not driven by a motion. Driven are: {driven}")
        if interface is not None and quantity not in MOTIONS and quantity not in INTERFACES:
            raise ModelError(f"{quantity} takes a body and no interface, {interface!r} was given")
        if interface is not None or quantity in INTERFACES:
            self._interface(shape, quantity, interface)
        if of is not None and interface is not None:
            shape.neighbours[interface].parts(of, f"{interface!r} of {name!r}")
        if name in self._wholes:
            return whole_motion(quantity, [self._shapes[n] for n in self._wholes[name]], interface, of, self.read)
        if of is not None and interface is not None:
            return self._channels.read(quantity, name, interface, of)
        return self._channels.read(quantity, name, interface or "")

    def _gear(self, name: str) -> tuple[str, ...]:
        if name not in self.gears:
            there = ", ".join(self.gears) or "none"
            raise ModelError(f"the run has no gear or rack called {name!r}. It has: {there}")
        return self.gears[name]

    def _contact(self, name: str) -> str:
        if name not in self.contacts:
            raise ModelError(f"the run has no contact called {name!r}. It has: {', '.join(self.contacts) or 'none'}")
        return name

    def _interface(self, shape: BodyShape, quantity: str, interface: str | None) -> str:
        if interface is None:
            raise ModelError(f"{quantity} of {shape.name!r} needs an interface, one of: {_listed(shape)}")
        if interface not in shape.interfaces:
            raise ModelError(f"body {shape.name!r} has no interface called {interface!r}. It has: {_listed(shape)}")
        return interface

    def _flexible(self, name: str) -> BodyShape:
        shape = self.body(name)
        if not shape.is_flexible:
            flexible = ", ".join(s.name for s in self._shapes.values() if s.is_flexible) or "none"
            raise ModelError(f"body {name!r} is rigid: it has no modes, mesh or interfaces. Flexible are: {flexible}")
        return shape


def _listed(shape: BodyShape) -> str:
    return ", ".join(shape.interfaces) or "none"
