"""A hanging chain of 20 links, run with fixed Runge-Kutta steps: the time per step, and the drift of the energy."""

import math

import numpy as np

import kanefe as kf

links, length, mass, step = 20, 0.1, 0.2, 1e-3  # -, m, kg, s

scene = kf.System(gravity=(0, -9.81, 0))
link = None
for i in range(links):
    # each hangs along its -y axis; the chain starts straight, at 60 degrees
    joint = kf.Revolute("z", position=math.pi / 3 if i == 0 else 0.0)
    link = scene.add_rigid_body(
        f"link {i}",
        mass,
        mass * length**2 / 12,
        com=(0, -length / 2, 0),
        parent=link,
        at=(0, -length, 0) if i else (0, 0, 0),
        joint=joint,
    )
scene.simulate((0.0, 10 * step), method="rk4", step=step)  # compiles the kernels, or loads them
result = scene.simulate((0.0, 2.0), method="rk4", step=step)

steps, seconds = result.statistics["steps"], result.statistics["seconds"]
print(f"{links} links, {round(2.0 / step)} steps of {1e3 * step:g} ms in {1e3 * seconds:.1f} ms")
print(f"that is {1e6 * seconds / round(2.0 / step):.1f} us a step, {2.0 / seconds:.0f} times real time")
energy = result.energy.total
print(f"of a swing of {np.ptp(result.energy.kinetic):.3f} J the energy drifts by {np.ptp(energy):.1e} J")

checked = (energy[-1], energy[0], 1e-6)  # J
