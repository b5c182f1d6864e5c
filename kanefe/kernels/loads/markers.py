"""Markers: frames fixed in rows, between which springs, bushings and constraints act."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, matrix, plus, product, rotated, vector
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.force_elements.places import End
from kanefe.kernels.layout import OMEGA, POSITION, VELOCITY, R
from kanefe.kernels.tree import Frame
from kanefe.kernels.values.records import Record, column
from kanefe.kernels.values.tensors import Matrix, Vector
from kanefe.kernels.values.tensors import cross as crossed


class Marker(Record):
    """A frame fixed in a row."""

    row: int  # -1: N
    point: Vector  # origin in axes of the row, and axes to those of the row
    axes: Matrix


POINT, MARKER_AXES, MARKER_NUMBERS = column(Marker, "point"), column(Marker, "axes"), Marker.number_count


@inlined
def put_motion(end: End, marker: Marker, frame: Frame) -> None:
    """Write the motion of a marker in N, by that of its row."""
    arm = frame.R @ marker.point
    end.p, end.A, end.v, end.w = frame.p + arm, frame.R @ marker.axes, frame.v + crossed(frame.w, arm), frame.w


@inlined
def lever_of(numbers: np.ndarray, n: int, row: int, work: np.ndarray) -> Numbers:
    """Return the marker's origin from the origin of its row, in N; from N's origin for row -1."""
    point = vector(numbers, n, POINT)
    if row < 0:
        zero = 0.0 * work[0, R]
        return zero + point[0], zero + point[1], zero + point[2]
    return rotated(matrix(work, row, R), point)


@inlined
def axes_of(numbers: np.ndarray, n: int, row: int, work: np.ndarray) -> Numbers:
    """Return the marker's axes to those of N."""
    axes = matrix(numbers, n, MARKER_AXES)
    if row < 0:
        z = 0.0 * work[0, R]
        return (
            z + axes[0],
            z + axes[1],
            z + axes[2],
            z + axes[3],
            z + axes[4],
            z + axes[5],
            z + axes[6],
            z + axes[7],
            z + axes[8],
        )
    return product(matrix(work, row, R), axes)


@inlined
def motion_of(row: int, lever: Numbers, work: np.ndarray) -> tuple[Numbers, Numbers, Numbers]:
    """Return position, velocity and angular velocity of a marker in N."""
    if row < 0:
        zero = 0.0 * lever[0]
        return lever, (zero, zero, zero), (zero, zero, zero)
    w = vector(work, row, OMEGA)
    return plus(vector(work, row, POSITION), lever), plus(vector(work, row, VELOCITY), cross(w, lever)), w
