"""Which forces are told of a state, and where, beside tables in which every body has a row of its own."""

from enum import IntEnum
from typing import Annotated, NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import IntegerRows, Integers, RealRows, Reals
from kanefe.kernels.contact.output_places import (
    CONTACT_OUTPUTS,
    POINT_OUTPUTS,
    ContactsOutputs,
    PointsOutputs,
)
from kanefe.kernels.force_elements.places import WRENCH, Wrenches
from kanefe.kernels.language import Array, Many, Record, Rows, Start, Table, Values, in_place, inlined
from kanefe.kernels.loads.markers import Marker
from kanefe.kernels.scene import Scene, Work, memory_size, work_in
from kanefe.kernels.values.tensors import Vector

BodyFrames = Rows[Marker]
"""The frame of each body, in its row."""


class ToldLoop(Record, is_frozen=True):
    """A loop joint, or another constraint with two ends: its first row, and how many it has."""

    first: int
    count: int


class ToldGear(Record, is_frozen=True):
    """A coordinate that a gear, rack or other coupler couples: the row of that, and its coefficient there."""

    row: int
    coefficient: float


class HeldBody(Record, is_frozen=True):
    """A flexible body with components fixed in G.

    Attributes
    ----------
    row, first, count : int
        Its row, the first of these components, and how many they are.
    width : int
        Numbers of a motion: 6, and k.
    motions : ndarray, shape (count, width)
        Of G and of the modes, by a unit displacement along each.
    """

    row: int
    first: int
    count: int
    width: int
    constants: Annotated[int, Start("pool")]
    motions: Annotated[np.ndarray, Array("count", "width")]


class FixedComponent(Record, is_frozen=True):
    """A component that is fixed in G: row of its interface, which of six it is, and its axis in G."""

    row: int
    component: int
    axis: Vector


class ToldPart(Record, is_frozen=True):
    """A part of the force at an interface: the row of that, the first of its sources, and how many they are."""

    row: int
    first: int
    count: int


class SourceKind(IntEnum):
    """What a force comes from: components fixed in G, a body, rows of constraints, an end of a load, a point load."""

    CARRIER = 0
    CHILD = 1
    LOOP = 2
    LOAD = 3
    POINT_LOAD = 4


class ToldSource(Record, is_frozen=True):
    """A source: its `SourceKind`, number of the first, how many there are, and the end of these (0, 1)."""

    kind: int
    first: int
    count: int
    end: int


ToldLoops = Rows[ToldLoop]
ToldGears = Rows[ToldGear]
HeldBodies = Rows[HeldBody]
FixedComponents = Rows[FixedComponent]
ToldParts = Rows[ToldPart]
ToldSources = Rows[ToldSource]


@in_place
class ForceTables(NamedTuple):
    """Forces that are told of a scene.

    Attributes
    ----------
    bodies, frames : ndarray
        `BodyFrames`.
    loops : ndarray of int
        `ToldLoops`.
    gears, coefficients : ndarray
        `ToldGears`.
    held, pool : ndarray
        `HeldBodies`.
    components, axes : ndarray
        `FixedComponents`.
    parts, sources : ndarray of int
        `ToldParts`, `ToldSources`.
    told, work : ndarray of int
        The whole numbers of `ToldForces` and of `ForceWork`.
    """

    bodies: IntegerRows
    frames: RealRows
    loops: IntegerRows
    gears: IntegerRows
    coefficients: RealRows
    held: IntegerRows
    pool: Reals
    components: IntegerRows
    axes: RealRows
    parts: IntegerRows
    sources: IntegerRows
    told: Integers
    work: Integers


class ToldForces(Record, is_frozen=True):
    """What is told of a state.

    Attributes
    ----------
    size : int
        How many numbers it has.
    rates : ndarray
        Of the state.
    reactions : Wrenches
        Of joints on their bodies.
    driving : ndarray
        Of drives.
    loops : Wrenches
        Of loops on their ends b.
    gears : ndarray
        Of gears on coordinates.
    parts, ends : Wrenches
        Parts of the forces at interfaces, and those of loads between frames on their ends.
    contacts, points : Rows
        Outputs of rigid contacts, and of their points.
    """

    size: int
    rate_count: int
    body_count: int
    drive_count: int
    loop_count: int
    gear_count: int
    part_count: int
    end_count: int
    contact_count: int
    point_count: int
    begins: Annotated[int, Start("memory")]
    rates: Annotated[np.ndarray, Array("rate_count")]
    reactions: Annotated[Wrenches, Table(Wrenches, "body_count", WRENCH)]
    driving: Annotated[np.ndarray, Array("drive_count")]
    loops: Annotated[Wrenches, Table(Wrenches, "loop_count", WRENCH)]
    gears: Annotated[np.ndarray, Array("gear_count")]
    parts: Annotated[Wrenches, Table(Wrenches, "part_count", WRENCH)]
    ends: Annotated[Wrenches, Table(Wrenches, "end_count", WRENCH)]
    contacts: Annotated[ContactsOutputs, Table(ContactsOutputs, "contact_count", CONTACT_OUTPUTS)]
    points: Annotated[PointsOutputs, Table(PointsOutputs, "point_count", POINT_OUTPUTS)]


class ForceWork(Record, is_frozen=True):
    """What is written on the way to the forces of a state, beside two works.

    Attributes
    ----------
    size, state_count, end_count, component_count, exerted_size : int
    load_rates, powers : ndarray, shapes (states,), (2,)
        That nobody asks for.
    points : Values
        Where the ends of loads are, in N.
    components, pivots : ndarray, shape (c,)
        Forces along the components fixed in G; workspace.
    system : ndarray, shape (c, c)
    exerted : ndarray
        What rows exert.
    """

    size: int
    state_count: int
    end_count: int
    component_count: int
    exerted_size: int
    begins: Annotated[int, Start("memory")]
    load_rates: Annotated[np.ndarray, Array("state_count")]
    powers: Annotated[np.ndarray, Array(2)]
    points: Annotated[Values, Many(Vector, "end_count")]
    components: Annotated[np.ndarray, Array("component_count")]
    pivots: Annotated[np.ndarray, Array("component_count")]
    system: Annotated[np.ndarray, Array("component_count", "component_count")]
    exerted: Annotated[np.ndarray, Array("exerted_size")]


class ForceMemory(NamedTuple):
    """All that is written on the way to the forces of a state.

    Attributes
    ----------
    work, moving : Work
        With the motion of the state, and with the motion that its accelerations would cause as speeds.
    own : ForceWork
    """

    work: Work
    moving: Work
    own: ForceWork


@inlined
def forces_in(memory: np.ndarray, scene: Scene, forces: ForceTables) -> ForceMemory:
    """Return the parts of a memory of `force_memory_size`."""
    work = work_in(scene, memory)
    return ForceMemory(work, work_in(scene, memory[work.size :]), ForceWork(forces.work, memory[2 * work.size :]))


def force_memory_size(scene: Scene, forces: ForceTables) -> int:
    """Return how long the memory is."""
    return 2 * memory_size(scene) + ForceWork(forces.work, np.zeros(0)).size
