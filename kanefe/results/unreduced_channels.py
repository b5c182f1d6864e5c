"""What results read of a run with unreduced bodies: frames of the condensed twin, energies of the bodies themselves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Vector
from kanefe.integrate.trajectory import Trajectory
from kanefe.kane.reactions import loop_forces
from kanefe.results.channels import Key, RunChannels, body_shape
from kanefe.unreduced.route import UnreducedScene


class UnreducedChannels(RunChannels):
    """Channels of a run with unreduced bodies. `model` and `trajectory` are those of the complete condensed twin.

    Parameters
    ----------
    model : Model
    trajectory : Trajectory
        With accelerations.
    """

    def __init__(self, model: Model, trajectory: Trajectory) -> None:
        self._scene = UnreducedScene(model)
        self._full = trajectory
        twin = self._scene.complete
        coordinates = [twin.coordinates(q) for q in trajectory.coordinates]
        speeds = [twin.speeds(u) for u in trajectory.speeds]
        condensed = replace(trajectory, coordinates=np.array(coordinates), speeds=np.array(speeds))
        super().__init__(twin.small, condensed, tuple(body_shape(model, body) for body in model.bodies))

    def _accelerations(self) -> np.ndarray:
        if self._du is None:
            self._du = np.array([self._scene.complete.speeds(du) for _, _, _, du in self._full_states()])
        return self._du

    def _full_states(self) -> list[tuple[float, Vector, Vector, Vector]]:
        run, scene = self._full, self._scene
        known = run.accelerations
        if known is None:
            states = zip(run.times, run.coordinates, run.speeds, strict=True)
            known = np.array([scene.accelerations(*state) for state in states])
        return list(zip(run.times, run.coordinates, run.speeds, known, strict=True))

    def _modes(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        terms = self._scene.model.flexible_terms(body)
        return {
            ("modal_coordinates", body, ""): self._full.coordinates[:, terms.eta].copy(),
            ("modal_speeds", body, ""): self._full.speeds[:, terms.speeds].copy(),
        }

    def _energies(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        found = [self._scene.energy(t, q, u) for t, q, u, _ in self._full_states()]
        return {
            ("kinetic_energy", "", ""): np.array([energy.kinetic for energy in found]),
            ("elastic_energy", "", ""): np.array([energy.elastic for energy in found]),
            ("gravity_energy", "", ""): np.array([energy.gravity for energy in found]),
            ("dissipated_energy", "", ""): np.array(self._full.dissipated),
            ("work", "", ""): np.array(self._full.work),
        }

    def _momenta(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        found = [self._scene.momenta(t, q, u) for t, q, u, _ in self._full_states()]
        linear, angular = (np.array(values) for values in zip(*found, strict=True))
        return {("linear_momentum", "", ""): linear, ("angular_momentum", "", ""): angular}

    def _loop_forces(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        forces = self._at_all_times(lambda model, t, q, u, du: loop_forces(model, t, q, u))
        return {("loop_force", name, ""): np.array([force[name] for force in forces]) for name in self.loops}

    def _at_all_times(self, function: Callable[..., Any]) -> np.ndarray:
        """Return ``function(twin, t, q, u, du)`` at every output time, with a twin that moves as the scene does."""
        found = []
        for t, q, u, du in self._full_states():
            twin, q_s, u_s, du_s = self._scene.equivalent(t, q, u, du)
            found.append(function(twin, t, q_s, u_s, du_s))
        return np.array(found)


def run_channels(model: Model, trajectory: Trajectory) -> RunChannels:
    """Return the channels of a run."""
    if model.has_unreduced:
        return UnreducedChannels(model, trajectory)
    return RunChannels(model, trajectory)
