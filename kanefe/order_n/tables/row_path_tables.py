"""Tables of the ways of constraint rows, and where and in which order their multipliers are eliminated."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from kanefe.kernels.bodies import BorderedBodies
from kanefe.kernels.constraints.constraint_rows import ConstraintRows, RowKind, Terms
from kanefe.kernels.constraints.row_paths import Guest, Meeting, Visit
from kanefe.kernels.tables import FlexibleTables, RowPaths, Tables
from kanefe.kernels.tree import Kind, Link, Links

NONE, WRENCH = -1, 6
SPEEDS = {Kind.FIXED: 0, Kind.SPHERICAL: 3, Kind.FREE: 6, Kind.INTERFACE: 0}
"""Speeds of links; else one."""


def row_paths(rows: ConstraintRows, terms: Terms, tables: Tables, flexible: FlexibleTables) -> tuple[RowPaths, int]:
    """Return what constraint rows visit, and how many numbers all visits have; write to the rows which are theirs.

    Parameters
    ----------
    rows, terms
        Of all constraints.
    tables, flexible
        Of the scene.
    """
    scene = _Scene(tables, flexible)
    ways = _ways(rows, terms, scene)
    ends_at = _eliminated_at(ways)
    visited = _Visits(scene)
    for j, (row, way, end) in enumerate(zip(rows, ways, ends_at, strict=True)):
        path = [i for i in way.path if i > end]
        row.first_visit = len(visited.visits)
        row.common = row.first_visit + sum(i > way.meets for i in path)
        visited.go(j, way, path, end)
        row.last_visit = len(visited.visits)
    guests = visited.guests
    order, ends, blocks = _elimination(ends_at, [[j for j, _ in at] for at in guests.values()])
    place = np.argsort(order)
    at_rows = np.arange(-1, len(tables.rows) + 1)
    places = np.searchsorted(np.asarray(ends_at)[order], at_rows)
    meetings: list[tuple[int, int, int]] = []
    invited: list[tuple[int, int]] = []
    for (_, i, is_modes), at in sorted(guests.items()):
        meetings.append((i, int(is_modes), len(invited)))
        invited += sorted(at, key=lambda guest: place[guest[0]])
    meetings.append((NONE, 0, len(invited)))
    paths = RowPaths(
        visits=np.array(visited.visits, dtype=np.int64).reshape(-1, Visit.integer_count),
        meetings=np.array(meetings, dtype=np.int64).reshape(-1, Meeting.integer_count),
        guests=np.array(invited, dtype=np.int64).reshape(-1, Guest.integer_count),
        order=order,
        place=place.astype(np.int64),
        places=places.astype(np.int64),
        meetings_at=np.searchsorted([end for end, _, _ in sorted(guests)], at_rows).astype(np.int64),
        ends=ends,
        blocks=blocks,
    )
    return paths, visited.numbers


class _Visits:
    """What the rows of constraints visit on their ways.

    Parameters
    ----------
    scene : _Scene

    Attributes
    ----------
    visits : list of ndarray
    numbers : int
        Of all visits so far.
    guests : dict
        By the row of the scene where a way is complete, the row that is visited, and whether its modes are: the rows of
        constraints that come there, each with the number of its visit.
    """

    def __init__(self, scene: _Scene) -> None:
        self._scene = scene
        self.visits, self.numbers = list[np.ndarray](), 0
        self.guests: dict[tuple[int, int, bool], list[tuple[int, int]]] = defaultdict(list)

    def go(self, j: int, way: _Way, path: Sequence[int], end: int) -> None:
        """Visit what is on a path to an end, and there, for a row of constraints."""
        modes: dict[int, int] = {}
        for i in path if end < 0 else (*path, end):
            self.visits.append(np.full(Visit.integer_count, NONE))
            visit, link = Visit(self.visits[-1], np.zeros(0)), self._scene.links[i]
            visit.row, visit.is_end, visit.speeds, visit.k, visit.n = i, i == end, 0, 0, 0
            if i in way.bent:
                visit.k, visit.n = self._scene.modes_of(i)
            if link.kind == Kind.INTERFACE:
                if i in way.bent and i != end:
                    self._visit_interface(visit, link, i, modes)
                continue
            if i in way.bent:
                visit.modes = modes[i]
                self.guests[end, i, True].append((j, len(self.visits) - 1))
            if i != end:
                visit.wrench, visit.speeds = self.numbers, self._scene.speeds(link)
                self.numbers += WRENCH + visit.speeds
                if visit.speeds > 0:
                    self.guests[end, i, False].append((j, len(self.visits) - 1))

    def _visit_interface(self, visit: Visit, link: Link, i: int, modes: dict[int, int]) -> None:
        """Write where the numbers of an interface are, and those of the modes of its body, which it shares."""
        if link.parent not in modes:
            modes[link.parent] = self.numbers
            self.numbers += 2 * visit.k + 3 * visit.n
        visit.modes = modes[link.parent]
        if link.carries:
            visit.wrench = visit.modes + 2 * visit.k + WRENCH * self._scene.carried(link.flexible).index(i)


class _Scene:
    """The links of a scene and its flexible bodies."""

    def __init__(self, tables: Tables, flexible: FlexibleTables) -> None:
        self.links = list(Links(tables.rows, tables.geometry))
        self._bodies = BorderedBodies(flexible.bodies, flexible.pool, np.zeros(0), np.zeros(0))
        self._carrying = flexible.carrying

    def ancestors(self, i: int) -> set[int]:
        """Return a row and all that carry it."""
        found: set[int] = set()
        while i >= 0:
            found.add(i)
            i = self.links[i].parent
        return found

    def speeds(self, link: Link) -> int:
        """Return how many speeds of a link are free."""
        return 0 if link.drive >= 0 else SPEEDS.get(Kind(link.kind), 1)

    def carried(self, f: int) -> list[int]:
        """Return the interfaces of a body that carry something."""
        body = self._bodies[f]
        return list(map(int, self._carrying[body.carried : body.carried + body.carried_count]))

    def modes_of(self, i: int) -> tuple[int, int]:
        """Return how many modes the body of a link or interface has, and numbers of what it carries."""
        body = self._bodies[self.links[i].flexible]
        return body.k, WRENCH * body.carried_count


def _ways(rows: ConstraintRows, terms: Terms, scene: _Scene) -> list[_Way]:
    """Return the ways of all rows: one for those between the same rows of the scene."""
    joints = {link.speed + c: i for i, link in enumerate(scene.links) for c in range(scene.speeds(link))}
    between: dict[tuple[int, int], _Way] = {}
    ways: list[_Way] = []
    for row in rows:
        if row.kind == RowKind.COUPLER:
            own = range(row.first_term, row.first_term + row.term_count)
            moved = [joints[terms[n].speed] for n in own if terms[n].speed in joints]
            ways.append(_Way(moved, [scene.links[i].parent for i in moved], scene))
            continue
        ends = row.a.row, row.b.row
        if ends not in between:
            between[ends] = _Way(ends, ends, scene)
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
    scene : _Scene

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

    def __init__(self, ends: Sequence[int], carriers: Sequence[int], scene: _Scene) -> None:
        links = scene.links
        self.path = sorted(set().union(*(scene.ancestors(i) for i in ends)), reverse=True)
        shared = set.intersection(*(scene.ancestors(i) for i in carriers)) if carriers else set()
        self.meets = max(shared, default=-1)
        interfaces = [i for i in self.path if links[i].kind == Kind.INTERFACE and scene.modes_of(i)[0] > 0]
        self.bent = {*interfaces, *(links[i].parent for i in interfaces)}
        self.held = {(links[i].parent, True) for i in interfaces if i not in shared}
        self.held.update((i, False) for i in self.path if i not in shared and scene.speeds(links[i]) > 0)


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
