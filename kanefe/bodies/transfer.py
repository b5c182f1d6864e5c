"""Deformation of a flexible body in the coordinates of another one of the same part: other modes, or a finer mesh."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.frames import Vector
from kanefe.storage.scipy_later import scipy, sp

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody

SAME = 1e-9
"""Distance of two nodes, relative to the size of the body, below which they are at one place."""

REPORTED = 1e-2
"""Relative part of a deformation that is lost from which it is reported."""


def same_places(old: FlexibleBody, new: FlexibleBody, nodes: np.ndarray) -> np.ndarray:
    """Return the node of the new body at the place of each of some nodes of the old one, -1 where there is none."""
    distance, found = scipy.spatial.cKDTree(new.nodes).query(old.nodes[nodes])
    size = float(np.ptp(old.nodes, axis=0).max()) or 1.0
    return np.where(distance <= SAME * size, found, -1)


def transferred(old: FlexibleBody, new: FlexibleBody, eta: Vector | None, name: str) -> Vector | None:
    """Return the coordinates (k,) of the new body that move it as `eta` moves the old one; None stays None.

    Displacements of the nodes that both have are fitted by least squares, with equal weights. Of exact beams the
    polynomials of each strain are the same, more or fewer.

    Parameters
    ----------
    old, new : FlexibleBody
    eta : ndarray, shape (k_old,), or None
        Coordinates, or their rates.
    name : str
        Of the body, for messages.

    Raises
    ------
    ModelError
        If the bodies have no nodes in common that determine the coordinates.

    Warns
    -----
    AccuracyWarning
        If the new body cannot take more than a hundredth of the deformation.
    """
    if eta is None or not np.any(eta):
        return None if eta is None else np.zeros(new.free_count)
    if old.bends_far or new.bends_far:
        return _of_strains(old, new, eta, name)
    every = np.arange(len(old.nodes))
    found = same_places(old, new, every)
    shared = found >= 0
    wanted = old.node_displacements(eta)[shared].ravel()
    rows = [new.components.index(c) for c in ("x", "y", "z") if c in new.components]
    width, k = len(new.components), new.free_count
    at = (found[shared][:, None] * width + np.array(rows)).ravel()
    motion = np.zeros((int(shared.sum()), 3, k))
    if sp.issparse(new.basis) or 3 * int(shared.sum()) < k:
        raise ModelError(
            f"{name!r} has other coordinates than before, and the deformation cannot be transferred to them. Remedy: "
            "start without it, or reduced bodies, the finer of which has the nodes of the other"
        )
    motion[:, ["xyz".index(c) for c in "xyz" if c in new.components]] = new.basis[at, :k].reshape(-1, len(rows), k)
    matrix = motion.reshape(-1, k)
    result = np.linalg.lstsq(matrix, wanted, rcond=1e-12)[0]
    lost = float(np.linalg.norm(wanted - matrix @ result) / max(float(np.linalg.norm(wanted)), 1e-300))
    if lost > REPORTED:
        warnings.warn(
            f"{name!r}: the other body can take the deformation of the first but for {100.0 * lost:.2g} % (root mean "
            "square over its nodes). Remedy: more modes",
            AccuracyWarning,
            stacklevel=outside(),
        )
    return np.asarray(result)


def _of_strains(old: FlexibleBody, new: FlexibleBody, eta: Vector, name: str) -> Vector:
    """Return the coordinates of an exact beam with more or fewer polynomials."""
    ours, theirs = new.line, old.line
    if ours is None or theirs is None or not (ours.last.any() and theirs.last.any()):
        raise ModelError(
            f"{name!r} has other functions of its strains than before. Remedy: start without deformation, or Legendre "
            "polynomials before and after"
        )
    result = np.zeros(new.free_count)
    for strain in np.unique(ours.strain_of):
        to, of = np.flatnonzero(ours.strain_of == strain), np.flatnonzero(theirs.strain_of == strain)
        count = min(len(to), len(of))
        result[to[:count]] = eta[of[:count]]
    return result
