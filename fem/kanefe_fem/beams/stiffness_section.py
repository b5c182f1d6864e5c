"""Sections of beams given by stiffness and mass per unit length: blades, composites, measured parts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe_fem.beams.beam_section import BeamSection, LineMass

_NAMES = ("EA", "GA_y", "GA_z", "GJ", "EI_y", "EI_z")
"""Names of the diagonal entries of the stiffness, in order."""

_IN_PLANE, _OUT_OF_PLANE = [0, 1, 5], [2, 3, 4]

_PRINTED = 1e-3
"""Largest relative deviation of matrices from symmetry or from those of a rigid section: files have four digits."""

Matrix = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class StiffnessSection(BeamSection):
    """Section by stiffness and mass, made by `kanefe_fem.Section.from_stiffness`.

    Attributes
    ----------
    stiffness : tuple, 6 x 6
        N, V_y, V_z, T, M_y, M_z from the strains; ``inf`` where shear is rigid, ``nan`` for numbers that were not given
        but are needed by beams in space.
    rho_A : float
        kg/m.
    centre_of_mass : (float, float)
        y and z in m.
    second_moments : tuple, 2 x 2
        ``int rho r r^T dA`` of r = (y, z) about the centre of mass, kg m.
    """

    stiffness: Matrix
    rho_A: float
    centre_of_mass: tuple[float, float]
    second_moments: Matrix

    @classmethod
    def of(
        cls, numbers: Mapping[str, Any], stiffness: Any, rho_A: Any, rho_I: Any, centre_of_mass: Any, mass: Any
    ) -> StiffnessSection:
        """Return the section from the arguments of `Section.from_stiffness`."""
        K = _diagonal(numbers) if stiffness is None else _matrix("stiffness", stiffness)
        if stiffness is not None and any(value is not None for value in numbers.values()):
            twice = next(name for name, value in numbers.items() if value is not None)
            raise ModelError(f"from_stiffness: both stiffness and {twice} are given. Remedy: one of them")
        if mass is None:
            centre = _centre(centre_of_mass)
            per_length = _positive("rho_A", rho_A, "the mass in kg/m")
            second = _second_moments(rho_I, per_length, K)
        elif rho_A is not None or rho_I is not None or tuple(np.ravel(centre_of_mass)) != (0.0, 0.0):
            raise ModelError("from_stiffness: mass is given beside rho_A, rho_I or centre_of_mass. Remedy: one of them")
        else:
            per_length, centre, second = _rigid(_matrix("mass", mass, definite=False))
        return cls(_tuples(K), per_length, (float(centre[0]), float(centre[1])), _tuples(second))

    @property
    def needs_material(self) -> bool:
        """False."""
        return False

    @property
    def turns_freely(self) -> bool:
        """Whether both directions across are equal and uncoupled."""
        K, J = np.array(self.stiffness), np.array(self.second_moments)
        coupled = (K - np.diag(np.diag(K))).any() or J[0, 1] != 0.0 or any(self.centre_of_mass)
        pairs = ((K[1, 1], K[2, 2]), (K[4, 4], K[5, 5]), (J[0, 0], J[1, 1]))
        return not coupled and all(a == b or math.isclose(a, b, rel_tol=1e-12) for a, b in pairs)

    def stiffness_of(self, material: Any, *, planar: bool) -> np.ndarray:
        """Return the stiffness, shape (6, 6).

        Raises
        ------
        ModelError
            If a number is missing, or the section couples motions in the plane of a planar model with others.
        """
        K = np.array(self.stiffness)
        if not planar:
            missing = [name for name, value in zip(_NAMES, np.diag(K), strict=True) if math.isnan(value)]
            if missing:
                raise ModelError(
                    f"the section has no {' and no '.join(missing)}, which a beam in space needs. Remedy: give it to "
                    "Section.from_stiffness, or planar=True"
                )
            return K
        if math.isnan(K[5, 5]):
            raise ModelError(
                "the section has no EI_z, the bending stiffness of a planar beam. Remedy: give it to "
                "Section.from_stiffness; EI_y is that of bending out of the plane"
            )
        if K[np.ix_(_IN_PLANE, _OUT_OF_PLANE)].any():
            raise ModelError(
                "the section's stiffness couples motions in the plane with twist or with bending out of it. Remedy: "
                "planar=False"
            )
        # there is no motion out of the plane: any positive number is possible
        for row in (3, 4):
            K[row, row] = K[5, 5] if math.isnan(K[row, row]) else K[row, row]
        return K

    def mass_of(self, material: Any) -> LineMass:
        """Return the mass."""
        return LineMass(self.rho_A, np.array(self.centre_of_mass), np.array(self.second_moments))


def _diagonal(numbers: Mapping[str, Any]) -> np.ndarray:
    """Return the stiffness by its numbers; nan where bending or twist was not given."""
    values = {name: None if given is None else _positive(name, given, "it") for name, given in numbers.items()}
    _positive("EA", values["EA"], "the axial stiffness in N")
    if values["EI_y"] is None and values["EI_z"] is None:
        raise ModelError("from_stiffness: no bending stiffness. Remedy: EI_y and EI_z in N m2, or stiffness (6, 6)")
    instead = {"GA_y": math.inf, "GA_z": math.inf}
    return np.diag([instead.get(name, math.nan) if values[name] is None else values[name] for name in _NAMES])


def _positive(name: str, given: Any, what: str) -> float:
    if isinstance(given, bool) or not hasattr(given, "__float__") or np.ndim(given):
        raise ModelError(f"from_stiffness: {name} = {given!r} is not a number. Remedy: give {what}, in SI units")
    value = float(given)
    if not 0.0 < value < math.inf:
        raise ModelError(f"from_stiffness: {name} = {value:g} must be positive and finite. Remedy: give SI units")
    return value


def _matrix(name: str, given: Any, definite: bool = True) -> np.ndarray:
    """Return a symmetric matrix (6, 6) that is positive when scaled to a diagonal of ones."""
    try:
        A = np.array(given, dtype=float)
    except (TypeError, ValueError):
        A = np.zeros(0)
    if A.shape != (6, 6) or not np.isfinite(A).all():
        raise ModelError(f"from_stiffness: {name} must be 6 x 6 finite numbers, not of shape {np.shape(given)}")
    size = np.sqrt(np.abs(np.diag(A)))
    size[size == 0.0] = 1.0
    scaled = A / np.outer(size, size)
    if np.abs(scaled - scaled.T).max() > _PRINTED:
        row, column = np.unravel_index(np.abs(scaled - scaled.T).argmax(), (6, 6))
        raise ModelError(
            f"from_stiffness: {name} is not symmetric: {A[row, column]:g} and {A[column, row]:g} in row {row + 1}, "
            f"column {column + 1}. Remedy: check its order (N, V_y, V_z, T, M_y, M_z) and its signs"
        )
    least = np.linalg.eigvalsh(0.5 * (scaled + scaled.T))[0]
    if least <= (0.0 if definite else -_PRINTED):
        raise ModelError(
            f"from_stiffness: {name} is not positive (least eigenvalue {least:.2g}, scaled to a diagonal of ones). "
            "Remedy: check its order (N, V_y, V_z, T, M_y, M_z) and its signs"
        )
    return 0.5 * (A + A.T)


def _centre(given: Any) -> np.ndarray:
    centre = np.asarray(given, dtype=float)
    if centre.shape != (2,) or not np.isfinite(centre).all():
        raise ModelError(f"from_stiffness: centre_of_mass={given!r}. Remedy: its y and z from the axis, in m")
    return centre


def _second_moments(rho_I: Any, rho_A: float, K: np.ndarray) -> np.ndarray:
    if rho_I is None:
        of_one_material = [rho_A * K[5, 5] / K[0, 0], rho_A * K[4, 4] / K[0, 0]]
        return np.diag(np.nan_to_num(of_one_material))
    values = np.asarray(rho_I, dtype=float)
    if values.shape not in ((), (2,)) or not np.isfinite(values).all() or values.min() < 0.0:
        raise ModelError(
            f"from_stiffness: rho_I={rho_I!r}. Remedy: one number or two (of bending about y and z), >= 0, in kg m"
        )
    about_y, about_z = np.broadcast_to(values, 2)
    return np.diag([about_z, about_y])


def _rigid(M: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass, centre and second moments of a rigid section from its matrix (6, 6)."""
    rho_A = _positive("mass[0][0]", M[0, 0], "the mass in kg/m")
    y, z = -M[0, 5] / rho_A, M[0, 4] / rho_A
    second = np.array([[M[5, 5], -M[4, 5]], [-M[4, 5], M[4, 4]]]) - rho_A * np.outer((y, z), (y, z))
    cross = np.array([[0.0, z, -y], [-z, 0.0, 0.0], [y, 0.0, 0.0]])  # velocity from the rates of rotation
    about_axis = second + rho_A * np.outer((y, z), (y, z))
    J = np.zeros((3, 3))
    J[0, 0] = np.trace(about_axis)
    J[1:, 1:] = [[about_axis[1, 1], -about_axis[0, 1]], [-about_axis[0, 1], about_axis[0, 0]]]
    wanted = np.block([[rho_A * np.eye(3), rho_A * cross], [rho_A * cross.T, J]])
    size = np.sqrt(np.maximum(np.diag(wanted), 1e-300))
    wrong = np.abs(M - wanted) / np.outer(size, size)
    if wrong.max() > _PRINTED or np.linalg.eigvalsh(second)[0] < -_PRINTED * np.trace(second):
        row, column = np.unravel_index(wrong.argmax(), (6, 6))
        raise ModelError(
            f"from_stiffness: no rigid section has this mass matrix: row {row + 1}, column {column + 1} is "
            f"{M[row, column]:g}, and by its others {wanted[row, column]:g}. Remedy: check its order (x along the "
            "beam) and that the polar inertia is the sum of the other two"
        )
    return rho_A, np.array((y, z)), second


def _tuples(matrix: np.ndarray) -> Matrix:
    return tuple(tuple(float(value) for value in row) for row in matrix)
