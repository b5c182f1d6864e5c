"""Scalars of a stress or strain state: von Mises, Tresca, principal values. Components xx, yy, zz, yz, xz, xy."""

from __future__ import annotations

import numpy as np

COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
"""Order of the components of stress and strain; shear strains are engineering ones, 2 e_yz."""


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
    known = np.isfinite(tensors).all(axis=(-1, -2))  # fields are NaN where a chosen material is not
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
