"""Dispersion relation of waves, and the frequency of encounter of a ship."""

from __future__ import annotations

import math

import numpy as np

from kanefe.environment.checks import checked_number
from kanefe.environment.spectra import GRAVITY
from kanefe.frames import Vector

ITERATIONS = 12
"""Largest number of iterations of Newton's method, which takes four from its initial guess."""


def wave_number(omega: Vector, depth: float = math.inf, gravity: float = GRAVITY) -> Vector:
    """Return k of linear waves, rad/m, by ``omega^2 = g k tanh(k depth)``.

    Parameters
    ----------
    omega : ndarray
        Wave frequencies, rad/s.
    depth : float
        Depth of the water, m.
    gravity : float
        m/s2.

    Raises
    ------
    ModelError
        If the depth is not above zero.
    """
    omega = np.asarray(omega, dtype=float)
    if depth != math.inf:
        checked_number(depth, "the depth of the water", above=0.0)
    deep = omega**2 / gravity
    if math.isinf(depth):
        return deep
    x = deep * depth
    # x / sqrt(tanh(x)) (Eckart 1952) is within 5 %; its limit is sqrt(x)
    y = np.where(x > 0.0, x / np.sqrt(np.tanh(np.maximum(x, 1e-300))), 0.0)
    for _ in range(ITERATIONS):
        tanh = np.tanh(y)
        slope = tanh + y * (1.0 - tanh**2)
        y = y - np.where(slope > 0.0, (y * tanh - x) / np.where(slope > 0.0, slope, 1.0), 0.0)
    return np.asarray(y / depth)


def encounter_frequency(omega: Vector, number: Vector, heading_deg: Vector | float, speed: float) -> Vector:
    """Return the frequency at which a ship meets waves, ``omega + k U cos(heading)``, rad/s, with its sign.

    Negative in following seas if the ship overtakes the waves; up to three waves can then have the same frequency of
    encounter, so that sums are over wave frequency.

    Parameters
    ----------
    omega, number : ndarray, shape (n,)
        rad/s, rad/m.
    heading_deg : ndarray, shape (n,), or float
        0: head seas; 180: following.
    speed : float
        Speed of the ship, m/s.
    """
    return np.asarray(omega + number * speed * np.cos(np.radians(heading_deg)))
