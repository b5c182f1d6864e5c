"""What the function of a link writes: the motion of its frame M seen from its frame F, in components of F."""

from kanefe.kernels.compiler.addresses import NUMBERS, VALUES
from kanefe.kernels.language import Matrix, Record, Vector

SIGNATURE = (NUMBERS, VALUES, VALUES)
"""Kinds of the arguments of the function: numbers, q, out."""


class WrittenMotion(Record):
    """The motion of M."""

    p: Vector  # position and axes
    A: Matrix
    V: Vector  # partial velocity and partial angular velocity
    W: Vector
    dV: Vector  # their derivatives by the coordinate
    dW: Vector
