"""The quantities of a result: titles, units and components, for accessors, axes and files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


@dataclass(frozen=True)
class Quantity:
    """Title and columns of a channel, for axes and files.

    Attributes
    ----------
    title : str
    parts : tuple of (label, unit, components)
        The columns in groups of one unit. Without components the channel has one number per time; the columns of a
        joint or of the modes are named by the body.
    """

    title: str
    parts: tuple[tuple[str, str, tuple[str, ...]], ...]

    @property
    def units(self) -> str:
        """Unit of the channel; if they differ, the units of its parts in order."""
        return ", ".join(unit for _, unit, _ in self.parts)


XYZ = ("x", "y", "z")
WRENCH = (("force", "N", XYZ), ("moment", "N m", XYZ))

MOTIONS = {
    "position": Quantity("position in N", (("position", "m", XYZ),)),
    "rotation": Quantity("Euler parameters from N", (("Euler parameters", "1", ("e0", "e1", "e2", "e3")),)),
    "velocity": Quantity("velocity in N", (("velocity", "m/s", XYZ),)),
    "angular_velocity": Quantity("angular velocity in the body's axes", (("angular velocity", "rad/s", XYZ),)),
    "acceleration": Quantity("acceleration in N", (("acceleration", "m/s2", XYZ),)),
    "angular_acceleration": Quantity(
        "angular acceleration in the body's axes", (("angular acceleration", "rad/s2", XYZ),)
    ),
}
JOINTS = {
    "joint_coordinates": Quantity("joint coordinates", (("joint coordinates", "by coordinate", ()),)),
    "joint_speeds": Quantity("joint speeds", (("joint speeds", "by coordinate", ()),)),
    "joint_reaction": Quantity("reaction of the joint on the body, in its axes", WRENCH),
}
DRIVES = {
    "driving_force": Quantity(
        "driving force of the joint", (("driving force", "N, of an angle N m, of a given pose W", ()),)
    )
}
LOOPS = {"loop_force": Quantity("force of the loop joint on its end b, in the axes of that end", WRENCH)}
GEARS = {
    "gear_force": Quantity(
        "force of the gear on each coordinate that it couples", (("gear force", "N, of an angle N m", ()),)
    )
}
LOADS = {"load": Quantity("load between frames", (("load", "by column", ()),))}
POINTS = {"contact_points": Quantity("points of a contact", (("contact points", "by column", ()),))}
MODES = {
    "modal_coordinates": Quantity("modal coordinates", (("modal coordinates", "kg^1/2 m (unreduced: m, rad)", ()),)),
    "modal_speeds": Quantity("modal speeds", (("modal speeds", "kg^1/2 m/s (unreduced: m/s, rad/s)", ()),)),
}
INTERFACES = {
    "deflection": Quantity("deflection in G", (("translation", "m", XYZ), ("slope", "rad", XYZ))),
    "coupling_force": Quantity("coupling force on the flexible body, in G", WRENCH),
}
ENERGIES = {
    "kinetic_energy": Quantity("kinetic energy", (("energy", "J", ()),)),
    "elastic_energy": Quantity("elastic energy", (("energy", "J", ()),)),
    "gravity_energy": Quantity("potential energy of gravity", (("energy", "J", ()),)),
    "dissipated_energy": Quantity("energy dissipated", (("energy", "J", ()),)),
    "work": Quantity("work of loads and drives", (("energy", "J", ()),)),
    "impact_energy": Quantity("energy given by impacts of rigid contacts", (("energy", "J", ()),)),
}
MOMENTA = {
    "linear_momentum": Quantity("linear momentum in N", (("linear momentum", "kg m/s", XYZ),)),
    "angular_momentum": Quantity("angular momentum about N's origin", (("angular momentum", "kg m2/s", XYZ),)),
}
CENTRES = {"center_of_mass": Quantity("centre of mass in N", (("position", "m", XYZ),))}
OF_SCENE = ENERGIES | MOMENTA
QUANTITIES: Mapping[str, Quantity] = (
    MOTIONS | CENTRES | JOINTS | DRIVES | LOOPS | GEARS | LOADS | POINTS | MODES | INTERFACES | OF_SCENE
)
WITH_OWN_NAMES = ("joint_coordinates", "joint_speeds", *DRIVES, *GEARS, *LOADS, *POINTS)
"""Quantities whose columns have names of their own: of the joint, the gear or the load."""

OF_CONNECTIONS = LOOPS | GEARS | LOADS | POINTS
"""Quantities of loops, gears, loads and contacts by their names, and not of bodies."""

FORCES = ("joint_reaction", "driving_force", "coupling_force", "loop_force", "gear_force")
"""Quantities that need the residuals of the equations."""


def resolved_parts(
    quantity: str, columns: Sequence[str] = (), count: int = 0, is_orthonormal: bool = True
) -> tuple[tuple[str, str, tuple[str, ...]], ...]:
    """Return (label, unit, column names) of a quantity of one body, in order, adjacent ones of the same unit together.

    Parameters
    ----------
    quantity : str
        A key of `QUANTITIES`.
    columns : sequence of str
        Names of the joint's coordinates (driven ones for a driving force, those of bodies for a gear's) or speeds with
        their units in brackets, as joints give them.
    count : int
        Number of modes.
    is_orthonormal : bool
        Whether the modes have unit modal mass.
    """
    parts = QUANTITIES[quantity].parts
    label, unit, _ = parts[0]
    if quantity in MODES:
        reduced, _, full = unit.removesuffix(")").partition(" (unreduced: ")
        return ((label, reduced if is_orthonormal else full, tuple(f"{i}" for i in range(count))),)
    if quantity in DRIVES and len(columns) == 1:
        return ((label, _force_unit(columns[0]), ()),)
    if quantity not in WITH_OWN_NAMES:
        return parts
    groups: list[tuple[str, list[str]]] = []
    for column in columns:
        name, _, bracket = column.partition(" [")
        of = _force_unit(column) if quantity in DRIVES or quantity in GEARS else bracket.removesuffix("]") or "1"
        if not groups or groups[-1][0] != of:
            groups.append((of, []))
        groups[-1][1].append(name)
    return tuple((label, unit, tuple(names)) for unit, names in groups)


def _force_unit(column: str) -> str:
    return "W" if "[s]" in column else "N m" if "rad" in column else "N"


@dataclass(frozen=True, eq=False)
class Energy:
    """Energies at the output times, each (T,) in J.

    Attributes
    ----------
    kinetic, elastic, gravity : ndarray
        `gravity` is zero if every centre of mass is at N's origin.
    dissipated, work : ndarray
        Dissipated by damping, and work of loads and drives, since the start.
    impacts : ndarray
        What impacts of rigid contacts have given to the motion of what touches since the start, below zero where they
        have taken it. It is within the former two: of surfaces that nothing drives it is part of `dissipated`.
    """

    kinetic: np.ndarray
    elastic: np.ndarray
    gravity: np.ndarray
    dissipated: np.ndarray
    work: np.ndarray
    impacts: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """Mechanical energy, kinetic + elastic + gravity."""
        return np.asarray(self.kinetic + self.elastic + self.gravity)

    @property
    def balance_error(self) -> np.ndarray:
        """Mechanical energy plus what was dissipated less the work, minus the start: zero in exact arithmetic."""
        balance = self.total + self.dissipated - self.work
        return np.asarray(balance - balance[0])


class Momentum(NamedTuple):
    """Momenta in components of N, each (T, 3): `linear` in kg m/s, `angular` about N's origin in kg m2/s."""

    linear: np.ndarray
    angular: np.ndarray
