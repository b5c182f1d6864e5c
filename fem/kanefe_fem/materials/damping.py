"""Damping of materials: proportional, structural (a loss factor) and viscoelastic (a Prony series).

With the moduli C as they are given,

    viscous     C_d = mass rho + stiffness C              `RayleighDamping`, of the mass and of the stiffness of a group
    structural  C (1 + i eta)                             a loss factor eta, at any frequency: in frequency responses
    Prony       C (1 - sum w_i + sum w_i exp(-t / tau_i)) relaxation after a step of strain: C is instantaneous

(Nashif, Jones & Henderson, Vibration Damping, 1985; Christensen, Theory of Viscoelasticity, 1982). All components of C
relax alike, so that Poisson's ratio is constant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.damping import RayleighDamping
from kanefe.frames import numbers

Series = tuple[tuple[float, float], ...]

LARGEST_LOSS = 2.0
"""Loss factor above which it was probably given in percent: 1.5 is that of the softest damping layers."""

ARMS_PER_DECADE, POINTS_PER_DECADE = 2, 40
"""Arms of a fit to a loss factor, and frequencies at which it is compared, in a decade of frequency."""


@dataclass(frozen=True)
class Losses:
    """The damping of a material.

    Attributes
    ----------
    damping : RayleighDamping or None
    loss_factor : float
    prony : tuple of (float, float)
        Weights, and relaxation times in s.
    """

    damping: RayleighDamping | None = None
    loss_factor: float = 0.0
    prony: Series = ()

    @property
    def are_there(self) -> bool:
        """Whether there are any."""
        return self.damping is not None or self.loss_factor > 0.0 or bool(self.prony)

    @property
    def long_term(self) -> float:
        """Share of the moduli that does not relax, ``1 - sum w_i``."""
        return 1.0 - sum(weight for weight, _ in self.prony)


def losses_of(material: Any) -> Losses:
    """Return the damping of a material; of one with axes of its own, that of the material inside."""
    own = getattr(material, "plain", material)
    return Losses(own.damping, own.loss_factor, own.prony) if hasattr(own, "prony") else Losses()


def put_losses(material: Any, label: str) -> None:
    """Check the fields `damping`, `loss_factor` and `prony` of a new material, and make them plain.

    Raises
    ------
    ModelError
        If one is not valid; the message names it and the remedy.
    """
    damping, loss_factor = material.damping, numbers(material.loss_factor)
    if not (damping is None or isinstance(damping, RayleighDamping)):
        raise ModelError(
            f"{label}: damping={damping!r}. Remedy: RayleighDamping(mass=..., stiffness=...), in 1/s and s"
        )
    if loss_factor.shape != () or not 0.0 <= loss_factor <= LARGEST_LOSS:
        raise ModelError(
            f"{label}: loss_factor={material.loss_factor!r} must be a number from 0 to {LARGEST_LOSS:g}. Remedy: 0.02 "
            "for 2 %; it is the loss modulus over the storage modulus, twice the damping ratio"
        )
    found = checked_series(label, material.prony)
    if loss_factor > 0.0 and found:
        raise ModelError(
            f"{label} has a loss factor and a Prony series, which has losses of its own. Remedy: one of them; "
            "prony_of_loss_factor fits a series to a loss factor"
        )
    object.__setattr__(material, "loss_factor", float(loss_factor))
    object.__setattr__(material, "prony", found)


def refuse_losses(material: Any, what: str, remedy: str) -> None:
    """Raise a ModelError for a damped material of something that does not take its damping."""
    if losses_of(material).are_there:
        raise ModelError(f"{what} has a damped material, and takes moduli and density of it alone. Remedy: {remedy}")


def described_losses(material: Any) -> dict[str, object]:
    """Return the damping of a material (json-able), without what it has not."""
    own = losses_of(material)
    found: dict[str, object] = {}
    if own.damping is not None:
        found["damping"] = {"mass": own.damping.mass, "stiffness": own.damping.stiffness}
    if own.loss_factor:
        found["loss_factor"] = own.loss_factor
    if own.prony:
        found["prony"] = [list(arm) for arm in own.prony]
    return found


def checked_series(label: str, given: Any) -> Series:
    """Return a Prony series as pairs of numbers; raise a ModelError if it is not valid."""
    remedy = "Remedy: prony=[(weight, relaxation time in s), ...], weights above 0 of the instantaneous modulus"
    table = numbers(list(given) if isinstance(given, (tuple, list)) else given)
    if table.size == 0 and isinstance(given, (tuple, list)):
        return ()
    if table.ndim != 2 or table.shape[1] != 2 or not np.isfinite(table).all():
        raise ModelError(f"{label}: prony={given!r} is not a list of pairs of finite numbers. {remedy}")
    weights, times = table.T
    if weights.min() <= 0.0:
        raise ModelError(
            f"{label}: the weight {weights.min():g} of prony is not above 0: an arm without stiffness, or one that "
            f"gives energy. {remedy}"
        )
    if times.min() <= 0.0:
        raise ModelError(f"{label}: the relaxation time {times.min():g} s of prony is not above 0. {remedy}")
    if weights.sum() >= 1.0:
        raise ModelError(
            f"{label}: the weights of prony add up to {weights.sum():g}, which leaves no stiffness at rest; they are "
            "shares of the instantaneous modulus E. Remedy: a sum below 1; shares e of the long-term modulus are "
            "e / (1 + sum e), with E times 1 + sum e"
        )
    if len(np.unique(times)) < len(times):
        raise ModelError(f"{label}: prony has a relaxation time twice. Remedy: one arm with the sum of their weights")
    return tuple((float(weight), float(time)) for weight, time in table)


@dataclass(frozen=True)
class PronyFit:
    """A Prony series in place of a loss factor, for runs.

    Attributes
    ----------
    prony : tuple of (float, float)
        Weights of the instantaneous modulus, and relaxation times in s.
    stiffness : float
        Instantaneous modulus over the one at the middle of the band, which is that of the material.
    loss_error : float
        Largest deviation of the loss factor in the band, relative to it.
    stiffness_error : float
        Largest deviation of the storage modulus in the band, relative to that of the material. It is none of the fit: a
        modulus that is damped alike at all frequencies grows with them.
    """

    prony: Series
    stiffness: float
    loss_error: float
    stiffness_error: float


@checked("band")
def prony_of_loss_factor(loss_factor: float, band: Sequence[float]) -> PronyFit:
    """Return the Prony series that has a loss factor within a band of frequencies.

    Parameters
    ----------
    loss_factor : float
        Above 0, and 2 at most.
    band : (float, float)
        First and last frequency in Hz.

    Raises
    ------
    ModelError
        If an argument is not valid.

    Notes
    -----
    With relaxation times at equal ratios, ``E'' - eta E'`` is linear in the weights of the arms: they are its
    non-negative least squares (Lawson & Hanson 1974).

    Examples
    --------
    >>> fit = prony_of_loss_factor(0.1, (10.0, 1000.0))
    >>> fit.loss_error < 0.02, fit.stiffness_error < 0.2
    (True, True)
    """
    from scipy.optimize import nnls  # only here: it takes long to import

    eta, limits = numbers(loss_factor), numbers(list(band))
    if eta.shape != () or not 0.0 < eta <= LARGEST_LOSS:
        raise ModelError(
            f"a loss factor to be fitted must be above 0 and {LARGEST_LOSS:g} at most, not {loss_factor!r}"
        )
    if limits.shape != (2,) or not np.isfinite(limits).all() or not 0.0 < limits[0] < limits[1]:
        raise ModelError(f"band={band!r} of a fit. Remedy: a lower and a higher frequency in Hz, above 0")
    first, last = 2.0 * np.pi * limits
    decades = np.log10(last / first)
    times = np.geomspace(3.0 / first, 1.0 / (3.0 * last), max(3, int(np.ceil(ARMS_PER_DECADE * (decades + 1.0)))))
    w = np.geomspace(first, last, max(20, int(POINTS_PER_DECADE * decades)))
    x = w[:, None] * times
    storage, loss = x**2 / (1.0 + x**2), x / (1.0 + x**2)
    found, _ = nnls(loss - eta * storage, np.full(len(w), float(eta)))
    E = 1.0 + storage @ found
    middle = float(np.interp(0.5 * np.log(first * last), np.log(w), E))
    kept, whole = found > 0.0, 1.0 + found.sum()
    return PronyFit(
        tuple((float(e / whole), float(tau)) for e, tau in zip(found[kept], times[kept], strict=True)),
        float(whole / middle),
        float(np.abs(loss @ found / E / eta - 1.0).max()),
        float(np.abs(E / middle - 1.0).max()),
    )
