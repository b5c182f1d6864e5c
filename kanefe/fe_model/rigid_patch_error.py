"""The error in compliance by a small rigid patch: the local compliance that the rigid tie suppresses.

The tie is released in a part of the mesh around the patch, held where the rest of the body begins. There the
compliances of the frame with a rigid and an average tie bracket the true one, and their difference is local, since the
two load distributions differ by one without resultant force or moment (Saint-Venant). A single node or a line of a
solid has no compliance of its own: the displacement under a force diverges as the mesh is refined. Nor can the mesh
resolve the field around a single facet. There all compliance of the next two rows of elements is counted as error.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import scipy.sparse.linalg as spla

from kanefe.errors import outside
from kanefe.fe_model.interface import Interface, as_interface
from kanefe.fe_model.model import COMPONENTS, ROTATIONS, FiniteElementModel, NodeGroup
from kanefe.fe_model.statics import StaticProblem
from kanefe.fe_model.ties import Tie, tie_interfaces

NOTEWORTHY = 0.1
"""Relative error of a compliance of the body from which a warning is issued."""

LARGEST_PATCH = 200
"""Number of nodes of a patch above which it is no longer small and is not checked."""

_AROUND = (300, 8, 1200)
"""Number of nodes in the part of the mesh: at least, per node of the patch, and at most."""

_SHARE = 0.6
"""Largest fraction of the body's nodes in this part: the rest is held."""

_ROWS = 2
"""Number of rows of elements around a single node, line or facet."""


class TieWarning(UserWarning):
    """A rigid tie that makes the body much stiffer than it is."""


def tie_errors(problem: StaticProblem, interfaces: Mapping[str, str | Interface]) -> dict[str, float]:
    """Return the relative error in the body's compliance by each small rigid patch of a solid, and warn of large ones.

    The error is the largest over the unit loads on all free interface components (gravity in three directions if there
    are none): the strain energy that an average tie would add locally, against that of the whole body.

    Parameters
    ----------
    problem : StaticProblem
    interfaces : dict of str to str or Interface
        Those from which the ties of the problem were made.

    Returns
    -------
    dict of str to float
        By the name of the interface. Large patches and whole ends of bars, which cannot be made larger, are left out.

    Warns
    -----
    TieWarning
        If an error is above `NOTEWORTHY`.
    """
    model = problem.model
    specs = {name: as_interface(name, given) for name, given in interfaces.items()}
    if set(ROTATIONS) & set(model.components) or len(model.nodes) < _AROUND[0] or model.generalised:
        return {}
    small = [tie for tie in problem.ties.ties if tie.is_rigid and len(tie.nodes) <= LARGEST_PATCH]
    candidates = [tie for tie in small if _is_sharp(model, tie) or not _is_whole_end(model, tie)]
    if not candidates:
        return {}
    energies, wrenches, cases = _cases(problem)
    errors = {}
    for tie in candidates:
        own = tie.rows - problem.ties.interior_count
        lost = _lost_compliance(model, tie, specs[tie.name])
        added = np.einsum("ic,ij,jc->c", wrenches[own], lost, wrenches[own])
        worst = int(np.argmax(added / energies))
        errors[tie.name] = float(added[worst] / energies[worst])
        if errors[tie.name] > NOTEWORTHY:
            _warn(tie, errors[tie.name], cases[worst], _is_sharp(model, tie))
    return errors


def _cases(problem: StaticProblem) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Return twice the energies (c,), the forces on all frame components (boundary, c) and the names of load cases."""
    start, boundary, released = problem.ties.interior_count, problem.boundary, problem.released
    names = [f"{name} of {tie.name!r}" for tie in problem.ties.ties for name in tie.names]
    if len(released) and not problem.rigid_count:
        S = np.asarray(problem.stiffness[boundary] @ problem.constraint_modes)
        free = released - start
        motion = np.linalg.pinv(S[np.ix_(free, free)], hermitian=True)
        return np.diag(motion).copy(), S[:, free] @ motion, [f"a load along {names[row]}" for row in free]
    if len(released):
        f = np.zeros((problem.size, len(released)))
        f[released, np.arange(len(released))] = 1.0
        cases = [f"a load along {names[row - start]}" for row in released]
    else:
        f = problem.ties.transformation.T @ (problem.model.mass @ problem.model.rigid_modes()[:, :3])
        cases = [f"gravity along {axis}" for axis in COMPONENTS[:3]]
    f = problem.relieved(f)
    u = problem.solve(f)
    energies = np.einsum("ic,ic->c", f, u)
    kept = energies > 0.0  # a planar body has no gravity across its plane
    forces = (problem.stiffness @ u)[boundary]
    return energies[kept], forces[:, kept], [case for case, keep in zip(cases, kept, strict=True) if keep]


def _lost_compliance(model: FiniteElementModel, tie: Tie, spec: Interface) -> np.ndarray:
    """Return the compliance that a rigid tie suppresses at its frame, (components, components), m/N, rad/(N m)."""
    width, is_sharp = len(model.components), _is_sharp(model, tie)
    piece = _rows_around(model, tie.nodes) if is_sharp else _nearest(model, tie.nodes)
    dofs = (piece[:, None] * width + np.arange(width)).ravel()
    groups = [model.groups[name] for name in spec.group_names(tie.name)]
    measure = groups[0].measure if len(groups) == 1 and len(groups[0].nodes) == len(tie.nodes) else None
    local = FiniteElementModel(
        nodes=model.nodes[piece],
        components=model.components,
        stiffness=model.stiffness[dofs][:, dofs].tocsr(),
        mass=model.mass[dofs][:, dofs].tocsr(),
        groups={tie.name: NodeGroup(np.searchsorted(piece, tie.nodes), tie.position, measure)},
    )
    here = replace(spec, kind="rigid", groups=None, position=tuple(tie.position))
    stiff = _compliance(local, tie.name, here)
    if is_sharp:
        return stiff
    return _compliance(local, tie.name, replace(here, kind="average")) - stiff


def _nearest(model: FiniteElementModel, patch: np.ndarray) -> np.ndarray:
    """Return the nodes nearest to a patch, in ascending order."""
    least, each, most = _AROUND
    count = max(min(max(least, each * len(patch)), most, int(_SHARE * len(model.nodes))), len(patch))
    from scipy.spatial import cKDTree  # slow to import, and needed by few bodies

    distance = cKDTree(model.nodes[patch]).query(model.nodes)[0]
    distance[patch] = -1.0
    return np.sort(np.argpartition(distance, count - 1)[:count])


def _rows_around(model: FiniteElementModel, patch: np.ndarray) -> np.ndarray:
    """Return the nodes of a patch and of the elements around it, in ascending order."""
    width, nodes = len(model.components), patch
    for _ in range(_ROWS):
        dofs = (nodes[:, None] * width + np.arange(width)).ravel()
        nodes = np.unique(model.stiffness[dofs].indices // width)
    return nodes


def _is_sharp(model: FiniteElementModel, tie: Tie) -> bool:
    """Return whether the patch is a single node, a line or a single facet of a solid, but not the end of a thin bar."""
    turns = {3, 4, 5} if "z" in model.components else {5}
    if not turns <= set(tie.components):
        return True
    width = len(model.components)
    dofs = (tie.nodes[:, None] * width + np.arange(width)).ravel()
    among = model.stiffness[dofs][:, dofs].tocoo()
    pairs = np.unique((among.row // width) * len(tie.nodes) + among.col // width)
    return len(pairs) == len(tie.nodes) ** 2 and not _is_whole_end(model, tie)


def _is_whole_end(model: FiniteElementModel, tie: Tie) -> bool:
    """Return whether the body around a patch is no wider than the patch, as at the end of a bar."""
    points = model.nodes[tie.nodes]
    dimensions = 2 if "z" in model.components else 1
    along = np.linalg.svd(points - points.mean(axis=0))[2][:dimensions]
    around = model.nodes[_rows_around(model, tie.nodes)]
    return bool((np.ptp(around @ along.T, axis=0) <= 1.1 * np.ptp(points @ along.T, axis=0)).all())


def _compliance(local: FiniteElementModel, name: str, spec: Interface) -> np.ndarray:
    ties = tie_interfaces(local, {name: spec})
    K = ties.project(local.stiffness).tocsc()
    rows = ties.ties[0].rows
    loads = np.zeros((K.shape[0], len(rows)))
    loads[rows, np.arange(len(rows))] = 1.0
    return np.asarray(spla.splu(K, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(loads)[rows])


def _warn(tie: Tie, error: float, case: str, is_sharp: bool) -> None:
    if is_sharp:
        text = (
            f"interface {tie.name!r} is a single node, line or facet of a solid: {error:.0%} of the body's compliance "
            f"under {case} is the local deformation of the elements there, which depends on their size. Remedy: a "
            "patch as large as the true contact, with at least three rows of elements across it"
        )
    else:
        text = (
            f"the rigid tie of interface {tie.name!r} ({len(tie.nodes)} nodes) takes up to {error:.0%} of the body's "
            f"compliance under {case}, against a tie on average. Remedy: Interface(..., kind='average') if what it is "
            "joined to is soft (the true value lies between the two), a larger patch, or keep it if that is stiff"
        )
    warnings.warn(text, TieWarning, stacklevel=outside())
