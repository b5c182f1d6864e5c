"""Control of a flexible arm: LQR and observer designed with python-control, on a scene that is stepped.

The arm of the demonstration, with 2 kg at its tip, is linearised, sampled at 100 Hz, and given a linear quadratic
regulator with a Kalman filter that measures the angle of the hub and the deflection of the tip. It controls the full
scene, with large rotations, all modes and a limited torque, through ``sim.step``; a PD controller that measures the
hub only is run for comparison.
"""

from pathlib import Path

import control
import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
from kanefe_fem.demo import beam_arm

DT, END, TARGET, MOST = 0.01, 2.0, 0.5, 15.0  # s, s, rad, N m

scene = kf.System(gravity=(0, 0, -9.81))
hub = scene.add_rigid_body("hub", mass=4.0, inertia=(0.02, 0.02, 0.03), joint=kf.Revolute("z"))
arm = scene.add_flexible_body("arm", beam_arm(), parent=hub, at=(0.1, 0, 0))
tip = scene.add_rigid_body("tip", mass=2.0, inertia=(2e-4, 2e-4, 2e-4), parent=arm.interface("tip"))

MEASURED = ("joint_coordinates hub", "deflection arm/tip y")
plant = kf.equilibrium(scene).linearise(inputs="motor hub", outputs=(*MEASURED, "position arm/tip y"))
sampled = control.sample_system(plant.to_control(), DT)
measures = control.ss(sampled.A, sampled.B, sampled.C[:2], sampled.D[:2], DT)

# cost: position and deflection of the tip; noise levels of the filter: 0.1 mrad, 0.1 mm, and torques of 0.3 N m
weighed = np.diag((0.0, 100.0, 100.0)) @ sampled.C
gain, _, _ = control.dlqr(sampled.A, sampled.B, weighed.T @ weighed, [[0.3]])
observer, _, _ = control.dlqe(sampled.A, sampled.B, measures.C, [[0.1]], 1e-8 * np.eye(2))


def quadratic() -> tuple[np.ndarray, np.ndarray]:
    """Return times, angle, deflection and torque with regulator and observer."""
    x = np.zeros(len(sampled.A))
    goal = np.zeros(len(x))
    goal[plant.state_names.index("hub: angle [rad]")] = TARGET

    def law(measured: np.ndarray) -> float:
        nonlocal x
        x = x + observer @ (measured - measures.C @ x)
        torque = float(np.clip(-gain @ (x - goal), -MOST, MOST)[0])
        x = sampled.A @ x + sampled.B[:, 0] * torque
        return torque

    return run(law)


def derivative() -> np.ndarray:
    """Return the same with a PD controller on the hub."""
    before = 0.0

    def law(measured: np.ndarray) -> float:
        nonlocal before
        rate, before = (measured[0] - before) / DT, measured[0]
        return float(np.clip(90.0 * (TARGET - measured[0]) - 16.0 * rate, -MOST, MOST))

    return run(law)


def run(law) -> np.ndarray:
    """Return times, angle, deflection and torque of the scene under a law, (T, 4)."""
    sim = scene.start(inputs="motor hub", outputs=MEASURED, every=DT, rtol=1e-5)
    rows = []
    while sim.time < END - 0.5 * DT:
        measured = np.array(list(sim.outputs.values()))
        torque = law(measured)
        rows.append((sim.time, *measured, torque))
        sim.step(DT, {"motor hub": torque})
    return np.array(rows)


runs = {"LQR and observer": quadratic(), "PD on the hub": derivative()}
figure, axes = plt.subplots(3, 1, figsize=(7.0, 6.0), sharex=True, layout="constrained")
for name, rows in runs.items():
    for column, axis, scale in zip((1, 2, 3), axes, (1.0, 1e3, 1.0), strict=True):
        axis.plot(rows[:, 0], scale * rows[:, column], label=name, drawstyle="steps-post" if column == 3 else "default")
for axis, label in zip(axes, ("hub angle [rad]", "tip bent aside [mm]", "torque [N m]"), strict=True):
    axis.set_ylabel(label)
    axis.grid(color="0.9")
axes[0].axhline(TARGET, color="0.6", linewidth=0.8)
axes[0].legend()
axes[2].set_xlabel("t [s]")
Path("out").mkdir(exist_ok=True)
figure.savefig(Path("out") / "control_of_an_arm.png", dpi=120)

late = {name: float(np.ptp(rows[rows[:, 0] > 1.0, 2])) for name, rows in runs.items()}
for name, swing in late.items():
    print(f"{name}: the tip swings by {1e3 * swing:.3f} mm after 1 s, the hub is at {runs[name][-1, 1]:.5f} rad")

checked = (float(runs["LQR and observer"][-1, 1]), TARGET, 1e-3)  # rad
