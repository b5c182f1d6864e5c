"""Interface: the user's specification of how a patch of nodes is tied to a frame with six components of motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.model import COMPONENTS, TRANSLATIONS
from kanefe.fe_model.places import Place, PlaceLike
from kanefe.frames import Orientation, numbers, orientation_parameters, rotation_matrix

RULES = ("rigid", "average", "node")
WEIGHTS = ("area", "mass", "uniform")
WORDS = {"all": COMPONENTS, "position": TRANSLATIONS}
"""Named sets of fixed components; those that the nodes cannot follow are left out."""


@checked("fixed", "kind", "released")
@dataclass(frozen=True)
class Interface:
    """How nodes of a body are tied to a frame, and which components of the frame are fixed in G.

    Parameters
    ----------
    fixed : sequence of str, "all" or "position"
        Components of the frame's motion that are fixed in G, among "x", "y", "z", "rx", "ry", "rz", along the axes of
        the interface. "all": those that the nodes can follow (clamped); "position": translations that they can follow
        (hinged); none: the frame moves freely.
    kind : {"rigid", "average", "node"}
        "rigid" (RBE2): the nodes move as a rigid body with the frame, so that the patch cannot deform. "average"
        (RBE3): the frame moves with the weighted mean of the nodes, fitted by least squares, and the patch deforms
        freely; no stiffness is added. "node": the frame is one node.
    weights : {"area", "mass", "uniform"} or sequence of float, optional
        Weights of the nodes in an average: the area (length, for lines) of the patch's facets, the mass matrix, equal
        weights, or one number for each node in the order of their numbers. Default: by area where the patch has facets
        or lines, else equal weights.
    position : array_like, shape (3,), optional
        Undeformed position of the frame in G, m; it may be off the mesh. Default: the area-weighted centroid of the
        facets, or the mean of the nodes. For kind "node" without a group: the position of the node.
    axes : array_like, shape (3, 3) or (4,), or Rotation of scipy, optional
        Axes of the frame in G when undeformed: a rotation matrix with the axes as columns, or Euler parameters
        (`rotation_about`, `euler_angles`). Default: those of G.
    released : sequence of str
        Components of the *nodes'* motion, along the axes of the interface, that do not follow the frame. With
        ``released=("x", "y")`` the nodes slide freely in the plane across z.
    groups : str or sequence of str, optional
        The groups of nodes that form the patch. Default: the group with the name of the interface.
    at : Near, OnPlane, InBox, InCylinder or function, optional
        Place of the patch, instead of groups: the facets of the body's skin that lie in it, or else its nodes. A
        function takes points, shape (n, 3), in m and returns which of them belong to the patch.

    Raises
    ------
    ModelError
        If an argument is not valid; the message names it.

    Notes
    -----
    A rigid tie makes the patch too stiff, an average one too soft: the true value lies between. An average over nodes
    without rotations follows the mean translation and the mean rotation ``(int r r^T)^-1 int r x u`` about the
    weighted centre, which are also the only motions on which a force or moment on the frame does work.

    Examples
    --------
    A hinge about z, a support that lets a bar contract across its axis, and one that slides on a plane:

    >>> hinge = Interface(fixed=("x", "y", "z", "rx", "ry"))
    >>> support = Interface(fixed="all", kind="average")
    >>> slider = Interface(fixed=("z", "rx", "ry"), released=("x", "y"))

    A patch where the mesh has no group:

    >>> from kanefe.fe_model.places import OnPlane
    >>> root = Interface("all", at=OnPlane((0.0, 0.0, 0.0), normal=(1.0, 0.0, 0.0)))
    """

    fixed: str | Sequence[str] = ()
    _: KW_ONLY
    kind: str = "rigid"
    weights: str | Sequence[float] | None = None
    position: Sequence[float] | None = None
    axes: Orientation | None = None
    released: Sequence[str] = ()
    groups: str | Sequence[str] | None = None
    at: PlaceLike | None = None

    def __post_init__(self) -> None:
        keep = object.__setattr__
        if not (isinstance(self.fixed, str) and self.fixed in WORDS):
            keep(self, "fixed", _components(self.fixed, "fixes"))
        keep(self, "released", _components(self.released, "releases"))
        if len(self.released) == len(COMPONENTS):
            raise ModelError("an interface that releases all components follows nothing. Remedy: leave it out")
        if self.kind not in RULES:
            raise ModelError(f"an interface is of kind {self.kind!r}. Remedy: one of {', '.join(RULES)}")
        if self.position is not None:
            keep(self, "position", _place(self.position))
        if self.axes is not None:
            axes = rotation_matrix(orientation_parameters(self.axes, "axes of an interface"))
            keep(self, "axes", tuple(map(tuple, axes.tolist())))
        if self.groups is not None:
            given = (self.groups,) if isinstance(self.groups, str) else self.groups
            given = tuple(given) if isinstance(given, Sequence) else ()
            if not given or not all(isinstance(name, str) for name in given):
                raise ModelError(f"groups={self.groups!r} of an interface. Remedy: names of groups of the mesh")
            keep(self, "groups", tuple(dict.fromkeys(given)))
        if self.at is not None and self.groups is not None:
            raise ModelError(f"groups={self.groups!r} and at={self.at!r} of an interface. Remedy: one of them")
        if self.at is not None and not isinstance(self.at, Place) and not callable(self.at):
            raise ModelError(
                f"at={self.at!r} of an interface is not a place. Remedy: kf.Near((1, 0, 0), 0.01), kf.OnPlane, "
                "kf.InBox, kf.InCylinder, or a function of points (n, 3)"
            )
        if self.weights is not None:
            if self.kind != "average":
                raise ModelError(
                    f"weights={self.weights!r} are for averages, this interface is of kind {self.kind!r}. "
                    "Remedy: kind='average', or leave them out"
                )
            keep(self, "weights", _weights(self.weights))

    @checked
    def group_names(self, name: str) -> tuple[str, ...]:
        """Return the groups with the nodes of the interface `name`; none if its nodes are found by position."""
        if self.groups is not None:
            return tuple(self.groups)
        if self.at is not None:
            return ()
        return () if self.kind == "node" and self.position is not None else (name,)

    @property
    def rotation(self) -> np.ndarray:
        """From the axes of the interface to those of G, shape (3, 3)."""
        return np.eye(3) if self.axes is None else np.array(self.axes)


def _components(given: str | Sequence[str], does: str) -> tuple[str, ...]:
    if isinstance(given, str) or not all(c in COMPONENTS for c in given):
        raise ModelError(
            f"an interface {does} components among {', '.join(COMPONENTS)}, not {given!r}. Remedy: ('x', 'y')"
        )
    return tuple(dict.fromkeys(given))


def _place(given: object) -> tuple[float, ...]:
    place = numbers(given)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise ModelError(f"the position of an interface must be three finite numbers in m, not {given!r}")
    return tuple(place.tolist())


def _weights(given: str | Sequence[float]) -> str | tuple[float, ...]:
    if isinstance(given, str):
        if given not in WEIGHTS:
            raise ModelError(f"weights={given!r} of an interface. Remedy: one of {', '.join(WEIGHTS)}, or numbers")
        return given
    values = numbers(given)
    if values.ndim != 1 or not np.isfinite(values).all() or values.min(initial=0.0) < 0.0 or not values.any():
        raise ModelError("weights of an interface must be finite numbers >= 0, one for each node, not all zero")
    return tuple(values.tolist())


KINDS: dict[str, Interface] = {
    "clamped": Interface("all"),
    "rigid": Interface(),
    "hinged": Interface("position"),
    "average": Interface(kind="average"),
    "node": Interface(kind="node"),
}
"""Predefined interfaces by name."""


def as_interface(name: str, spec: str | Interface) -> Interface:
    """Return an interface, given as such or by the name of a predefined one; a ModelError names it."""
    if isinstance(spec, Interface):
        return spec
    if not isinstance(spec, str) or spec not in KINDS:
        raise ModelError(
            f"interface {name!r} cannot be {spec!r}. Remedy: one of {', '.join(KINDS)}, or Interface(fixed=(...))"
        )
    return KINDS[spec]
