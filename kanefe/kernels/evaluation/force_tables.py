"""Which forces are told of a state, and where, beside tables in which every body has a row of its own."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler._numba import expanded
from kanefe.kernels.compiler.arrays import IntegerRows, Integers, RealRows, Reals
from kanefe.kernels.constraints.loop_tables import wrenches_size
from kanefe.kernels.layout import DRIVES, MODAL_SIZE, SPEEDS, STATES, WORK, work_size
from kanefe.kernels.loads.loads_layout import WHOLE
from kanefe.kernels.tables import FlexibleTables, LoadsBetween, Loops, Tables

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


class ForceWorkspace(NamedTuple):
    """What is written on the way to the forces of a state.

    Attributes
    ----------
    work, moving : ndarray, shape (rows, WORK)
        With the motion of the state, and with the motion that its accelerations would cause as speeds.
    modal, modal_rates : ndarray
        Of flexible bodies, likewise.
    applied : ndarray, shape (free + driven,)
    load_rates : ndarray, shape (states,)
    still : ndarray, shape (driven, 3)
        Drives that do not move.
    points : ndarray, shape (ends, 3)
        Where the ends of loads are, in N.
    components : ndarray, shape (c,)
        Forces along the components fixed in G.
    system, pivots : ndarray, shapes (c c,), (c,)
    holding, acting : ndarray
        Of what rows exert, and of `add_loads_between`.
    """

    work: np.ndarray
    moving: np.ndarray
    modal: np.ndarray
    modal_rates: np.ndarray
    applied: np.ndarray
    load_rates: np.ndarray
    still: np.ndarray
    points: np.ndarray
    components: np.ndarray
    system: np.ndarray
    pivots: np.ndarray
    holding: np.ndarray
    acting: np.ndarray


def force_memory_size(
    tables: Tables, flexible: FlexibleTables, between: LoadsBetween, loops: Loops, forces: ForceTables
) -> int:
    """Return how many numbers the workspace has."""
    modes = int(flexible.sizes[MODAL_SIZE])
    driven, c = int(tables.sizes[DRIVES]), len(forces.components)
    speeds = int(tables.sizes[SPEEDS]) + driven
    size = 2 * (work_size(tables) + modes) + speeds + int(tables.sizes[STATES]) + 3 * driven
    of_loads = 3 * len(between.rows) + int(between.workspace_size[WHOLE])
    return size + of_loads + c * (2 + c) + wrenches_size(loops)


@expanded
def force_workspace(
    memory: np.ndarray,
    tables: Tables,
    flexible: FlexibleTables,
    between: LoadsBetween,
    loops: Loops,
    forces: ForceTables,
) -> ForceWorkspace:
    """Return the parts of a memory of `force_memory_size`."""
    rows, driven, c = work_size(tables), tables.sizes[DRIVES], len(forces.components)
    speeds, states, modes, ends = (
        tables.sizes[SPEEDS] + driven,
        tables.sizes[STATES],
        flexible.sizes[MODAL_SIZE],
        len(between.rows),
    )
    holds = wrenches_size(loops)
    work, moving, rest = memory[:rows], memory[rows : 2 * rows], memory[2 * rows :]
    modal, modal_rates, rest = rest[:modes], rest[modes : 2 * modes], rest[2 * modes :]
    applied, load_rates, rest = rest[:speeds], rest[speeds : speeds + states], rest[speeds + states :]
    still, points, rest = rest[: 3 * driven], rest[3 * driven : 3 * (driven + ends)], rest[3 * (driven + ends) :]
    components, pivots, rest = rest[:c], rest[c : 2 * c], rest[2 * c :]
    system, holding, acting = rest[: c * c], rest[c * c : c * c + holds], rest[c * c + holds :]
    return ForceWorkspace(
        work.reshape(-1, WORK),
        moving.reshape(-1, WORK),
        modal,
        modal_rates,
        applied,
        load_rates,
        still.reshape(-1, 3),
        points.reshape(-1, 3),
        components,
        system,
        pivots,
        holding,
        acting,
    )
