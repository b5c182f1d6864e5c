"""What the function of a link writes: the motion of its frame M seen from its frame F, in components of F."""

from __future__ import annotations

from kanefe.kernels.compiler.addresses import NUMBERS, VALUES
from kanefe.kernels.values.records import Record
from kanefe.kernels.values.tensors import Matrix, Vector

SIGNATURE = (NUMBERS, VALUES, VALUES)
"""Kinds of the arguments of the function: numbers, q, out."""


class WrittenMotion(Record):
    """The motion of M.

    Attributes
    ----------
    p, A : Vector, Matrix
        Position and axes.
    V, W : Vector
        Partial velocity and partial angular velocity.
    dV, dW : Vector
        Their derivatives by the coordinate.
    """

    p: Vector
    A: Matrix
    V: Vector
    W: Vector
    dV: Vector
    dW: Vector
