"""Scalars of stress and strain: von Mises, Tresca, principal values, and the failure indices of layers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
"""Order of the components of stress and strain; shear strains are engineering strains, 2 e_yz."""

PLANE, ACROSS = [0, 1, 5], [4, 3]
"""Places of 11, 22, 12 and of 13, 23 among them, of shells."""


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Return von Mises' equivalent stress, shape (...,), from stresses of shape (..., 6).

    Examples
    --------
    >>> von_mises(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])).round(6)
    1.732051
    """
    xx, yy, zz, yz, xz, xy = np.moveaxis(np.asarray(stress, dtype=float), -1, 0)
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(0.5 * normal + 3.0 * (yz**2 + xz**2 + xy**2)))


def principal(stress: np.ndarray) -> np.ndarray:
    """Return the principal values, greatest first, shape (..., 3), of stresses (..., 6)."""
    tensors = tensor(stress)
    known = np.isfinite(tensors).all(axis=(-1, -2))  # fields are NaN outside of a chosen material
    values = np.linalg.eigvalsh(np.where(known[..., None, None], tensors, 0.0))[..., ::-1]
    return np.where(known[..., None], values, np.nan)


def principal_strains(strain: np.ndarray) -> np.ndarray:
    """Return the principal strains, greatest first, shape (..., 3), of strains (..., 6) with engineering shears."""
    return principal(strain * np.array([1.0, 1.0, 1.0, 0.5, 0.5, 0.5]))


def tresca(stress: np.ndarray) -> np.ndarray:
    """Return Tresca's equivalent stress, the difference of the greatest and least principal value, shape (...,)."""
    values = principal(stress)
    return np.asarray(values[..., 0] - values[..., 2])


def tensor(components: np.ndarray) -> np.ndarray:
    """Return the symmetric tensors (..., 3, 3) of components (..., 6)."""
    return np.asarray(components)[..., [[0, 5, 4], [5, 1, 3], [4, 3, 2]]]


def along(direction: np.ndarray) -> np.ndarray:
    """Return the row (6,) that takes strains to the strain along a unit direction (3,)."""
    x, y, z = direction
    return np.array([x * x, y * y, z * z, y * z, x * z, x * y])


Scalar = Literal["von_mises", "tresca", "max_principal", "min_principal", "max_shear", "tsai_wu", "max_stress"]


SCALARS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "von_mises": von_mises,
    "tresca": tresca,
    "max_principal": lambda stress: principal(stress)[..., 0],
    "min_principal": lambda stress: principal(stress)[..., 2],
    "max_shear": lambda stress: 0.5 * tresca(stress),
}
"""Scalar functions of the stress, Pa."""


def worst_of(quantity: str) -> np.ufunc:
    """Return the function that takes the worse of two values of a scalar, and the other one where one is NaN."""
    return np.fmin if quantity == "min_principal" else np.fmax


def max_stress(stress: np.ndarray, strengths: np.ndarray) -> np.ndarray:
    """Return the largest share of a strength that a stress takes, shape (...,): 1 is failure.

    Parameters
    ----------
    stress : ndarray, shape (..., 6)
        In the axes of the layer, Pa.
    strengths : ndarray, shape (..., 6)
        Xt, Xc, Yt, Yc, S and the interaction, as of `kanefe_fem.Strengths`.

    Examples
    --------
    >>> float(max_stress(np.array([0.0, -50e6, 0.0, 0.0, 0.0, 30e6]), np.array([1e9, 8e8, 5e7, 2e8, 7.5e7, -0.5])))
    0.4
    """
    s1, s2, s12 = (stress[..., i] for i in (0, 1, 5))
    Xt, Xc, Yt, Yc, S, _ = np.moveaxis(strengths, -1, 0)
    of_1, of_2 = s1 / np.where(s1 > 0.0, Xt, Xc), s2 / np.where(s2 > 0.0, Yt, Yc)
    return np.asarray(np.maximum(np.maximum(np.abs(of_1), np.abs(of_2)), np.abs(s12) / S))


def tsai_wu(stress: np.ndarray, strengths: np.ndarray) -> np.ndarray:
    """Return the index of Tsai and Wu, shape (...,), from the arguments of `max_stress`.

    It is 1 / R, where R is the factor on the stress at which ``F_i s_i + F_ij s_i s_j`` is 1 (J. Composite Materials 5
    (1971) 58), so that it grows with the load as the stress does.

    Examples
    --------
    >>> float(tsai_wu(np.array([0.0, 25e6, 0.0, 0.0, 0.0, 0.0]), np.array([1e9, 8e8, 5e7, 2e8, 7.5e7, -0.5])).round(12))
    0.5
    """
    s1, s2, s12 = (stress[..., i] for i in (0, 1, 5))
    Xt, Xc, Yt, Yc, S, interaction = np.moveaxis(strengths, -1, 0)
    linear = (1.0 / Xt - 1.0 / Xc) * s1 + (1.0 / Yt - 1.0 / Yc) * s2
    products = 2.0 * interaction / np.sqrt(Xt * Xc * Yt * Yc) * s1 * s2
    quadratic = s1**2 / (Xt * Xc) + s2**2 / (Yt * Yc) + s12**2 / S**2 + products
    return np.asarray(0.5 * (linear + np.sqrt(linear**2 + 4.0 * quadratic)))


FAILURES: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {"tsai_wu": tsai_wu, "max_stress": max_stress}
"""Failure indices of layers: 1 is failure."""


TITLES = {
    "von_mises": "von Mises stress",
    "tresca": "Tresca stress",
    "max_principal": "greatest principal stress",
    "min_principal": "least principal stress",
    "max_shear": "greatest shear stress",
    "tsai_wu": "Tsai-Wu index",
    "max_stress": "share of the strength",
}
