"""Tables of the ways of constraint rows, and where and in which order their multipliers are eliminated."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from kanefe.kernels.constraints.constraint_rows import COUPLER_ROW
from kanefe.kernels.constraints.loop_factors import WRENCH, modes_size
from kanefe.kernels.constraints.loop_tables import FIRST_TERM, KIND_OF, ROW_A, ROW_B, TERM_COUNT
from kanefe.kernels.constraints.row_paths import MEETING_INTEGERS, OF_AXIS, OF_BALL, OF_FREE, VISIT_INTEGERS
from kanefe.kernels.layout import (
    CARRIED,
    CARRIED_COUNT,
    CARRIES,
    COUNT,
    DRIVE,
    FIXED,
    FLEXIBLE,
    FREE,
    INTERFACE,
    KIND,
    PARENT,
    SPEED,
    SPHERICAL,
)
from kanefe.kernels.tables import FlexibleTables, RowPaths, Tables

NONE = -1


def row_paths(constraints: np.ndarray, speeds: Sequence[int], tables: Tables, flexible: FlexibleTables) -> RowPaths:
    """Return what constraint rows visit.

    Parameters
    ----------
    constraints : ndarray of int, shape (m, CONSTRAINT_INTEGERS)
        See `kanefe.kernels.constraints.loop_tables.Loops`.
    speeds : sequence of int
        Of the terms of couplers.
    tables, flexible
        Of the scene.
    """
    ways = _ways(constraints, speeds, tables, flexible)
    ends_at = _eliminated_at(ways)
    first, common, numbers = [0], [], 0
    visits: list[tuple[int, int, int, int]] = []
    guests: dict[tuple[int, int, bool], list[tuple[int, int]]] = defaultdict(list)
    for j, (way, end) in enumerate(zip(ways, ends_at, strict=True)):
        modes: dict[int, int] = {}
        path = [i for i in way.path if i > end]
        common.append(len(visits) + sum(i > way.meets for i in path))
        for i in path if end < 0 else (*path, end):
            row, body = tables.rows[i], flexible.bodies[tables.rows[i][FLEXIBLE]] if i in way.bent else None
            of_joint = of_modes = of_wrench = NONE
            if body is not None and row[KIND] != INTERFACE:
                of_modes = modes[i]
                guests[end, i, True].append((j, len(visits)))
            if i == end:
                pass
            elif row[KIND] == INTERFACE:
                if body is not None:
                    link = int(row[PARENT])
                    if link not in modes:
                        modes[link] = numbers
                        numbers += modes_size(int(body[COUNT]), int(body[CARRIED_COUNT]))
                    of_modes = modes[link]
                    if row[CARRIES]:
                        carrying = flexible.carrying[body[CARRIED] : body[CARRIED] + body[CARRIED_COUNT]].tolist()
                        of_modes += 2 * int(body[COUNT]) + WRENCH * carrying.index(i)
            else:
                of_wrench, numbers = numbers, numbers + WRENCH
                if row[KIND] != FIXED and row[DRIVE] < 0:
                    of_joint, numbers = numbers, numbers + _size(int(row[KIND]))
                    guests[end, i, False].append((j, len(visits)))
            visits.append((i, of_joint, of_modes, of_wrench))
        first.append(len(visits))
    order, ends, blocks = _elimination(ends_at, [[j for j, _ in at] for at in guests.values()])
    place = np.argsort(order)
    rows = np.arange(-1, len(tables.rows) + 1)
    places = np.searchsorted(np.asarray(ends_at)[order], rows)
    meetings: list[tuple[int, int, int]] = []
    invited: list[tuple[int, int]] = []
    for (_, i, is_modes), at in sorted(guests.items()):
        meetings.append((i, int(is_modes), len(invited)))
        invited += sorted(at, key=lambda guest: place[guest[0]])
    meetings.append((NONE, 0, len(invited)))
    return RowPaths(
        first=np.array(first, dtype=np.int64),
        common=np.array(common, dtype=np.int64),
        visits=np.array(visits, dtype=np.int64).reshape(-1, VISIT_INTEGERS),
        order=order,
        place=place.astype(np.int64),
        places=places.astype(np.int64),
        meetings_at=np.searchsorted([end for end, _, _ in sorted(guests)], rows).astype(np.int64),
        meetings=np.array(meetings, dtype=np.int64).reshape(-1, MEETING_INTEGERS),
        guests=np.array(invited, dtype=np.int64).reshape(-1, 2),
        ends=ends,
        blocks=blocks,
        sizes=np.array([numbers], dtype=np.int64),
    )


def _ways(constraints: np.ndarray, speeds: Sequence[int], tables: Tables, flexible: FlexibleTables) -> list[_Way]:
    """Return the ways of all rows: one for those between the same rows of the scene."""
    joints = _rows_of_speeds(tables.rows)
    between: dict[tuple[int, int], _Way] = {}
    ways: list[_Way] = []
    for constraint in constraints:
        if constraint[KIND_OF] == COUPLER_ROW:
            at = int(constraint[FIRST_TERM])
            moved = [joints[speed] for speed in speeds[at : at + int(constraint[TERM_COUNT])] if speed in joints]
            ways.append(_Way(moved, [int(tables.rows[i, PARENT]) for i in moved], tables, flexible))
            continue
        ends = int(constraint[ROW_A]), int(constraint[ROW_B])
        if ends not in between:
            between[ends] = _Way(ends, ends, tables, flexible)
        ways.append(between[ends])
    return ways


class _Way:
    """The way of a row of constraints.

    Parameters
    ----------
    ends : sequence of int
        Rows of the scene at which it begins; -1: N.
    carriers : sequence of int
        What it is between: these, or of a coupler what carries its joints.
    tables, flexible
        Of the scene.

    Attributes
    ----------
    path : list of int
        Rows of the scene that carry its ends, with these, children before parents.
    meets : int
        The first of these that carries both; -1: N.
    bent : set of int
        Interfaces on the way whose body has modes, and the links of these bodies.
    held : set
        The joints that move, and the links whose modes do, of what the ends do not share.
    """

    def __init__(self, ends: Sequence[int], carriers: Sequence[int], tables: Tables, flexible: FlexibleTables) -> None:
        rows = tables.rows
        self.path = sorted(set().union(*(_ancestors(rows, i) for i in ends)), reverse=True)
        shared = set.intersection(*(_ancestors(rows, i) for i in carriers)) if carriers else set()
        self.meets = max(shared, default=-1)
        interfaces = [
            i for i in self.path if rows[i, KIND] == INTERFACE and flexible.bodies[rows[i, FLEXIBLE], COUNT] > 0
        ]
        self.bent = {*interfaces, *(int(rows[i, PARENT]) for i in interfaces)}
        self.held: set[tuple[int, bool]] = set()
        for i in self.path:
            if i in self.bent and rows[i, KIND] == INTERFACE and i not in shared:
                self.held.add((int(rows[i, PARENT]), True))
            if i not in shared and rows[i, KIND] not in (FIXED, INTERFACE) and rows[i, DRIVE] < 0:
                self.held.add((i, False))


def _eliminated_at(ways: Sequence[_Way]) -> list[int]:
    """Return at which row of the scene each way is complete, with all those that share a joint or modes with it."""
    group = list(range(len(ways)))

    def root(j: int) -> int:
        while group[j] != j:
            group[j] = j = group[group[j]]
        return j

    owner: dict[tuple[int, bool], int] = {}
    for j, way in enumerate(ways):
        for held in way.held:
            group[root(j)] = root(owner.setdefault(held, j))
    found: dict[int, int] = {}
    for j, way in enumerate(ways):
        found[root(j)] = min(found.get(root(j), way.meets), way.meets)
    return [found[root(j)] for j in range(len(ways))]


def _rows_of_speeds(rows: np.ndarray) -> dict[int, int]:
    """Return which row each free speed of a joint is of."""
    found: dict[int, int] = {}
    for i, row in enumerate(rows):
        if row[KIND] not in (FIXED, INTERFACE) and row[DRIVE] < 0:
            count = {SPHERICAL: 3, FREE: 6}.get(int(row[KIND]), 1)
            found.update((int(row[SPEED]) + c, i) for c in range(count))
    return found


def _ancestors(rows: np.ndarray, i: int) -> set[int]:
    """Return a row and all that carry it."""
    found: set[int] = set()
    while i >= 0:
        found.add(i)
        i = int(rows[i, PARENT])
    return found


def _size(kind: int) -> int:
    return {SPHERICAL: OF_BALL, FREE: OF_FREE}.get(kind, OF_AXIS)


def _elimination(at: Sequence[int], meetings: list[list[int]]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the order of rows that are eliminated at some rows of the scene, and ends and blocks of its envelope.

    Those of a meeting have something in common. Rows that have it with the same others stay together: they are a block.
    Blocks keep their order if nothing is filled in; else they take that of Cuthill and McKee, reversed, which keeps
    neighbours close.
    """
    neighbours: list[set[int]] = [{j} for j in range(len(at))]
    for rows in meetings:
        for j in rows:
            neighbours[j].update(rows)
    kinds: dict[frozenset[int], int] = {}
    kind = [kinds.setdefault(frozenset(own), j) for j, own in enumerate(neighbours)]
    order = sorted(range(len(at)), key=lambda j: (at[j], kind[j], j))
    widths = _widths(order, neighbours)
    place = {j: a for a, j in enumerate(order)}
    if any(width > sum(place[o] <= a for o in neighbours[order[a]]) for a, width in enumerate(widths)):
        from scipy.sparse import csr_matrix
        from scipy.sparse.csgraph import reverse_cuthill_mckee

        ends = np.cumsum([0, *map(len, neighbours)])
        columns = np.array([other for own in neighbours for other in sorted(own)])
        graph = csr_matrix((np.ones(len(columns)), columns, ends), shape=(len(at), len(at)))
        nearest = np.argsort(reverse_cuthill_mckee(graph, symmetric_mode=True)).tolist()
        closer = sorted(range(len(at)), key=lambda j: (at[j], nearest[kind[j]], j))
        if sum(_widths(closer, neighbours)) < sum(widths):
            order, widths = closer, _widths(closer, neighbours)
    blocks = [a + 1 for a in range(len(order))]
    for a in range(len(order) - 2, -1, -1):
        if kind[order[a]] == kind[order[a + 1]]:
            blocks[a] = blocks[a + 1]
    return (
        np.array(order, dtype=np.int64),
        np.cumsum([0, *widths], dtype=np.int64),
        np.array(blocks, dtype=np.int64),
    )


def _widths(order: Sequence[int], neighbours: list[set[int]]) -> list[int]:
    """Return how far each row of an order is from its first neighbour, with itself."""
    place = {j: a for a, j in enumerate(order)}
    return [a - min(place[other] for other in neighbours[j]) + 1 for a, j in enumerate(order)]
