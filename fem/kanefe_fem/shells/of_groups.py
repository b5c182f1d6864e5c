"""Thickness, section and axes of the groups of cells of a shell, checked against its mesh."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.fe_model.shapes import shape
from kanefe.frames import numbers
from kanefe_fem.materials.damping import refuse_losses
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.materials.laminate import Laminate
from kanefe_fem.materials.of_groups import refuse_unknown
from kanefe_fem.materials.oriented import Oriented, SolidMaterial
from kanefe_fem.mesh.checks import extent
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.shells.sections import ShellSection, section

Thickness = float | Callable[[np.ndarray], np.ndarray]
"""In m, or a function of points (n, 3) in m that returns it, shape (n,)."""

THINNEST, THICKEST = 1e-9, 0.5
"""Smallest and largest thickness of a shell, relative to the size of its mesh."""

TINY_OFFSET = (1e-9, 1e-2)
"""Offsets between these, as fractions of the thickness, are told: above round-off of decks, they look like metres."""

ALONG = 0.1
"""Sine of the least angle between the normal of a cell and the first axis of its material."""


def shell_groups(
    mesh: Mesh,
    materials: Mapping[str, SolidMaterial],
    thickness: Any,
    offset: Any,
    shear_factor: float | None,
) -> dict[str, ShellGroup]:
    """Return what the groups of cells of a mesh are made of.

    Parameters
    ----------
    mesh : Mesh
    materials : dict of str to SolidMaterial
        Of every group.
    thickness, offset, shear_factor
        As for `kanefe_fem.shell_model`.

    Raises
    ------
    ModelError
        If one is not valid, or is given for a group that the mesh does not have.
    """
    _check_shear_factor(shear_factor)
    for what, given in (("a thickness", thickness), ("an offset", offset)):
        for name in given if isinstance(given, Mapping) else ():
            refuse_unknown(mesh, name, what)
    if thickness is None or isinstance(thickness, Mapping):
        thickness = {**mesh.thickness, **(thickness or {})}
    size = extent(mesh)
    return {
        name: ShellGroup(name, material, thickness, offset, shear_factor, size) for name, material in materials.items()
    }


class ShellGroup:
    """Material, section and thickness of a group of cells."""

    def __init__(
        self, name: str, material: Any, thickness: Any, offset: Any, shear_factor: float | None, size: float
    ) -> None:
        self.name, self.material = name, material
        refuse_losses(material, f"group {name!r} of a shell", "damping= of shell_body, or a solid")
        self.plain = material.plain if isinstance(material, Oriented) else material
        self.size = size
        self.thickness = _thickness_of(name, self.plain, thickness, size)
        self.offset = _offset_of(name, offset)
        self.section: ShellSection = section(self.plain, self.offset, shear_factor)

    @property
    def is_isotropic(self) -> bool:
        """Whether all layers have the same moduli in all directions."""
        return _is_isotropic(self.material)

    @property
    def described(self) -> float | str:
        """The thickness for the record: a number in m, or that it varies."""
        return "a function" if callable(self.thickness) else self.thickness

    def at_nodes(self, x: np.ndarray) -> np.ndarray:
        """Return the thickness at the nodes (m, n, 3) of cells, shape (m, n)."""
        if not callable(self.thickness):
            return np.full(x.shape[:2], self.thickness)
        values = numbers(self.thickness(x.reshape(-1, 3)))
        if values.shape != (x.shape[0] * x.shape[1],) or not np.all(np.isfinite(values) & (values > 0.0)):
            raise ModelError(
                f"the function of the thickness of group {self.name!r} returns no positive finite number for each of "
                f"{x.shape[0] * x.shape[1]} points. Remedy: an array of metres, one for each row"
            )
        if values.max() > THICKEST * self.size:
            raise _no_shell(self.name, float(values.max()), self.size)
        return values.reshape(x.shape[:2])

    def along(self, x: np.ndarray, kind: str) -> np.ndarray:
        """Return the direction of the first axis of the cells (m, n, 3), shape (m, 3)."""
        element = shape(kind)
        centre = element.nodes[: element.corners].mean(axis=0)[None]
        tangents = np.einsum("pna,mni->mai", element.gradients(centre), x)
        if self.is_isotropic:  # any direction does
            return np.ascontiguousarray(tangents[:, 0])
        first = np.broadcast_to((1.0, 0.0, 0.0), (len(x), 3))
        if isinstance(self.material, Oriented):
            axes = self.material.axes_at(self.name, np.einsum("pn,mni->mi", element.values(centre), x))
            first = np.broadcast_to(axes[..., 0], (len(x), 3))
        normal = np.cross(tangents[:, 0], tangents[:, 1])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        inside = np.linalg.norm(np.cross(normal, first), axis=1)
        if inside.min() < ALONG:
            raise ModelError(
                f"axis 1 of the material of group {self.name!r} is across the surface in a cell at "
                f"{x[inside.argmin()].mean(axis=0).round(6).tolist()} m. Remedy: Oriented(...), with axes whose first "
                "is along the surface"
            )
        return np.ascontiguousarray(first)


def _is_isotropic(material: Any) -> bool:
    plies = [ply.material for ply in material.plies] if isinstance(material, Laminate) else [material]
    return all(isinstance(one, Material) for one in plies)


def _thickness_of(name: str, material: Any, given: Any, size: float) -> Any:
    value = given.get(name) if isinstance(given, Mapping) else given
    own = material.thickness if isinstance(material, Laminate) else None
    if value is None:
        if own is None:
            raise ModelError(
                f"group {name!r} has no thickness. Remedy: thickness={{{name!r}: ...}} in m, or one for all"
            )
        return own
    if callable(value):
        return value
    number = numbers(value)
    if number.shape != () or not np.isfinite(number) or number <= 0.0:
        raise ModelError(f"thickness of group {name!r} is {value!r}. Remedy: a positive number of metres")
    if not THINNEST * size <= number <= THICKEST * size:
        raise _no_shell(name, value, size)
    if own is not None and not math.isclose(float(value), own, rel_tol=1e-6):
        raise ModelError(
            f"thickness of group {name!r} is {float(value):g} m, but its plies make {own:g} m. Remedy: leave it out "
            "(of a middle surface: dataclasses.replace(mesh, thickness={}))"
        )
    return float(value)


def _no_shell(name: str, thickness: float, size: float) -> ModelError:
    return ModelError(
        f"thickness of group {name!r} is {thickness!r} m, of a mesh of {size:.3g} m: that is no shell. Remedy: metres, "
        "not millimetres; a thick part is a solid"
    )


def _offset_of(name: str, given: Any) -> float:
    value = given.get(name, 0.0) if isinstance(given, Mapping) else given
    if numbers(value).shape != () or not np.isfinite(numbers(value)) or abs(float(value)) > 10.0:
        raise ModelError(
            f"offset of group {name!r} is {value!r}. Remedy: a fraction of the thickness, such as 0.5 for a mesh of "
            "the bottom of the sheet"
        )
    if TINY_OFFSET[0] < abs(float(value)) < TINY_OFFSET[1]:
        warnings.warn(
            f"offset of group {name!r} is {float(value):g} of its thickness, next to nothing: it is a fraction, "
            "and no length in m. Remedy: 0.5 for a mesh of the bottom of the sheet, or 0",
            AccuracyWarning,
            stacklevel=outside(),
        )
    return float(value)


def _check_shear_factor(factor: Any) -> None:
    value = numbers(factor) if factor is not None else None
    if value is not None and (value.shape != () or not 0.0 < value <= 1.0):
        raise ModelError(
            f"shear_factor={factor!r} of a shell must be a number above 0 and at most 1. Remedy: None, which takes "
            "that of the stack; 5/6 is that of one material"
        )
