"""A scene, a state of it, and what an evaluation writes on its way: what kernels are given, in this order."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from kanefe.kernels.bodies import BorderedBodies
from kanefe.kernels.language import Array, Integers, Record, Start, Table, in_place, inlined
from kanefe.kernels.tables import FlexibleTables, LoadsBetween, Loops, Tables
from kanefe.kernels.tree import FRAME_NUMBERS, Frames, Links

WRENCH = 6


@in_place
class Scene(NamedTuple):
    """A frozen scene.

    Attributes
    ----------
    tables : Tables
    flexible : FlexibleTables
    between : LoadsBetween
    loops : Loops
    work : ndarray of int
        The whole numbers of its `Work`.
    """

    tables: Tables
    flexible: FlexibleTables
    between: LoadsBetween
    loops: Loops
    work: Integers


class State(NamedTuple):
    """A state, and what else is given of its time.

    Attributes
    ----------
    t : float
        s.
    q, u, z : ndarray, shapes (coordinates,), (free,), (states,)
        Coordinates, free speeds, internal states of loads and constraints.
    drives : ndarray, shape (driven, 3)
        Position, speed and acceleration of the driven coordinates.
    inputs : ndarray
        Values of loads.
    """

    t: float
    q: np.ndarray
    u: np.ndarray
    z: np.ndarray
    drives: np.ndarray
    inputs: np.ndarray


class Rates(NamedTuple):
    """What an evaluation gives.

    Attributes
    ----------
    dq, du, dz : ndarray, shapes (coordinates,), (free,), (states,)
    powers : ndarray, shape (2,)
        Taken and given, W.
    """

    dq: np.ndarray
    du: np.ndarray
    dz: np.ndarray
    powers: np.ndarray


class Work(Record, is_frozen=True):
    """What an evaluation writes on its way, of the type of the state.

    Attributes
    ----------
    size : int
        How long its memory is.
    row_count : int
        Rows of the scene, and that of the ground.
    speed_count, driven_count : int
        Free and driven speeds; driven ones alone.
    modal_size, border_size, holding_size, load_size : int
    constraint_count, bearing_count : int
    frames : Frames
    modal, border : ndarray
        Of flexible bodies: see `kanefe.kernels.bodies`.
    applied, added : ndarray, shape (free + driven,)
        Generalised forces at the joints, and inertia that a linearly implicit evaluation adds along them.
    driving : ndarray, shape (driven,)
        Forces that drive the driven coordinates.
    multipliers : ndarray, shape (m,)
        Of the constraints.
    holding : ndarray
        Of the sweeps with loops, or of `kanefe.kernels.constraints.multipliers.hold` where there are rigid contacts.
    still : ndarray, shape (driven, 3)
        Drives that do not move.
    reactions : ndarray, shape (bearings, 6)
        Of joints whose load is followed.
    acting : ndarray
        Of `kanefe.kernels.loads.loads_between.add_loads_between`.
    """

    size: int
    row_count: int
    speed_count: int
    driven_count: int
    modal_size: int
    border_size: int
    constraint_count: int
    holding_size: int
    bearing_count: int
    load_size: int
    begins: Annotated[int, Start("memory")]
    frames: Annotated[Frames, Table(Frames, "row_count", FRAME_NUMBERS)]
    modal: Annotated[np.ndarray, Array("modal_size")]
    border: Annotated[np.ndarray, Array("border_size")]
    applied: Annotated[np.ndarray, Array("speed_count")]
    added: Annotated[np.ndarray, Array("speed_count")]
    driving: Annotated[np.ndarray, Array("driven_count")]
    still: Annotated[np.ndarray, Array("driven_count", 3)]
    multipliers: Annotated[np.ndarray, Array("constraint_count")]
    holding: Annotated[np.ndarray, Array("holding_size")]
    reactions: Annotated[np.ndarray, Array("bearing_count", WRENCH)]
    acting: Annotated[np.ndarray, Array("load_size")]


@inlined
def work_in(scene: Scene, memory: np.ndarray) -> Work:
    """Return what an evaluation writes, in a memory of `Work.size`."""
    return Work(scene.work, memory)


def memory_size(scene: Scene) -> int:
    """Return how long the memory of an evaluation is."""
    return Work(scene.work, np.zeros(0)).size


@inlined
def links_of(scene: Scene) -> Links:
    """Return what is given of all rows."""
    return Links(scene.tables.rows, scene.tables.geometry)


@inlined
def bodies_of(scene: Scene, work: Work) -> BorderedBodies:
    """Return the flexible bodies."""
    return BorderedBodies(scene.flexible.bodies, scene.flexible.pool, work.modal, work.border)


class Sizes(Record, is_frozen=True):
    """Of a scene, in space or in the plane: of `Tables.sizes`."""

    coordinate_count: int
    free_count: int
    driven_count: int
    state_count: int


class FlexibleSizes(Record, is_frozen=True):
    """Of flexible bodies: of `FlexibleTables.sizes`.

    Attributes
    ----------
    modal, border : int
        Numbers of the modal and of the border work.
    measure : int
        How slopes of interfaces are read: `kanefe.kernels.sweeps.slopes.Slopes`.
    """

    modal: int
    border: int
    measure: int


@inlined
def state_in(tables: Any, t: float, y: np.ndarray, drives: np.ndarray, inputs: np.ndarray) -> State:
    """Return the parts of a state ``(q, u, z, ...)``, of `Tables` or those in the plane."""
    sizes = Sizes(tables.sizes)
    n, m = sizes.coordinate_count, sizes.coordinate_count + sizes.free_count
    return State(t, y[:n], y[n:m], y[m : m + sizes.state_count], drives, inputs)


@inlined
def rates_in(tables: Any, slope: np.ndarray) -> Rates:
    """Return the parts of the rates of such a state and its quadratures."""
    sizes = Sizes(tables.sizes)
    n, m = sizes.coordinate_count, sizes.coordinate_count + sizes.free_count
    k = m + sizes.state_count
    return Rates(slope[:n], slope[n:m], slope[m:k], slope[k:])
