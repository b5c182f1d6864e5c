"""Loads between frames: what is given of each, and what an evaluation of them writes on its way."""

from typing import Annotated

import numpy as np

from kanefe.kernels.force_elements.places import END_NUMBERS
from kanefe.kernels.language import Array, Record, Rows, Start, inlined
from kanefe.kernels.loads.markers import Marker
from kanefe.kernels.scene import Scene, Work
from kanefe.kernels.tables import LoadsBetween

COORDINATE, A_POINT = -2, -3
"""Values in place of the row of an end: it is a joint coordinate; it is a point of a flexible body."""


class BetweenLoad(Record):
    """A load between frames."""

    first_end: int
    end_count: int
    first_number: int  # of its constants and of its inputs
    first_input: int
    first_state: int  # internal states
    state_count: int
    team: int  # -1: none
    first_point: int  # its points in the team, how many they are, and the end that is the first of them
    point_count: int
    point_end: int
    is_swept: bool  # a linearly implicit sweep has its stiffness
    # addresses, for real and for complex numbers; of loads that are watched of what writes their event values,
    # and of what changes their states
    function: int
    complex_function: int


class BetweenLoads(Rows[BetweenLoad]):
    """All loads between frames: of `LoadsBetween.loads`."""


class LoadEnd(Marker):
    """An end of a load."""

    coordinate: int  # of a coordinate of a joint or a mode; -1 - drive: it is driven
    speed: int
    flexible: int  # the body whose mode it is; -1: it is none


class LoadEnds(Rows[LoadEnd]):
    """The ends of all loads: of `LoadsBetween.ends` and `LoadsBetween.markers`."""


class Acting(Record, is_frozen=True):
    """What an evaluation of loads writes on its way."""

    size: int
    ball_count: int
    swell_count: int
    swept_ball_count: int
    load_count: int
    near_count: int
    point_count: int
    end_count: int
    done_size: int
    begins: Annotated[int, Start("memory")]
    balls: Annotated[np.ndarray, Array("4ball_count")]  # `Ball` after `Ball`: where they are, as large as they are
    grown: Annotated[np.ndarray, Array("swell_count")]  # (swells,): by how much balls on flexible bodies grow
    keys: Annotated[np.ndarray, Array("swept_ball_count")]  # (swept balls,): of the sweep over balls
    order: Annotated[np.ndarray, Array("swept_ball_count")]
    # (loads,): whether each is near, above zero; else minus the gap, as far as known
    nearness: Annotated[np.ndarray, Array("load_count")]
    near: Annotated[np.ndarray, Array("near_count")]  # (swept loads,): the numbers of those of them that are near
    # (6 points,): displacements of the points of a team and how fast they change; then forces in the place of
    # displacements
    shifts: Annotated[np.ndarray, Array("6point_count")]
    rates: Annotated[np.ndarray, Array("6point_count")]
    tangents: Annotated[np.ndarray, Array("9point_count")]  # `Tangent` after `Tangent`: how slopes of points turn them
    ends: Annotated[np.ndarray, Array(f"{END_NUMBERS}end_count")]  # `Ends` of a load
    done: Annotated[np.ndarray, Array("done_size")]  # what it writes: see `kanefe.kernels.force_elements.places.Done`


@inlined
def acting_in(scene: Scene, work: Work) -> Acting:
    """Return what an evaluation of loads writes."""
    return Acting(scene.between.workspace, work.acting)


def acting_size(between: LoadsBetween) -> int:
    """Return how many numbers an evaluation of loads writes."""
    return Acting(between.workspace, np.zeros(0)).size


@inlined
def loads_of(scene: Scene) -> BetweenLoads:
    """Return all loads between frames."""
    return BetweenLoads(scene.between.loads)


@inlined
def ends_of(scene: Scene) -> LoadEnds:
    """Return the ends of all loads."""
    return LoadEnds(scene.between.ends, scene.between.markers)
