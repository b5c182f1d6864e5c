"""Isotropic linear elastic materials in SI units, and a warning about probably wrong units."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError, UnitWarning, outside
from kanefe.fe_model.damping import RayleighDamping
from kanefe.fe_model.moduli import isotropic
from kanefe_fem.materials.damping import described_losses, prony_of_loss_factor, put_losses
from kanefe_fem.materials.strengths import Strengths, check_strengths, described_strengths
from kanefe_fem.materials.voigt import one_number


class AccuracyWarning(UserWarning):
    """A discretisation that is known to be inaccurate for this material."""


WAVE_SPEED = (10.0, 20e3)
"""Range of sqrt(E / rho) of solids, m/s: soft rubber 30, diamond 18 000."""

DENSITY = (0.1, 5e4)
"""Range of densities, kg/m3: aerogel 1, osmium 22 600."""

EXTENT = (1e-5, 200.0)
"""Range of the size of one solid body, m."""

MASS = 1e8
"""Largest mass of one solid body, kg."""

LOCKING_NU = 0.45
"""Poisson ratio from which elements of order 1 are much too stiff."""


@checked("name")
@dataclass(frozen=True)
class Material:
    """Isotropic linear elastic material.

    Parameters
    ----------
    E : float
        Young's modulus in Pa, > 0.
    nu : float
        Poisson's ratio, -1 < nu < 0.5.
    rho : float
        Density in kg/m3, > 0.
    name : str, optional
        Used in messages only.
    damping : RayleighDamping, optional
        Viscous damping of its part of a body, proportional to mass and stiffness of that part.
    loss_factor : float
        Structural damping, from 0 to 2: the loss modulus over the storage modulus. For frequency responses and loss
        factors of modes; runs need a Prony series, see `viscoelastic`.
    prony : sequence of (float, float)
        Arms of a generalised Maxwell model: weights, shares of the instantaneous modulus E, and relaxation times in s.
    strengths : Strengths, optional
        For failure indices of shells.

    Raises
    ------
    ModelError
        If a value is out of range or not finite.

    Examples
    --------
    >>> aluminium = Material(E=70e9, nu=0.33, rho=2700.0, name="aluminium")
    >>> round(aluminium.shear_modulus / 1e9, 2)
    26.32
    >>> rubber = Material(E=6e6, nu=0.48, rho=1100.0, prony=[(0.3, 0.01), (0.2, 0.1)])
    """

    E: float
    nu: float
    rho: float
    name: str | None = None
    damping: RayleighDamping | None = None
    loss_factor: float = 0.0
    prony: Sequence[tuple[float, float]] = ()
    strengths: Strengths | None = None

    def __post_init__(self) -> None:
        label = f"material {self.name!r}" if self.name else "material"
        for field in ("E", "nu", "rho"):
            number = one_number(label, field, getattr(self, field))
            if not math.isfinite(number):
                raise ModelError(f"{label}: {field} = {number} is not finite. Remedy: give one number, in SI units")
            object.__setattr__(self, field, number)
        if self.E <= 0.0:
            raise ModelError(f"{label}: E = {self.E:g} Pa must be positive. Remedy: steel has E=210e9")
        if not -1.0 < self.nu < 0.5:
            raise ModelError(
                f"{label}: nu = {self.nu:g} must be above -1 and below 0.5 (the body would be incompressible, or gain "
                "energy when deformed). Remedy: metals have nu=0.3; for rubber take nu=0.49 and order=2"
            )
        if self.rho <= 0.0:
            raise ModelError(f"{label}: rho = {self.rho:g} kg/m3 must be positive. Remedy: steel has rho=7850")
        put_losses(self, label)
        check_strengths(self, label)

    @checked("band")
    def viscoelastic(self, band: Sequence[float]) -> Material:
        """Return the material with a Prony series in place of its loss factor, for runs.

        Parameters
        ----------
        band : (float, float)
            Frequencies in Hz between which it has the loss factor. In their middle E is that of this material.

        Raises
        ------
        ModelError
            If it has no loss factor, or the band is not valid.

        See Also
        --------
        kanefe_fem.prony_of_loss_factor : tells the error of the fit.

        Examples
        --------
        >>> layer = Material(E=2.6e6, nu=0.45, rho=970.0, loss_factor=0.5).viscoelastic((10.0, 1000.0))
        >>> layer.loss_factor, len(layer.prony) > 3
        (0.0, True)
        """
        fit = prony_of_loss_factor(self.loss_factor, band)
        return replace(self, E=self.E * fit.stiffness, loss_factor=0.0, prony=fit.prony)

    @property
    def shear_modulus(self) -> float:
        """Lame's second parameter mu = E / (2 (1 + nu)), in Pa."""
        return self.E / (2.0 * (1.0 + self.nu))

    @property
    def lame(self) -> float:
        """Lame's first parameter lambda = E nu / ((1 + nu) (1 - 2 nu)), in Pa."""
        return self.E * self.nu / ((1.0 + self.nu) * (1.0 - 2.0 * self.nu))

    @property
    def plane_stress_lame(self) -> float:
        """Lame's first parameter of plane stress, E nu / (1 - nu^2), in Pa."""
        return self.E * self.nu / (1.0 - self.nu**2)

    @property
    def stiffness(self) -> np.ndarray:
        """Stresses from strains in the order xx, yy, zz, yz, xz, xy, shape (6, 6), Pa."""
        return isotropic(self.lame, self.shear_modulus)

    def describe(self) -> dict[str, object]:
        """Return the constants (json-able)."""
        own = {"E": self.E, "nu": self.nu, "rho": self.rho, "name": self.name}
        return {**own, **described_losses(self), **described_strengths(self)}


def warn_of_units(label: str, E: float, rho: float, size: float, mass: float) -> None:
    """Warn (UnitWarning) if size, mass, density or stiffness of a body are not those of a solid in SI units.

    Parameters
    ----------
    label : str
        Name of the body or of its group, for the message.
    E : float
        Young's modulus of the stiffest direction in Pa.
    rho : float
        Density in kg/m3.
    size : float
        Diagonal of the bounding box in m.
    mass : float
        Mass in kg.

    Notes
    -----
    The limits are `EXTENT`, `MASS`, `DENSITY` and `WAVE_SPEED`. A mesh in mm gives a body of hundreds of metres and
    millions of tons; E in MPa a wave speed of some m/s; rho in t/mm3 a density of 1e-9. Each warning contains the first
    frequency of the body as a free rod, ``sqrt(E / rho) / (2 size)``.
    """
    odd = []
    if not EXTENT[0] <= size <= EXTENT[1]:
        odd.append(f"it is {size:.3g} m in size (is the mesh in mm? kanefe takes m)")
    odd += odd_mass(mass) + odd_material(E, rho)
    if odd:
        warnings.warn(
            f"{label}: {'; '.join(odd)}. First frequency as a free rod: {math.sqrt(E / rho) / (2.0 * size):.3g} Hz. "
            "Remedy: lengths in m, E in Pa, rho in kg/m3",
            UnitWarning,
            stacklevel=outside(),
        )


def odd_mass(mass: float) -> list[str]:
    """Return a remark on an implausible mass of one body in kg, if it is."""
    return [f"its mass is {mass:.3g} kg (is the mesh in mm, or rho in g/m3?)"] if mass > MASS else []


def odd_material(E: float, rho: float) -> list[str]:
    """Return a remark on an implausible modulus in Pa and density in kg/m3, if they are."""
    c = math.sqrt(E / rho)
    if not DENSITY[0] <= rho <= DENSITY[1]:
        return [f"its density is {rho:.3g} kg/m3 (is rho in t/mm3 or g/m3?)"]
    if not WAVE_SPEED[0] <= c <= WAVE_SPEED[1]:
        return [
            f"its wave speed sqrt(E/rho) is {c:.3g} m/s for E = {E:.3g} Pa and rho = {rho:.3g} kg/m3 "
            "(is E in MPa or GPa, or rho in g/cm3?)"
        ]
    return []
