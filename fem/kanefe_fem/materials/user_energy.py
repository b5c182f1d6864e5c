"""Materials by a strain energy of the user: its tangent at the reference state, by automatic differentiation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import InitVar, dataclass, field
from typing import Any, Literal

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe_fem import _fenicsx
from kanefe_fem.materials.voigt import PLACES, check_density, check_stiffness

Measure = Literal["strain", "deformation gradient"]

REST = 1e-8
"""Stress at rest and stiffness against rotation, relative to the moduli, that count as zero."""


@checked
@dataclass(frozen=True, eq=False)
class UserEnergy:
    """Elastic material with a strain energy density W, linearised about its reference state.

    Parameters
    ----------
    energy : callable
        W in J/m3 as a UFL expression: of the small (or Green-Lagrange) strain, or of the deformation gradient
        ``F = I + grad u``, a 3 x 3 tensor.
    rho : float
        Density in kg/m3, > 0.
    of : {"strain", "deformation gradient"}
        Argument of `energy`.
    name : str, optional
        Used in messages only.

    Attributes
    ----------
    stiffness : ndarray, shape (6, 6)
        ``C = d2W / de de`` at rest, in Pa, in the material's axes (see `kanefe_fem.Oriented`), in the order 11, 22, 33,
        23, 13, 12 with engineering shear strains. The energy itself is not stored.

    Raises
    ------
    ModelError
        If the energy is not a scalar, has no derivatives at rest, is stressed there, resists rotation, or is not
        positive definite.
    MissingDependency
        If UFL is not installed.

    Examples
    --------
    A compressible neo-Hookean rubber:

    >>> import ufl                                                            # doctest: +SKIP
    >>> def W(F):                                                             # doctest: +SKIP
    ...     J = ufl.det(F)
    ...     return 0.5e6 * (ufl.tr(F.T * F) - 3.0 - 2.0 * ufl.ln(J)) + 5e6 * (J - 1.0) ** 2
    >>> rubber = UserEnergy(W, rho=1100.0, of="deformation gradient")         # doctest: +SKIP
    """

    energy: InitVar[Callable[[Any], Any]]
    rho: float
    of: InitVar[Measure] = "strain"
    name: str | None = None
    stiffness: np.ndarray = field(init=False)

    def __post_init__(self, energy: Callable[[Any], Any], of: Measure) -> None:
        label = f"material {self.name!r}" if self.name else "material"
        object.__setattr__(self, "rho", check_density(label, self.rho))
        if not callable(energy) or not isinstance(of, str) or of not in ("strain", "deformation gradient"):
            raise ModelError(
                f"{label}: energy={energy!r}, of={of!r}. Remedy: a function of the strain (of='strain') or of F "
                "(of='deformation gradient') that returns a UFL expression"
            )
        tangent = _tangent_in_strain if of == "strain" else _tangent_in_gradient
        remedy = "check the signs and that the second derivative at rest does not vanish for any strain"
        stiffness = check_stiffness(label, tangent(label, energy), remedy)
        stiffness.flags.writeable = False
        object.__setattr__(self, "stiffness", stiffness)

    def describe(self) -> dict[str, object]:
        """Return the tangent (json-able), which is all that is used of the energy."""
        return {"kind": "energy", "stiffness": self.stiffness.tolist(), "rho": self.rho, "name": self.name}


def _tangent_in_strain(label: str, energy: Callable[[Any], Any]) -> np.ndarray:
    """Return d2W / de_I de_J at e = 0, shape (6, 6), Pa."""
    ufl, _ = _fenicsx.load_ufl()
    e = [ufl.variable(ufl.as_ufl(0.0)) for _ in PLACES]
    number = {pair: i for i, pair in enumerate(PLACES)}
    rows = [[e[number[min(a, b), max(a, b)]] * (1.0 if a == b else 0.5) for b in range(3)] for a in range(3)]
    stress, C = _derivatives(label, energy, ufl.as_matrix(rows), e)
    _refuse_stress(label, stress, C)
    return C


def _tangent_in_gradient(label: str, energy: Callable[[Any], Any]) -> np.ndarray:
    """Return the tangent in strains from W(F): if F = I is free of stress, d2W / dF dF acts on the strain only."""
    ufl, _ = _fenicsx.load_ufl()
    F = [ufl.variable(ufl.as_ufl(float(a == b))) for a in range(3) for b in range(3)]
    stress, A = _derivatives(label, energy, ufl.as_matrix([F[:3], F[3:6], F[6:]]), F)
    _refuse_stress(label, stress, A)
    turn = np.zeros((9, 3))
    for k, (a, b) in enumerate(((1, 2), (2, 0), (0, 1))):
        turn[3 * a + b, k], turn[3 * b + a, k] = -1.0, 1.0
    if np.abs(A @ turn).max() > REST * np.abs(A).max():
        raise ModelError(
            f"{label}: the energy resists a rotation of the body. Remedy: let W depend on C = F^T F only (or on its "
            "invariants), or give it as a function of the small strain (of='strain')"
        )
    strain = np.zeros((9, 6))
    for column, (a, b) in enumerate(PLACES):
        strain[3 * a + b, column] += 0.5
        strain[3 * b + a, column] += 0.5
    return np.asarray(strain.T @ A @ strain)


def _derivatives(
    label: str, energy: Callable[[Any], Any], argument: Any, variables: list[Any]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the first and second derivatives of the energy, at the values the variables have."""
    ufl, ufl_error = _fenicsx.load_ufl()
    remedy = "return one number in J/m3 that is twice differentiable at rest, made of the argument by UFL's functions"
    try:
        W = ufl.as_ufl(energy(argument))
    except (ufl_error, TypeError, ValueError) as problem:
        raise ModelError(f"{label}: the energy is not a UFL expression ({problem}). Remedy: {remedy}") from problem
    if W.ufl_shape != () or W.ufl_free_indices != ():
        raise ModelError(f"{label}: the energy has shape {W.ufl_shape}, it is not a scalar. Remedy: {remedy}")
    size = len(variables)
    try:
        slopes = [ufl.diff(W, e) for e in variables]
        first = np.array([float(slope(())) for slope in slopes])
        second = np.zeros((size, size))
        for i in range(size):
            for j in range(i, size):
                second[i, j] = second[j, i] = float(ufl.diff(slopes[i], variables[j])(()))
    except (ArithmeticError, TypeError, ValueError, ufl_error) as problem:
        raise ModelError(f"{label}: the energy has no derivatives at rest ({problem}). Remedy: {remedy}") from problem
    if not (np.isfinite(first).all() and np.isfinite(second).all()):
        raise ModelError(f"{label}: the derivatives of the energy at rest are not finite. Remedy: {remedy}")
    return first, second


def _refuse_stress(label: str, stress: np.ndarray, tangent: np.ndarray) -> None:
    if np.abs(stress).max() > REST * np.abs(tangent).max():
        raise ModelError(
            f"{label}: the energy has the stress {np.abs(stress).max():.3g} Pa at rest. Remedy: subtract what makes it "
            "(such as - 2 mu ln J of a neo-Hookean material); for a body that is stressed on purpose use Preload"
        )
