"""Forces along components of a body that are fixed in G, at all states of a run, where its wrench leaves them open.

More than six components share forces by how the body deforms: a body on four saddles. A displacement along one of them
moves G back and deforms the body, as its constraint mode does; the work of inertia, elasticity and loads in that motion
is that of the force (Eq. 31-35, 38). `kanefe.kane.coupling` computes the same state by state, from equations over all
coordinates of a body.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import cast

import numpy as np

from kanefe.bodies.flexible import InterfaceFrame
from kanefe.bodies.marker import CoordinateMarker, Marker
from kanefe.bodies.mass_moments import MassMoments
from kanefe.frames import Matrix, skews
from kanefe.states.interactions import unit_wrenches
from kanefe.tree.body_terms import FlexibleTerms
from kanefe.tree.model_data import ModelData
from kanefe.tree.run_sweeps import FrameMotions

AT_ONCE = 2000
"""Number of states in one go: a few megabytes for each component."""


def are_served(model: ModelData, number: int) -> bool:
    """Return whether forces along fixed components of a body are computed here: it is linear, and what acts is told.

    At nodes beside interfaces that is so of loads between frames; of spread loads nothing is told.
    """
    body = model.bodies[number]
    terms = body.flexible
    if terms is None or not isinstance(terms.all_moments, MassMoments) or body.field_loads:
        return False
    frames = [frame for _, frame in body.loads]
    frames += [child.parent_interface for child in model.bodies if child.parent == number]
    frames += [marker.interface for _, _, marker in _ends_on(model, number, constraints=True)]
    interfaces = terms.body.interfaces
    at_interfaces = all(frame is None or any(frame is n for n in interfaces) for frame in frames)
    is_linear = terms.all_moments.quadratic_first is None and all(n.is_linear for n in interfaces)
    return is_linear and at_interfaces


def _ends_on(model: ModelData, number: int, constraints: bool) -> Iterator[tuple[int, int, Marker]]:
    """Yield what acts on a body by number, end and marker: constraints and rigid contacts, or other loads."""
    rigid = set(model.rigid_contacts)
    acting = model.constraints if constraints else ()
    found = [(i, e, marker) for i, one in enumerate(acting) for e, marker in enumerate(one.ends)]
    loads = [(i, load) for i, load in enumerate(model.loads) if (i in rigid) == constraints]
    found += [(i, e, marker) for i, load in loads for e, marker in enumerate(load.ends)]
    for i, e, marker in found:
        if marker.body == number and not isinstance(marker, CoordinateMarker):
            yield i, e, marker


class HeldForces:
    """The forces along the fixed components of a body at T states.

    Parameters
    ----------
    model : ModelData
    number : int
        Of the body.
    states, accelerations : ndarray, shapes (T, state), (T, free)
    motion : FrameMotions
        Of the body's frame G, with accelerations.
    reaction : ndarray, shape (T, 6)
        Wrench of its joint on it, about G's origin, in axes of G.
    at_interface : callable
        Returns what acts at an interface, by its name, about the deformed interface, in axes of G, (T, 6): children,
        constraints, rigid contacts and given forces.
    on_end : callable
        Returns the wrench of a load between frames on one of its ends, (T, 6), in N.
    """

    def __init__(
        self,
        model: ModelData,
        number: int,
        states: Matrix,
        accelerations: Matrix,
        motion: FrameMotions,
        reaction: Matrix,
        at_interface: Callable[[str], Matrix],
        on_end: Callable[[int, int], Matrix],
    ) -> None:
        self._model, self._number = model, number
        self._terms = terms = cast(FlexibleTerms, model.bodies[number].flexible)
        n = model.coordinate_count
        self._eta, self._deta = states[:, terms.eta], states[:, n + terms.speeds.start : n + terms.speeds.stop]
        self._ddeta = accelerations[:, terms.speeds]
        self._motion, self._reaction, self._at_interface, self._on_end = motion, reaction, at_interface, on_end

    def forces(self) -> Matrix:
        """Return them along the axes of the interfaces, in the order of the coordinates of the body, (T, fixed)."""
        found = self._reaction @ self._terms.fixed_rigid + self._elastic_work() - self._work_of_loads()
        for chunk in self._chunks():
            found[chunk] = np.linalg.solve(self._unit_work(chunk), found[chunk][..., None])[..., 0]
        return found

    def on_body(self, frame: InterfaceFrame, forces: Matrix) -> Matrix:
        """Return the wrench at an interface that has such components, about its place, in axes of G, (T, 6)."""
        columns = [column - self._terms.body.free_count for column in frame.fixed_columns]
        return np.einsum("tac,tc->ta", self._unit_wrenches(frame, self._tangents(frame)), forces[:, columns])

    def _chunks(self) -> Iterator[slice]:
        for first in range(0, len(self._eta), AT_ONCE):
            yield slice(first, first + AT_ONCE)

    def _elastic_work(self) -> Matrix:
        """Return the work of inertia and elasticity in the deformations, (T, fixed)."""
        terms, k = self._terms, self._terms.body.free_count
        moments, E = cast(MassMoments, terms.all_moments), terms.fixed_elastic  # see `are_served`
        product = np.einsum("abij,ic->abcj", moments.shape_product[..., :k], E)
        along = moments.shape_first @ E, moments.shape_second @ E, product
        found = np.empty((len(self._eta), E.shape[1]))
        for chunk in self._chunks():
            found[chunk] = self._work_of_inertia(*along, chunk)
        found += self._eta @ (terms.fixed_elastic.T @ terms.body.stiffness[:, :k]).T
        if terms.damping is not None:
            found += self._deta @ (terms.fixed_elastic.T @ terms.damping[:, :k]).T
        return found

    def _work_of_inertia(self, first: Matrix, second: np.ndarray, product: np.ndarray, chunk: slice) -> Matrix:
        """Return the rows of `MassMoments.terms` along the deformations, from the moments of these, at some states."""
        motion, body = self._motion, self._model.bodies[self._number]
        axes = motion.axes[chunk]
        gravity = self._model.gravity if body.has_gravity else np.zeros(3)
        linear, angular = (cast(Matrix, x)[chunk] for x in (motion.acceleration, motion.angular_acceleration))
        moving = linear - gravity, angular, motion.angular_velocity[chunk]
        a, alpha, w = (np.einsum("tji,tj->ti", axes, x) for x in moving)
        of_eta, of_deta = (np.einsum("abcj,tj->tabc", product, x[chunk]) for x in (self._eta, self._deta))
        P = second + of_eta.swapaxes(1, 2)
        W = skews(w)
        turning = np.stack(
            (P[:, 1, 2] - P[:, 2, 1], P[:, 2, 0] - P[:, 0, 2], P[:, 0, 1] - P[:, 1, 0]), axis=1
        )  # (T, 3, fixed)
        found = a @ first + np.einsum("ta,tac->tc", alpha, turning)
        found += self._ddeta[chunk] @ np.einsum("aacj->jc", product)
        found += np.einsum("tba,tabc->tc", W @ W, P) + 2.0 * np.einsum("tab,tabc->tc", W, of_deta)
        return found

    def _work_of_loads(self) -> Matrix:
        """Return the work of what acts, but for the joint, in the deformations, (T, fixed)."""
        body, axes = self._terms.body, self._motion.axes
        found = self._work_of_arms()
        for interface in body.interfaces:
            found += self._work_at(interface, self._at_interface(interface.name))
        for load, end, marker in _ends_on(self._model, self._number, constraints=False):
            frame = marker.interface
            if frame is None:
                continue
            force, moment = (np.einsum("tji,tj->ti", axes, x) for x in np.split(self._on_end(load, end), 2, axis=1))
            if marker.point.any():  # the end is beside its node, and turns about it
                turned = [self._model.slopes.rotation(theta) for theta in frame.displacements(self._eta)[:, 3:]]
                moment = moment + np.cross(np.array(turned) @ marker.point, force)
            found += self._work_at(frame, np.hstack((force, moment)))
        return found

    def _work_of_arms(self) -> Matrix:
        """Return that of the arms of a viscoelastic body, with what is transferred to fixed components."""
        k, elastic = self._terms.body.free_count, self._terms.fixed_elastic
        found = np.zeros((len(self._eta), elastic.shape[1]))
        for i, load in enumerate(self._model.loads):
            if load.kind == "relaxation" and load.ends[0].body == self._number:
                along = elastic[:k] + self._terms.transfer.T @ elastic[k:]
                found += np.column_stack([self._on_end(i, e)[:, 0] for e in range(len(load.ends))]) @ along
        return found

    def _work_at(self, frame: InterfaceFrame, wrench: Matrix) -> Matrix:
        """Return the work of a wrench at a frame, about its place, in axes of G, in the deformations, (T, fixed)."""
        moved = frame.motion @ self._terms.fixed_elastic
        found = wrench[:, :3] @ moved[:3]
        if wrench[:, 3:].any() and moved[3:].any():
            found += np.einsum("tba,tb->ta", self._tangents(frame), wrench[:, 3:]) @ moved[3:]
        return found

    def _tangents(self, frame: InterfaceFrame, chunk: slice = slice(None)) -> np.ndarray:
        """Return T of the slopes of a frame at states, (T, 3, 3)."""
        slopes = frame.displacements(self._eta[chunk])[:, 3:]
        if not slopes.any():
            return np.broadcast_to(np.eye(3), (len(slopes), 3, 3))
        return np.array([self._model.slopes.tangent(theta) for theta in slopes])

    def _unit_wrenches(self, frame: InterfaceFrame, tangents: np.ndarray) -> np.ndarray:
        """Return `unit_wrenches` of an interface with its tangents, (T, 6, forces)."""
        if tangents.strides[0] == 0:
            one = unit_wrenches(frame.fixed_components, tangents[0], frame.axes)
            return np.broadcast_to(one, (len(tangents), *one.shape))
        return np.array([unit_wrenches(frame.fixed_components, tangent, frame.axes) for tangent in tangents])

    def _unit_work(self, chunk: slice) -> np.ndarray:
        """Return the work of unit forces (columns) in motions along the components (rows), (T, fixed, fixed).

        The identity without deformation; a partly released interface moves off its place and turns.
        """
        terms = self._terms
        k, rigid, fixed = terms.body.free_count, terms.fixed_rigid, terms.body.fixed_count
        eta = self._eta[chunk]
        found = np.zeros((len(eta), fixed, fixed))
        for frame in terms.body.interfaces:
            if not frame.fixed_components:
                continue
            moved, tangents = frame.motion @ terms.fixed_elastic, self._tangents(frame, chunk)
            place = frame.position + frame.displacements(eta)[:, :3]
            velocity = rigid[:3] + moved[:3] - skews(place) @ rigid[3:]
            motions = np.concatenate((velocity, rigid[3:] + tangents @ moved[3:]), axis=1)
            columns = [column - k for column in frame.fixed_columns]
            found[:, :, columns] = motions.swapaxes(1, 2) @ self._unit_wrenches(frame, tangents)
        return found
