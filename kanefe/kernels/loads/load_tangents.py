"""How loads between frames answer to the unknowns of an implicit step, and the few directions in which they do.

A load with the motions e of its ends (6 each, of a joint coordinate 1) and internal states z gives wrenches F and rates
g. Where the accelerations at the end of a step change by ``ddu``, ends move by ``r e`` and their speeds change by
``s e`` with ``e = B^T ddu``; F_e and g_e below are the derivatives along both at once, by complex steps. With the share
p of the rates in z, ``dz = p (g_e e + g_z dz) + rest`` is solved for dz, of each load alone:

    dz = X e + Y rest,      D = 1 - p g_z,   X = D^-1 p g_e,   Y = D^-1,
    dF = T e + T_z rest,    T = F_e + F_z X,   T_z = F_z Y.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from kanefe.kernels.algebra.lu import factorise, solve
from kanefe.kernels.algebra.vectors import copy
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.compiler.calls import call_address
from kanefe.kernels.force_elements.places import END_NUMBERS, WRENCH, WRENCHES, A, P, V, W
from kanefe.kernels.loads.loads_layout import (
    AT,
    COMPLEX,
    COORDINATE,
    END_COUNT,
    FIRST_END,
    FIRST_NUMBER,
    FIRST_STATE,
    INPUT,
    STATE_COUNT,
    place_of_load,
)
from kanefe.kernels.scene import Scene, State, Work
from kanefe.kernels.tables import LoadsBetween

COMPLEX_STEP = 1e-30


class TangentMemory(NamedTuple):
    """Workspace of the tangents of a load.

    Attributes
    ----------
    motion, states, out : ndarray of complex
        What its function is given and writes.
    T : ndarray, shape (6 ends + states, 6 ends + states)
        Derivatives; on return the rows are T and T_z, then X and Y.
    D, pivots, column : ndarray, shapes (states, states), (states,), (states,)
    """

    motion: np.ndarray
    states: np.ndarray
    out: np.ndarray
    T: np.ndarray
    D: np.ndarray
    pivots: np.ndarray
    column: np.ndarray


def tangent_size(ends: int, states: int) -> int:
    """Return how many numbers the memory of a load with so many ends and internal states has."""
    size = WRENCH * ends + states
    return 2 * (END_NUMBERS * ends + states + WRENCHES + size) + size * size + states * (states + 2)


@inlined
def tangent_memory(between: LoadsBetween, n: int, followed: int, memory: np.ndarray) -> TangentMemory:
    """Return the parts of a memory of `tangent_size`, of a load of which so many states are followed."""
    ends, states = between.loads[n, END_COUNT], between.loads[n, STATE_COUNT]
    motion, out, size = END_NUMBERS * ends, WRENCHES + WRENCH * ends + states, WRENCH * ends + followed
    numbers = memory[: 2 * (motion + states + out)].view(np.complex128)
    rest = memory[2 * (motion + states + out) :]
    T, rest = rest[: size * size].reshape(size, size), rest[size * size :]
    D, rest = rest[: followed * followed].reshape(followed, followed), rest[followed * followed :]
    return TangentMemory(
        numbers[:motion],
        numbers[motion : motion + states],
        numbers[motion + states :],
        T,
        D,
        rest[:followed],
        rest[followed : 2 * followed],
    )


@kernel
def put_tangents(
    scene: Scene, state: State, work: Work, n: int, shares: tuple[float, float, float], memory: TangentMemory
) -> bool:
    """Write T of a load whose ends have been evaluated; return whether D is regular.

    Parameters
    ----------
    shares : tuple of float
        s, r and p.
    """
    between, t, inputs, states, workspace = scene.between, state.t, state.inputs, state.z, work.acting
    motion, own, out, T = memory.motion, memory.states, memory.out, memory.T
    count, followed = WRENCH * between.loads[n, END_COUNT], len(memory.D)
    first, place = between.loads[n, FIRST_STATE], place_of_load(between)
    address, numbers = between.addresses[n, COMPLEX], between.numbers[between.loads[n, FIRST_NUMBER] :]
    given = inputs[between.loads[n, INPUT] :]
    T[:] = 0.0
    for k in range(count + followed):
        if k < count and not _moves(between, n, k):
            continue
        for i in range(len(motion)):
            motion[i] = workspace[place + i]
        for i in range(len(own)):
            own[i] = states[first + i]
        if k < count:
            _displace(motion[END_NUMBERS * (k // WRENCH) :], k % WRENCH, shares[0], shares[1])
        else:
            own[k - count] += complex(0.0, COMPLEX_STEP)
        out[:] = 0.0
        call_address(address, (t, numbers, given, motion, own, out))
        for i in range(count + followed):
            if i >= count or _moves(between, n, i):
                T[i, k] = out[WRENCHES + i].imag / COMPLEX_STEP
    return _eliminate_states(shares[2], count, memory)


@inlined
def _moves(between: LoadsBetween, n: int, k: int) -> bool:
    """Return whether the end of a direction k of a load moves in it with the unknowns."""
    end = between.loads[n, FIRST_END] + k // WRENCH
    row = between.rows[end]
    return bool(row >= 0 or (row == COORDINATE and k % WRENCH == 0 and between.markers[end, AT] >= 0.0))


@inlined
def _displace(end: Any, k: int, share_of_speed: float, share_of_place: float) -> None:
    """Displace an end in one of its directions, by a complex step."""
    speed, place = complex(0.0, COMPLEX_STEP * share_of_speed), complex(0.0, COMPLEX_STEP * share_of_place)
    if k < 3:
        end[P + k] += place
        end[V + k] += speed
        return
    c, a, b = k - 3, (k - 2) % 3, (k - 1) % 3  # an axis, and the two behind it
    end[W + c] += speed
    for i in range(3):
        y, z = end[A + 3 * a + i], end[A + 3 * b + i]
        end[A + 3 * a + i] -= place * z
        end[A + 3 * b + i] += place * y


@kernel
def _eliminate_states(share: float, count: int, memory: TangentMemory) -> bool:
    """Replace the derivatives of a load by T, T_z, X and Y; return whether D is regular."""
    T, D, column = memory.T, memory.D, memory.column
    followed = len(D)
    for i in range(followed):
        for j in range(followed):
            D[i, j] = (1.0 if i == j else 0.0) - share * T[count + i, count + j]
    if followed > 0 and not factorise(D, memory.pivots):
        return False
    for k in range(count + followed):
        for i in range(followed):
            column[i] = share * T[count + i, k] if k < count else (1.0 if i == k - count else 0.0)
        solve(D, memory.pivots, column)
        for i in range(followed):
            T[count + i, k] = column[i]
    for i in range(count):
        copy(T[i, count:], column)
        T[i, count:] = 0.0
        for k in range(count + followed):
            for j in range(followed):
                T[i, k] += column[j] * T[count + j, k]
    return True


@inlined
def largest_of(T: np.ndarray, count: int) -> tuple[float, int, int]:
    """Return the largest element of the first rows of a matrix, and where it is."""
    largest, row, column = 0.0, 0, 0
    for i in range(count):
        for k in range(T.shape[1]):
            if abs(T[i, k]) > largest:
                largest, row, column = abs(T[i, k]), i, k
    return largest, row, column


@inlined
def take_off(T: np.ndarray, count: int, row: int, column: int) -> None:
    """Take from the first rows of a matrix the product of one of its columns and one of its rows, over their pivot."""
    pivot = T[row, column]
    for i in range(count):
        share = T[i, column] / pivot
        if i != row and share != 0.0:
            for k in range(T.shape[1]):
                T[i, k] -= share * T[row, k]
            T[i, column] = 0.0
    T[row] = 0.0
