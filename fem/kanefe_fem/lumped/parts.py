"""Lumped masses, inertias and springs on the nodes and groups of a finite-element model.

A part on a group follows its mean motion, the weighted least-squares fit of a rigid motion to the nodes (RBE3),

    (d, theta) = T q,   T = (R^T W R)^+ R^T W,   R the rigid motions of the nodes about the point,

so the group is not stiffened. A group that is a rigid interface of the body moves rigidly anyway, and its mean motion
is the motion of the frame (RBE2). The mass enters M and, as points that move with the group, the mass field: the
inertia of the moving body is as exact as that of the mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import scipy.sparse as sp

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.model import FiniteElementModel, MassField, fields_together, rigid_motion
from kanefe.fe_model.source import changed_model
from kanefe.frames import numbers
from kanefe_fem.lumped.mean_motion import Target, mean_motion, patch, place
from kanefe_fem.materials.voigt import check_numbers

Vector: TypeAlias = Sequence[float] | np.ndarray

FOLLOWS = 1e-8
"""Largest part of a motion that the nodes may be unable to follow, relative to the motion."""


@checked("at")
@dataclass(frozen=True)
class LumpedMass:
    """A small rigid body that moves with a node or a group.

    Parameters
    ----------
    at : str or int
        Name of a group, or number of a node of the model.
    mass : float
        In kg. Default: none, for example of a flywheel whose mass is in the mesh; `inertia` is required then.
    inertia : array_like, shape (3,) or (3, 3), optional
        Inertia about its centre of mass, in axes of G, kg m2: three moments about axes parallel to those of G, or the
        matrix. ``(0, 0, I)`` is enough for planar models. Default: a point mass.
    position : array_like, shape (3,), optional
        Its centre of mass in G in m. Default: the position of the node or the group.

    Raises
    ------
    ModelError
        If a number is out of range, or no body can have this inertia.

    Examples
    --------
    >>> motor = LumpedMass("flange", mass=1.2, inertia=(2e-3, 2e-3, 1e-3), position=(0.5, 0.0, 0.06))
    """

    at: Target
    mass: float = 0.0
    inertia: Any = None
    position: Any = None

    def __post_init__(self) -> None:
        label = self.label
        if numbers(self.mass).shape == () and numbers(self.mass) == 0.0:  # any other value is checked below
            object.__setattr__(self, "mass", 0.0)
        else:
            object.__setattr__(self, "mass", check_numbers(label, ("mass",), (self.mass,), "give it in kg")[0])
        object.__setattr__(self, "position", _point(label, self.position))
        if self.inertia is None:
            if self.mass == 0.0:
                raise ModelError(f"{label} has neither mass nor inertia. Remedy: mass in kg, or inertia in kg m2")
            return
        J = numbers(self.inertia)
        J = np.diag(J) if J.shape == (3,) else J
        if J.shape != (3, 3) or not np.isfinite(J).all() or np.abs(J - J.T).max() > 1e-9 * np.abs(J).max():
            raise ModelError(
                f"{label}: inertia={self.inertia!r}. Remedy: three moments, or a symmetric matrix, in kg m2"
            )
        if not np.trace(J) > 0.0:
            raise ModelError(f"{label}: inertia={self.inertia!r} is zero. Remedy: leave it out, or give it in kg m2")
        object.__setattr__(self, "inertia", tuple(map(tuple, J.tolist())))
        if not self.is_planar:
            self._check_possible()

    @property
    def label(self) -> str:
        """Name in messages."""
        return f"lumped mass on {self.at!r}"

    @property
    def is_planar(self) -> bool:
        """Whether it has inertia about z only, which no body in space has."""
        return self.inertia is not None and not np.delete(np.ravel(self.inertia), 8).any()

    def cloud(self, size: float, planar: bool) -> tuple[np.ndarray, np.ndarray]:
        """Return positions about the centre of mass, (P, 3) in m, and masses, (P,) in kg, of points with its inertia.

        If the total mass is zero, a point in the middle has the negative mass of the others.

        Parameters
        ----------
        size : float
            Size of the model, m, from which the distance of the points follows if the total mass is zero.
        planar : bool
            Whether the model moves in the x-y plane only.

        Raises
        ------
        ModelError
            If it has inertia about z only, and the model is not planar.
        """
        if self.inertia is None:
            return np.zeros((1, 3)), np.array([self.mass])
        J = np.array(self.inertia)
        if self.is_planar and planar:
            second = 0.5 * np.diag((J[2, 2], J[2, 2], 0.0))
        else:
            self._check_possible()
            second = _second_moments(J)
        values, vectors = np.linalg.eigh(second)
        of_points = self.mass or np.trace(second) / size**2
        arms = (np.sqrt(3.0 * np.maximum(values, 0.0) / of_points) * vectors).T
        points, masses = np.concatenate([arms, -arms]), np.full(6, of_points / 6.0)
        if self.mass > 0.0:
            return points, masses
        return np.concatenate([points, np.zeros((1, 3))]), np.append(masses, -of_points)

    def _check_possible(self) -> None:
        J = np.array(self.inertia)
        if np.linalg.eigvalsh(_second_moments(J))[0] < -1e-9 * np.trace(J):
            raise ModelError(
                f"{self.label}: no body has the inertia {np.round(np.linalg.eigvalsh(J), 9).tolist()} kg m2 (each "
                "principal moment is at most the sum of the other two). Remedy: give it about the centre of mass; (0, "
                "0, I) is for planar models"
            )


@checked("at", "to")
@dataclass(frozen=True)
class LumpedSpring:
    """A massless spring, damper or bushing from a node or a group to G, or to another node or group.

    Parameters
    ----------
    at : str or int
        Name of a group, or number of a node of the model.
    stiffness : array_like, shape (3,), (6,), (3, 3) or (6, 6)
        Stiffness against translations (N/m) and rotations (N m/rad) in axes of G: values along the axes, or a symmetric
        positive semidefinite matrix. With three rows, there is none against rotations.
    to : str or int, optional
        The other end. Default: G, the frame in which the body is meshed; it moves with the body's fixed interfaces.
    position : array_like, shape (3,), optional
        The point where the motions of both ends are compared, in m, so that a rigid motion of the body does not deform
        a spring between two groups. Default: the position of the node or group, or the middle of the two.
    damping : array_like, optional
        Damping against the rates of the same motions, in N s/m and N m s/rad, of the shapes of the stiffness; with it
        the stiffness may be zero. A `damping` of the body replaces it.

    Raises
    ------
    ModelError
        If stiffness or damping is not positive semidefinite, or both are zero.

    Examples
    --------
    >>> mount = LumpedSpring("foot", stiffness=(2e6, 2e6, 5e6))
    >>> strut = LumpedSpring("left", stiffness=(0.0, 1e7, 0.0), to="right")
    >>> damper = LumpedSpring("left", stiffness=(0.0, 0.0, 0.0), to="right", damping=(0.0, 300.0, 0.0))
    """

    at: Target
    stiffness: Any
    to: Target | None = None
    position: Any = None
    damping: Any = None

    def __post_init__(self) -> None:
        label = self.label
        object.__setattr__(self, "stiffness", _six_by_six(label, "stiffness", self.stiffness, "N/m and N m/rad"))
        if self.damping is not None:
            object.__setattr__(self, "damping", _six_by_six(label, "damping", self.damping, "N s/m and N m s/rad"))
        if not np.any(self.stiffness) and not np.any(self.damping or 0.0):
            raise ModelError(f"{label}: the stiffness is zero or negative in a direction. Remedy: positive numbers")
        object.__setattr__(self, "position", _point(label, self.position))
        if self.to is not None and self.to == self.at:
            raise ModelError(f"{label}: both ends are the same. Remedy: leave `to` out for a spring to G")

    @property
    def label(self) -> str:
        """Name in messages."""
        return f"lumped spring on {self.at!r}" if self.to is None else f"lumped spring {self.at!r} to {self.to!r}"


def _six_by_six(label: str, what: str, given: Any, unit: str) -> tuple[tuple[float, ...], ...]:
    """Return the stiffness or damping of a spring as rows of a matrix (6, 6)."""
    S = numbers(given)
    S = np.diag(S) if S.shape in ((3,), (6,)) else S
    if S.shape not in ((3, 3), (6, 6)) or not np.isfinite(S).all() or np.abs(S - S.T).max() > 1e-9 * np.abs(S).max():
        raise ModelError(f"{label}: {what}={given!r}. Remedy: three or six numbers, or a symmetric matrix, in {unit}")
    # translations and rotations have different units: each row is scaled before the eigenvalues are compared
    scale = np.sqrt(np.abs(np.diagonal(S)))
    scale[scale == 0.0] = 1.0
    if np.linalg.eigvalsh(S / np.outer(scale, scale))[0] < -1e-9:
        raise ModelError(f"{label}: the {what} is zero or negative in a direction. Remedy: positive numbers")
    full = np.zeros((6, 6))
    full[: len(S), : len(S)] = 0.5 * (S + S.T)
    return tuple(map(tuple, full.tolist()))


Lumped: TypeAlias = LumpedMass | LumpedSpring


class _Cloud(NamedTuple):
    """Points of a lumped mass: positions, masses, displacement and rotation by the dofs, and arms from its nodes."""

    points: np.ndarray
    shares: np.ndarray
    motion: sp.csr_matrix
    turns: sp.csr_matrix
    arms: np.ndarray


@checked("model")
def attach(model: FiniteElementModel, lumped: Sequence[Lumped]) -> FiniteElementModel:
    """Return the model with lumped masses and springs on its nodes and groups.

    Parameters
    ----------
    model : FiniteElementModel
        Of a solid, of beams, or from matrices.
    lumped : sequence of LumpedMass or LumpedSpring

    Returns
    -------
    FiniteElementModel
        With the masses in M and in the mass field, the springs in K, and their damping in C.

    Raises
    ------
    ModelError
        If a group or node is unknown or cannot follow the motion, such as a mass at a distance from a single node of a
        solid, which has no rotation, or an inertia on nodes that lie on a line.

    Notes
    -----
    The forces in springs do not contribute to the geometric stiffness of `Preload` and of stiffening by motion.

    Examples
    --------
    >>> from kanefe_fem.beams.body import straight_beam
    >>> from kanefe_fem.materials.isotropic import Material
    >>> from kanefe_fem.beams.sections import Rectangle
    >>> beam = straight_beam(1.0, Rectangle(0.05, 0.1), Material(E=210e9, nu=0.3, rho=7850.0))
    >>> heavy = attach(beam, [LumpedMass("tip", mass=3.0)])
    """
    given: Any = lumped
    if (
        isinstance(given, str)
        or not isinstance(given, Sequence)
        or not all(isinstance(item, (LumpedMass, LumpedSpring)) for item in lumped)
    ):
        raise ModelError(f"lumped={lumped!r}. Remedy: a list of LumpedMass(...) and LumpedSpring(...)")
    parts = tuple(lumped)
    return changed_model(model, lambda whole: _with_lumped(whole, parts), by_number=held_by_number(parts))


def _with_lumped(model: FiniteElementModel, lumped: Sequence[Lumped]) -> FiniteElementModel:
    stiffness, mass, damping = model.stiffness, model.mass, model.damping
    clouds: list[_Cloud] = []
    for item in lumped:
        if isinstance(item, LumpedSpring):
            T = _spring_motion(model, item)
            stiffness = stiffness + T.T @ sp.csr_matrix(np.array(item.stiffness)) @ T
            if item.damping is not None:
                of_item = T.T @ sp.csr_matrix(np.array(item.damping)) @ T
                damping = of_item if damping is None else damping + of_item
            continue
        cloud = _cloud_of(model, item)
        mass = mass + cloud.motion.T @ sp.diags(np.repeat(cloud.shares, 3)) @ cloud.motion
        clouds.append(cloud)
    return replace(
        model,
        stiffness=sp.csr_matrix(stiffness),
        mass=sp.csr_matrix(mass),
        damping=None if damping is None else sp.csr_matrix(damping),
        mass_field=_extended(model.mass_field, clouds),
        provenance={**model.provenance, "lumped": [_described(item) for item in lumped]},
    )


def held_by_number(lumped: Sequence[Lumped]) -> str:
    """Return what of lumped parts belongs to the numbers of nodes of one mesh, as a reason; empty if nothing."""
    ends = [
        end for item in lumped for end in (item.at, getattr(item, "to", None)) if isinstance(end, (int, np.integer))
    ]
    return f"a lumped part is at node {ends[0]} by its number; a group with this node would be kept" if ends else ""


def groups_of(lumped: Sequence[Lumped]) -> list[str]:
    """Return the names of the groups to which lumped parts are attached."""
    ends = [end for item in lumped for end in (getattr(item, "at", None), getattr(item, "to", None))]
    return [end for end in ends if isinstance(end, str)]


def _cloud_of(model: FiniteElementModel, item: LumpedMass) -> _Cloud:
    """Return the points of a mass, with their displacements and rotations from the degrees of freedom."""
    centre = place(model, item.at) if item.position is None else np.array(item.position)
    arm = max(float(np.ptp(model.nodes, axis=0).max()), 1e-300)
    around, shares = item.cloud(arm, planar="z" not in model.components)
    points = centre + around
    T, blind = mean_motion(model, item.at, centre)
    levers = rigid_motion(points, centre)
    if blind.size and np.abs(levers @ blind).max() > FOLLOWS * arm:
        raise ModelError(
            f"{item.label}: its nodes cannot turn it, since they "
            f"{'are one node without rotations' if len(patch(model, item.at)[0]) == 1 else 'lie on a line'}. Remedy: "
            "leave out the inertia and the position, or attach it to a group of facets"
        )
    turns = sp.vstack([T[3:]] * len(points), format="csr")
    nodes, weights = patch(model, item.at)
    turned_about = weights @ model.nodes[nodes] / weights.sum()  # valid to second order: the mean arm is zero
    return _Cloud(points, shares, sp.csr_matrix(sp.csr_matrix(levers) @ T), turns, points - turned_about)


def _spring_motion(model: FiniteElementModel, spring: LumpedSpring) -> sp.csr_matrix:
    """Return the motion of one end relative to the other at the spring's point, shape (6, N)."""
    ends = [spring.at] if spring.to is None else [spring.at, spring.to]
    centre = np.mean([place(model, end) for end in ends], axis=0)
    centre = centre if spring.position is None else np.array(spring.position)
    given = [np.array(matrix) for matrix in (spring.stiffness, spring.damping) if matrix is not None]
    S = np.sum([matrix / (np.abs(matrix).max() or 1.0) for matrix in given], axis=0)
    motions = []
    for end in ends:
        T, blind = mean_motion(model, end, centre)
        if blind.size and np.abs(S @ blind).max() > FOLLOWS * np.abs(S).max() * np.abs(blind).max():
            raise ModelError(
                f"{spring.label}: the nodes of {end!r} cannot follow a rotation that the spring resists. Remedy: put "
                "`position` at the node, leave out the stiffness against rotation, or take a group of facets"
            )
        motions.append(T)
    return motions[0] if spring.to is None else sp.csr_matrix(motions[0] - motions[1])


def _extended(field: MassField | None, clouds: list[_Cloud]) -> MassField | None:
    """Return the mass field with the points of lumped masses after its own; they rotate with their nodes."""
    if field is None or not clouds:
        return field
    return fields_together([field, *(MassField(one.points, sp.diags(one.shares), *one[2:]) for one in clouds)])


def _described(item: Lumped) -> dict[str, Any]:
    kind = "mass" if isinstance(item, LumpedMass) else "spring"
    own = {name: getattr(item, name) for name in item.__dataclass_fields__}
    return {"kind": kind, **{name: value for name, value in own.items() if name != "damping" or value is not None}}


def _second_moments(inertia: np.ndarray) -> np.ndarray:
    """Return int r r^T dm from the inertia int (r^2 I - r r^T) dm, about the same point."""
    return 0.5 * np.trace(inertia) * np.eye(3) - inertia


def _point(label: str, position: Any) -> tuple[float, ...] | None:
    if position is None:
        return None
    point = numbers(position)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise ModelError(f"{label}: position={position!r} is not a point. Remedy: three coordinates in m")
    return tuple(point.tolist())
