"""Axes of a material in a body: constant, for each cell, or depending on position (rings, spherical shells)."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe_fem.materials.voigt import rotated

Vector = Sequence[float] | np.ndarray
Axes = np.ndarray | Sequence[Sequence[float]] | Callable[[np.ndarray], np.ndarray]

ORTHONORMAL = 1e-9
"""Largest error of A^T A for given axes, dimensionless."""


@runtime_checkable
class SolidMaterial(Protocol):
    """A material of a solid: 6 x 6 moduli in its own axes, a density and a name."""

    @property
    def stiffness(self) -> np.ndarray:
        """Stresses from strains in the order 11, 22, 33, 23, 13, 12, shape (6, 6), Pa."""

    @property
    def rho(self) -> float:
        """Density in kg/m3."""

    @property
    def name(self) -> str | None:
        """Name in messages."""

    def describe(self) -> dict[str, object]:
        """Return the data of the material (json-able)."""


@dataclass(frozen=True, eq=False)
class Oriented:
    """A material whose axes 1, 2, 3 are not those of the mesh.

    Parameters
    ----------
    material : SolidMaterial
        `Orthotropic`, `Laminate`, ...
    axes : array_like, shape (3, 3) or (m, 3, 3), or callable
        A_GM: the axes 1, 2, 3 as columns, in components of G. One for all cells; one for each of the m cells of the
        group, in the order of the mesh; or a function of the centres of the cells (m, 3) in m that returns (m, 3, 3),
        such as `cylindrical_axes` and `spherical_axes`. Axes are constant on each cell.

    Raises
    ------
    ModelError
        If the axes are not right-handed and orthonormal.

    Examples
    --------
    Fibres at 30 degrees from x in the x-y plane, and fibres that wind around the z axis:

    >>> from kanefe_fem.materials.orthotropic import Orthotropic
    >>> carbon = Orthotropic.transversely_isotropic(E1=140e9, E2=9e9, nu12=0.3, nu23=0.4, G12=5e9, rho=1600.0)
    >>> skin = Oriented(carbon, axes_at_angle(np.radians(30.0)))
    >>> tube = Oriented(carbon, cylindrical_axes(axis=(0, 0, 1), first="around"))
    """

    material: SolidMaterial
    axes: Axes

    def __post_init__(self) -> None:
        if not isinstance(self.material, SolidMaterial):
            raise ModelError(
                f"{self.material!r} is not a material to be oriented. Remedy: Orthotropic(...), Laminate(...)"
            )
        if not callable(self.axes):
            axes = _checked(self._label, self.axes)
            axes.flags.writeable = False
            object.__setattr__(self, "axes", axes)

    @property
    def rho(self) -> float:
        """Density in kg/m3."""
        return self.material.rho

    @property
    def name(self) -> str | None:
        """Name of the material."""
        return self.material.name

    @property
    def stiffness(self) -> np.ndarray:
        """Moduli in the axes of the mesh if the axes are constant, else in the material's, shape (6, 6), Pa."""
        constant = not callable(self.axes) and np.ndim(self.axes) == 2
        return rotated(self.material.stiffness, np.asarray(self.axes)) if constant else self.material.stiffness

    @property
    def plain(self) -> SolidMaterial:
        """The material in its own axes."""
        return self.material.plain if isinstance(self.material, Oriented) else self.material

    def stiffness_at(self, group: str, centres: np.ndarray) -> np.ndarray:
        """Return the moduli in axes of G at the centres (m, 3) of the group's cells, shape (m, 6, 6) or (1, 6, 6).

        Raises
        ------
        ModelError
            As `axes_at`.
        """
        return rotated(self.plain.stiffness, self.axes_at(group, centres))

    def axes_at(self, group: str, centres: np.ndarray) -> np.ndarray:
        """Return the axes of `plain` in G at the centres (m, 3) of the group's cells, shape (m, 3, 3) or (1, 3, 3).

        Raises
        ------
        ModelError
            If the number of axes is wrong, or they are not finite and orthonormal.
        """
        label = f"group {group!r}, {self._label}"
        if callable(self.axes):
            axes = _checked(label, self.axes(np.array(centres)))
            if axes.shape != (len(centres), 3, 3):
                raise ModelError(
                    f"{label}: the function of the axes returns shape {axes.shape} for {len(centres)} points. Remedy: "
                    f"return ({len(centres)}, 3, 3), the axes as columns"
                )
        else:
            axes = np.asarray(self.axes)
            if axes.ndim == 3 and len(axes) != len(centres):
                raise ModelError(
                    f"{label}: {len(axes)} axes are given for {len(centres)} cells. Remedy: one for each cell of the "
                    "group in the order of the mesh, or a function of position"
                )
        axes = axes.reshape(-1, 3, 3)
        inner = self.material
        return axes @ inner.axes_at(group, centres) if isinstance(inner, Oriented) else axes

    def describe(self) -> dict[str, object]:
        """Return the data of the material (json-able); a function of the user is given by its name."""
        return {"kind": "oriented", "material": self.material.describe(), "axes": _described(self.axes)}

    @property
    def _label(self) -> str:
        return f"axes of material {self.name!r}" if self.name else "axes of the material"


@dataclass(frozen=True)
class PositionAxes:
    """Axes about a centre or an axis, made by `cylindrical_axes` and `spherical_axes`.

    Attributes
    ----------
    kind : "cylindrical" or "spherical"
    origin, axis : tuple of float
        A point on the axis in m, and its direction.
    first : str
        Direction of axis 1; the other two follow in right-handed order.
    """

    kind: str
    origin: tuple[float, ...]
    axis: tuple[float, ...]
    first: str

    def __call__(self, positions: np.ndarray) -> np.ndarray:
        """Return the axes at positions (m, 3), shape (m, 3, 3)."""
        r = np.asarray(positions, dtype=float) - self.origin
        pole = np.array(self.axis)
        outward = r - np.outer(r @ pole, pole)
        size = np.linalg.norm(outward, axis=1)
        lost = size <= 1e-9 * max(np.abs(r).max(initial=0.0), np.finfo(float).tiny)
        if lost.any():
            x = np.asarray(positions)[np.argmax(lost)]
            raise ModelError(
                f"{self.kind} axes have no direction outward at ({x[0]:.4g}, {x[1]:.4g}, {x[2]:.4g}) m, which lies on "
                "their axis. Remedy: move the axis, or give the cells on it a group and axes of their own"
            )
        outward /= size[:, None]
        around = np.cross(pole, outward)
        third = np.broadcast_to(pole, r.shape)
        if self.kind == "spherical":
            outward = r / np.linalg.norm(r, axis=1)[:, None]
            third = np.cross(outward, around)
        turn = _NAMES[self.kind].index(self.first)
        triad = [outward, around, third]
        return np.stack(triad[turn:] + triad[:turn], axis=-1)


_NAMES = {"cylindrical": ("outward", "around", "along"), "spherical": ("outward", "around", "north")}


@checked
def cylindrical_axes(
    origin: Vector = (0.0, 0.0, 0.0), axis: Vector = (0.0, 0.0, 1.0), first: str = "outward"
) -> PositionAxes:
    """Return axes (outward, around, along) of a cylinder, for `Oriented`.

    Parameters
    ----------
    origin : array_like, shape (3,)
        A point on the axis in m.
    axis : array_like, shape (3,)
        Its direction, of any length.
    first : {"outward", "around", "along"}
        Direction of the material's axis 1; 2 and 3 are the next ones in this order. For fibres wound around the axis
        use first="around".

    Raises
    ------
    ModelError
        If the axis is zero, or `first` is unknown.
    """
    return _position_axes("cylindrical", origin, axis, first)


@checked
def spherical_axes(
    origin: Vector = (0.0, 0.0, 0.0), pole: Vector = (0.0, 0.0, 1.0), first: str = "outward"
) -> PositionAxes:
    """Return axes (outward, around, north) of a sphere, for `Oriented`.

    Parameters
    ----------
    origin : array_like, shape (3,)
        Centre in m.
    pole : array_like, shape (3,)
        Direction of the polar axis: "around" is tangential to it, and "north" points towards it.
    first : {"outward", "around", "north"}
        Direction of the material's axis 1; 2 and 3 are the next ones in this order.

    Raises
    ------
    ModelError
        If the pole is zero, or `first` is unknown.
    """
    return _position_axes("spherical", origin, pole, first)


@checked
def axes_at_angle(angle: float, axis: Vector = (0.0, 0.0, 1.0), along: Vector = (1.0, 0.0, 0.0)) -> np.ndarray:
    """Return axes with 3 along `axis` and 1 rotated about it by an angle from `along`, shape (3, 3).

    Parameters
    ----------
    angle : float
        In rad.
    axis : array_like, shape (3,)
        Axis 3, such as the normal of a ply.
    along : array_like, shape (3,)
        Direction of axis 1 at the angle 0 (its part across `axis`).

    Raises
    ------
    ModelError
        If `axis` is zero, or `along` is parallel to it.
    """
    normal, reference = _direction("axis", axis), _direction("along", along)
    first = reference - (reference @ normal) * normal
    if np.linalg.norm(first) < 1e-6 or not np.isfinite(numbers(angle)):
        raise ModelError(
            f"axes_at_angle: along={along!r} is parallel to axis={axis!r}, or angle={angle!r} is not finite. Remedy: "
            "give the direction of the fibres at the angle 0, across the axis"
        )
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    c, s = np.cos(float(angle)), np.sin(float(angle))
    return np.column_stack((c * first + s * second, c * second - s * first, normal))


def _position_axes(kind: str, origin: Vector, axis: Vector, first: str) -> PositionAxes:
    if first not in _NAMES[kind]:
        raise ModelError(f"{kind} axes: first={first!r} is unknown. Remedy: one of {', '.join(_NAMES[kind])}")
    point = numbers(origin)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise ModelError(f"{kind} axes: origin={origin!r} is not a point. Remedy: three coordinates in m")
    return PositionAxes(
        kind,
        tuple(point.tolist()),
        tuple(_direction("axis" if kind == "cylindrical" else "pole", axis).tolist()),
        first,
    )


def _direction(name: str, vector: Vector) -> np.ndarray:
    direction = numbers(vector)
    if direction.shape != (3,) or not np.isfinite(direction).all() or not np.linalg.norm(direction) > 0.0:
        raise ModelError(f"{name}={vector!r} is not a direction. Remedy: three components, not all zero")
    return direction / np.linalg.norm(direction)


def _checked(label: str, axes: Any) -> np.ndarray:
    """Return axes as an array (3, 3) or (m, 3, 3)."""
    A = numbers(axes)
    if A.shape[-2:] != (3, 3) or A.ndim not in (2, 3):
        raise ModelError(f"{label} have shape {A.shape}. Remedy: (3, 3), or (m, 3, 3) for the m cells of the group")
    error = np.abs(np.swapaxes(A, -1, -2) @ A - np.eye(3)).max()
    if not error <= ORTHONORMAL or (np.linalg.det(A) < 0.0).any():
        raise ModelError(
            f"{label} are not right-handed and orthonormal (error {error:.2g}). Remedy: unit vectors as columns, "
            "3 = 1 x 2; axes_at_angle makes them"
        )
    return A


def _described(axes: Any) -> object:
    if isinstance(axes, PositionAxes):
        return {"kind": axes.kind, "origin": axes.origin, "axis": axes.axis, "first": axes.first}
    if not callable(axes):
        array = np.ascontiguousarray(axes)
        return array.tolist() if array.ndim == 2 else {"sha256": hashlib.sha256(array.tobytes()).hexdigest()}
    return {"function": getattr(axes, "__qualname__", type(axes).__name__)}
