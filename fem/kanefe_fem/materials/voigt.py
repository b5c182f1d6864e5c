"""Stiffness matrices of materials in six components: rotation, condensation, and checks.

Stresses and strains are listed as xx, yy, zz, yz, xz, xy, with engineering shear strains (2 e_yz, ...).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers

PLACES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Tensor components of the six Voigt indices."""

IN_PLANE = (0, 1, 5)
"""Voigt indices of xx, yy and xy."""

_ROWS, _COLUMNS = (np.array(indices) for indices in zip(*PLACES, strict=True))


LARGEST = 1e100
"""Largest modulus (Pa) or density (kg/m3): products of several stay within the range of floats."""


def rotated(stiffness: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return stiffness matrices in components of G, ``C_G = T C_M T^T``.

    Parameters
    ----------
    stiffness : ndarray, shape (6, 6)
        C_M, in the material's axes, Pa.
    axes : ndarray, shape (..., 3, 3)
        A_GM: the material's axes as columns, in components of G.

    Returns
    -------
    ndarray, shape (..., 6, 6)

    Notes
    -----
    T takes stresses from M to G, ``s_G = T s_M``, and its transpose takes engineering strains from G to M (the Bond
    matrix; Auld, Acoustic Fields and Waves in Solids, 1973, sec. 3.D).
    """
    T = bond_matrix(axes)
    C = T @ stiffness @ np.swapaxes(T, -1, -2)
    return np.asarray(0.5 * (C + np.swapaxes(C, -1, -2)))


def bond_matrix(axes: np.ndarray) -> np.ndarray:
    """Return T of `rotated`, which takes stresses to the components of G, shape (..., 6, 6)."""
    A = np.asarray(axes, dtype=float)
    # (A s A^T)_ab = sum over i <= j of (A_ai A_bj + A_aj A_bi) s_ij, once for i = j
    first = A[..., _ROWS[:, None], _ROWS] * A[..., _COLUMNS[:, None], _COLUMNS]
    second = A[..., _ROWS[:, None], _COLUMNS] * A[..., _COLUMNS[:, None], _ROWS]
    return np.asarray(first + np.where(_ROWS == _COLUMNS, 0.0, second))


def plane_stress(stiffness: np.ndarray) -> np.ndarray:
    """Return the stiffness in plane stress: the inverse of the in-plane part of the compliance, (..., 3, 3)."""
    compliance = np.linalg.inv(stiffness)
    return np.asarray(np.linalg.inv(compliance[..., IN_PLANE, :][..., IN_PLANE]))


def plane_strain(stiffness: np.ndarray) -> np.ndarray:
    """Return the stiffness in plane strain, shape (..., 3, 3)."""
    return stiffness[..., IN_PLANE, :][..., IN_PLANE]


def in_space(plane: np.ndarray) -> np.ndarray:
    """Return plane stiffnesses (..., 3, 3) in the places of xx, yy, xy, zero elsewhere, shape (..., 6, 6)."""
    full = np.zeros((*plane.shape[:-2], 6, 6))
    full[..., np.array(IN_PLANE)[:, None], np.array(IN_PLANE)] = plane
    return full


def poisson_ratio(stiffness: np.ndarray) -> float:
    """Return Poisson's ratio of the isotropic material with the same Reuss averages: near 0.5 it is incompressible.

    Hill, The elastic behaviour of a crystalline aggregate, Proc. Phys. Soc. A 65 (1952).
    """
    S = np.linalg.inv(stiffness)
    direct, sum_of_all = np.trace(S[:3, :3]), S[:3, :3].sum()
    bulk = 1.0 / sum_of_all
    shear = 15.0 / (6.0 * direct - 2.0 * sum_of_all + 3.0 * np.trace(S[3:, 3:]))
    return float((3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear))


def check_stiffness(label: str, stiffness: Any, remedy: str) -> np.ndarray:
    """Return a symmetric positive definite stiffness matrix, shape (6, 6).

    Raises
    ------
    ModelError
        If it has another shape, is not finite, not symmetric, or not positive definite; the message names a strain with
        a negative energy.
    """
    C = numbers(stiffness)
    if C.shape != (6, 6):
        raise ModelError(f"{label}: the stiffness has shape {C.shape}, not (6, 6). Remedy: {remedy}")
    if not np.isfinite(C).all():
        raise ModelError(f"{label}: the stiffness is not finite. Remedy: {remedy}")
    if np.abs(C - C.T).max() > 1e-9 * np.abs(C).max():
        raise ModelError(f"{label}: the stiffness is not symmetric, so there is no energy. Remedy: {remedy}")
    C = 0.5 * (C + C.T)
    values, vectors = np.linalg.eigh(C)
    if values[0] <= 1e-14 * values[-1]:
        mode = ", ".join(f"{x:.2g}" for x in vectors[:, 0])
        raise ModelError(
            f"{label}: the stiffness is not positive definite: the strain ({mode}) in the order xx, yy, zz, yz, xz, xy "
            f"has the modulus {values[0]:.3g} Pa. Remedy: {remedy}"
        )
    return C


def check_density(label: str, rho: Any) -> float:
    """Return a density in kg/m3; raise a ModelError if it is not positive and finite."""
    return check_numbers(label, ("rho",), (rho,), "steel has rho=7850")[0]


def one_number(label: str, name: str, value: Any) -> float:
    """Return a number; raise a ModelError if it is not one."""
    if numbers(value).shape != () or (np.isnan(numbers(value)) and not isinstance(value, (float, np.floating))):
        raise ModelError(f"{label}: {name} is {value!r}. Remedy: give one number, in SI units")
    return float(value)


def check_numbers(label: str, names: Sequence[str], values: Sequence[Any], remedy: str) -> list[float]:
    """Return positive finite numbers; raise a ModelError that names the first one which is not."""
    found = []
    for name, value in zip(names, values, strict=True):
        number = one_number(label, name, value)
        if not 0.0 < number < LARGEST:
            raise ModelError(f"{label}: {name} = {number:g} must be positive and below {LARGEST:g}. Remedy: {remedy}")
        found.append(number)
    return found
