"""Lengths and directions of vectors; of complex ones those whose derivatives they carry."""

from typing import Any

import numpy as np

from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.values.tensors import Vector, cross, dot


@inlined
def norm(a: Vector) -> Any:
    """Return the length of a."""
    return np.sqrt(dot(a, a))


@inlined
def unit(a: Vector) -> Vector:
    """Return the direction of a, which has one."""
    return (1.0 / norm(a)) * a


@inlined
def across(a: Vector, n: Vector) -> Vector:
    """Return the part of a across a unit vector."""
    return a - dot(a, n) * n


@inlined
def largest_in(a: Vector) -> float:
    """Return the largest size of a component."""
    return max(abs(a.x), max(abs(a.y), abs(a.z)))


@inlined
def beside(n: Vector) -> Vector:
    """Return a unit vector across n, along none of whose axes it is long."""
    x, y, z = abs(n.x.real), abs(n.y.real), abs(n.z.real)
    zero = 0.0 * n.x
    helper = Vector(zero, zero, zero + 1.0)
    if x <= y and x <= z:
        helper = Vector(zero + 1.0, zero, zero)
    elif y <= z:
        helper = Vector(zero, zero + 1.0, zero)
    return unit(cross(n, helper))
