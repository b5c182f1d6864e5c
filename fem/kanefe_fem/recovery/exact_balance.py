"""Section forces of an exact beam by balance: of all that acts beyond a section, gravity and inertia included."""

from __future__ import annotations

import numpy as np

from kanefe.bodies.exact.beam import ExactBeam, SectionFrame
from kanefe.bodies.exact.beam_line import integrals_to
from kanefe.bodies.exact.inertia import BeamInertia
from kanefe.errors import ModelError
from kanefe.frames import rotation_matrices
from kanefe.results.reader import Reader
from kanefe_fem.recovery.free_body_loads import forces_at_nodes


def exact_beam_balance(result: Reader, name: str, frames: np.ndarray, xi: np.ndarray) -> np.ndarray:
    """Return forces and moments of the part beyond a section on that before it, (T, C, s, 6), in section axes.

    The sections are at xi (s,) of each cell over its length.

    ``F' + f = 0`` and ``M' + p' x F + m = 0`` from the end of the beam, with the loads f and m at the Gauss points as
    polynomials over each cell.

    Raises
    ------
    ModelError
        If the result was read from a file.
    """
    run, body = result.run, result.body(name).flexible
    if run is None or not isinstance(body, ExactBeam):
        raise ModelError(
            f"a result read from a file does not contain the loads on {name!r}. Remedy: inertia=False, or recover in "
            "the program that runs the scene"
        )
    line, inertia, terms = body.line, BeamInertia(body.line), run.model.flexible_terms(name)
    gravity = run.model.gravity if run.model.bodies[run.model.index(name)].has_gravity else np.zeros(3)
    to_G = rotation_matrices(result.rotation(name)[frames]).transpose(0, 2, 1)
    of_G = np.squeeze(to_G @ (result.acceleration(name)[frames] - gravity)[..., None], -1)
    w, alpha = (x[frames] for x in (result.angular_velocity(name), result.angular_acceleration(name)))
    eta, deta = (x[frames] for x in (result.modal_coordinates(name), result.modal_speeds(name)))
    rates = np.hstack((of_G, alpha, run.accelerations()[frames][:, terms.speeds]))
    rows = zip(eta, deta, w, rates, strict=True)
    (C, P), T = line.masses.shape, len(frames)
    gauss = line.gauss_nodes
    at = np.zeros((T, line.node_count, 6))  # at the stations
    at[:, gauss] = np.reshape([inertia.wrenches(*row) for row in rows], (T, C, P, 6))
    for frame in body.interfaces:
        if isinstance(frame, SectionFrame) and not frame.is_held:
            at[:, frame.station] += result.coupling_force(name, frame.name)[frames]
    for row, node, acting in forces_at_nodes(result, name, body, frames):
        at[row, node] += acting
    strains = line.strains(eta)[..., :3] + (1.0, 0.0, 0.0)
    along = np.squeeze(line.places(eta)[0][:, gauss] @ strains[..., None], -1)  # p'
    to_end, beyond = (line.weights - integrals_to(x, line.points, line.weights) for x in (line.points, xi))
    found, end = np.empty((T, C, len(xi), 6)), np.zeros((T, 6))
    for c in reversed(range(C)):
        h = line.lengths[c]
        end += at[:, line.end_node(c)]
        loads = at[:, gauss[c]] / (h * line.weights)[:, None]
        forces = end[:, None, :3] + h * (to_end @ loads[..., :3])
        loads[..., 3:] += np.cross(along[:, c], forces)
        found[:, c] = end[:, None] + h * (beyond @ loads)
        end += h * (line.weights @ loads)
    own = line.within(eta, xi)[0].swapaxes(-1, -2)
    return np.concatenate([np.squeeze(own @ x[..., None], -1) for x in np.split(found, 2, axis=-1)], axis=-1)
