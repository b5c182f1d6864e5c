"""Drift of energy and momenta in free flight over a million steps of fixed size."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from kanefe.checks.robustness.bodies import lattice
from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import long_methods, stepped_run
from kanefe.equations.model import Model
from kanefe.frames import Vector
from kanefe.integrate.trajectory import Trajectory
from kanefe.joints import Free, Spherical
from kanefe.system import System

STEPS = 1_000_000
LIMIT = 1e-10
REASON = "the goal for 1e6 steps of free flight"
SAMPLES = 200
"""Number of samples of each run at which the invariants are evaluated."""


def tumbling_pair() -> Model:
    """Return two asymmetric rigid bodies joined by a ball joint, tumbling freely at 3 rad/s."""
    scene = System()
    first = scene.add_rigid_body(
        "first",
        2.0,
        (0.1, 0.2, 0.25),
        com=(0.05, 0.0, 0.02),
        joint=Free(angular_velocity=(0.2, 3.0, 0.1)),
    )
    scene.add_rigid_body(
        "second",
        1.0,
        (0.03, 0.05, 0.06),
        com=(0.2, 0.05, 0.0),
        parent=first,
        at=(0.3, 0.0, 0.1),
        joint=Spherical(angular_velocity=(1.0, -0.5, 0.7)),
    )
    return at_rest(scene.freeze())


def tumbling_lattice() -> Model:
    """Return a free flexible body, 1 m long and deformed by some centimetres, tumbling at 1 rad/s."""
    scene = System()
    scene.add_flexible_body("lattice", lattice(1, {}, modes=4), joint=Free(angular_velocity=(0.3, 1.0, 0.2)))
    model = scene.freeze()
    q = model.initial_coordinates.copy()
    q[model.flexible_terms("lattice").eta] = (0.05, -0.04, 0.03, 0.03)
    return at_rest(replace(model, initial_coordinates=q))


def at_rest(model: Model) -> Model:
    """Return the model with its centre of mass at rest, so that it stays near N's origin, to which momenta refer."""
    u = model.initial_speeds.copy()
    linear, _ = model.literal.momenta(0.0, np.concatenate((model.initial_coordinates, u)))
    u[model.bodies[0].speeds[:3]] -= linear / mass_of(model)
    return replace(model, initial_speeds=u)


def mass_of(model: Model) -> float:
    """Return the mass of the scene in kg."""
    return sum(b.flexible.body.mass if b.flexible else b.rigid.mass if b.rigid else 0.0 for b in model.bodies)


FLIGHTS: dict[str, tuple[Callable[[], Model], float]] = {
    "two rigid bodies on a ball joint, tumbling": (tumbling_pair, 1e-3),
    "a soft flexible body, strained and tumbling": (tumbling_lattice, 2e-4),
}
"""Scenes with steps (s) of about a thousandth of the period of the fastest motion."""


def invariants(model: Model, run: Trajectory) -> tuple[Vector, Vector, Vector]:
    """Return energy (T,), linear momentum (T, 3) and angular momentum (T, 3) of a run, in SI units."""
    states = zip(run.times.tolist(), run.coordinates, run.speeds, strict=True)
    found = [(t, np.concatenate((q, u))) for t, q, u in states]
    rows = [(model.energy(t, y).total, *model.literal.momenta(t, y)) for t, y in found]
    energy, linear, angular = (np.array(column) for column in zip(*rows, strict=True))
    return energy, linear, angular


def free_flight(effort: Effort) -> Iterator[Finding]:
    """Yield the drift of energy and momenta in free flight."""
    for method in long_methods(effort.method):
        for name, (scene, step) in FLIGHTS.items():
            yield from _drifts(name, scene(), step, method, effort.count(STEPS, 20_000))


def _drifts(name: str, model: Model, step: float, method: str, count: int) -> Iterator[Finding]:
    energy, linear, angular = invariants(model, stepped_run(model, count, step, method, SAMPLES))
    # the total momentum is zero: it is compared with that of the mass at the speed of the parts
    thrust = np.sqrt(2.0 * mass_of(model) * energy[0])
    drifts = {
        "energy": np.abs(energy - energy[0]) / energy[0],
        "linear momentum": np.abs(linear - linear[0]).max(axis=1) / thrust,
        "angular momentum": np.abs(angular - angular[0]).max(axis=1) / np.linalg.norm(angular[0]),
    }
    for what, drift in drifts.items():
        yield Finding(
            f"free flight of {name}, {count:.0e} steps of {step:g} s",
            count,
            f"drift of {what}, relative",
            float(drift.max()),
            LIMIT,
            REASON,
            method,
        )
    # the error of a method that conserves energy on average oscillates; a growing mean is drift
    early, late = (drifts["energy"][part].mean() for part in (slice(1, SAMPLES // 10), slice(-SAMPLES // 10, None)))
    yield Finding(
        f"free flight of {name}, growth over {count:.0e} steps",
        count,
        "late less early drift, relative",
        float(late - early),
        LIMIT,
        "a growing drift exceeds the goal some time later",
        method,
    )


CASES = (StressCase("drift", "energy and momentum drift over 1e6 steps", free_flight),)
