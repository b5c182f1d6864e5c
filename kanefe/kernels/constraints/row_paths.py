"""Tables of the ways of rows of constraints: the joints and modes between their ends and what carries both."""

from typing import Annotated

import numpy as np

from kanefe.kernels.language import Array, One, Record, Rows, Start, Vector
from kanefe.kernels.tables import RowPaths


class Visit(Record, is_frozen=True):
    """What a unit multiplier of a row does where its way passes: at a joint, and at the modes of a body.

    Attributes
    ----------
    row : int
        Of the scene.
    is_end : bool
        Whether the way ends there, without a joint or wrench.
    speeds : int
        Of its joint that are free; 0: none.
    k, n : int
        Modes of its body that give way, and numbers of what this carries; of an interface those of its body.
    wrench : int
        Where the wrench that the link needs is; -1: none. Of an interface that carries something: in G, among `on`.
    force, moment : Vector
    answer : ndarray, shape (speeds,)
        How the joint answers: acceleration along an axis, turning of a ball, both accelerations of a free body.
    modes : int
        Where the answer of the modes is; -1: none. An interface has that of its body.
    p, x : ndarray, shape (k,)
        Forces on the modes, and their accelerations.
    on, moved, y : ndarray, shape (n,)
        What acts on the carried interfaces, how these move, and y of `eliminate_modes`.
    """

    row: int
    is_end: bool
    speeds: int
    k: int
    n: int
    wrench: Annotated[int, Start("visited")]
    force: Annotated[Vector, One(Vector)]
    moment: Annotated[Vector, One(Vector)]
    answer: Annotated[np.ndarray, Array("speeds")]
    modes: Annotated[int, Start("visited")]
    p: Annotated[np.ndarray, Array("k")]
    x: Annotated[np.ndarray, Array("k")]
    on: Annotated[np.ndarray, Array("n")]
    moved: Annotated[np.ndarray, Array("n")]
    y: Annotated[np.ndarray, Array("n")]


class Visits(Rows[Visit]):
    """All visits: of `RowPaths.visits` and the numbers of all visits."""


class Meeting(Record, is_frozen=True):
    """Where rows of constraints have something in common.

    Attributes
    ----------
    row : int
        Of the scene.
    is_modes : bool
        Whether it is the modes that are shared.
    first_guest : int
        Number of the first of those that meet, which reach up to that of the next meeting.
    """

    row: int
    is_modes: bool
    first_guest: int


class Meetings(Rows[Meeting]):
    """All meetings, and an empty one behind: of `RowPaths.meetings`."""


class Guest(Record, is_frozen=True):
    """A row of constraints at a meeting, by its number and that of its visit there."""

    row: int
    visit: int


class Guests(Rows[Guest]):
    """The guests of all meetings, in the order of elimination: of `RowPaths.guests`."""


def no_paths() -> RowPaths:
    """Return the tables of a scene without constraints."""
    none, one = np.zeros(0, dtype=np.int64), np.zeros(1, dtype=np.int64)
    visits, meetings, guests = (
        np.zeros((count, record.integer_count), dtype=np.int64)
        for record, count in ((Visit, 0), (Meeting, 1), (Guest, 0))
    )
    return RowPaths(visits, meetings, guests, none, none, none, none, one, none)
