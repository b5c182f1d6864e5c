"""Loads on the free body of a body of beams: gravity and inertia of its mass points, and forces at its nodes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.errors import ModelError
from kanefe.fe_model.model import COMPONENTS, TRANSLATIONS
from kanefe.frames import rotation_matrices
from kanefe.kane.active import loaded_frames
from kanefe.kane.reactions import held_wrenches
from kanefe.results.reader import Reader
from kanefe.states.constraints import HeldWrench
from kanefe.states.interactions import MarkerWrench, load_wrenches
from kanefe.states.kinematics import FrameMotion
from kanefe.states.state import State
from kanefe.tree.neighbours import interface_at
from kanefe_fem.beams import elements as be
from kanefe_fem.beams.properties import ElementProperties

BALANCE = 1e-4
"""Imbalance of the free body, relative to the forces on it, above which a load must be missing."""


@dataclass(frozen=True, eq=False)
class SpreadLoads:
    """Loads along m elements, polynomials through samples at g Gauss stations, in the axes L of the elements.

    Attributes
    ----------
    lengths : ndarray, shape (m,)
        Lengths of the elements, m.
    samples : ndarray, shape (T, m, g, 6)
        Force and moment per unit length, N/m and N.
    fixed_ends : ndarray, shape (T, m, 12)
        Forces on the ends that do the same work, N and N m.
    """

    lengths: np.ndarray
    samples: np.ndarray
    fixed_ends: np.ndarray

    @classmethod
    def of_station_forces(cls, properties: ElementProperties, wrenches: np.ndarray) -> SpreadLoads:
        """Return the load that corresponds to wrenches (T, m, g, 6) at its Gauss stations."""
        stations, weights = be.gauss_stations(wrenches.shape[2])
        samples = wrenches / (weights[:, None] * properties.length[:, None, None])
        N = be.interpolation(properties, stations)
        return cls(properties.length, samples, np.einsum("mgij,tmgi->tmj", N, wrenches))

    def before(self, xi: np.ndarray) -> np.ndarray:
        """Return the resultant about each station x/l (s,) of the load between the first end and the station.

        The shape is (T, m, s, 6).
        """
        count = self.samples.shape[2]
        stations = be.gauss_stations(count)[0]
        to_polynomial = np.linalg.inv(np.vander(stations, count, increasing=True))
        q = np.einsum("cg,tmgi->tmci", to_polynomial, self.samples)
        powers = np.arange(count)
        total = xi[:, None] ** (powers + 1) / (powers + 1)  # int_0^xi s^c ds
        arm = xi[:, None] ** (powers + 2) / ((powers + 1) * (powers + 2))  # int_0^xi (xi - s) s^c ds
        length = self.lengths[:, None, None]
        wrench = np.einsum("sc,tmci->tmsi", total, q) * length
        moved = np.einsum("sc,tmci->tmsi", arm, q[..., :3]) * length**2
        # a force at the distance a before the station, r = (-a, 0, 0), has the moment r x F = (0, a F_z, -a F_y)
        wrench[..., 4] += moved[..., 2]
        wrench[..., 5] -= moved[..., 1]
        return wrench


@dataclass(frozen=True, eq=False)
class FreeBodyLoads:
    """Loads on a body of beams, in G, at T times.

    Attributes
    ----------
    points : ndarray, shape (P, 3)
        Undeformed positions of the mass points, m.
    point_forces : ndarray, shape (T, P, 3)
        Gravity minus mass times acceleration, N.
    nodal_forces : ndarray, shape (T, N)
        Forces on the degrees of freedom of the nodes, from interfaces, contacts and given forces, N and N m.
    """

    points: np.ndarray
    point_forces: np.ndarray
    nodal_forces: np.ndarray


def free_body_loads(result: Reader, name: str, frames: np.ndarray) -> FreeBodyLoads:
    """Return the loads on a body at some output times of a run in memory.

    Raises
    ------
    ModelError
        If the result was read from a file, an interface has several nodes, or the forces are not in balance, because
        distributed loads act on the body.
    """
    body = result.body(name).flexible
    if result.run is None or body is None:
        raise ModelError(
            f"a result read from a file does not contain the loads on {name!r}. Remedy: inertia=False, or recover in "
            "the program that runs the scene"
        )
    forces, moved = inertia_forces(result, name, body, frames)
    nodal = np.zeros((len(frames), len(body.nodes) * len(body.components)))
    kept = [COMPONENTS.index(c) for c in body.components]
    wrench = np.concatenate((forces.sum(axis=1), np.cross(moved, forces).sum(axis=1)), axis=1)
    scale = np.concatenate(
        (abs(forces).sum(axis=(1, 2)), (np.linalg.norm(moved, axis=2) * np.linalg.norm(forces, axis=2)).sum(axis=1))
    )
    eta = result.modal_coordinates(name)[frames]
    for frame in body.interfaces:
        coupling = result.coupling_force(name, frame.name)[frames]
        if not coupling.any():
            continue
        node = _node_of(name, body, frame)
        nodal[:, node * len(kept) + np.arange(len(kept))] += coupling[:, kept]
        place = frame.position + np.array([frame.moved(row)[0][:3] for row in eta])
        wrench += np.concatenate((coupling[:, :3], coupling[:, 3:] + np.cross(place, coupling[:, :3])), axis=1)
        scale = np.maximum(scale, np.repeat([abs(coupling[:, :3]).max(), abs(coupling[:, 3:]).max()], len(frames)))
    for row, node, acting in forces_at_nodes(result, name, body, frames):
        nodal[row, node * len(kept) + np.arange(len(kept))] += acting[kept]
        place = body.nodes[node] + body.node_displacements(eta[row])[node]
        wrench[row] += np.concatenate((acting[:3], acting[3:] + np.cross(place, acting[:3])))
        scale[row] = max(scale[row], abs(acting[:3]).max())
    _check_balance(name, wrench[:, kept], np.repeat(scale.reshape(2, -1), 3, axis=0).T[:, kept])
    return FreeBodyLoads(body.inertia_points, forces, nodal)


def inertia_forces(result: Reader, name: str, body: FlexibleBody, frames: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return gravity minus mass times acceleration of the mass points, and their positions, each (T, P, 3), in G."""
    run = result.run
    if run is None or not body.is_exact:
        raise ModelError(
            f"body {name!r} has no mass points that move with its modes. Remedy: inertia=False, or make it with "
            "kanefe_fem.beam_body and a reduction"
        )
    number = run.model.index(name)
    terms = run.model.flexible_terms(name)
    gravity = run.model.gravity if run.model.bodies[number].has_gravity else np.zeros(3)
    basis, axes = body.inertia_basis[:, : body.free_count], rotation_matrices(result.rotation(name)[frames])
    a = (result.acceleration(name)[frames] - gravity)[:, None] @ axes
    w, alpha = (x[frames][:, None] for x in (result.angular_velocity(name), result.angular_acceleration(name)))
    of_modes = result.modal_coordinates(name), result.modal_speeds(name), run.accelerations()[:, terms.speeds]
    deformed, velocity, acceleration = ((x[frames] @ basis.T).reshape(len(frames), -1, 3) for x in of_modes)
    moved = body.inertia_points + deformed
    total = a + np.cross(alpha, moved) + np.cross(w, np.cross(w, moved) + 2.0 * velocity) + acceleration
    side_by_side = total.transpose(1, 0, 2).reshape(len(body.inertia_points), -1)
    forces = -(body.inertia_mass @ side_by_side).reshape(-1, len(frames), 3).transpose(1, 0, 2)
    forces[:, :, [a for a, c in enumerate(TRANSLATIONS) if c not in body.components]] = 0.0  # across a planar body
    return forces, moved


def forces_at_nodes(
    result: Reader, name: str, body: FlexibleBody, frames: np.ndarray
) -> Iterator[tuple[int, int, np.ndarray]]:
    """Yield row, node, and force and moment about it in G (6,), of every load at a node that is no interface."""
    run = result.run
    if run is None or not (
        run.model.is_constrained or run.model.loads or run.model.bodies[run.model.index(name)].loads
    ):
        return
    number = run.model.index(name)
    for row, frame in enumerate(frames):
        trajectory = run.trajectory
        q, u, z = trajectory.coordinates[frame], trajectory.speeds[frame], trajectory.internal[frame]
        state = State(run.model, run.times[frame], q, u, z)
        G = state.motion(number, None)
        for at, placed, wrench in _acting(state, number):
            if at is None or interface_at(body, at) is not None:
                continue
            to_G = G.A_NF.T @ placed.A_NF
            force, moment = to_G @ wrench[:3], to_G @ wrench[3:]
            arm = G.A_NF.T @ (placed.p_NoFo_N - state.motion(number, at).p_NoFo_N)
            node = getattr(at, "station", None)
            if node is None:
                node = int(np.linalg.norm(body.nodes - at.position, axis=1).argmin())
            yield row, node, np.concatenate((force, moment + np.cross(arm, force)))


def _acting(state: State, number: int) -> Iterator[tuple[InterfaceFrame | None, FrameMotion, np.ndarray]]:
    """Yield interface or node, frame, and force and moment (6,) in it, of loads, loops and contacts on a body."""
    acting: list[HeldWrench | MarkerWrench] = [*held_wrenches(state), *load_wrenches(state)]
    for one in acting:
        if one.marker.body == number:
            yield one.marker.interface, one.frame, one.wrench
    terms = state.model.bodies[number]
    frames = loaded_frames(state, terms, state.motion(number, None))
    for (load, placed), (_, at) in zip(frames, terms.loads, strict=True):
        yield at, placed, np.concatenate(load.wrench(state.t, placed, state))


def _node_of(name: str, body: FlexibleBody, frame: InterfaceFrame) -> int:
    """Return the node of an interface; raise a ModelError if it has several."""
    distance = np.linalg.norm(body.nodes - frame.position, axis=1)
    node = int(distance.argmin())
    own = body.node_frame(node).motion
    if (
        distance[node] > 1e-9 * np.ptp(body.nodes, axis=0).max()
        or abs(own - frame.motion).max() > 1e-9 * abs(own).max()
    ):
        raise ModelError(
            f"interface {frame.name!r} of {name!r} has several nodes, and how its force is shared between them is not "
            "known. Remedy: inertia=False, or interfaces of one node"
        )
    return node


def _check_balance(name: str, wrench: np.ndarray, scale: np.ndarray) -> None:
    worst = float((abs(wrench) / np.maximum(scale, 1e-300)).max(initial=0.0))
    if worst > BALANCE and abs(wrench).max() > 0.0:
        raise ModelError(
            f"gravity, inertia and the forces at interfaces and nodes of {name!r} are not in balance (by {worst:.1e} "
            "of them): distributed loads act on it. Remedy: inertia=False, or put those loads on interfaces and nodes"
        )
