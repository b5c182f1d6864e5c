"""Scenes of the tests of the linear analysis."""

import numpy as np

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.integrate.run import integrate
from kanefe.linear.linearisation import Linearisation
from kanefe.literal.loop_closure import project_positions, project_speeds

GRAVITY = (0.0, 0.0, -9.81)
WEIGHTS = np.array((1.0, -8.0, 8.0, -1.0)) / 12.0
OFFSETS = (-2, -1, 1, 2)


def governor(speed: float | None, shaft_inertia: float = 0.01) -> kf.System:
    """Return a point mass on an arm of 0.5 m, hinged on a shaft that is driven, or free and given its speed later."""
    scene = kf.System(gravity=GRAVITY)
    joint = kf.Revolute("z") if speed is None else kf.Revolute("z", motion=kf.Motion.steady(speed))
    shaft = scene.add_rigid_body("shaft", 1.0, shaft_inertia, joint=joint)
    scene.add_rigid_body("arm", 1.0, 0.0, parent=shaft, com=(0, 0, -0.5), joint=kf.Revolute("y", position=0.3))
    return scene


def cart_and_rod(motion: kf.Motion | None = None) -> kf.System:
    """Return a cart of 2 kg on a spring, or driven, with a rod of 1 kg that hangs from it and is damped."""
    scene = kf.System(gravity=GRAVITY)
    spring = kf.CoordinateForce(stiffness=200.0, damping=1.0)
    joint = kf.Prismatic("x", forces=spring) if motion is None else kf.Prismatic("x", motion=motion)
    cart = scene.add_rigid_body("cart", 2.0, joint=joint)
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(damping=0.05))
    scene.add_rigid_body("rod", 1.0, 0.1, com=(0, 0, -0.5), parent=cart, joint=hinge)
    return scene


def state_beside(small: Linearisation, x: np.ndarray) -> np.ndarray:
    """Return a consistent state of the model at x of the linearisation, to second order."""
    model, t, n = small.model, small.time, small.model.coordinate_count
    y = small.moved(x)
    q = project_positions(model, t, y[:n])
    return np.concatenate((q, project_speeds(model, t, q, y[n:])))


def rates_of_run(small: Linearisation, step: float = 1e-3) -> np.ndarray:
    """Return the lower half of A by central differences of the accelerations, of the fourth order."""
    n, lead = small.model.coordinate_count, small.small.speeds.leading
    columns = []
    for i in range(len(small.A)):
        x = np.zeros(len(small.A))
        x[i] = step
        rates = [small.model.rhs(small.time, state_beside(small, k * x))[n:][lead] for k in OFFSETS]
        columns.append(WEIGHTS @ np.array(rates) / step)
    return np.array(columns).T


def run_beside(small: Linearisation, x: np.ndarray, stop: float) -> np.ndarray:
    """Return the state at the end of a run that starts at x of the linearisation."""
    from dataclasses import replace

    model: Model = small.model
    y = state_beside(small, x)
    n = model.coordinate_count
    start = replace(model, initial_coordinates=y[:n].copy(), initial_speeds=y[n:].copy())
    run = integrate(start, (0.0, stop), rtol=1e-11, atol=1e-13, method="dop853", progress=False)
    return np.concatenate((run.coordinates[-1], run.speeds[-1]))
