"""Orthotropic and fully anisotropic linear elastic materials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.damping import RayleighDamping
from kanefe.frames import numbers
from kanefe_fem.materials.damping import Losses, described_losses, put_losses
from kanefe_fem.materials.strengths import Strengths, check_strengths, described_strengths
from kanefe_fem.materials.voigt import check_density, check_numbers, check_stiffness


@checked("name")
@dataclass(frozen=True, kw_only=True)
class Orthotropic:
    """Orthotropic linear elastic material, in its own axes 1, 2, 3 (see `kanefe_fem.Oriented`).

    ``e_1 = s_1/E1 - nu21 s_2/E2 - nu31 s_3/E3``, and so on; ``nu_ij`` is the contraction along j when pulled along i,
    so that ``nu_ij / E_i = nu_ji / E_j``.

    Parameters
    ----------
    E1, E2, E3 : float
        Young's moduli in Pa, > 0.
    nu12, nu13, nu23 : float
        Poisson's ratios.
    G12, G13, G23 : float
        Shear moduli in Pa, > 0.
    rho : float
        Density in kg/m3, > 0.
    name : str, optional
        Used in messages only.
    damping, loss_factor, prony : optional
        As those of `Material`, of all moduli alike.
    strengths : Strengths, optional
        For failure indices of shells.

    Raises
    ------
    ModelError
        If a value is out of range, or the nine constants together are not positive definite.

    Examples
    --------
    >>> wood = Orthotropic(E1=11e9, E2=0.9e9, E3=0.5e9, nu12=0.37, nu13=0.42, nu23=0.47,
    ...                    G12=0.75e9, G13=0.70e9, G23=0.04e9, rho=450.0, name="spruce")
    >>> wood.stiffness.shape
    (6, 6)
    """

    E1: float
    E2: float
    E3: float
    nu12: float
    nu13: float
    nu23: float
    G12: float
    G13: float
    G23: float
    rho: float
    name: str | None = None
    damping: RayleighDamping | None = None
    loss_factor: float = 0.0
    prony: Sequence[tuple[float, float]] = ()
    strengths: Strengths | None = None

    def __post_init__(self) -> None:
        moduli = ("E1", "E2", "E3", "G12", "G13", "G23", "rho")
        ratios = ("nu12", "nu13", "nu23")
        found = check_numbers(self._label, moduli, [getattr(self, n) for n in moduli], "moduli in Pa, rho in kg/m3")
        for name, number in zip(moduli, found, strict=True):
            object.__setattr__(self, name, number)
        for name in ratios:
            value = getattr(self, name)
            if numbers(value).shape != () or not np.isfinite(numbers(value)):
                raise ModelError(f"{self._label}: {name} is {value!r}. Remedy: give one finite number")
            object.__setattr__(self, name, float(value))
        for ratio, along, across in (("nu12", "E1", "E2"), ("nu13", "E1", "E3"), ("nu23", "E2", "E3")):
            nu, limit = getattr(self, ratio), np.sqrt(getattr(self, along) / getattr(self, across))
            if abs(nu) >= limit:
                raise ModelError(
                    f"{self._label}: |{ratio}| = {abs(nu):g} must be below sqrt({along}/{across}) = {limit:.3g}, or a "
                    f"strain gains energy. Remedy: is it the other ratio, {ratio[:2]}{ratio[3]}{ratio[2]} = {ratio} "
                    f"{across}/{along}?"
                )
        compliance = self.compliance
        if np.linalg.eigvalsh(compliance[:3, :3] * np.sqrt(np.outer(self._E, self._E)))[0] <= 1e-12:
            raise ModelError(
                f"{self._label}: nu12, nu13 and nu23 together let a strain gain energy (1 - nu12 nu21 - nu13 nu31 - "
                "nu23 nu32 - 2 nu21 nu32 nu13 must be positive). Remedy: check that nu_ij is the contraction along j "
                "when pulled along i"
            )
        put_losses(self, self._label)
        check_strengths(self, self._label)

    @classmethod
    @checked
    def transversely_isotropic(
        cls,
        *,
        E1: float,
        E2: float,
        nu12: float,
        nu23: float,
        G12: float,
        rho: float,
        name: str | None = None,
        strengths: Strengths | None = None,
    ) -> Orthotropic:
        """Return a material with the fibre direction 1 that is the same in all directions across it.

        Parameters
        ----------
        E1, E2 : float
            Young's moduli along and across the fibres in Pa.
        nu12, nu23 : float
            Poisson's ratios: pulled along the fibres, and within the plane across them.
        G12 : float
            Shear modulus along the fibres in Pa.
        rho : float
            Density in kg/m3.
        name : str, optional
        strengths : Strengths, optional
            For failure indices of shells.
        """
        label = f"material {name!r}" if name else "material"
        across = check_numbers(label, ("E2",), (E2,), "moduli in Pa")[0]
        if nu23 <= -1.0:
            raise ModelError(f"{label}: nu23 = {nu23!r} must be above -1. Remedy: Poisson's ratio across the fibres")
        return cls(
            E1=E1,
            E2=E2,
            E3=E2,
            nu12=nu12,
            nu13=nu12,
            nu23=nu23,
            G12=G12,
            G13=G12,
            G23=across / (2.0 * (1.0 + nu23)),
            rho=rho,
            name=name,
            strengths=strengths,
        )

    @property
    def compliance(self) -> np.ndarray:
        """Strains from stresses in the order 11, 22, 33, 23, 13, 12, shape (6, 6), 1/Pa."""
        S = np.diag(1.0 / np.array([self.E1, self.E2, self.E3, self.G23, self.G13, self.G12]))
        S[0, 1] = S[1, 0] = -self.nu12 / self.E1
        S[0, 2] = S[2, 0] = -self.nu13 / self.E1
        S[1, 2] = S[2, 1] = -self.nu23 / self.E2
        return S

    @property
    def stiffness(self) -> np.ndarray:
        """Stresses from strains in the material's axes, shape (6, 6), Pa."""
        C = np.zeros((6, 6))
        C[:3, :3] = np.linalg.inv(self.compliance[:3, :3])
        C[[3, 4, 5], [3, 4, 5]] = self.G23, self.G13, self.G12
        return C

    def describe(self) -> dict[str, object]:
        """Return the constants (json-able)."""
        own = {f.name: getattr(self, f.name) for f in fields(self) if not hasattr(Losses, f.name)}
        own.pop("strengths")
        return {"kind": "orthotropic", **own, **described_losses(self), **described_strengths(self)}

    @property
    def _E(self) -> np.ndarray:
        return np.array([self.E1, self.E2, self.E3])

    @property
    def _label(self) -> str:
        return f"material {self.name!r}" if self.name else "material"


@checked("name")
@dataclass(frozen=True, eq=False)
class Anisotropic:
    """Linear elastic material given by its stiffness matrix.

    Parameters
    ----------
    stiffness : array_like, shape (6, 6)
        Stresses from strains in Pa, in the material's axes, in the order 11, 22, 33, 23, 13, 12, with engineering shear
        strains; symmetric and positive definite.
    rho : float
        Density in kg/m3, > 0.
    name : str, optional
        Used in messages only.
    damping, loss_factor, prony : optional
        As those of `Material`, of all moduli alike.

    Raises
    ------
    ModelError
        If the matrix is not symmetric and positive definite; the message names a strain with a negative energy.

    Examples
    --------
    A single crystal of silicon (cubic):

    >>> C = np.diag([165.7e9] * 3 + [79.6e9] * 3)
    >>> C[:3, :3] += 63.9e9 * (1.0 - np.eye(3))
    >>> silicon = Anisotropic(C, rho=2329.0, name="silicon")
    """

    stiffness: np.ndarray
    rho: float
    name: str | None = None
    damping: RayleighDamping | None = None
    loss_factor: float = 0.0
    prony: Sequence[tuple[float, float]] = ()

    def __post_init__(self) -> None:
        label = f"material {self.name!r}" if self.name else "material"
        remedy = "a symmetric positive definite 6 x 6 matrix in Pa, in the order 11, 22, 33, 23, 13, 12"
        matrix = check_stiffness(label, self.stiffness, remedy)
        matrix.flags.writeable = False
        object.__setattr__(self, "stiffness", matrix)
        object.__setattr__(self, "rho", check_density(label, self.rho))
        put_losses(self, label)

    def describe(self) -> dict[str, object]:
        """Return the constants (json-able)."""
        own = {"kind": "anisotropic", "stiffness": self.stiffness.tolist(), "rho": self.rho, "name": self.name}
        return {**own, **described_losses(self)}
