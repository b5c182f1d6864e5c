"""Controllers in a run: what they read, when they are called, when their drives begin to act, and a log of all that."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector, euler_parameters_from_matrix, rotation_vector
from kanefe.integrate.run_checks.drive_growth import DriveGrowth
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.loads.controller import Controller, Reading

Read = Callable[[float, Vector, Callable[[], SceneState]], float]

END_SHARE = 1e-9
"""Time between a sample and the end of a run, relative to the sampling interval, below which the sample is skipped."""


AT_ONCE = 1e-9
"""Time difference, relative to the shortest sampling interval, below which samples are simultaneous, such as 3 times
0.1 s and 15 times 0.02 s."""


@dataclass(frozen=True, eq=False)
class ControllerLog:
    """All samples of a controller in a run, K of them.

    Attributes
    ----------
    times : ndarray, shape (K,)
        s.
    reads, drives : ndarray, shape (K, reads) and (K, drives)
        What it was given and what it gave; drives begin to act its delay later.
    read_names, drive_names : tuple of str
        With units in brackets.
    """

    times: np.ndarray
    reads: np.ndarray
    drives: np.ndarray
    read_names: tuple[str, ...]
    drive_names: tuple[str, ...]

    def __repr__(self) -> str:
        return f"{len(self.times)} samples of {', '.join(self.read_names)}; drives {', '.join(self.drive_names)}"


class Sampler:
    """The controllers of a model in a run.

    Parameters
    ----------
    model : Model
    start, stop : float
        s.
    """

    def __init__(self, model: Model, start: float, stop: float) -> None:
        self._model, self._stop = model, stop
        self._first_held = model.coordinate_count + model.free_count
        sampled = [one for one in model.controllers if one.is_sampled]
        together = AT_ONCE * min((one.every for one in sampled), default=0.0)
        self._controllers = [_Sampled(model, one, start, together) for one in sampled]

    def aim(self, stop: float) -> None:
        """Let the run end at another time, s."""
        self._stop = stop

    @property
    def next(self) -> float:
        """When the next sample is, or drives begin to act, s; the end of the run if there is none before."""
        return min(self._stop, *(one.next(self._stop) for one in self._controllers))

    def sampled(self, t: float, y: Vector) -> Vector:
        """Return the state with the drives as they are from time t (s) on, after what is to be sampled there."""
        before, y = y, y.copy()
        state = _SeenOnce(self._model, t, before)
        for one in self._controllers:
            values = one.at(t, self._stop, before, state)  # all read what was before any of them drove
            if values is not None:
                held = self._model.held[one.controller.name]
                y[self._first_held + held.start : self._first_held + held.stop] = values
        return y

    def snapshot(self) -> tuple[object, ...]:
        """Return what is needed to continue."""
        return tuple(one.snapshot() for one in self._controllers)

    def resume(self, snapshot: tuple[Any, ...]) -> None:
        """Continue from a snapshot, of this run or of another of the same scene."""
        for one, kept in zip(self._controllers, snapshot, strict=True):
            one.resume(kept)

    def growth(self, times: float) -> tuple[str, str] | None:
        """Return the description and the remedy of a run in which the drives of a controller have grown by a factor."""
        for one in self._controllers:
            grown = one.growth.grown(times)
            if grown is not None:
                controller = one.controller
                return (
                    f"controller {controller.name!r} now changes {controller.drives[grown.drive]!r} by "
                    f"{grown.change:.2g} from one sample to the next, {grown.times:.2g} times as much as at the start: "
                    "the sampled loop may be unstable",
                    f"smaller gains or a shorter every= of controller {controller.name!r} (now {controller.every:g} s)",
                )
        return None

    def logs(self) -> dict[str, ControllerLog]:
        """Return all samples so far, by the names of the controllers."""
        return {one.controller.name: one.log() for one in self._controllers}


class _SeenOnce:
    """The state of a scene at a time, made on request: joints are read without it."""

    def __init__(self, model: Model, t: float, y: Vector) -> None:
        self._given = model, t, y
        self._state: SceneState | None = None

    def __call__(self) -> SceneState:
        if self._state is None:
            model, t, y = self._given
            self._state = model.route.state(t, y)
        return self._state


class _Sampled:
    """One controller in a run."""

    def __init__(self, model: Model, controller: Controller, start: float, together: float) -> None:
        self.controller, self._start, self._together = controller, start, together
        self._count = 0
        self._memory: dict[str, Any] = {}
        self._late: deque[tuple[float, Vector]] = deque()
        self._times: list[float] = []
        self._reads: list[Vector] = []
        self._drives: list[Vector] = []
        self._readers = [reader(model, reading) for reading in controller.reads]
        self.growth = DriveGrowth(controller.drive_count)

    @property
    def _time(self) -> float:
        return self._start + self._count * self.controller.every

    def next(self, stop: float) -> float:
        """When something is to be done, s; infinite for never."""
        sample = self._time if self._time < stop - END_SHARE * self.controller.every else math.inf
        return min(sample, self._late[0][0] if self._late else math.inf)

    def at(self, t: float, stop: float, y: Vector, state: Callable[[], SceneState]) -> Vector | None:
        """Sample if that is due; return the drives that begin to act now, None if there are none."""
        acting: Vector | None = None
        due = t + self._together
        while self._late and self._late[0][0] <= due:
            acting = self._late.popleft()[1]
        if self._time > due or self._time >= stop - END_SHARE * self.controller.every:
            return acting
        reads = np.array([read(t, y, state) for read in self._readers])
        values = self._called(t, reads)
        self._times.append(t)
        self._reads.append(reads)
        self._drives.append(values)
        self.growth.add(values)
        self._count += 1
        if self.controller.delay == 0.0:
            return values
        self._late.append((t + self.controller.delay, values))
        return acting

    def snapshot(self) -> tuple[object, ...]:
        """Return what is needed to continue; lists that only grow are represented by their length."""
        return self._count, deepcopy(self._memory), tuple(self._late), self._times, self._reads, self._drives

    def resume(self, snapshot: tuple[Any, ...]) -> None:
        """Continue from a snapshot."""
        count, memory, late, times, reads, drives = snapshot
        self._count, self._memory, self._late = count, deepcopy(memory), deque(late)
        self._times, self._reads, self._drives = times[:count], reads[:count], drives[:count]

    def _called(self, t: float, reads: Vector) -> Vector:
        controller = self.controller
        given = controller.function(t, reads.copy(), self._memory)
        try:
            values = np.atleast_1d(np.asarray(given, dtype=float))
        except (TypeError, ValueError):
            values = np.zeros(0)
        if values.shape != (controller.drive_count,) or not np.all(np.isfinite(values)):
            wanted = "one finite number" if controller.drive_count == 1 else f"{controller.drive_count} finite numbers"
            raise ModelError(
                f"controller {controller.name!r} must give {wanted} ({', '.join(controller.drives)}); at t = {t:.6g} s "
                f"it gave {given!r}"
            )
        return values

    def log(self) -> ControllerLog:
        """Return all samples so far."""
        controller = self.controller
        return ControllerLog(
            np.array(self._times),
            np.array(self._reads).reshape(-1, len(controller.reads)),
            np.array(self._drives).reshape(-1, controller.drive_count),
            tuple(reading.label for reading in controller.reads),
            controller.drives,
        )


def reader(model: Model, reading: Reading) -> Read:
    """Return what reads one number of a state."""
    i, body = reading.component, model.bodies[model.index(reading.body)]
    n = model.coordinate_count
    if reading.what == "joint_coordinates":
        at = int(body.coordinates[i])
        if at >= 0:
            return lambda t, y, state: float(y[at])
        return lambda t, y, state: float(state().joint_coordinates(reading.body)[i])
    if reading.what == "joint_speeds":
        speed = int(body.speeds[i])
        if speed < model.free_count:
            return lambda t, y, state: float(y[n + speed])
        return lambda t, y, state: float(state().joint_speeds(reading.body)[i])
    if reading.what == "modal_coordinates":
        return lambda t, y, state: float(state().modal_coordinates(reading.body)[i])
    if reading.what == "modal_speeds":
        return lambda t, y, state: float(state().modal_speeds(reading.body)[i])
    if reading.what == "deflection":
        frame = model.flexible_terms(reading.body).body.interface(reading.interface)
        return lambda t, y, state: float(frame.displacements(state().modal_coordinates(reading.body)[None])[0, i])
    vector = partial(_VECTORS[reading.what], model, reading)

    def read(t: float, y: Vector, state: Callable[[], SceneState]) -> float:
        value = vector(t, y, state())
        if reading.is_own:
            value = state().rotation(reading.body, reading.interface).T @ value
        return float(value[i])

    return read


def _position(model: Model, reading: Reading, t: float, y: Vector, state: SceneState) -> Vector:
    return state.position(reading.body, reading.interface)


def _rotation(model: Model, reading: Reading, t: float, y: Vector, state: SceneState) -> Vector:
    return rotation_vector(euler_parameters_from_matrix(state.rotation(reading.body, reading.interface)))


def _velocity(model: Model, reading: Reading, t: float, y: Vector, state: SceneState) -> Vector:
    return state.velocity(reading.body, reading.interface)


def _angular_velocity(model: Model, reading: Reading, t: float, y: Vector, state: SceneState) -> Vector:
    A = state.rotation(reading.body, reading.interface)
    return np.asarray(A @ state.angular_velocity(reading.body, reading.interface))


def _acceleration(model: Model, reading: Reading, t: float, y: Vector, state: SceneState) -> Vector:
    return _accelerations(model, reading, t, y)[0]


def _angular_acceleration(model: Model, reading: Reading, t: float, y: Vector, state: SceneState) -> Vector:
    return _accelerations(model, reading, t, y)[1]


def _accelerations(model: Model, reading: Reading, t: float, y: Vector) -> tuple[Vector, Vector]:
    """Return the accelerations of a frame in N, with the drives as they were before the sample."""
    route, du = model.route, model.parts(model.route.evaluate(t, y).rates)[1]
    view, du = route.acting(t, y, du)
    rates = np.concatenate((du, view.driven_rates))
    frame = None
    if reading.interface:
        frame = view.model.flexible_terms(reading.body).body.interface(reading.interface)
    F = view.motion(model.index(reading.body), frame)
    return F.A_NF @ (F.V @ rates + F.Z), F.A_NF @ (F.W @ rates + F.Y)


_VECTORS: dict[str, Callable[..., Vector]] = {
    "position": _position,
    "rotation": _rotation,
    "velocity": _velocity,
    "angular_velocity": _angular_velocity,
    "acceleration": _acceleration,
    "angular_acceleration": _angular_acceleration,
}
