"""Load cases that a reduction is to represent well: inertial loads, interface loads, load patterns, given forces.

A load case is given by a name,

- ``"gravity"``: unit accelerations of the body along x, y, z, in m/s2 (gravity and the acceleration of G alike);
- ``"angular acceleration"``: unit angular accelerations about the axes of G through its origin, rad/s2;
- ``"centrifugal"``: the six products w_a w_b of a steady spin about G's origin, (rad/s)2;
- the name of an interface: unit forces and moments on its components that are not fixed;
- the name of a load pattern: unit tractions along x, y, z, and a unit pressure;

as a `LoadCase`, or as the points of a contact patch, `PatchCase`. A spin about another point is a combination of
"centrifugal" and "gravity". The static shapes of load cases (load-dependent vectors) make a basis statically complete
for them (Wilson, Yuan & Dickens 1982, "Dynamic analysis by direct superposition of Ritz vectors").
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.model import COMPONENTS, PRODUCTS, TRANSLATIONS, FiniteElementModel
from kanefe.fe_model.statics import StaticProblem
from kanefe.frames import numbers
from kanefe.reduction.patch_case import PatchCase

INERTIAL = ("gravity", "angular acceleration", "centrifugal")
"""Names of the inertia loads by the motion of G."""

LOADED = 1e-9
"""Force relative to the largest of a group below which a column has no effect."""


@checked("name")
@dataclass(frozen=True, eq=False)
class LoadCase:
    """Named forces on the nodes of a model.

    Parameters
    ----------
    name : str
    forces : ndarray, shape (N,) or (N, m)
        Forces on the degrees of freedom of the model, N and N m: one load, or m loads of the same unit.

    Raises
    ------
    ModelError
        If the forces are not finite numbers of one of these shapes.

    Examples
    --------
    Two nodes of a planar model, pulled apart:

    >>> LoadCase("pull", np.array([-1.0, 0.0, 1.0, 0.0])).forces.shape
    (4, 1)
    """

    name: str
    forces: np.ndarray

    def __post_init__(self) -> None:
        forces = numbers(self.forces)
        if forces.ndim not in (1, 2) or not forces.size or not np.all(np.isfinite(forces)):
            raise ModelError(
                f"the forces of load case {self.name!r} must be finite numbers of shape (N,) or (N, m), not of shape "
                f"{forces.shape}"
            )
        object.__setattr__(self, "forces", forces.reshape(len(forces), -1))

    def __repr__(self) -> str:
        digest = hashlib.sha256(np.ascontiguousarray(self.forces).tobytes()).hexdigest()[:16]
        return f"LoadCase({self.name!r}, {self.forces.shape}, sha256 {digest})"


Load = str | LoadCase | PatchCase


@dataclass(frozen=True, eq=False)
class LoadGroup:
    """Loads of one name and one unit in tied coordinates.

    Attributes
    ----------
    name : str
    unit : str
        Unit of the load to which the forces belong.
    forces : ndarray, shape (tied, m)
        Zero on the fixed components. Columns without effect are left out.
    kept : tuple of int
        Components of the load that the columns belong to.
    """

    name: str
    unit: str
    forces: np.ndarray
    kept: tuple[int, ...] = ()


def checked_loads(loads: Any) -> tuple[Load, ...]:
    """Return loads as a tuple; refuse anything but a sequence of names and load cases."""
    if isinstance(loads, (str, LoadCase, PatchCase)) or not isinstance(loads, Sequence):
        raise ModelError(f"loads must be a sequence of names and LoadCases, such as ('gravity', 'tip'), not {loads!r}")
    kept = tuple(loads)
    for load in kept:
        if not isinstance(load, (str, LoadCase, PatchCase)):
            raise ModelError(
                f"each of loads is a name, a LoadCase or a PatchCase, not {type(load).__name__}. Remedy: "
                "LoadCase('my load', forces) with forces on the degrees of freedom of the model"
            )
    return kept


def default_loads(problem: StaticProblem) -> tuple[Load, ...]:
    """Return the loads on a body in any scene: those on its interfaces that move, and those of inertia."""
    names = tuple(tie.name for tie in problem.ties.ties if len(tie.fixed) < len(tie.rows))
    return (*names, *INERTIAL)


def spread_loads(problem: StaticProblem) -> tuple[str, ...]:
    """Return the loads of inertia, and the load patterns that deform a body."""
    deforming = [
        name
        for name in problem.model.load_patterns
        if any(_settled(problem, group).kept for group in _pattern_groups(problem, name))
    ]
    return (*INERTIAL, *deforming)


def load_groups(problem: StaticProblem, loads: Sequence[Load]) -> list[LoadGroup]:
    """Return the forces of loads in tied coordinates, one group for each name and unit.

    Raises
    ------
    ModelError
        If a name is unknown, or a load has another size or does not deform the body.
    """
    groups = []
    for load in loads:
        found = [_settled(problem, group) for group in _groups_of(problem, load)]
        found = [group for group in found if group.forces.shape[1]]
        # inertial loads may have no effect: a floating body is in free fall under gravity
        if not found and not (isinstance(load, str) and load in INERTIAL):
            name = load if isinstance(load, str) else load.name
            raise ModelError(
                f"load {name!r} does not deform the body: it acts on nothing but components fixed in G, or has no "
                "forces. Remedy: leave it out"
            )
        groups += found
    return groups


def some_groups(problem: StaticProblem, loads: Sequence[Load]) -> list[LoadGroup]:
    """Return the groups of loads, or of `default_loads` if there are none; refuse loads that do not deform the body."""
    groups = load_groups(problem, loads or default_loads(problem))
    if not groups:
        raise ModelError(
            "none of the loads deforms the body: one that floats falls and turns freely. Remedy: "
            "loads=('centrifugal',), the names of its interfaces, or a LoadCase"
        )
    return groups


def spread_groups(problem: StaticProblem) -> list[LoadGroup]:
    """Return the groups of inertia and of load patterns that deform the body, without those of its interfaces."""
    model = problem.model
    found = [_settled(problem, group) for name in INERTIAL for group in _groups_of(problem, name)]
    for name in model.load_patterns:
        found += [_settled(problem, group) for group in _pattern_groups(problem, name)]
    return [group for group in found if group.forces.shape[1]]


def centrifugal_forces(model: FiniteElementModel) -> np.ndarray:
    """Return the nodal forces of spins with w_a w_b = 1 (see `PRODUCTS`) about the origin of G, shape (N, 6).

    The force on a point is ``-rho w x (w x X) = rho (|w|^2 X - w (w . X))``.
    """
    field = model.mass_field
    if field is not None:
        points, to_nodes = field.points, field.interpolation.T
        momenta = field.mass @ points
        return np.column_stack([to_nodes @ _centrifugal(momenta, a, b).reshape(-1) for a, b in PRODUCTS])
    width = len(model.components)
    columns = np.zeros((model.size, len(PRODUCTS)))
    for column, (a, b) in enumerate(PRODUCTS):
        accelerations = _centrifugal(model.nodes, a, b)
        for c, component in enumerate(model.components):
            if component in TRANSLATIONS:
                columns[c::width, column] = accelerations[:, TRANSLATIONS.index(component)]
    return np.asarray(model.mass @ columns)


def _centrifugal(X: np.ndarray, a: int, b: int) -> np.ndarray:
    field = np.zeros_like(X)
    if a == b:
        field[:] = X
        field[:, a] = 0.0
    else:
        field[:, a], field[:, b] = -X[:, b], -X[:, a]
    return field


def _groups_of(problem: StaticProblem, load: Load) -> list[LoadGroup]:
    model, T = problem.model, problem.ties.transformation.T
    if isinstance(load, LoadCase):
        if len(load.forces) != model.size:
            raise ModelError(
                f"load case {load.name!r} has forces on {len(load.forces)} degrees of freedom, the model has "
                f"{model.size}. Remedy: {len(model.components)} components ({', '.join(model.components)}) a node"
            )
        return [LoadGroup(load.name, "1", T @ load.forces)]
    if isinstance(load, PatchCase):
        return [LoadGroup(load.name, "N", T @ load.forces(model))]
    if load == "gravity":
        return [LoadGroup(load, "m/s2", T @ (model.mass @ model.rigid_modes()[:, :3]))]
    if load == "angular acceleration":
        return [LoadGroup(load, "rad/s2", T @ (model.mass @ model.rigid_modes()[:, 3:]))]
    if load == "centrifugal":
        return [LoadGroup(load, "rad2/s2", T @ centrifugal_forces(model))]
    groups = []
    for tie in problem.ties.ties:
        if tie.name == load:
            unit = np.zeros((problem.size, len(tie.rows)))
            unit[tie.rows, range(len(tie.rows))] = 1.0
            turning = np.array([COMPONENTS[c] not in TRANSLATIONS for c in tie.components], dtype=bool)
            groups.append(LoadGroup(f"{load} force", "N", unit[:, ~turning]))
            groups.append(LoadGroup(f"{load} moment", "N m", unit[:, turning]))
    if load in model.load_patterns:
        groups += _pattern_groups(problem, load)
    if not groups:
        known = [*INERTIAL, *(tie.name for tie in problem.ties.ties), *model.load_patterns]
        raise ModelError(
            f"there is no load called {load!r}. There are: {', '.join(dict.fromkeys(known))}. Remedy: one of them, or "
            "a LoadCase with the forces"
        )
    return groups


def _pattern_groups(problem: StaticProblem, name: str) -> list[LoadGroup]:
    """Return the unit tractions of a load pattern, and its unit pressure if it has a side for one."""
    pattern, T = problem.model.load_patterns[name], problem.ties.transformation.T
    groups = [LoadGroup(f"{name} traction", "Pa" if pattern.kind == "surface" else "N/m", T @ pattern.traction)]
    if pattern.pressure is not None:
        groups.append(LoadGroup(f"{name} pressure", "Pa", T @ pattern.pressure[:, None]))
    return groups


def _settled(problem: StaticProblem, group: LoadGroup) -> LoadGroup:
    """Return the group without forces on fixed components, and without columns that only move a floating body."""
    forces = np.array(group.forces, dtype=float)
    before = np.linalg.norm(forces, axis=0)
    forces[problem.fixed] = 0.0
    left = np.linalg.norm(problem.relieved(forces), axis=0)
    kept = np.flatnonzero(left > LOADED * before.max(initial=0.0))
    return LoadGroup(group.name, group.unit, forces[:, kept], tuple(kept.tolist()))


def load_vectors(problem: StaticProblem, loads: Sequence[Load]) -> tuple[np.ndarray, dict[str, int]]:
    """Return the static shapes of loads, shape (tied, m), and their number by the name of the group.

    For a floating body: under the loads balanced by the inertia of its rigid motion.
    """
    groups = load_groups(problem, loads)
    if not groups:
        return np.zeros((problem.size, 0)), {}
    shapes = problem.checked_solution(np.hstack([group.forces for group in groups]), "load case")
    return shapes, {group.name: group.forces.shape[1] for group in groups}
