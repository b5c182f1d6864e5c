"""Strengths of a layer in its own axes, for failure indices."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe_fem.materials.voigt import check_numbers


@checked
@dataclass(frozen=True, kw_only=True)
class Strengths:
    """Stresses at which a layer fails, in its plane.

    Parameters
    ----------
    Xt, Xc : float
        In tension and compression along axis 1, Pa, both positive.
    Yt, Yc : float
        The same along axis 2.
    S : float
        In shear 12, Pa.
    interaction : float
        Tsai and Wu's coefficient of the product of both normal stresses, ``F12 / sqrt(F11 F22)``, between -1 and 1.

    Raises
    ------
    ModelError
        If a value is out of range.

    Examples
    --------
    >>> carbon = Strengths(Xt=1500e6, Xc=1200e6, Yt=50e6, Yc=200e6, S=70e6)
    """

    Xt: float
    Xc: float
    Yt: float
    Yc: float
    S: float
    interaction: float = -0.5

    def __post_init__(self) -> None:
        names = ("Xt", "Xc", "Yt", "Yc", "S")
        given = [getattr(self, name) for name in names]
        found = check_numbers("strengths", names, given, "positive stresses in Pa, in compression too")
        for name, number in zip(names, found, strict=True):
            object.__setattr__(self, name, number)
        coefficient = numbers(self.interaction)
        if coefficient.shape != () or not -1.0 < coefficient < 1.0:
            raise ModelError(
                f"strengths: interaction = {self.interaction!r} must be between -1 and 1. Remedy: -0.5, if it is not "
                "measured"
            )
        object.__setattr__(self, "interaction", float(coefficient))

    def array(self) -> np.ndarray:
        """Return Xt, Xc, Yt, Yc, S and the interaction, shape (6,)."""
        return np.array(list(asdict(self).values()))


def check_strengths(material: Any, label: str) -> None:
    """Raise a ModelError if the field `strengths` of a new material is something else."""
    if not (material.strengths is None or isinstance(material.strengths, Strengths)):
        raise ModelError(f"{label}: strengths={material.strengths!r}. Remedy: Strengths(Xt=..., Xc=..., ...), in Pa")


def described_strengths(material: Any) -> dict[str, object]:
    """Return the strengths of a material (json-able), if it has them."""
    return {} if material.strengths is None else {"strengths": asdict(material.strengths)}


def strengths_of(material: Any) -> np.ndarray:
    """Return the strengths of a material, shape (6,), Pa; NaN if it has none."""
    own = getattr(getattr(material, "plain", material), "strengths", None)
    return np.full(6, np.nan) if own is None else own.array()
