"""A cable car is hauled up between two masts that bend, stops, and its cabin swings on.

The wheels of the carriage run on a track rope, over which it slides without friction (`kf.Rope` over a point). A winch
draws in the haul rope as commanded, from standstill to five metres a second and back to a stop.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
from kanefe_fem import Material, Tube, exact_beam

LOW, HIGH, MAST = (0.0, 0.0, 0.0), (160.0, 0.0, 60.0), 25.0  # feet of the masts and their height, m
CARRIAGE, CABIN, HANGER = 500.0, 2500.0, 4.0  # kg, kg, m
CRUISE, RAMP, SPAN = 5.0, 6.0, 34.0  # m/s, s, s

steel = Material(E=210e9, nu=0.3, rho=7850.0)
upright = ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))  # its x axis points up
mast = exact_beam(MAST, Tube(1.2, 0.02), steel, basis=4, axes=upright, damping=kf.ModalDamping(0.02))

scene = kf.System(gravity=(0.0, 0.0, -9.81))
TOPS = {"low": np.add(LOW, (0.0, 0.0, MAST)), "high": np.add(HIGH, (0.0, 0.0, MAST))}
tip_low, tip_high = TOPS.values()
low = scene.add_flexible_body("low", mast, at=LOW).interface("tip")
high = scene.add_flexible_body("high", mast, at=HIGH).interface("tip")
start = 0.15 * tip_high + 0.85 * tip_low - (0.0, 0.0, 6.0)
carriage = scene.add_point("carriage", CARRIAGE, joint=kf.Translation(position=tuple(start)))
hinge = kf.Revolute("y", forces=kf.CoordinateForce(damping=300.0))
scene.add_rigid_body("cabin", CABIN, 4000.0, parent=carriage, com=(0.0, 0.0, -HANGER), joint=hinge)

way = np.linalg.norm(start - tip_low) + np.linalg.norm(tip_high - start)
scene.add(kf.Rope("track", (low, carriage, high), axial_stiffness=1.2e8, damping=4e7, length=0.999 * way))
times = np.linspace(0.0, SPAN, 341)
ramp = np.clip(times / RAMP, 0.0, 1.0) - np.clip((times - 24.0) / RAMP, 0.0, 1.0)
speed = CRUISE * ramp**2 * (3.0 - 2.0 * ramp)
hauled = np.concatenate(((0.0,), np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(times))))
haul = kf.Motion.table(times, np.linalg.norm(tip_high - start) - hauled)
scene.add(kf.Rope("haul", (high, carriage), axial_stiffness=4e7, damping=2e7, length=haul))
rest = kf.equilibrium(scene, steady=False)  # at one time: the winch moves later
result = scene.simulate((0.0, SPAN), start=rest.state, output_step=0.05)
stop = kf.equilibrium(scene, t=SPAN, start=result.at(SPAN), steady=False)

place, swing = result.position("carriage"), np.degrees(result.joint_coordinates("cabin")[:, 0])
tension = {name: 1e-3 * result.load(name, "tension") for name in ("track", "haul")}
bent = {name: 1e3 * np.abs(result.position(name, "tip")[:, 0] - top[0]) for name, top in TOPS.items()}
print(result)
pulls = ", ".join(f"the {name} rope carries up to {values.max():.0f} kN" for name, values in tension.items())
print(f"the car is hauled by {hauled[-1]:.1f} m and up by {np.ptp(place[:, 2]):.1f} m; {pulls}")
print(f"the cabin swings by up to {np.abs(swing).max():.1f} degrees, at the end by {np.abs(swing[-80:]).max():.1f}")
print(f"the masts bend by {bent['low'].max():.0f} and {bent['high'].max():.0f} mm")
lifted = (CARRIAGE + CABIN) * 9.81 * (place[-1, 2] - place[0, 2])
print(f"work of the winch {1e-3 * result.energy.work[-1]:.1f} kJ, for a weight lifted by {1e-3 * lifted:.1f} kJ")

figure, (view, pull, turn) = plt.subplots(3, 1, figsize=(8, 8), height_ratios=(3, 1, 1), layout="constrained")
ends = [result.position(name, "tip")[0] for name in TOPS]
for name, foot in (("low", LOW), ("high", HIGH)):
    view.plot(*np.transpose((foot, TOPS[name]))[[0, 2]], color="0.4", linewidth=4)
for row in range(0, len(place), 170):
    shade = plt.cm.viridis(0.9 * row / len(place))
    hung = place[row] - HANGER * np.array((np.sin(np.radians(swing[row])), 0.0, np.cos(np.radians(swing[row]))))
    view.plot(*np.transpose((ends[0], place[row], ends[1]))[[0, 2]], color=shade, linewidth=0.8)
    view.plot(*np.transpose((place[row], hung))[[0, 2]], "o-", color=shade, label=f"{result.times[row]:.0f} s")
view.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
figure.legend(loc="outside upper center", ncols=6)
for name, values in tension.items():
    pull.plot(result.times, values, label=f"{name} rope")
pull.set(ylabel="tension [kN]", ylim=(0.0, None))
pull.legend(loc="center")
turn.plot(result.times, swing)
turn.set(xlabel="time [s]", ylabel="swing [degrees]")
out = Path("out")
out.mkdir(exist_ok=True)
figure.savefig(out / "cable_car.png", dpi=120)

# Where the car swings about at the end is where it would rest there.
checked = (float(place[-80:, 2].mean()), float(stop.position("carriage")[2]), 0.02)  # m
