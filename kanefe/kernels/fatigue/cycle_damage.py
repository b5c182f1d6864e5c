"""Damage of stress histories: rainflow counting (ASTM E1049-85, 5.4.4), mean stress, S-N curve, Miner's sum."""

import math
from enum import IntEnum

import numpy as np

from kanefe.kernels.language import RealBlocks, Reals, Record, copy, entry, kernel


class Correction(IntEnum):
    """Corrections for mean stress.

    The parameter of Goodman's and Gerber's is the ultimate strength, Pa; of Walker's gamma.
    """

    NONE = 0
    GOODMAN = 1
    GERBER = 2
    WALKER = 3


class DamageLaw(Record):
    """An S-N curve, with a correction for mean stress.

    Attributes
    ----------
    amplitude, cycles : float
        At the knee, Pa and 1.
    slope, slope_below : float
        Above and below it; inf: no damage below.
    correction, parameter : float
        `Correction`.
    """

    amplitude: float
    cycles: float
    slope: float
    slope_below: float
    correction: float
    parameter: float


SIGNED_VON_MISES = 6
"""Number of the scalar that has the sign of the trace of the stress; 0 to 5 are its components."""


@kernel
def damage_of_cycle(amplitude: float, mean: float, law: DamageLaw) -> float:
    """Return the damage of one cycle, 1/N; inf if its mean stress breaks the material.

    The amplitude of the cycle without mean stress that is as damaging is ``S_a / (1 - S_m / R)`` by Goodman,
    ``S_a / (1 - (S_m / R)^2)`` by Gerber, both for a mean stress above zero, and
    ``(S_m + S_a)^(1 - gamma) S_a^gamma`` by Walker (1/2: Smith, Watson and Topper).
    """
    correction, parameter = int(law.correction), law.parameter
    if (correction == Correction.GOODMAN or correction == Correction.GERBER) and mean > 0.0:
        share = mean / parameter
        if share >= 1.0:
            return np.inf
        amplitude /= 1.0 - (share if correction == Correction.GOODMAN else share * share)
    elif correction == Correction.WALKER:
        highest = mean + amplitude
        amplitude = highest ** (1.0 - parameter) * amplitude**parameter if highest > 0.0 else 0.0
    size = amplitude / law.amplitude
    slope = law.slope if size >= 1.0 else law.slope_below
    return 0.0 if size <= 0.0 or slope == np.inf else size**slope / law.cycles


@kernel
def _damage_between(first: float, second: float, law: DamageLaw) -> float:
    """Return the damage of the cycle between two reversals."""
    return damage_of_cycle(0.5 * abs(second - first), 0.5 * (first + second), law)


@kernel
def _put_reversals(history: np.ndarray, reversals: np.ndarray) -> int:
    """Write the first and last value of a history (T,) and those between where it turns; return how many."""
    reversals[0], count, x, rise = history[0], 1, history[0], 0.0
    for i in range(1, len(history)):
        step = history[i] - x
        if step == 0.0:
            continue
        if rise * step < 0.0:
            reversals[count] = x
            count += 1
        x, rise = history[i], step
    reversals[count] = x
    return count + 1


@kernel
def damage_of_history(history: np.ndarray, law: DamageLaw, reversals: np.ndarray) -> float:
    """Return the damage of a stress history (T,) in Pa; `reversals` (T + 1,) is workspace.

    Reversals that are not part of a cycle yet are kept. X is the range between the last two of them, Y the one before.
    As long as X is not below Y, Y is a full cycle, or half a cycle if it begins with the first reversal.
    """
    total, count = 0.0, 0
    for i in range(_put_reversals(history, reversals)):
        reversals[count] = reversals[i]
        count += 1
        while count >= 3:
            first, second, third = reversals[count - 3], reversals[count - 2], reversals[count - 1]
            if abs(third - second) < abs(second - first):
                break
            if count == 3:
                total += 0.5 * _damage_between(first, second, law)
                reversals[0], reversals[1], count = second, third, 2
            else:
                total += _damage_between(first, second, law)
                reversals[count - 3] = third
                count -= 2
    for i in range(count - 1):
        total += 0.5 * _damage_between(reversals[i], reversals[i + 1], law)
    return total


@kernel
def _put_scalar(stress: np.ndarray, scalar: int, out: np.ndarray) -> None:
    """Write a scalar (T,) of stresses (6, T)."""
    if scalar != SIGNED_VON_MISES:
        copy(stress[scalar], out)
        return
    for i in range(len(out)):
        xx, yy, zz = stress[0, i], stress[1, i], stress[2, i]
        yz, xz, xy = stress[3, i], stress[4, i], stress[5, i]
        normal = (xx - yy) * (xx - yy) + (yy - zz) * (yy - zz) + (zz - xx) * (zz - xx)
        size = math.sqrt(0.5 * normal + 3.0 * (yz * yz + xz * xz + xy * xy))
        out[i] = size if xx + yy + zz >= 0.0 else -size


@entry()
def damage_of_stresses(stresses: RealBlocks, scalar: int, law: Reals, memory: Reals, out: Reals) -> None:
    """Write the damage at nodes (n,) from stresses (n, 6, T) in Pa; `memory` (2 T + 1,) is workspace."""
    count = stresses.shape[2]
    for node in range(len(stresses)):
        _put_scalar(stresses[node], scalar, memory[:count])
        out[node] = damage_of_history(memory[:count], DamageLaw(law), memory[count:])
