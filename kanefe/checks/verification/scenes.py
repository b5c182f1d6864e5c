"""Common functions of the cases: states of a run at given times, frames at a state, modes of a system at rest."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import scipy.linalg

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification.tolerance import scaled
from kanefe.equations.model import Model
from kanefe.errors import SimulationError, SimulationWarning
from kanefe.integrate.events.event import Event
from kanefe.integrate.run import integrate
from kanefe.integrate.trajectory import Trajectory
from kanefe.kane.assemble import assemble
from kanefe.states.kinematics import FrameMotion
from kanefe.states.state import State
from kanefe.system import System
from kanefe.tree.scene_state import SceneState
from kanefe.tree.tangents import constant_tangents

Sample = tuple[float, np.ndarray, np.ndarray]
"""Time in s, coordinates q and free speeds u."""


def states_at(
    model: Model, times: Sequence[float], rtol: float, atol: float | None = None, method: str = "dop853"
) -> list[Sample]:
    """Run a model once from t = 0 and return its states at these times (s), multiples of a common step.

    Raises
    ------
    SimulationError
        If the run fails.
    """
    step = _common_step(times)
    run = whole_run(model, (0.0, max(times)), rtol, atol=atol, method=method, output_step=step)
    rows = [round(t / step) for t in times]
    return [(float(run.times[i]), run.coordinates[i], run.speeds[i]) for i in rows]


def whole_run(
    model: Model, t_span: tuple[float, float], rtol: float, atol: float | None = None, **options: Any
) -> Trajectory:
    """Return a complete run with the tolerances of the case, scaled by ``kanefe verify --tol``."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SimulationWarning)  # the error contains it
        run = integrate(model, t_span, rtol=scaled(rtol), atol=atol and scaled(atol), progress=False, **options)
    run.raise_for_status()
    return run


def state_after(model: Model, t: float, rtol: float) -> Sample:
    """Return the state at one time t in s."""
    return states_at(model, [t], rtol)[0]


def zero_crossings(
    model: Model, quantity: Callable[[Sample], float], count: int, stop: float, rtol: float
) -> list[float]:
    """Return the first times in (0, stop) at which a quantity changes sign.

    Raises
    ------
    SimulationError
        If it changes sign less often.
    """
    n = model.coordinate_count

    def value(t: float, state: SceneState) -> float:
        y = state.vector
        return quantity((t, y[:n], y[n:]))

    run = whole_run(model, (0.0, stop), rtol, method="dop853", output_step=stop, events=Event("turn", value))
    found: list[float] = run.events["turn"].tolist()
    if len(found) < count:
        raise SimulationError(f"the motion turns {len(found)} times in {stop:g} s where {count} are expected")
    return found[:count]


def frame_at(model: Model, name: str, state: Sample) -> FrameMotion:
    """Return the motion of the frame (R or G) of a body at a state."""
    t, q, u = state
    return State(model, t, q, u).motion(model.index(name), None)


def displaced_node(model: Model, name: str, node: int, state: Sample) -> tuple[np.ndarray, np.ndarray]:
    """Return position in N and displacement in G of a node of a flexible body, each (3,) in m."""
    terms = model.flexible_terms(name)
    displacement = terms.body.node_displacements(state[1][terms.eta])[node]
    G = frame_at(model, name, state)
    return G.p_NoFo_N + G.A_NF @ (terms.body.nodes[node] + displacement), displacement


def system_modes(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Return natural frequencies (rad/s) and modes (free, modes) of an undeformed scene at rest, without gravity.

    M is that of the assembled Kane equations, K that of the unloaded bodies. Rigid motions come first, with
    frequencies of about zero.
    """
    q, u = model.initial_coordinates, np.zeros(model.free_count)
    mass, _ = assemble(State(model, 0.0, q, u))
    stiffness, _ = constant_tangents(model)
    return natural_modes(stiffness, mass)


def natural_modes(stiffness: np.ndarray, mass: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies in rad/s and mass-normal modes of (K, M), lowest frequency first."""
    scale = 1.0 / np.sqrt(np.diag(mass))  # with unit masses on the diagonal LAPACK loses fewer digits of low modes
    squares, modes = scipy.linalg.eigh(stiffness * np.outer(scale, scale), mass * np.outer(scale, scale))
    return np.sqrt(np.maximum(squares, 0.0)), scale[:, None] * modes


def _common_step(times: Sequence[float]) -> float:
    """Return the largest step, in whole nanoseconds, of which all times are multiples; a single time itself."""
    if len(times) == 1:
        return times[0]
    return math.gcd(*(round(t * 1e9) for t in times)) * 1e-9


def stretching_frequencies_with_tip_mass(body: FlexibleBody, mass: float) -> np.ndarray:
    """Return the frequencies (Hz) of axial vibration of a clamped bar along x with a point mass (kg) at its "tip"."""
    scene = System()
    bar = scene.add_flexible_body("bar", body)
    scene.add_rigid_body("tip", mass, parent=bar.interface("tip"))
    model = scene.freeze()
    frequencies, modes = system_modes(model)
    tip = np.abs(body.interface("tip").motion[:, : model.free_count] @ modes)
    return frequencies[tip[0] > 1e3 * tip[1]] / (2.0 * np.pi)
