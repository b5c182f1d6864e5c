"""Outlines of sections, and torsion constants and shear factors without an elementary formula."""

from __future__ import annotations

import math

import numpy as np

FIBRES = 16
"""Number of fibres around the outline of each section. If the bending axis of a circle is between two, the largest
stress is 2 % higher."""

ZETA_OF_5 = 1.03692775514337
"""Value of Riemann's zeta function at 5: the sum of n^-5."""


def circle(diameter: float) -> np.ndarray:
    """Return points around a circle, y and z in m, (FIBRES, 2)."""
    angles = 2.0 * math.pi * np.arange(FIBRES) / FIBRES
    return 0.5 * diameter * np.column_stack((np.cos(angles), np.sin(angles)))


def rectangle(width: float, height: float) -> np.ndarray:
    """Return points around a rectangle, its corners among them, y and z in m, (FIBRES, 2)."""
    corners = 0.5 * np.array([(-width, -height), (width, -height), (width, height), (-width, height)])
    share = np.arange(FIBRES // 4)[:, None] / (FIBRES // 4)
    return np.concatenate([a + share * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])


def rectangle_torsion(long: float, short: float) -> float:
    """Return Saint-Venant's series for the torsion constant of a rectangle in m4."""
    # sum over odd n of tanh(n pi a / 2 b) / n^5: the part with tanh = 1 is 31/32 zeta(5), and the rest decreases like
    # exp(-n pi), so that seven terms are exact in double precision
    total = 31.0 / 32.0 * ZETA_OF_5
    for n in range(1, 14, 2):
        total += (math.tanh(n * math.pi * long / (2.0 * short)) - 1.0) / n**5
    return long * short**3 * (1.0 / 3.0 - 64.0 / math.pi**5 * short / long * total)


def box_torsion(b: float, h: float, t: float) -> float:
    """Return the torsion constant of a box with sharp corners in m4; mid-line lengths and wall."""
    # Prandtl's stress function is c phi_1 + phi_0: phi_1 is harmonic, 1 in the hole and 0 outside; phi_0 has
    # -Laplacian 2 and vanishes on both. Straight walls give Bredt's term and perimeter t^3/3. Each L-shaped corner
    # changes the flux of phi_1, its integral and that of phi_0 by a constant: 2 ln 2 / pi exactly, and the other two
    # from solving Laplace's and Poisson's equations on the L (160 elements across the wall, extrapolated).
    perimeter = 2.0 * (b + h)
    area = b * h - 4.0 * 0.1052 * t**2
    flux = perimeter / t - 4.0 * 2.0 * math.log(2.0) / math.pi
    return 4.0 * area**2 / flux + perimeter * t**3 / 3.0 + 4.0 * 0.0725 * t**4


def box_shear_factor(web: float, flange: float, nu: float) -> float:
    """Return Cowper's factor of a thin-walled box of uniform wall; mid-line lengths, the web along the force."""
    m = flange / web
    stretch = 12.0 + 72.0 * m + 150.0 * m**2 + 90.0 * m**3
    poisson = 11.0 + 66.0 * m + 135.0 * m**2 + 90.0 * m**3
    flanges = 10.0 * m**2 * ((3.0 + nu) * m + 3.0 * m**2)
    return 10.0 * (1.0 + nu) * (1.0 + 3.0 * m) ** 2 / (stretch + nu * poisson + flanges)
