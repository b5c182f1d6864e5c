"""A soft noodle, thrown by a force and a torque on one end, tumbles and flaps through free flight.

The noodle of Simo & Vu-Quoc (Comput. Methods Appl. Mech. Eng. 66, 1988) as one exact beam in 24 coordinates of its
strains: its ends turn against each other by more than a right angle. The push ends after 5 s.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
from kanefe_fem import Section, exact_beam, recover

soft = Section.from_stiffness(EA=1e4, EI_y=500.0, EI_z=500.0, GJ=500.0, rho_A=1.0, rho_I=10.0)
lower, upper = np.array((6.0, 0.0, 0.0)), np.array((0.0, 0.0, 8.0))
along, across = (upper - lower) / 10.0, np.array((0.0, 1.0, 0.0))
noodle = exact_beam(10.0, soft, basis=8, axes=np.column_stack((along, across, np.cross(along, across))))


def push(t: float) -> float:
    """Return the torque of the throw in N m: up to 200 after half of its 5 s, and down again."""
    return 80.0 * max(0.0, min(t, 5.0 - t))


scene = kf.System()
flying = scene.add_flexible_body("noodle", noodle, at=lower, joint=kf.Free())
end = flying.interface("root")
scene.add_force(end, lambda t: (push(t) / 10.0, 0.0, 0.0))
scene.add_torque(end, lambda t: (0.0, push(t) / 2.0, push(t)))
result = scene.simulate((0.0, 10.0), rtol=1e-8, output_step=0.05)

bending = recover(result, "noodle").section_forces(41)
moment = np.linalg.norm(bending.forces[:, 0, :, 4:], axis=-1)
turned = np.degrees(np.linalg.norm(result.deflection("noodle", "tip")[:, 3:], axis=1))
flight = result.times >= 5.0
momentum = result.momentum.linear[flight][:, 0]
spin = result.momentum.angular[flight]
drift = np.abs(spin - spin[0]).max() / np.linalg.norm(spin[0])
print(f"the ends turn against each other by up to {turned.max():.0f} degrees")
print(f"bending moment up to {moment.max():.0f} N m, {moment[flight].max():.0f} N m in free flight")
print(f"momentum {momentum[0]:.6f} N s; the angular momentum drifts by {drift:.0e} in free flight")

shapes = result.nodal_positions("noodle")
figure, axes = plt.subplots(figsize=(9, 3), layout="constrained")
for row in range(0, len(shapes), 10):
    shade = plt.cm.viridis(0.9 * row / len(shapes))
    label = f"{result.times[row]:.0f} s" if row % 40 == 0 else None
    axes.plot(shapes[row, :, 0], shapes[row, :, 2], color=shade, label=label)
    axes.plot(*shapes[row, 0, [0, 2]], "o", color=shade, markersize=4)
axes.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
figure.legend(loc="outside upper center", ncols=6)
out = Path("out")
out.mkdir(exist_ok=True)
figure.savefig(out / "flying_noodle.png", dpi=120)

# The throw gives the momentum of its impulse, whatever the noodle does.
checked = (momentum[-1], 50.0, 1e-5)  # N s
