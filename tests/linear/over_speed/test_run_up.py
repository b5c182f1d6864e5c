"""A rotor that runs up through its critical speed, against its equations of motion integrated by scipy."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

import kanefe as kf

MASS, STIFFNESS, DAMPING, OFFSET = 5.0, 2e5, 40.0, 1e-4
RATE = np.sqrt(STIFFNESS / MASS)
"""rad/s."""

RISE, STOP = 150.0, 3.0
"""Angular acceleration, rad/s2, and how long: to 2.25 times the critical speed."""

SPEEDS = np.array((0.0, 200.0, 500.0))
CROSS = 20.0
"""Cross-coupled stiffness over the speed, N/m per rad/s: between the speeds of a table it grows evenly too."""


def rotor() -> kf.System:
    """Return an unbalanced disc in a bearing whose coefficients follow its speed."""
    scene = kf.System()
    slide = scene.add_frame("slide", joint=kf.Prismatic("y"))
    centre = scene.add_frame("centre", parent=slide, joint=kf.Prismatic("z"))
    run_up = kf.Motion(lambda t: 0.5 * RISE * t**2, lambda t: RISE * t, lambda t: RISE)
    spin = kf.Revolute("x", motion=run_up)
    disc = scene.add_rigid_body("disc", MASS, (0.02, 0.01, 0.01), com=(0.0, OFFSET, 0.0), parent=centre, joint=spin)
    turns = np.array(((0.0, 1.0), (-1.0, 0.0)))
    stiffness = [STIFFNESS * np.eye(2) + CROSS * speed * turns for speed in SPEEDS]
    scene.add(kf.Bearing("film", (scene.ground, disc), stiffness, 3 * [DAMPING * np.eye(2)], speeds=SPEEDS))
    return scene


def orbit(times: np.ndarray) -> np.ndarray:
    """Return r = y + i z of the disc, ``m r'' + c r' + (k - i c_k W) r = m e (W^2 - i dW/dt) exp(i angle)``.

    Newton's law of the centre of mass, r + e exp(i angle).
    """

    def rates(t, x):
        speed = RISE * t
        push = MASS * OFFSET * (speed**2 - 1j * RISE) * np.exp(0.5j * RISE * t**2)
        return x[1], (push - DAMPING * x[1] - (STIFFNESS - 1j * CROSS * speed) * x[0]) / MASS

    found = solve_ivp(rates, (0.0, STOP), np.zeros(2, complex), method="DOP853", t_eval=times, rtol=1e-10, atol=1e-16)
    return found.y[0]


def test_a_rotor_runs_up_through_its_critical_speed():
    result = rotor().simulate((0.0, STOP), output_step=2e-3, rtol=1e-9, atol=1e-12)
    expected = orbit(result.times)
    found = result.joint_coordinates("slide")[:, 0] + 1j * result.joint_coordinates("centre")[:, 0]
    peak = np.abs(expected).max()
    # ten times the tolerance of a step, and as much again for other machines
    np.testing.assert_allclose(found, expected, atol=2e-8 * peak)
    at = np.abs(found).argmax()
    assert at == np.abs(expected).argmax()
    # a run-up peaks later and lower than what stands (Lewis, Trans. ASME 54, 1932)
    assert RISE * result.times[at] > 1.02 * RATE
    assert peak < 0.5 * OFFSET * RATE * MASS / (DAMPING - CROSS)
