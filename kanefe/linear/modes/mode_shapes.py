"""Shapes of small motions of a scene: motions of bodies, interfaces and nodes, participation, the deformed scene."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers
from kanefe.instants.instant import Instant
from kanefe.kane.inertia import flexible_inertia, rigid_inertia
from kanefe.linear.small_motions import SmallMotions
from kanefe.states.kinematics import FrameMotion, elastic_state


class Shapes(ABC):
    """Small motions of a scene about a state, one per column: of modes, or of buckling."""

    @property
    @abstractmethod
    def _small(self) -> SmallMotions:
        """The small motions of the scene."""

    @property
    @abstractmethod
    def tangents(self) -> np.ndarray:
        """Shapes as tangents of the tree (free, shapes): what `Model.advance` takes."""

    @cached_property
    def participation(self) -> dict[str, Vector]:
        """Share of each body in the kinetic energy of each shape, by name, each (shapes,)."""
        masses = body_masses(self._small)
        z = self.tangents
        parts = {name: np.einsum("ik,ij,jk->k", z.conj(), M, z).real for name, M in masses.items()}
        total = sum(parts.values())
        return {name: part / np.where(total > 0.0, total, 1.0) for name, part in parts.items()}

    @checked
    def shape(self, body: str, interface: str = "") -> np.ndarray:
        """Return the motion of a frame in each shape: displacement (m) and rotation (rad) in N, (shapes, 6).

        Scaled as `tangents`; complex for modes, with the phase of the motion.

        Raises
        ------
        ModelError
            If there is no such body or interface.
        """
        frame = self._frame(body, interface)
        n = self._small.model.free_count
        partial = np.vstack((frame.A_NF @ frame.V[:, :n], frame.A_NF @ frame.W[:, :n]))
        return np.asarray((partial @ self.tangents).T)

    @checked
    def displacements(self, body: str, mode: int) -> np.ndarray:
        """Return the motion of the nodes of a flexible body in a shape, in N, including its rigid motion, (n, 3).

        Raises
        ------
        ModelError
            If the body is rigid or unknown, or there is no such shape.
        """
        self._check(mode)
        model, q = self._small.model, self._small.q
        terms = model.flexible_terms(body)
        G, z = self._frame(body, ""), self.tangents[:, mode]
        n, eta = model.free_count, q[terms.eta]
        v, w = G.V[:, :n] @ z, G.W[:, :n] @ z
        own = terms.body.node_velocities(eta, z[terms.speeds].real)
        if np.iscomplexobj(z):
            own = own + 1j * terms.body.node_velocities(eta, z[terms.speeds].imag)
        return np.asarray((v + np.cross(w, terms.body.nodes + terms.body.node_displacements(eta)) + own) @ G.A_NF.T)

    @checked
    def shown(self, mode: int, size: float = 1.0) -> Instant:
        """Return the scene displaced along a shape by `size` times `tangents`, for pictures and files.

        For complex modes, the real part. Loops are closed to first order.

        Raises
        ------
        ModelError
            If there is no such shape, or the size is not a finite number.

        Examples
        --------
        ``kf.buckling(scene).shown(0, size=0.1).to_vtk("buckled.pvd")``
        """
        self._check(mode)
        if numbers(size).shape != () or not np.isfinite(numbers(size)):
            raise ModelError(f"the size of a shape must be a finite number, not {size!r}")
        small = self._small
        model = small.model
        q = model.advance(small.q, float(size) * self.tangents[:, mode].real)
        return Instant(model, small.t, np.concatenate((q, np.zeros(model.free_count), model.initial_states)))

    @checked
    def describe(self, mode: int) -> str:
        """Return the bodies with the largest shares of kinetic energy in a shape."""
        self._check(mode)
        shares = sorted(((float(part[mode]), name) for name, part in self.participation.items()), reverse=True)
        return ", ".join(f"{name} {100 * share:.0f} %" for share, name in shares[:3] if share >= 0.05)

    def _check(self, mode: int) -> None:
        count = self.tangents.shape[1]
        if not 0 <= mode < count:
            there_are = f"there are 0 to {count - 1}" if count else "there are none"
            raise ModelError(f"there is no mode {mode}: {there_are}")

    def _frame(self, body: str, interface: str) -> FrameMotion:
        small = self._small
        at = small.model.flexible_terms(body).body.interface(interface) if interface else None
        return small.here.motion(small.model.index(body), at)


def body_masses(small: SmallMotions) -> dict[str, Matrix]:
    """Return the share of each body in the mass matrix over the free speeds, by name; massless frames are left out.

    Rotors behind the gears of a joint count with the body that it carries.
    """
    model, n, none = small.model, small.model.free_count, np.zeros(3)
    state = small.here
    found = {}
    for body, frame in zip(model.bodies, state.motions, strict=True):
        if body.rigid is not None and body.rigid.mass > 0.0:
            found[body.name] = rigid_inertia(body.rigid, frame, none)[0][:n, :n]
        elif body.flexible is not None:
            eta = elastic_state(body.flexible, state.q, state.full, False)
            found[body.name] = flexible_inertia(body.flexible, frame, none, *eta)[0][:n, :n]
        for speed in body.speeds[body.speeds < n]:
            if model.armatures[speed]:
                found.setdefault(body.name, np.zeros((n, n)))[speed, speed] += model.armatures[speed]
    return found
