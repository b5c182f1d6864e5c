"""Large rotations: ten thousand revolutions, slopes near a right angle, rotation vectors near a full turn."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from kanefe.bodies.slopes import SLOPE_MEASURES, SlopeMeasure
from kanefe.checks.robustness.bodies import lattice
from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import follow
from kanefe.equations.model import Model
from kanefe.frames import (
    axis_rotation,
    euler_parameters,
    euler_parameters_from_matrix,
    rotation_matrix,
    rotation_vector,
    skew,
)
from kanefe.joints import Free, Motion, Revolute
from kanefe.kane.assemble import accelerations
from kanefe.kane.energy import elastic_energy, kinetic_energy
from kanefe.states.state import State
from kanefe.system import System

RATE = 2.0 * math.pi
"""Angular velocity of one revolution per second, rad/s."""


def revolutions(effort: Effort) -> Iterator[Finding]:
    """Spin through many revolutions: a hinge, a free symmetric top, a driven arm."""
    turns = effort.count(10_000, 200)
    label = f"{turns} revolutions"
    scene = System()
    scene.add_rigid_body("disc", 1.0, 0.1, com=(0.2, 0.1, 0.0), joint=Revolute("z", speed=RATE))
    run = follow(scene.freeze(), turns, rtol=1e-10, output_step=turns / 10)
    error = np.abs(run.coordinates[:, 0] - RATE * run.times).max() / (RATE * turns)
    yield Finding(f"disc on a hinge, {label}", turns, "angle, relative", float(error), 1e-11, "round-off of the sums")
    yield _symmetric_top(turns, label)

    scene = System()
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=Revolute("z", motion=Motion.steady(RATE)))
    scene.add_rigid_body("arm", 1.0, 0.05, com=(0.5, 0, 0), parent=hub, at=(1, 0, 0), joint=Revolute("z", position=0.1))
    model = scene.freeze()
    first = model.rhs(0.137, model.initial_state)[-1]
    for count in (turns, 100 * turns):
        # its state is that of the hinge: only the angle of the hub, 2 pi count + a, is another one
        change = abs(model.rhs(count + 0.137, model.initial_state)[-1] / first - 1.0)
        yield Finding(
            f"pendulum on a hub that has been driven through {count} revolutions",
            count,
            "acceleration, relative",
            float(change),
            1e-15 * RATE * count + 1e-14,
            "known limit: in a plane the angles are added up, to the last bit of the largest",
        )


def _symmetric_top(turns: int, label: str) -> Finding:
    """Compare a free symmetric top with its closed form: precession about the angular momentum, spin about the axis."""
    A, C, spin, tilt = 1.0, 1.6, RATE, 0.4
    # body rates: constant along z, a circle across it
    across = C * spin * math.tan(tilt) / A
    scene = System()
    # H along z of N: the axis is tilted against it about x, so that the rate across lies along y of the body
    orientation = euler_parameters((1.0, 0.0, 0.0), tilt).tolist()
    joint = Free(orientation=orientation, angular_velocity=(0.0, across, spin))
    scene.add_rigid_body("top", 1.0, (A, A, C), joint=joint)
    model = scene.freeze()
    run = follow(model, turns, rtol=1e-12, method="dop853", output_step=turns / 10)
    precession = math.hypot(A * across, C * spin) / A
    own = spin - precession * math.cos(tilt)
    errors = []
    x, z = np.eye(3)[0], np.eye(3)[2]
    for t, q in zip(run.times.tolist(), run.coordinates, strict=True):
        exact = axis_rotation(z, precession * t) @ axis_rotation(x, tilt) @ axis_rotation(z, own * t)
        errors.append(float(np.abs(rotation_matrix(q[3:7]) - exact).max()))
    return Finding(
        f"free symmetric top, {label}, rtol 1e-12",
        turns,
        "direction cosines",
        max(errors),
        1e-7 * max(turns / 1e4, 0.1),
        "some ten steps a revolution, 1e-12 each, all on one side",
    )


def slopes(effort: Effort) -> Iterator[Finding]:
    """Convert and differentiate slopes beside the places where a measure of them is singular."""
    rng = np.random.default_rng(0)
    count = effort.count(2000, 200)
    angles, tangents, remainders, vectors, vector_tangents = [], [], [], [], []
    for i in range(count):
        gap = 10.0 ** rng.uniform(-16, 0) * rng.choice((-1, 1)) * (i % 10 > 0)
        theta = rng.uniform(-3, 3, 3)
        theta[1] = rng.choice((-1, 1)) * 0.5 * math.pi + gap
        measure = SLOPE_MEASURES["tait-bryan"]
        angles.append(_there_and_back(measure, theta))
        rates = rng.standard_normal(3)
        tangents.append(_tangent_error(measure, theta, rates))
        remainders.append(_remainder_error(measure, theta, rates))
        direction = rng.standard_normal(3)
        near = (2.0 * math.pi + gap) * direction / np.linalg.norm(direction)
        measure = SLOPE_MEASURES["rotation-vector"]
        vectors.append(_there_and_back(measure, near))
        vector_tangents.append(max(_tangent_error(measure, near, rates), _remainder_error(measure, near, rates)))
    place = "within 1 ... 1e-16 rad, and at it"
    reason = "differences of order 8 over 0.02 rad, and what they lose"
    for what, figure, errors, limit, why in (
        ("Tait-Bryan slopes near +-90 deg", "there and back, matrix", angles, 1e-13, "round-off"),
        ("Tait-Bryan slopes near +-90 deg", "tangent against differences", tangents, 1e-10, reason),
        ("Tait-Bryan slopes near +-90 deg", "remainder against differences", remainders, 1e-9, reason),
        ("rotation vectors near 2 pi", "there and back, matrix", vectors, 1e-13, "round-off"),
        ("rotation vectors near 2 pi", "tangents against differences", vector_tangents, 1e-9, reason),
    ):
        yield Finding.of(f"{what}, {place}", errors, figure, limit, why)
    full = [_vector_of_matrix(rng, 10.0 ** rng.uniform(-16, 0) * (i % 10 > 0)) for i in range(count)]
    yield Finding.of(
        f"rotations near half a turn, {place}: vector and parameters of a matrix", full, "matrix", 1e-13, "round-off"
    )
    for name, target in (("tait-bryan", 0.5 * math.pi), ("rotation-vector", 2.0 * math.pi)):
        yield _through_singular_slopes(name, target)
        yield _routes_beside(name, target, effort)


def _there_and_back(measure: SlopeMeasure, theta: np.ndarray) -> float:
    A = measure.rotation(theta)
    back = measure.rotation(measure.from_euler_parameters(euler_parameters_from_matrix(A)))
    return float(np.abs(back - A).max())


def _vector_of_matrix(rng: np.random.Generator, gap: float) -> float:
    axis = rng.standard_normal(3)
    A = axis_rotation(axis / np.linalg.norm(axis), math.pi - gap)
    theta = rotation_vector(euler_parameters_from_matrix(A))
    return float(np.abs(SLOPE_MEASURES["rotation-vector"].rotation(theta) - A).max())


OFFSETS = 0.02 * np.arange(-4, 5)
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]) / 0.02


def _tangent_error(measure: SlopeMeasure, theta: np.ndarray, rates: np.ndarray) -> float:
    """Compare ``w = T dtheta`` with the difference quotient of the matrix."""
    slope = np.tensordot(WEIGHTS, [measure.rotation(theta + s * rates) for s in OFFSETS], 1)
    spin = slope @ measure.rotation(theta).T
    return float(np.abs(skew(measure.tangent(theta) @ rates) - spin).max() / (1.0 + rates @ rates))


def _remainder_error(measure: SlopeMeasure, theta: np.ndarray, rates: np.ndarray) -> float:
    slope = np.tensordot(WEIGHTS, [measure.tangent(theta + s * rates) @ rates for s in OFFSETS], 1)
    return float(np.abs(measure.remainder(theta, rates) - slope).max() / (1.0 + rates @ rates))


def _bent_scene(name: str, target: float, off: float) -> Model:
    """Return a soft body whose tip, which carries a body, has slopes `off` rad before the singular place."""
    scene = System(slopes=name)
    arm = scene.add_flexible_body("arm", lattice(1, modes=2, spring=2.0), joint=Free(angular_velocity=(0.2, 0.1, -0.3)))
    scene.add_rigid_body(
        "tip", 0.4, (0.01, 0.012, 0.015), com=(0.05, 0.1, -0.02), parent=arm.interface("tip"), joint=Revolute((1, 2, 3))
    )
    model = scene.freeze()
    terms = model.flexible_terms("arm")
    slopes_of = terms.body.interface("tip").motion[3:, : terms.body.free_count]
    axis = np.array((0.0, 1.0, 0.0) if name == "tait-bryan" else (0.36, 0.48, 0.8))
    wanted = (target - off) * axis
    rates = 10.0 * axis
    q, u = model.initial_coordinates.copy(), model.initial_speeds.copy()
    q[terms.eta], u[terms.speeds] = (np.linalg.pinv(slopes_of) @ x for x in (wanted, rates))
    return replace(model, initial_coordinates=q, initial_speeds=u)


def _through_singular_slopes(name: str, target: float) -> Finding:
    """Let the slopes of an interface run through the singular place of their measure; energy shows every error."""
    model = _bent_scene(name, target, 0.05)
    run = follow(model, 0.05, rtol=1e-12, method="dop853", output_step=0.001)
    slopes_of = model.flexible_terms("arm").body.interface("tip").motion[3:]
    eta = run.coordinates[:, model.flexible_terms("arm").eta]
    theta = eta @ slopes_of[:, : eta.shape[1]].T
    size = theta[:, 1] if name == "tait-bryan" else np.linalg.norm(theta, axis=1)
    passes = int(np.count_nonzero(np.diff(np.sign(size - target))))
    energy = [
        kinetic_energy(state) + elastic_energy(state)
        for state in map(partial(State, model), run.times, run.coordinates, run.speeds)
    ]
    drift = float(np.ptp(energy) / abs(energy[0])) if passes else float("nan")
    degrees = round(math.degrees(target))
    return Finding(
        f"interface that turns through {degrees} deg with slopes={name!r}, rtol 1e-12",
        passes,
        "energy, relative",
        drift,
        1e-10,
        "a hundred steps of 1e-12",
        f"{run.statistics['steps']} steps",
    )


def _routes_beside(name: str, target: float, effort: Effort) -> Finding:
    """Compare both routes near the singular place, and at it."""
    errors = []
    for off in (0.0, *(10.0**-k for k in range(1, effort.count(16, 8)))):
        model = _bent_scene(name, target, off)
        q, u = model.initial_coordinates, model.initial_speeds
        swept, dense = model.rhs(0.0, model.initial_state)[len(q) :], accelerations(State(model, 0.0, q, u))
        errors.append(float(np.abs(swept - dense).max() / np.abs(dense).max()))
    degrees = round(math.degrees(target))
    return Finding.of(
        f"interface turned to {degrees} deg and 0.1 ... 1e-15 rad beside it, slopes={name!r}: both routes",
        errors,
        "accelerations, relative",
        1e-9,
        "round-off times the condition of the mass matrix",
    )


CASES = (
    StressCase("revolutions", "1e4 revolutions", revolutions),
    StressCase("slopes", "slopes near +-90 degrees, rotation vectors near 2 pi", slopes),
)
