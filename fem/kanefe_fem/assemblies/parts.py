"""A part of an assembly: its mass, its surface, and its mesh if it is flexible."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np

from kanefe.errors import ModelError, did_you_mean
from kanefe_fem.cad.geometry import REST
from kanefe_fem.cad.shapes import Colour, Solid, by_name, name_of_colour
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.mesh import Mesh

MaterialOrDensity: TypeAlias = Material | float
"""A material, or the density of a rigid part in kg/m3."""


MOST_DENSITY = 1e6
"""Largest density of a part, kg/m3: no matter on earth has a tenth of it."""


@dataclass(frozen=True, eq=False)
class Part:
    """A part of an assembly, in the axes of its file.

    Attributes
    ----------
    name, product, path : str
        Name in the assembly, name that equal parts share, and the assemblies it is in.
    colour : tuple of int, optional
        Red, green and blue, 0 to 255.
    volume : float
        m^3.
    center : ndarray, shape (3,)
        Centre of mass, m.
    moments : ndarray, shape (3, 3)
        Inertia about the centre at density one, m^5.
    material : Material or float, optional
        Or its density, kg/m3; None if none was given.
    vertices, triangles : ndarray, shape (n, 3) and (m, 3)
        Its surface: points in m and the points of each triangle, counterclockwise from outside.
    mesh : Mesh, optional
        Of a flexible part; its groups of facets have the names of the joints that the part may have.
    """

    name: str
    product: str
    path: str
    colour: Colour | None
    volume: float
    center: np.ndarray
    moments: np.ndarray
    material: MaterialOrDensity | None
    vertices: np.ndarray
    triangles: np.ndarray
    mesh: Mesh | None = None

    @property
    def density(self) -> float:
        """kg/m3.

        Raises
        ------
        ModelError
            If the part has no material.
        """
        if self.material is None:
            raise ModelError(
                f"part {self.name!r} has no material, and so no mass. Remedy: read_step(..., "
                f"materials={{{self.name!r}: 7850.0}}), a Material or a density by name of part, product or colour; "
                "'*' is all others"
            )
        return float(self.material) if isinstance(self.material, float | int) else self.material.rho

    @property
    def mass(self) -> float:
        """Kg."""
        return self.density * self.volume

    @property
    def inertia(self) -> np.ndarray:
        """Inertia about the centre of mass, kg m2, shape (3, 3)."""
        return self.density * self.moments

    def __str__(self) -> str:
        """Return the part in one line."""
        what = "flexible, " if self.mesh is not None else ""
        mass = f"{self.mass:.4g} kg" if self.material is not None else f"no material, {1e6 * self.volume:.4g} cm3"
        at = ", ".join(f"{one:.4g}" for one in self.center)
        colour = f", {name_of_colour(self.colour)}" if self.colour else ""
        return f"{self.name}: {what}{mass}, centre at ({at}) m{colour}"


def materials_of(
    solids: Sequence[Solid], given: MaterialOrDensity | Mapping[str, MaterialOrDensity] | None, path: Path
) -> dict[str, MaterialOrDensity | None]:
    """Return the material of each solid by its name, product or colour, or "*" for all others.

    Raises
    ------
    ModelError
        If a name stands for no part, or a density is not positive.
    """
    if given is None:
        return {solid.name: None for solid in solids}
    own = dict(given) if isinstance(given, Mapping) else {REST: given}
    known = {solid.name: solid for solid in solids}
    found: dict[str, MaterialOrDensity | None] = dict.fromkeys(known, own.get(REST))
    # a name is more special than the product, and that than a colour
    rank = {solid.product for solid in solids}
    for name in sorted(own, key=lambda one: 2 if one in known else 1 if one in rank else 0):
        material = own[name]
        if not isinstance(material, Material | float | int) or isinstance(material, bool):
            raise ModelError(
                f"{path.name}: materials[{name!r}] is {material!r}. Remedy: a Material, or a density in kg/m3 for "
                "parts that stay rigid"
            )
        if isinstance(material, float | int) and not 0.0 < material <= MOST_DENSITY:
            raise ModelError(
                f"{path.name}: the density of {name!r} is {material!r}. Remedy: kg/m3, > 0 and at most {MOST_DENSITY:g}"
            )
        those = by_name(known, name)
        if not those and name != REST:
            raise ModelError(
                f"{path.name}: materials= names {name!r}, which is no part, product or colour. "
                f"{did_you_mean(name, known)}Remedy: one of {', '.join(map(repr, [*known, REST]))}"
            )
        found |= dict.fromkeys((solid.name for solid in those), material)
    return found
