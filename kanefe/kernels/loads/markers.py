"""Markers: frames fixed in rows, between which springs, bushings and constraints act."""

from typing import NamedTuple

from kanefe.kernels.force_elements.places import End
from kanefe.kernels.language import Matrix, Record, Vector, cross, inlined
from kanefe.kernels.tree import Frame, Frames


class Marker(Record, is_frozen=True):
    """A frame fixed in a row.

    Attributes
    ----------
    row : int
        Of the scene; -1: N.
    point, axes : Vector, Matrix
        Its origin, and its axes, in those of the row.
    """

    row: int
    point: Vector
    axes: Matrix


class MarkerMotion(NamedTuple):
    """Motion of a marker in N.

    Attributes
    ----------
    p, A : Vector, Matrix
        Position and axes.
    v, w, Z, Y : Vector
        See `kanefe.kernels.tree.Motion`; gravity in Z cancels.
    """

    p: Vector
    A: Matrix
    v: Vector
    w: Vector
    Z: Vector
    Y: Vector


@inlined
def motion_of(marker: Marker, frames: Frames) -> MarkerMotion:
    """Return how a marker moves, after an outward sweep."""
    frame = frames[marker.row]
    lever, w, Y = frame.R @ marker.point, frame.w, frame.Y
    swing = cross(w, lever)
    Z = frame.Z + cross(Y, lever) + cross(w, swing)
    return MarkerMotion(frame.p + lever, frame.R @ marker.axes, frame.v + swing, w, Z, Y)


@inlined
def put_motion(end: End, marker: Marker, frame: Frame) -> None:
    """Write the motion of a marker in N, by that of its row."""
    arm = frame.R @ marker.point
    end.p, end.A, end.v, end.w = frame.p + arm, frame.R @ marker.axes, frame.v + cross(frame.w, arm), frame.w
