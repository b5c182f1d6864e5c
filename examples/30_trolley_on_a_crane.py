"""A trolley with a hanging load runs out along the jib of a crane, which bends under it and swings on.

The jib is one exact beam, and the trolley is held on it by the stiffness of its wheels (`kf.Guide`). It is pushed off
and rolls down the bent jib against its drag.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
from kanefe_fem import Material, Rectangle, exact_beam

LENGTH, TROLLEY, LOAD, ROPE = 12.0, 80.0, 400.0, 4.0  # m, kg, kg, m
alloy = Material(E=70e9, nu=0.33, rho=2700.0)
jib = exact_beam(LENGTH, Rectangle(0.15, 0.24), alloy, basis=6, damping=kf.ModalDamping(0.01))

scene = kf.System(gravity=(0.0, 0.0, -9.81))
crane = scene.add_flexible_body("jib", jib)
start = kf.Translation(position=(1.0, 0.0, 0.0), velocity=(1.5, 0.0, 0.0))
trolley = scene.add_point("trolley", TROLLEY, joint=start)
last = len(jib.nodes) - 1
rail = [crane.node(i) for i in (*range(0, last, 3), last)]
scene.add(kf.Guide("rail", (trolley, *rail), stiffness=2e6, damping=5e3, drag=20.0))
hook = kf.Revolute("y", position=0.0)
scene.add_rigid_body("load", LOAD, 10.0, parent=trolley, com=(0.0, 0.0, -ROPE), joint=hook)
result = scene.simulate((0.0, 5.0), output_step=0.02)

place = result.load("rail", "arc length")
sag = -result.position("jib", "tip")[:, 2]
swing = np.degrees(result.joint_coordinates("load")[:, 0])
lost = np.abs(result.energy.balance_error).max()
print(result)
print(f"the trolley runs from {place[0]:.2f} to {place[-1]:.2f} m, and the jib sags by up to {1e3 * sag.max():.0f} mm")
print(f"the load swings by up to {np.abs(swing).max():.1f} degrees; the energy balance is off by {lost:.1e} J")

shapes, carried = result.nodal_positions("jib"), result.position("trolley")
figure, (view, press) = plt.subplots(2, 1, figsize=(8, 5), height_ratios=(3, 2), layout="constrained")
for row in range(0, len(shapes), 50):
    shade = plt.cm.viridis(0.9 * row / len(shapes))
    hung = carried[row] + ROPE * np.array((-np.sin(np.radians(swing[row])), 0.0, -np.cos(np.radians(swing[row]))))
    view.plot(shapes[row, :, 0], shapes[row, :, 2], color=shade, label=f"{result.times[row]:.0f} s")
    view.plot(*np.transpose((carried[row], hung))[[0, 2]], "o-", color=shade, linewidth=0.8, markersize=4)
view.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
figure.legend(loc="outside upper center", ncols=6)
press.plot(place, 1e-3 * result.load("rail", "force"))
press.set(xlabel="place of the trolley on the jib [m]", ylabel="force of its wheels [kN]")
out = Path("out")
out.mkdir(exist_ok=True)
figure.savefig(out / "trolley_on_a_crane.png", dpi=120)

# What springs, weight, damping and drag exchange is in balance, to some millionths of the energy that moves.
checked = (lost, 0.0, 1e-2)  # J
