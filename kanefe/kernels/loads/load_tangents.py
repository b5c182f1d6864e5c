"""How loads between frames answer to the unknowns of an implicit step, and the few directions in which they do.

A load with the motions e of its ends (6 each, of a joint coordinate 1) and internal states z gives wrenches F and rates
g. Where the accelerations at the end of a step change by ``ddu``, ends move by ``r e`` and their speeds change by
``s e`` with ``e = B^T ddu``; F_e and g_e below are the derivatives along both at once, by complex steps. With the share
p of the rates in z, ``dz = p (g_e e + g_z dz) + rest`` is solved for dz, of each load alone:

    dz = X e + Y rest,      D = 1 - p g_z,   X = D^-1 p g_e,   Y = D^-1,
    dF = T e + T_z rest,    T = F_e + F_z X,   T_z = F_z Y.
"""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.algebra.lu import factorise, solve
from kanefe.kernels.force_elements.places import END_NUMBERS, WRENCH, WRENCHES, End, Ends, done_size
from kanefe.kernels.language import Vector, call_address, copy, inlined, kernel, skew
from kanefe.kernels.loads.acting import COORDINATE, BetweenLoad, LoadEnds, acting_in, ends_of, loads_of
from kanefe.kernels.scene import Scene, State, Work

COMPLEX_STEP = 1e-30


class TangentMemory(NamedTuple):
    """Workspace of the tangents of a load."""

    motion: np.ndarray  # what its function is given and writes
    states: np.ndarray
    out: np.ndarray
    T: np.ndarray  # (6 ends + states, 6 ends + states): derivatives; on return the rows are T and T_z, then X and Y
    D: np.ndarray  # (states, states), (states,), (states,)
    pivots: np.ndarray
    column: np.ndarray


def tangent_size(ends: int, states: int) -> int:
    """Return how many numbers the memory of a load with so many ends and internal states has."""
    size = WRENCH * ends + states
    return 2 * (END_NUMBERS * ends + states + done_size(ends, states)) + size * size + states * (states + 2)


@inlined
def tangent_memory(load: BetweenLoad, followed: int, memory: np.ndarray) -> TangentMemory:
    """Return the parts of a memory of `tangent_size`, of a load of which so many states are followed."""
    motion, states, size = END_NUMBERS * load.end_count, load.state_count, WRENCH * load.end_count + followed
    numbers = 2 * (motion + states + done_size(load.end_count, states))
    of_complex, rest = memory[:numbers].view(np.complex128), memory[numbers:]
    T, rest = rest[: size * size].reshape(size, size), rest[size * size :]
    D, rest = rest[: followed * followed].reshape(followed, followed), rest[followed * followed :]
    own, out = of_complex[motion : motion + states], of_complex[motion + states :]
    return TangentMemory(of_complex[:motion], own, out, T, D, rest[:followed], rest[followed : 2 * followed])


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
    load, ends, acting, between = loads_of(scene)[n], ends_of(scene), acting_in(scene, work), scene.between
    motion, own, out, T = memory.motion, memory.states, memory.out, memory.T
    count, followed = WRENCH * load.end_count, len(memory.D)
    constants, given = between.numbers[load.first_number :], state.inputs[load.first_input :]
    T[:] = 0.0
    for k in range(count + followed):
        if k < count and not _moves(ends, load, k):
            continue
        for i in range(len(motion)):
            motion[i] = acting.ends[i]
        for i in range(len(own)):
            own[i] = state.z[load.first_state + i]
        if k < count:
            _displace(Ends(motion)[k // WRENCH], k % WRENCH, shares[0], shares[1])
        else:
            own[k - count] += complex(0.0, COMPLEX_STEP)
        out[:] = 0.0
        call_address(load.complex_function, (state.t, constants, given, motion, own, out))
        for i in range(count + followed):
            if i >= count or _moves(ends, load, i):
                T[i, k] = out[WRENCHES + i].imag / COMPLEX_STEP
    return _eliminate_states(shares[2], count, memory)


@inlined
def _moves(ends: LoadEnds, load: BetweenLoad, k: int) -> bool:
    """Return whether the end of a direction k of a load moves in it with the unknowns."""
    end = ends[load.first_end + k // WRENCH]
    return end.row >= 0 or (end.row == COORDINATE and k % WRENCH == 0 and end.coordinate >= 0)


@inlined
def _displace(end: End, k: int, share_of_speed: float, share_of_place: float) -> None:
    """Displace an end in one of its directions, by a complex step."""
    speed, place = complex(0.0, COMPLEX_STEP * share_of_speed), complex(0.0, COMPLEX_STEP * share_of_place)
    along = Vector(1.0 * (k % 3 == 0), 1.0 * (k % 3 == 1), 1.0 * (k % 3 == 2))
    if k < 3:
        end.p += place * along
        end.v += speed * along
    else:
        end.w += speed * along
        end.A += place * (skew(along) @ end.A)


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
