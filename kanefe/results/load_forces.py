"""Forces of loads between frames on their ends, and vectors in the axes of bodies."""

from __future__ import annotations

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import rotation_matrices
from kanefe.results.channels import RunChannels


def load_forces(run: RunChannels | None, name: str, end: int) -> np.ndarray:
    """Return force (N) and moment (N m) of a load on one of its ends, in components of N, shape (T, 6).

    Raises
    ------
    ModelError
        If the run is from a file, or the load has no such end or is a rigid contact.
    """
    if run is None:
        raise ModelError(
            "forces of loads on their ends come from the model, which a file does not contain. Remedy: the "
            "result that System.simulate returned"
        )
    model = run.model
    number = next(i for i, load in enumerate(model.loads) if load.name == name)
    load = model.loads[number]
    if number in model.rigid_contacts:
        raise ModelError(f"{name!r} is a rigid contact. Remedy: result.contact({name!r}).force")
    count = len(load.ends)
    if not isinstance(end, (int, np.integer)) or not -count <= end < count:
        raise ModelError(f"{load.kind} {name!r} has ends 0 to {count - 1}, there is no end {end!r}")
    return run.forces.on_end(number, end % count)


def turned_into(vectors: object, rotation: np.ndarray, what: str) -> np.ndarray:
    """Return vectors given in N in components of frames with Euler parameters (T, 4) or (4,).

    Raises
    ------
    ModelError
        If the shape is not one vector for each time, of three components or, for a force and a moment, of six.
    """
    given = np.asarray(vectors, dtype=float)
    if given.shape[:-1] != rotation.shape[:-1] or given.shape[-1:] not in ((3,), (6,)):
        wanted = (*rotation.shape[:-1], 3)
        raise ModelError(
            f"vectors to be turned into the axes of {what} must have shape {wanted} or 6, not {given.shape}"
        )
    axes = rotation_matrices(np.atleast_2d(rotation)).reshape(*rotation.shape[:-1], 3, 3)
    parts = given.reshape(*given.shape[:-1], -1, 3)  # one or two vectors of each time
    return np.asarray(parts @ axes).reshape(given.shape)
