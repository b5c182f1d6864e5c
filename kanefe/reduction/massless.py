"""What a body without mass in some motions cannot do: told by interface and component, and by axis.

Lumped matrices leave rotations without mass. They follow the rest statically (`kanefe.reduction.orthonormal`), which is
exact as long as nothing loads them. A load on an interface that would deform the body along such a motion alone, as a
torque twists a bar of lumped masses without inertia about its axis, finds it rigid there.
"""

from __future__ import annotations

import warnings

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from kanefe.errors import AccuracyWarning, outside
from kanefe.fe_model.statics import NO_MASS, StaticProblem
from kanefe.frames import Vector
from kanefe.reduction.orthonormal import stiff_and_free

NOTEWORTHY = 0.01
"""Part of the compliance of an interface component, relative to all of it, from which a warning is issued."""

SINGULAR = 1e-13
"""Smallest eigenvalue of a mass matrix with a unit diagonal, up to which some motion counts as massless."""


def has_massless(M: sp.csr_matrix, largest: Vector) -> bool:
    """Return whether some motion has no mass, for small matrices and the largest mass of each coordinate."""
    masses = M.diagonal()
    if np.any(masses <= NO_MASS * largest):
        return True
    scale = 1.0 / np.sqrt(masses)
    return bool(scipy.linalg.eigvalsh(M.toarray() * np.outer(scale, scale))[0] < SINGULAR)


def tell_massless(problem: StaticProblem, massless: np.ndarray, *, statics: bool) -> dict[str, float]:
    """Return and tell the part of the static compliance that is lost with motions without mass.

    Parameters
    ----------
    problem : StaticProblem
    massless : ndarray, shape (tied, m)
        Motions with stiffness and without mass that are not among the modes.
    statics : bool
        Whether the static shapes of the interfaces may have others, since the columns of the modes are not all motions.

    Returns
    -------
    dict of str to float
        By "interface component", of the released components that lose some.

    Warns
    -----
    AccuracyWarning
        If a component loses `NOTEWORTHY` or more, or the body has no inertia in a rigid motion.
    """
    _tell_rigid(problem)
    rows = problem.released
    if not len(rows):
        return {}
    if statics:
        massless = np.hstack((massless, _static_shapes_without_mass(problem)))
        massless = stiff_and_free(massless, problem.stiffness, problem.largest_masses)[1]
    if not massless.shape[1]:
        return {}
    forces = np.zeros((problem.size, len(rows)))
    forces[rows, np.arange(len(rows))] = 1.0
    whole = np.einsum("ii->i", problem.solve(forces)[rows])
    own = massless[rows]
    lost = np.einsum("ij,ji->i", own, np.linalg.solve(massless.T @ (problem.stiffness @ massless), own.T))
    names = {
        row: f"{tie.name} {name}" for tie in problem.ties.ties for row, name in zip(tie.rows, tie.names, strict=True)
    }
    shares = np.minimum(lost / np.maximum(whole, lost + 1e-300), 1.0)
    found = {names[row]: float(share) for row, share in zip(rows, shares, strict=True) if share > 1e-6}
    large = {name: share for name, share in found.items() if share >= NOTEWORTHY}
    if large:
        listed = ", ".join(f"{name} ({100 * share:.3g} %)" for name, share in large.items())
        warnings.warn(
            "the mass matrix gives no inertia to some motions: they follow the others statically, and a load on an "
            f"interface does not deform the body along them. What that takes of its compliance: {listed}. Remedy: "
            "rotary inertia in the matrices, if loads act there; what is below 100 % is kept by "
            "reduction=CraigBampton(modes=...)",
            AccuracyWarning,
            stacklevel=outside(),
        )
    return found


def _static_shapes_without_mass(problem: StaticProblem) -> np.ndarray:
    """Return static shapes of motions of the released interface components that have no mass."""
    shapes = problem.constraint_modes[:, problem.released - problem.ties.interior_count]
    gram = shapes.T @ (problem.mass @ shapes)
    scale = 1.0 / np.sqrt(np.maximum(gram.diagonal(), NO_MASS * problem.largest_masses[problem.released]))
    squares, vectors = scipy.linalg.eigh(gram * np.outer(scale, scale))
    return np.asarray(shapes @ (scale[:, None] * vectors[:, squares < SINGULAR]))


def tell_of_frames_without_inertia(problem: StaticProblem, modes: np.ndarray) -> None:
    """Warn if the modes of a held body have all its mass: a joint at its fixed interface moves none by itself."""
    R = problem.ties.coordinates(problem.model.rigid_modes(about=problem.ties.ties[0].position))
    size = np.linalg.norm(R, axis=0)
    R = R[:, size > 0.0] / size[size > 0.0]
    weighted = problem.mass @ R
    gram = R.T @ weighted
    part = modes.T @ weighted
    left = np.diag(gram - part.T @ part) < 1e-9 * np.diag(gram)
    if np.any(left & (np.diag(gram) > 0.0)):
        warnings.warn(
            "all that has mass in the body can move beside its fixed interface, so that a joint there that turns "
            "or slides has no inertia of its own. Remedy: reduction=CraigBampton(modes=...), or a fixed interface "
            "that has inertia",
            AccuracyWarning,
            stacklevel=outside(),
        )


def _tell_rigid(problem: StaticProblem) -> None:
    """Warn of rigid motions of a floating body without inertia."""
    motions = problem.massless_motions
    if not motions.shape[1]:
        return
    model = problem.model
    rigid = problem.ties.coordinates(model.rigid_modes(about=model.nodes.mean(axis=0)))
    axes = np.linalg.lstsq(rigid, motions, rcond=None)[0][3:].T
    units = [axis / (np.linalg.norm(axis) * np.sign(axis[np.argmax(abs(axis))])) for axis in axes]
    named = ", ".join(str((axis.round(6) + 0.0).tolist()) for axis in units)
    warnings.warn(
        f"the body floats, and has no inertia about {named} through {model.nodes.mean(axis=0).round(6).tolist()} m: "
        "some joint or loop must hold this turn. Remedy: rotary inertia in the matrices, or an interface fixed in G",
        AccuracyWarning,
        stacklevel=outside(),
    )
