"""Friction against turning, of Coulomb's: about the normal, and against rolling, by anchors (Eq. 11)."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.algebra.vectors import Numbers, dot, minus, norm, plus, rotated, rotated_back, three, times
from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.contact.laws.coulomb import AT


@kernel
def couple(
    numbers: Any,
    at: int,
    share: float,
    lever: float,
    pressed: Any,
    normal: Numbers,
    A_s: Numbers,
    omega: Numbers,
    gone: Numbers,
    states: Any,
    first: int,
    rates: Any,
    rates_at: int,
) -> Any:
    """Return the moment (N m) on the surface, and energy, power taken and that of slipping alone; add to the rates.

    Parameters
    ----------
    numbers : array of float
        From `at` on those of the law.
    share, lever : float
        Of the contact that the point has; from its centre to where it touches, m.
    pressed : float
        Normal force, N; 0 where it does not touch: anchors then follow.
    normal, omega, gone : tuple of 3 floats
        Normal; angular velocity of what touches past the surface, rad/s; how far it turned since a rest, rad; in N.
    A_s : tuple of 9 floats
        From the axes of the surface to those of N.
    states, rates : array of float
        From `first` and `rates_at` on: the twist about the normal, rad; that of rolling in axes of the surface, rad.
    """
    k, c = share * numbers[at + AT.stiffness], share * numbers[at + AT.damping]
    zero = 0.0 * pressed
    moment, energy, taken, work = (zero, zero, zero), zero, zero, zero
    about, along = times(dot(omega, normal), normal), dot(gone, normal)
    arm, rolling = numbers[at + AT.torsional], numbers[at + AT.rolling]
    if arm > 0.0:
        twist = times(states[first] + along, normal)
        most = max(numbers[at + AT.mu_along], numbers[at + AT.mu_across]) * arm * pressed
        tangential, given, energy, taken, work = braked(twist, twist, about, k * arm * arm, c * arm * arm, most)
        moment = plus(moment, tangential)
        rates[rates_at] += dot(given, normal)
        first, rates_at = first + 1, rates_at + 1
    if rolling > 0.0:
        twist = plus(rotated(A_s, three(states, first)), minus(gone, times(along, normal)))
        flat, most = minus(twist, times(dot(twist, normal), normal)), rolling * pressed
        k, c = k * lever * lever, c * lever * lever
        tangential, given, more, more_taken, more_work = braked(twist, flat, minus(omega, about), k, c, most)
        moment = plus(moment, tangential)
        energy, taken, work = energy + more, taken + more_taken, work + more_work
        in_surface = rotated_back(A_s, given)
        for j in range(3):
            rates[rates_at + j] += in_surface[j]
    return moment, energy, taken, work


@kernel
def braked(twist: Numbers, along: Numbers, rate: Numbers, k: float, c: float, most: Any) -> Any:
    """Return the moment against turning, the rate of a twist, energy, power taken and, of slipping alone, its work.

    `twist` is the whole state of the anchor, `along` that of it which follows the motion.
    """
    pull = plus(times(k, along), times(c, rate))
    size = norm(pull)
    tangential = pull if size.real <= most.real else times(most / size, pull)
    given = times(1.0 / c, minus(tangential, times(k, twist)))
    work = dot(tangential, minus(rate, given)) if most.real > 0.0 else 0.0 * size
    return tangential, given, 0.5 * k * dot(twist, twist), dot(tangential, rate) - k * dot(twist, given), work
