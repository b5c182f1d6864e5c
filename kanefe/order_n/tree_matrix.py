"""The Newton matrix of a tree in its structure: which entries it has, found once, and their values at a state."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Vector
from kanefe.kernels.algebra.sparse import Pattern, fill_in
from kanefe.kernels.bodies import AllModalCoordinates, ModalBodies
from kanefe.kernels.compiler.entries import LATER
from kanefe.kernels.evaluation.evaluation import ASKED, AT_TIME, evaluate, scene_of
from kanefe.kernels.evaluation.linear_unknowns import Entries, Place, Size, Unknowns, own_size
from kanefe.kernels.evaluation.linearised_tree import Evaluated as InKernels
from kanefe.kernels.evaluation.linearised_tree import linearise
from kanefe.kernels.language import column
from kanefe.kernels.loads.acting import ends_of, loads_of
from kanefe.kernels.loads.point_and_field_loads import FieldLoad, PointLoads
from kanefe.kernels.scene import Scene, links_of
from kanefe.kernels.steppers.moves import STRAIGHT
from kanefe.kernels.steppers.step_commands import VECTOR
from kanefe.kernels.tree import Kind, Link
from kanefe.kernels.values.filled import filled_rows
from kanefe.order_n.tables.load_points import body_of_points
from kanefe.tree.model_data import QUADRATURES, ModelData
from kanefe.tree.scales import coordinate_moves

if TYPE_CHECKING:
    from kanefe.order_n.evaluated import Evaluated

JOINT_SPEEDS = {Kind.FIXED: 0, Kind.INTERFACE: 0, Kind.SPHERICAL: 3, Kind.FREE: 6}
"""Free speeds of the joint of a row, where they are not one."""


LEAST_PRODUCTS = 500
"""Products of the elimination of a row of a tree, of a rigid body on a hinge: counted."""

DEARER = 1.6
"""Time of a product whose place is looked up, relative to that of one in a dense matrix: measured with chains of
hinges, for which both ways take as long with 50 links."""


@dataclass(frozen=True, eq=False)
class TreePattern:
    """Where the entries of the Newton matrix of a tree are.

    Attributes
    ----------
    factors : Pattern
    known, masses : ndarray of int
        Places of the entries of the linearised equations among those of the factors.
    mass_rows, mass_speeds : ndarray of int
        Of masses, the speeds and internal states by their numbers.
    turns : ndarray of int, shape (speeds, 3)
        Places of the entries by which coordinates follow speeds; of one that goes straight the first.
    coordinates, unknowns : ndarray of int
        Rows of the coordinates, and of speeds and internal states.
    """

    factors: Pattern
    known: np.ndarray
    masses: np.ndarray
    mass_rows: np.ndarray
    mass_speeds: np.ndarray
    turns: np.ndarray
    coordinates: np.ndarray
    unknowns: np.ndarray

    @cached_property
    def work(self) -> float:
        """How many products elimination takes, of which each costs more than one in a dense matrix."""
        starts, columns, diagonals = self.factors
        above = starts[1:] - diagonals - 1
        is_below = columns < np.repeat(np.arange(len(diagonals)), np.diff(starts))
        return DEARER * float(above[columns[is_below]].sum())


class TreeMatrix:
    """The linearised equations of a scene: of one thread at a time.

    Parameters
    ----------
    route : Evaluated
        Of a scene that `keeps_structure`.
    """

    def __init__(self, route: Evaluated) -> None:
        model, scene = route.model, route.scene
        self._route, size = route, model.coordinate_count + model.free_count + model.state_count + QUADRATURES
        self._drives, self._inputs = np.zeros((model.driven_count, 3)), np.zeros(len(route.inputs.constants))
        self._vectors, memory = np.zeros((2, size), dtype=complex), np.zeros(route.memory_size, dtype=complex)
        given = scene, self._drives, self._inputs, self._vectors, memory
        self._evaluation = evaluate.bound(ASKED, *given, is_complex=True).prepared()
        rows = scene.tables.rows.copy()
        rows[:, column(Link, "carries")] = 1  # what acts on an interface stays there
        opened = scene_of(scene.tables._replace(rows=rows), route.flexible, route.between, route.loops)
        self.unknowns = unknowns_of(scene, model)
        self._moves = np.array(coordinate_moves(model), dtype=np.int64).reshape(-1, 3)
        own = np.zeros(own_size(len(rows)), dtype=complex)
        evaluated = InKernels(self._evaluation.for_kernels(), *given[1:], own, self._moves)
        self._bound = linearise.bound(evaluated, opened, self.unknowns, LATER, LATER, is_complex=True)
        self.known, self.masses = _room(0), _room(0)
        start = np.concatenate((model.initial_coordinates, model.initial_speeds, model.initial_states))
        self._linearise(0.0, start)
        self.known, self.masses = _room(int(self.known.found[0])), _room(int(self.masses.found[0]))
        self._linearise(0.0, start)

    def _linearise(self, t: float, y: Vector) -> bool:
        self._evaluation.numbers[AT_TIME] = t
        self._vectors[VECTOR.at], self._vectors[VECTOR.at, : len(y)] = 0.0, y
        self._drives[:], self._inputs[:] = self._route.drives(t), self._route.values(t, y)
        return bool(self._bound(self.known, self.masses))

    def put_entries(self, t: float, y: Vector) -> None:
        """Write `known` and `masses` of a state with quadratures.

        Raises
        ------
        SimulationError
            If the mass matrix is singular; the message names the speeds without inertia.
        """
        if not self._linearise(t, y[: len(y) - QUADRATURES]):
            self._route.explain(t, y)

    def pattern(self) -> TreePattern:
        """Return where entries are."""
        coordinates, speeds, states = self.unknowns.coordinates, self.unknowns.speeds, self.unknowns.states
        count = matrix_size(self.unknowns)
        kinds, _, first = self._moves.T
        straight, turning = first[kinds == STRAIGHT], first[kinds != STRAIGHT]
        follow = np.full((len(speeds), 3), -1, dtype=np.int64)  # speeds that coordinates follow
        follow[straight, 0] = straight
        for c in range(3):
            follow[turning + c] = turning[:, None] + np.arange(3)
        own, by = np.nonzero(follow >= 0)
        ones = np.arange(count)
        rows = np.concatenate((self.known.rows, self.masses.rows, coordinates[own], ones))
        columns = np.concatenate((self.known.columns, self.masses.columns, speeds[follow[own, by]], ones))
        found = filled_pattern(rows, columns, count)
        at = np.repeat(ones, np.diff(found.starts)) * count + found.columns
        known, masses, turns, _ = np.split(
            np.searchsorted(at, rows * count + columns),
            np.cumsum([len(self.known.rows), len(self.masses.rows), len(own)]),
        )
        follow[own, by] = turns
        number = np.full(count, -1, dtype=np.int64)
        unknowns = np.concatenate((speeds, states))
        number[unknowns] = np.arange(len(unknowns))
        mass_rows, mass_speeds = self.masses.rows.copy(), number[self.masses.columns]
        return TreePattern(found, known, masses, mass_rows, mass_speeds, follow, coordinates, unknowns)


def _room(count: int) -> Entries:
    rows, columns = np.zeros((2, count), dtype=np.int64)
    return Entries(np.zeros(1, dtype=np.int64), rows, columns, np.zeros(count))


def filled_pattern(rows: np.ndarray, columns: np.ndarray, count: int) -> Pattern:
    """Return the pattern of the factors of a matrix with entries in rows and columns, its diagonal among them."""
    order = np.argsort(rows, kind="stable")
    starts = np.concatenate(([0], np.cumsum(np.bincount(rows, minlength=count))))
    given, filled, diagonals = columns[order], np.zeros(count + 1, dtype=np.int64), np.zeros(count, dtype=np.int64)
    size, into, marks = 2 * len(rows), np.zeros(0, dtype=np.int64), np.zeros(count, dtype=np.int64)
    while size > len(into):
        into = np.zeros(size, dtype=np.int64)
        size = int(fill_in(starts, given, filled, into, diagonals, marks))
        size = size if size <= len(into) else max(size, 2 * len(into))
    return Pattern(filled, into[:size].copy(), diagonals)


def matrix_size(unknowns: Unknowns) -> int:
    """Return how many unknowns there are."""
    moving = (Size.MOTION + Size.NEED) * len(unknowns.places)
    return moving + len(unknowns.coordinates) + len(unknowns.speeds) + len(unknowns.states)


def unknowns_of(scene: Scene, model: ModelData) -> Unknowns:
    """Number the unknowns in the order of their elimination: internal states, then rows from the tips inward."""
    links, bodies = links_of(scene), AllModalCoordinates(scene.flexible.bodies)
    followed = model.state_count if model.states_move else 0
    standing, carrying = _rows_of_standing_forces(scene), _rows_of_inner_loads(scene)
    inner = np.flatnonzero(carrying >= 0)
    inner = inner[np.argsort(carrying[inner], kind="stable")]
    rows = carrying[inner]
    coordinates, speeds = (np.full(model.free_count, -1, dtype=np.int64) for _ in range(2))
    places, count = [], followed
    for i in range(len(links) - 1, -1, -1):
        link = links[i]
        joint = 0 if link.drive >= 0 else JOINT_SPEEDS.get(Kind(link.kind), 1)
        is_body = link.kind != Kind.INTERFACE and link.flexible >= 0
        modes = bodies[link.flexible].k if is_body else 0
        of_joint = list(range(link.speed, link.speed + joint))
        first = bodies[link.flexible].first_deta if is_body else 0
        of_modes = list(range(first, first + modes))
        motion, count = count, count + Size.MOTION
        for numbers, own in ((coordinates, of_joint + of_modes), (speeds, of_modes)):
            numbers[own], count = np.arange(count, count + len(own)), count + len(own)
        need, count = count, count + Size.NEED
        speeds[of_joint], count = np.arange(count, count + joint), count + joint
        turns = i in standing or (link.kind != Kind.INTERFACE and not link.has_gravity)
        place = {"motion": motion, "need": need, "joint": joint, "modes": modes, "turns": turns}
        first_load, end = np.searchsorted(rows, (i, i + 1)).tolist()
        places.append(place | {"first_load": first_load, "loads": end - first_load})
    (of_rows,) = filled_rows(Place, places[::-1])
    is_inner = np.asarray(carrying >= 0, dtype=np.int64)
    return Unknowns(of_rows, coordinates, speeds, np.arange(followed, dtype=np.int64), inner, is_inner)


def _rows_of_inner_loads(scene: Scene) -> np.ndarray:
    """Return of each load the row whose motion, seen from its parent, is all that it depends on; -1: there is none.

    Between two bodies a load does the same wherever these are together.
    """
    links, loads, ends = links_of(scene), loads_of(scene), ends_of(scene)
    found = np.full(len(loads), -1, dtype=np.int64)
    for n in range(len(loads)):
        own = range(loads[n].first_end, loads[n].first_end + loads[n].end_count)
        rows = sorted({ends[i].row for i in own})
        if len(rows) == 2 and rows[0] >= 0 and links[rows[1]].parent == rows[0]:
            found[n] = rows[1]
    return found


def _rows_of_standing_forces(scene: Scene) -> set[int]:
    """Return the rows on which forces act that need not turn with them: loads, and a fluid, which has no weight."""
    loads, flexible = PointLoads(scene.tables.loads, scene.tables.points), scene.flexible
    bodies = ModalBodies(flexible.bodies, flexible.pool, np.zeros(0))
    loaded = set(flexible.fields[:, column(FieldLoad, "body")].tolist())
    of_bodies = {bodies[f].link for f in range(len(bodies)) if f in loaded or bodies[f].wet >= 0}
    return of_bodies | {loads[n].row for n in range(len(loads))}


def keeps_structure(route: Evaluated) -> bool:
    """Return whether the equations of a scene are linearised row by row, see `linearised_tree` of the kernels.

    Functions of the state couple what they read, loops and rigid contacts what they hold.
    """
    model = route.model
    is_tree = not (model.is_constrained or model.bearings or route.inputs.needs_state) and route.is_complex
    bodies = ModalBodies(route.flexible.bodies, route.flexible.pool, np.zeros(0))
    return (
        is_tree
        and not any(bodies[f].is_exact for f in range(len(bodies)))
        and all(body_of_points(load, load.reach) < 0 for load in model.loads)
    )


def expected_work(route: Evaluated) -> float:
    """Return how many products elimination takes about, without making anything; infinite where matrices are dense.

    Modes are eliminated from their own rows and those of two needs, with entries of modes, a motion and a need; states
    that move one by one, from those of their load that are left and two needs. Paths between far ends are left out.
    """
    if not keeps_structure(route):
        return np.inf
    bodies, model = AllModalCoordinates(route.scene.flexible.bodies), route.model
    modes = [bodies[f].k for f in range(len(bodies))]
    of_modes = sum(k * (k + 2 * Size.NEED) * (k + Size.MOTION + Size.NEED) for k in modes)
    counts = [own.stop - own.start for own in model.load_states] if model.states_move else []
    of_states = sum((left + 2 * Size.NEED) * (left + Size.MOTION) for count in counts for left in range(count))
    return DEARER * (LEAST_PRODUCTS * len(route.scene.tables.rows) + of_modes + of_states)


def pattern_if_less(route: Evaluated) -> TreePattern | None:
    """Return where the entries of the Newton matrix of a tree are; None if a dense matrix has less work, or must do."""
    model = route.model
    dense = (model.free_count + (model.state_count if model.states_move else 0)) ** 3 / 3
    if dense < expected_work(route):
        return None
    pattern = TreeMatrix(route).pattern()
    return pattern if pattern.work < dense else None
