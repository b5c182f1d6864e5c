"""Which forces are told of a state, and where, beside tables in which every body has a row of its own."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.arrays import IntegerRows, Integers, RealRows, Reals
from kanefe.kernels.compiler.signatures import in_place
from kanefe.kernels.scene import Scene, Work, memory_size, work_in
from kanefe.kernels.values.records import Array, Record, Start

WRENCH = 6

RATES, REACTIONS, DRIVING, LOOP_FORCES, GEAR_FORCES, PARTS, ENDS, CONTACTS, POINTS, WIDTH = range(10)
"""Columns at which the rates of the state begin in a row of what is told, and forces: of joints on their bodies, of
drives, of loops on their ends b, of gears on coordinates, parts of those at interfaces, of loads between frames on
their ends, outputs of rigid contacts and of their points; its width."""

# Columns of the integers of a held body
HELD_ROW, FIRST_COMPONENT, COMPONENT_COUNT, HELD_POOL = range(4)
# Columns of a component that is fixed in G: row of its interface, and which of six it is
AT_ROW, COMPONENT = range(2)
# Columns of a part of the force at an interface
PART_ROW, FIRST_SOURCE, SOURCE_COUNT = range(3)
# Columns of a source; the numbers are those of the first component, body, row of constraints, end or point load
SOURCE_KIND, FIRST_OF_SOURCE, COUNT_OF_SOURCE, END_OF_SOURCE = range(4)
OF_CARRIER, OF_CHILD, OF_LOOP, OF_LOAD, OF_POINT_LOAD = range(5)


@in_place
class ForceTables(NamedTuple):
    """Forces that are told of a scene.

    Attributes
    ----------
    bodies : ndarray of int, shape (bodies,)
        Row of each body.
    frames : ndarray, shape (bodies, 12)
        Origin and axes of its frame in the row.
    loops : ndarray of int, shape (loops, 2)
        First row of each loop joint or other constraint with two ends, and number of rows.
    gear_rows : ndarray of int, shape (g,)
        Row of the gear, of each coordinate that a gear, rack or other coupler couples.
    coefficients : ndarray, shape (g,)
        Its coefficient there.
    held : ndarray of int, shape (flexible bodies with components fixed in G, 4)
        Row, first component and their number, and where constants are in the pool: for each component the motion of G,
        (6,), and that of the k modes.
    components : ndarray of int, shape (c, 2)
    axes : ndarray, shape (c, 3)
        Axis of each component in G.
    pool : ndarray
    parts : ndarray of int, shape (p, 3)
    sources : ndarray of int, shape (s, 4)
    places : ndarray of int, shape (10,)
    work : ndarray of int
        The whole numbers of `ForceWork`.
    """

    bodies: Integers
    frames: RealRows
    loops: IntegerRows
    gear_rows: Integers
    coefficients: Reals
    held: IntegerRows
    components: IntegerRows
    axes: RealRows
    pool: Reals
    parts: IntegerRows
    sources: IntegerRows
    places: Integers
    work: Integers


class ForceWork(Record, is_frozen=True):
    """What is written on the way to the forces of a state, beside two works.

    Attributes
    ----------
    size, state_count, end_count, component_count, exerted_size : int
    load_rates, powers : ndarray, shapes (states,), (2,)
        That nobody asks for.
    points : ndarray, shape (ends, 3)
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
    points: Annotated[np.ndarray, Array("end_count", 3)]
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
