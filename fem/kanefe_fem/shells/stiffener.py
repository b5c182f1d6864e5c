"""Stiffener: the user's specification of a beam along lines of a shell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.arguments import checked, told
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe_fem.beams.beam_section import BeamSection
from kanefe_fem.materials.damping import refuse_losses
from kanefe_fem.materials.isotropic import Material

SIDES = {"above": 1.0, "below": -1.0}
"""Words for an offset, and the side of the shell that they mean."""


@checked("orientation")
@dataclass(frozen=True)
class Stiffener:
    """A beam along a group of lines of a shell, fastened to it all along, beside it if it is eccentric.

    Parameters
    ----------
    section : BeamSection
        `Rectangle`, `Box`, `Tube`, `SolidCircle`, `Section` or `StiffnessSection`.
    material : Material, optional
        None: sections by stiffness have none.
    offset : float, "above", "below", or array_like, shape (3,)
        From the mesh to the axis of the beam: a height along the normal of the shell in m, or a vector in m. "above"
        and "below": the section touches the shell's top (its side along the normal) or bottom.
    orientation : array_like, shape (3,), optional
        Direction in G of local z of the section (its part across the axis). Default: the normal of the shell.

    Raises
    ------
    ModelError
        If an argument is not valid.

    Examples
    --------
    >>> from kanefe_fem.beams.sections import Rectangle
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> rib = Stiffener(Rectangle(width=3e-3, height=20e-3), steel, offset="below")
    """

    section: BeamSection
    material: Any = None
    offset: float | str | Sequence[float] = 0.0
    orientation: Sequence[float] | None = None

    def __post_init__(self) -> None:
        keep = object.__setattr__
        if not isinstance(self.section, BeamSection):
            raise ModelError(f"the section of a stiffener is {self.section!r}. Remedy: Rectangle(...), Box(...), ...")
        if self.section.needs_material and not isinstance(self.material, Material):
            raise ModelError(
                f"the material of a stiffener is {self.material!r}. Remedy: Material(E=..., nu=..., rho=...)"
            )
        if self.material is not None:
            refuse_losses(self.material, "a stiffener", "damping= of shell_body")
        if not (isinstance(self.offset, str) and self.offset in SIDES):
            value = numbers(self.offset)
            if value.shape not in ((), (3,)) or not np.isfinite(value).all():
                raise ModelError(
                    f"offset={self.offset!r} of a stiffener. Remedy: a height along the normal in m, 'above', "
                    "'below', or three numbers in m"
                )
            keep(self, "offset", float(value) if value.shape == () else tuple(value.tolist()))
        if self.orientation is not None:
            value = numbers(self.orientation)
            if value.shape != (3,) or not np.isfinite(value).all() or not value.any():
                raise ModelError(f"orientation={self.orientation!r} of a stiffener. Remedy: a direction (3,)")
            keep(self, "orientation", tuple(value.tolist()))
        if not np.isfinite(self.stiffness).all():
            raise ModelError("the section of a stiffener has no shear stiffness. Remedy: give GA_y and GA_z")

    @property
    def stiffness(self) -> np.ndarray:
        """Stiffness of the section to N, V_y, V_z, T, M_y and M_z, shape (6, 6)."""
        return self.section.stiffness_of(self.material, planar=False)

    @property
    def half_height(self) -> tuple[float, float]:
        """How far the section reaches along local z, down and up, m.

        Raises
        ------
        ModelError
            If the shape of the section is not known.
        """
        fibres = self.section.fibres_of(self.material)
        if fibres is None:
            raise ModelError(
                f"offset={self.offset!r} of a stiffener needs the shape of its section, and {self.section!r} has "
                "numbers only. Remedy: offset= a height in m"
            )
        return -float(fibres[:, 1].min()), float(fibres[:, 1].max())


def checked_stiffeners(beams: Any) -> dict[str, Stiffener]:
    """Return stiffeners by groups of lines; a ModelError names what is none."""
    given = {} if beams is None else beams
    if not isinstance(given, Mapping) or not all(isinstance(one, Stiffener) for one in given.values()):
        raise ModelError(f"beams={told(beams)} of a shell. Remedy: {{'rib': Stiffener(section, material)}}")
    return dict(given)
