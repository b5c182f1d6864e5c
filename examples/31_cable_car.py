"""A cabin is hauled up along a slack track rope, from standstill to cruise and to a stop at the upper tower.

The track rope is an exact beam of low bending stiffness, which a counterweight tightens over a sheave; the carriage
runs on it by `kf.Guide`, and a winch draws in the haul rope (`kf.Rope` of commanded length). The run starts from the
rest that `kf.equilibrium` finds.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
from kanefe_fem import Section, exact_beam

SPAN, RISE, HANGER = 40.0, 12.0, 2.0  # m
LENGTH = float(np.hypot(SPAN, RISE))
CARRIAGE, CABIN, COUNTERWEIGHT, GRAVITY = 30.0, 150.0, 1500.0, 9.81  # kg, m/s2
FIRST, LAST, RAMP, CRUISE = 6.0, 34.0, 5.0, 9.0  # m along the rope, s

along = np.array((SPAN, 0.0, RISE)) / LENGTH
across = np.array((-along[2], 0.0, along[0]))
axes = np.column_stack((along, across, np.cross(along, across)))
# stiffer in bending than a real rope, so that the bend under the carriage is as wide as the functions along it resolve
rope = Section.from_stiffness(EA=1e7, EI_z=5e3, rho_A=3.0)
damping = kf.RayleighDamping(stiffness=0.02)
track = exact_beam(LENGTH, rope, planar=True, basis=kf.BSpline(3, 12), axes=axes, damping=damping)

scene = kf.System(gravity=(0.0, 0.0, -GRAVITY))
cable = scene.add_flexible_body("track", track, joint=kf.Revolute("y"))
sheave = scene.ground.frame(at=tuple((LENGTH + 2.0) * along))
below = tuple((LENGTH + 2.0) * along + np.array((0.5, 0.0, -5.0)))
weight = scene.add_point("counterweight", COUNTERWEIGHT, at=below, joint=kf.Prismatic("z"))
tight = {"axial_stiffness": 5e6, "damping": 5e5, "preload": COUNTERWEIGHT * GRAVITY}
scene.add(kf.Rope("tension", (cable.interface("tip"), sheave, weight), **tight))

carriage = scene.add_point("carriage", CARRIAGE, joint=kf.Translation(position=tuple(FIRST * along)))
last = len(track.nodes) - 1
rail = [cable.node(i) for i in np.linspace(0, last, 19).round().astype(int).tolist()]
scene.add(kf.Guide("wheels", (carriage, *rail), stiffness=2e5, damping=2e3, drag=5.0))
scene.add_rigid_body("cabin", CABIN, 60.0, parent=carriage, com=(0.0, 0.0, -HANGER), joint=kf.Revolute("y"))


def ramp(t: np.ndarray) -> np.ndarray:
    """Return the way from standstill to 1 m/s, m: the speed follows a polynomial of the fifth degree."""
    s = np.clip(t / RAMP, 0.0, 1.0)
    return RAMP * s**4 * (2.5 - 3.0 * s + s**2) + np.maximum(t - RAMP, 0.0)


times = np.linspace(0.0, 26.0, 131)
speed = (LAST - FIRST) / (RAMP + CRUISE)
drawn_in = speed * (ramp(times) - ramp(times - RAMP - CRUISE))
tower, drum = scene.ground.frame(at=(SPAN, 0.0, RISE)), scene.ground.frame(at=(SPAN, 0.0, RISE - 3.0))
length = kf.Motion.table(times, 3.0 + LENGTH - FIRST - 0.05 - drawn_in)
scene.add(kf.Rope("haul", (drum, tower, carriage), axial_stiffness=1e6, damping=1e5, length=length))

rest = kf.equilibrium(scene, steady=False)  # at one time: the winch moves later
result = scene.simulate((0.0, 26.0), start=rest.state, output_step=0.1, rtol=1e-4)

shapes, carried = result.nodal_positions("track"), result.position("carriage")
sag = -(shapes @ across).min(axis=1)
swing = np.degrees(result.joint_coordinates("cabin")[:, 0])
haul = result.load("haul", "tension")
lost = np.abs(result.energy.balance_error).max()
string = (GRAVITY * (CARRIAGE + CABIN) / 4.0 + GRAVITY * 3.0 * LENGTH / 8.0) * SPAN / (COUNTERWEIGHT * GRAVITY)
print(result)
print(f"the track sags by up to {sag.max():.2f} m across, a string of that tension by {string:.2f} m")
print(f"the haul rope pulls {haul[0]:.0f} N at rest, {haul.max():.0f} N at most and {haul[-1]:.0f} N at the end")
print(f"the cabin goes at {speed:.1f} m/s and swings by up to {np.abs(swing).max():.1f} degrees")
print(f"the winch does {1e-3 * result.energy.work[-1]:.1f} kJ; the energy balance is off by {lost:.1e} J")

figure, (view, pulls, swings) = plt.subplots(3, 1, figsize=(8, 7), height_ratios=(3, 1, 1), layout="constrained")
view.plot(*np.transpose(((0.0, 0.0), (SPAN, RISE))), ":", color="0.6", linewidth=0.8)
for row in range(0, len(shapes), 40):
    shade = plt.cm.viridis(0.9 * row / len(shapes))
    turned = np.radians(swing[row])
    hung = carried[row] - HANGER * np.array((np.sin(turned), 0.0, np.cos(turned)))
    view.plot(shapes[row, :, 0], shapes[row, :, 2], color=shade, label=f"{result.times[row]:.0f} s")
    view.plot(*np.transpose((carried[row], hung))[[0, 2]], "o-", color=shade, linewidth=0.8, markersize=4)
view.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
figure.legend(loc="outside upper center", ncols=7)
pulls.plot(result.times, haul)
pulls.set(ylabel="haul rope [N]")
swings.plot(result.times, swing)
swings.set(xlabel="time [s]", ylabel="swing [degrees]")
out = Path("out")
out.mkdir(exist_ok=True)
figure.savefig(out / "cable_car.png", dpi=120)

# What the winch, springs, weights and dampers exchange is in balance, to rtol of what the winch does, 14 kJ.
checked = (lost, 0.0, 1.4)  # J
