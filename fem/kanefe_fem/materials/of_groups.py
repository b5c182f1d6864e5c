"""Materials of a solid by groups: checked against the mesh, then assigned to its cells."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.errors import ModelError, outside
from kanefe.fe_model.model import Cells, Elasticity
from kanefe.fe_model.shapes import kind_of_order, shape, stretches
from kanefe_fem.materials import voigt
from kanefe_fem.materials.damping import Losses, losses_of
from kanefe_fem.materials.isotropic import LOCKING_NU, AccuracyWarning, Material, warn_of_units
from kanefe_fem.materials.moduli import AnisotropicModuli, IsotropicModuli, Moduli
from kanefe_fem.materials.oriented import Oriented, SolidMaterial
from kanefe_fem.mesh.checks import extent
from kanefe_fem.mesh.mesh import Mesh

Materials = SolidMaterial | Mapping[str, SolidMaterial]

SLOW_NU = 0.495
"""Poisson ratio from which elements of order 2 are also clearly too stiff on coarse meshes."""


@dataclass(frozen=True, eq=False)
class CellMaterials:
    """Materials of every cell, in the order of the mesh.

    Attributes
    ----------
    moduli : IsotropicModuli or AnisotropicModuli
        For the assembly, times the thickness of a plane body; of viscoelastic materials the instantaneous ones.
    density : ndarray, shape (m,)
        kg/m3, times the thickness (kg/m2) of a plane body.
    elasticity : Elasticity
        For stresses: in Pa, without the thickness; of viscoelastic materials the long-term moduli.
    losses : tuple of Losses
        Damping of each group.
    counts : tuple of int
        Number of cells of each group.
    """

    moduli: Moduli
    density: np.ndarray
    elasticity: Elasticity
    losses: tuple[Losses, ...]
    counts: tuple[int, ...]

    def of_each(self, of_group: Callable[[Losses], float]) -> np.ndarray:
        """Return a number of the damping of each cell, shape (m,)."""
        return np.repeat([float(of_group(own)) for own in self.losses], self.counts)

    @property
    def long_term_moduli(self) -> Moduli:
        """The moduli that do not relax."""
        return self.moduli.times(self.of_each(lambda own: own.long_term))


def materials_by_group(
    mesh: Mesh, materials: Materials, order: int, plane: str | None, densities: Mapping[str, float] | None = None
) -> dict[str, SolidMaterial]:
    """Return a material for every group of cells; warn of those for which elements of this order are inaccurate.

    Raises
    ------
    ModelError
        If a group has no material, there is no such group, something is not a material, or a density is out of range.
    """
    if order not in (1, 2):
        raise ModelError(f"order={order!r} of the displacement is not possible. Remedy: give 1 or 2")
    groups = list(mesh.cells)
    if not isinstance(materials, Mapping):
        if len(groups) > 1 and isinstance(materials, SolidMaterial):
            raise ModelError(
                f"one material is given, but {mesh.source} has the groups {', '.join(map(repr, groups))}. "
                f"Remedy: materials={{{groups[0]!r}: Material(...), ...}}"
            )
        materials = {groups[0]: materials}
    for name, material in materials.items():
        if not isinstance(material, SolidMaterial):
            raise ModelError(f"the material of {name!r} is {material!r}. Remedy: Material(E=..., nu=..., rho=...)")
        refuse_unknown(mesh, name, "a material")
    for name in groups:
        if name not in materials:
            raise ModelError(
                f"{mesh.source}: the group {name!r} has no material. Remedy: add {name!r}: Material(...) to materials"
            )
        if not (isinstance(plane, str) and plane == "stress"):
            _warn_of_locking(name, materials[name], order)
    densities = {} if densities is None else densities
    if not isinstance(densities, Mapping):
        raise ModelError(f"densities must be a dict by groups, in kg/m3, not {densities!r}")
    for name, rho in densities.items():
        refuse_unknown(mesh, name, "a density")
        voigt.check_density(f"density of the group {name!r}", rho)
    return {name: materials[name] for name in groups}


def density_of(name: str, material: SolidMaterial, densities: Mapping[str, float] | None) -> float:
    """Return the density of a group in kg/m3: its own if there is one, else the material's."""
    return float((densities or {}).get(name, material.rho))


def cell_materials(
    mesh: Mesh,
    materials: Mapping[str, SolidMaterial],
    plane: str | None,
    thickness: float,
    densities: Mapping[str, float] | None = None,
) -> CellMaterials:
    """Return moduli and density of every cell of a mesh whose groups have been checked.

    Parameters
    ----------
    mesh : Mesh
    materials : dict of str to SolidMaterial
        Material of every group, in the order of the mesh's groups.
    plane : {"stress", "strain"} or None
    thickness : float
        In m; 1 for a solid.
    densities : dict of str to float, optional
        Densities of groups, instead of those of their materials, kg/m3.
    """
    counts = [sum(len(block.nodes) for block in mesh.cells[name]) for name in materials]
    density = [density_of(name, material, densities) for name, material in materials.items()]
    losses = tuple(losses_of(material) for material in materials.values())
    tables, of_cell, start = [], [], 0
    long_term: list[np.ndarray] = []
    for (name, material), count, own in zip(materials.items(), counts, losses, strict=True):
        C = _moduli_of_group(mesh, name, material)
        tables.append(voigt.in_space(voigt.plane_stress(C)) if plane == "stress" else C)
        long_term.append(own.long_term * tables[-1])
        of_cell.append(start + (np.arange(count) if len(C) == count else np.zeros(count, dtype=np.int64)))
        start += len(C)
    table, numbers = np.concatenate(tables), np.concatenate(of_cell)
    return CellMaterials(
        moduli=_moduli(mesh.dimension, materials, counts, plane, thickness, table, numbers),
        density=thickness * np.repeat(density, counts),
        elasticity=Elasticity(np.concatenate(long_term), numbers),
        losses=losses,
        counts=tuple(counts),
    )


def _moduli(
    dimension: int,
    materials: Mapping[str, SolidMaterial],
    counts: list[int],
    plane: str | None,
    thickness: float,
    table: np.ndarray,
    of_cell: np.ndarray,
) -> Moduli:
    """Return Lame's parameters if all materials are isotropic (a smaller form), else the full matrices."""
    isotropic = [material for material in materials.values() if isinstance(material, Material)]
    if len(isotropic) < len(materials):
        return AnisotropicModuli(thickness * (table if dimension == 3 else voigt.plane_strain(table))[of_cell])
    lame = [m.plane_stress_lame if plane == "stress" else m.lame for m in isotropic]
    shear = [m.shear_modulus for m in isotropic]
    return IsotropicModuli(thickness * np.repeat(lame, counts), thickness * np.repeat(shear, counts))


def _moduli_of_group(mesh: Mesh, name: str, material: SolidMaterial) -> np.ndarray:
    """Return the stiffness in axes of G, shape (cells of the group, 6, 6), or (1, 6, 6) if it is the same in all."""
    if not isinstance(material, Oriented):
        return np.asarray(material.stiffness)[None]
    middles = []
    for block in mesh.cells[name]:
        centre = shape(block.kind).nodes.mean(axis=0)[None]
        middles.append(np.einsum("mnx,n->mx", mesh.nodes[block.nodes], shape(block.kind).values(centre)[0]))
    return material.stiffness_at(name, np.concatenate(middles))


def warn_of_group_units(
    mesh: Mesh, materials: Mapping[str, SolidMaterial], thickness: float, densities: Mapping[str, float] | None = None
) -> None:
    """Warn if a group's material, or the size and mass of the body, are not those of a solid in SI units."""
    size = extent(mesh)
    volumes = {
        name: thickness * sum(_straight_volume(mesh, block) for block in blocks) for name, blocks in mesh.cells.items()
    }
    rho = {name: density_of(name, material, densities) for name, material in materials.items()}
    mass = sum(rho[name] * volume for name, volume in volumes.items())
    for name, material in materials.items():
        stiffest = material.E if isinstance(material, Material) else _youngs_modulus(material)
        warn_of_units(f"group {name!r} of {mesh.source}", stiffest, rho[name], size, mass)


def _straight_volume(mesh: Mesh, block: Cells) -> float:
    """Return the volume of cells between their corners, m3: enough to distinguish metres from millimetres."""
    kind = kind_of_order(block.kind, 1)
    corners = block.nodes[:, : shape(kind).corners]
    return float(sum(weight * size.sum() for weight, _, size in stretches(kind, mesh.nodes[corners], degree=1)))


def _youngs_modulus(material: SolidMaterial) -> float:
    """Return the greatest of the three moduli along the axes, in Pa."""
    return float(1.0 / np.diagonal(np.linalg.inv(material.stiffness))[:3].min())


def _warn_of_locking(name: str, material: SolidMaterial, order: int) -> None:
    nu = material.nu if isinstance(material, Material) else voigt.poisson_ratio(material.stiffness)
    if order == 1 and nu >= LOCKING_NU:
        problem, remedy = "with elements of order 1 is much too stiff (locking)", "Use order=2"
    elif order == 2 and nu >= SLOW_NU:
        problem = (
            "is nearly incompressible: a bar with two elements of order 2 through its thickness bends 5 % too stiff, "
            "against 0.6 % with nu = 0.3"
        )
        remedy = "Refine the mesh until the frequencies settle"
    else:
        return
    kind = "nu" if isinstance(material, Material) else "its average Poisson ratio"
    warnings.warn(f"group {name!r}: {kind} = {nu:.6g} {problem}. {remedy}", AccuracyWarning, stacklevel=outside())


def refuse_unknown(mesh: Mesh, name: Any, what: str) -> None:
    """Raise a ModelError if the mesh has no group of cells of this name; `what` is given for it."""
    if name not in mesh.cells:
        raise ModelError(
            f"{what} is given for {name!r}, but {mesh.source} has no such group of cells. "
            f"Remedy: use the names of its groups, {', '.join(map(repr, mesh.cells))}"
        )
