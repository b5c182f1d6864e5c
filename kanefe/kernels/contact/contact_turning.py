"""Friction of contacts against turning: about the normal, and against rolling, by anchors (Eq. 11)."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.algebra.vectors import (
    Numbers,
    dot,
    minus,
    plus,
    product,
    rotated,
    rotated_back,
    three,
    times,
    transposed,
)
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.contact_shapes import norm
from kanefe.kernels.force_elements.bushing import nine
from kanefe.kernels.force_elements.places import END_NUMBERS, POTENTIAL, TAKEN, A, W


@kernel
def turned_since(numbers: Any, at: int, ends: Any, end: int) -> Numbers:
    """Return how far what touches has turned past the surface since a state of rest, to first order."""
    A_s = nine(ends, A)
    R = product(product(transposed(A_s), nine(ends, END_NUMBERS * end + A)), transposed(nine(numbers, at)))
    return rotated(A_s, (0.5 * (R[7] - R[5]), 0.5 * (R[2] - R[6]), 0.5 * (R[3] - R[1])))


@inlined
def spins(ends: Any, end: int, normal: Numbers) -> Any:
    """Return the angular velocity of what touches past the surface: its part about the normal, and the rest."""
    omega = minus(three(ends, END_NUMBERS * end + W), three(ends, W))
    about = times(dot(omega, normal), normal)
    return about, minus(omega, about)


@kernel
def braked(
    twist: Numbers, along: Numbers, rate: Numbers, k: float, c: float, most: Any, out: Any, work_at: int
) -> tuple[Numbers, Numbers]:
    """Return the moment against turning and the rate of a twist; add to energy, power taken and, of slipping, work.

    `twist` is the whole state of the anchor, `along` that of it which follows the motion.
    """
    pull = plus(times(k, along), times(c, rate))
    size = norm(pull)
    drag = pull if size.real <= most.real else times(most / size, pull)
    given = times(1.0 / c, minus(drag, times(k, twist)))
    out[POTENTIAL] += 0.5 * k * dot(twist, twist)
    out[TAKEN] += dot(drag, rate) - k * dot(twist, given)
    if most.real > 0.0:
        out[work_at] += dot(drag, minus(rate, given))
    return drag, given


@kernel
def put_rolling(A_s: Numbers, given: Numbers, out: Any, at: int) -> None:
    """Write the rate of a twist of rolling, in axes of the surface."""
    in_surface = rotated_back(A_s, given)
    for j in range(3):
        out[at + j] = in_surface[j]
