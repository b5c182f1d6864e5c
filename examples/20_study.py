"""A study: how often the load of a crane swings too far, for several speeds and rope lengths, in random wind.

A trolley is driven from rest to a speed in one second; its load hangs on a rigid rope and is pushed by gusts of wind,
which each seed draws anew. Each combination of speed, rope and seed is a run, of which only the largest angle is kept.
A script runs a study on all cores under ``if __name__ == "__main__":``, since each worker imports it; with
``executor="serial"``, as here, this is not needed.
"""

import math
from pathlib import Path

import numpy as np

import kanefe as kf

G, MASS, GUST = 9.81, 800.0, 150.0  # m/s2, kg, N


def crane(speed: float, rope: float, seed: int | None) -> kf.System:
    """Return a trolley that starts, and its load in the wind; without a seed there is none."""
    scene = kf.System(gravity=(0, 0, -G))
    times = np.linspace(0.0, 10.0, 1001)
    way = speed * np.where(times < 1.0, 0.5 * times**2, times - 0.5)
    trolley = scene.add_rigid_body("trolley", 300.0, joint=kf.Prismatic("x", motion=kf.Motion.table(times, way)))
    load = scene.add_rigid_body("load", MASS, 1.0, com=(0, 0, -rope), parent=trolley, joint=kf.Revolute("y"))
    if seed is not None:
        generator = np.random.default_rng(seed)
        phases, rates = generator.uniform(0.0, 2.0 * math.pi, 8), np.linspace(0.5, 3.0, 8)
        hook = load.frame(at=(0, 0, -rope))
        scene.add_force(hook, lambda t: (GUST * np.sin(rates * t + phases).sum() / 2.0, 0.0, 0.0))
    return scene


def swing(result: kf.Result) -> dict[str, float]:
    """Return the largest angle of the rope, in degrees."""
    return {"swing": float(np.degrees(np.abs(result.joint_coordinates("load")).max()))}


study = kf.Study(crane, swing, duration=8.0, rtol=1e-8, speed=[0.5, 1.0], rope=[4.0, 6.0], seed=range(6))
table = study.run(executor="serial", store=Path("out") / "crane")
print(table)

often = table.operability({"swing": 10.0})
for row in often.rows():
    estimate = f"P(swing > 10 degrees) = {row['fit probability']:.2f}, {row['fit probability low']:.2f} to "
    print(f"{row['speed']} m/s, {row['rope']} m: {estimate}{row['fit probability high']:.2f}")
often.to_html(Path("out") / "crane.html")

# without wind the load swings about an angle of a / g backwards, and then about the vertical
calm = kf.Study(crane, swing, duration=8.0, rtol=1e-8, speed=[0.1], rope=[4.0], seed=[None]).run(executor="serial")
arm = 4.0 + 1.0 / (MASS * 4.0)  # of a pendulum with the inertia of the load
turn = math.sqrt(G / arm) * 1.0  # rad in the second in which the trolley speeds up
closed = math.degrees(2.0 * (0.1 / G) * abs(math.sin(0.5 * turn)))  # of what is left when the speed is reached
late = math.degrees((0.1 / G) * (1.0 - math.cos(min(turn, math.pi))))  # and of the start itself
checked = (float(calm.column("swing")[0]), max(closed, late), 1e-3)  # between outputs: 6e-5
print(f"in calm air the load swings {checked[0]:.4f} degrees; closed form of small angles {checked[1]:.4f}")
