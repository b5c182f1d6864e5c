"""Tables of the ways of constraint rows to N, and the order in which their multipliers are eliminated."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from kanefe.kernels.constraints.constraint_rows import COUPLER_ROW
from kanefe.kernels.constraints.loop_system import WRENCH, modes_size
from kanefe.kernels.constraints.loop_tables import FIRST_TERM, KIND_OF, ROW_A, ROW_B, TERM_COUNT
from kanefe.kernels.constraints.row_paths import OF_AXIS, OF_BALL, OF_FREE, VISIT_INTEGERS, RowPaths
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
    FlexibleTables,
    Tables,
)


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
    first, common, visits, numbers = [0], [], [], 0
    met: dict[int, list[tuple[int, int]]] = defaultdict(list)
    row_of_speed = _rows_of_speeds(tables.rows)
    for j, constraint in enumerate(constraints):
        is_coupler = constraint[KIND_OF] == COUPLER_ROW
        if is_coupler:
            at = int(constraint[FIRST_TERM])
            ends = [row_of_speed.get(speed, -1) for speed in speeds[at : at + int(constraint[TERM_COUNT])]]
        else:
            ends = [int(constraint[ROW_A]), int(constraint[ROW_B])]
        path = _ancestors(tables.rows, ends)
        shared = set() if is_coupler else set(_ancestors(tables.rows, ends[:1])) & set(_ancestors(tables.rows, ends[1:]))
        common.append(len(visits) + len(path) - len(shared))
        modes: dict[int, int] = {}
        for i in path:
            row = tables.rows[i]
            body = flexible.bodies[row[FLEXIBLE]] if row[FLEXIBLE] >= 0 else None
            of_joint = of_modes = -1
            if row[KIND] == INTERFACE:
                assert body is not None
                link = int(row[PARENT])
                if body[COUNT] > 0:
                    if link not in modes:
                        modes[link] = numbers
                        numbers += modes_size(int(body[COUNT]), int(body[CARRIED_COUNT]))
                    of_modes = modes[link]
                    if row[CARRIES]:
                        carrying = flexible.carrying[body[CARRIED] : body[CARRIED] + body[CARRIED_COUNT]].tolist()
                        of_modes += 2 * int(body[COUNT]) + WRENCH * carrying.index(i)
            else:
                of_modes = modes.get(i, -1)
                if row[KIND] != FIXED and row[DRIVE] < 0:
                    of_joint, numbers = numbers, numbers + _size(int(row[KIND]))
                if of_joint >= 0 or of_modes >= 0:
                    met[i].append((j, len(visits)))
            visits.append((i, of_joint, of_modes))
        first.append(len(visits))
    order, ends_of = _elimination(len(constraints), [[j for j, _ in at] for at in met.values()])
    place = np.argsort(order)
    meetings = [sorted(met.get(i, []), key=lambda row: place[row[0]]) for i in range(len(tables.rows))]
    return RowPaths(
        first=np.array(first, dtype=np.int64),
        common=np.array(common, dtype=np.int64),
        visits=np.array(visits, dtype=np.int64).reshape(-1, VISIT_INTEGERS),
        met_first=np.cumsum([0, *(len(at) for at in meetings)], dtype=np.int64),
        met=np.array([pair for at in meetings for pair in at], dtype=np.int64).reshape(-1, 2),
        order=order,
        place=place.astype(np.int64),
        ends=ends_of,
        sizes=np.array([numbers], dtype=np.int64),
    )


def _rows_of_speeds(rows: np.ndarray) -> dict[int, int]:
    """Return which row each free speed of a joint is of."""
    found = {}
    for i, row in enumerate(rows):
        if row[KIND] not in (FIXED, INTERFACE) and row[DRIVE] < 0:
            count = {SPHERICAL: 3, FREE: 6}.get(int(row[KIND]), 1)
            found.update((int(row[SPEED]) + c, i) for c in range(count))
    return found


def _ancestors(rows: np.ndarray, ends: Sequence[int]) -> list[int]:
    """Return some rows and all that carry them, children before parents."""
    found = set()
    for i in ends:
        while i >= 0 and i not in found:
            found.add(i)
            i = int(rows[i, PARENT])
    return sorted(found, reverse=True)


def _size(kind: int) -> int:
    return {SPHERICAL: OF_BALL, FREE: OF_FREE}.get(kind, OF_AXIS)


def _elimination(m: int, meetings: list[list[int]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the order of m rows, of which those of a meeting have something in common, and the ends of its envelope.

    The given order, if nothing is filled in; else that of Cuthill and McKee, reversed, which keeps neighbours close.
    """
    order = np.arange(m)
    neighbours: list[set[int]] = [{j} for j in range(m)]
    for rows in meetings:
        for j in rows:
            neighbours[j].update(rows)
    widths = _widths(order, neighbours)
    if any(width > sum(other <= j for other in neighbours[j]) for j, width in enumerate(widths)):
        from scipy.sparse import csr_matrix
        from scipy.sparse.csgraph import reverse_cuthill_mckee

        ends = np.cumsum([0, *map(len, neighbours)])
        columns = np.array([other for own in neighbours for other in sorted(own)])
        graph = csr_matrix((np.ones(len(columns)), columns, ends), shape=(m, m))
        closer = np.asarray(reverse_cuthill_mckee(graph, symmetric_mode=True), dtype=np.int64)
        closer_widths = _widths(closer, neighbours)
        if sum(closer_widths) < sum(widths):
            order, widths = closer, closer_widths
    return order.astype(np.int64), np.cumsum([0, *widths], dtype=np.int64)


def _widths(order: np.ndarray, neighbours: list[set[int]]) -> list[int]:
    """Return how far each row of an order is from its first neighbour, with itself."""
    place = {int(j): a for a, j in enumerate(order)}
    return [a - min(place[other] for other in neighbours[int(j)]) + 1 for a, j in enumerate(order)]
