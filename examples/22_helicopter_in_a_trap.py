"""A helicopter in space on an icy, moving deck: a probe under its fuselage in a trap with a gap holds it in place.

The gear comes from a mesh of beams (`meshes/skid_gear.py`), with 16 modes and eight shoes. There is almost no friction:
the aircraft slides until its probe touches the trap, a round hole in the deck that is 25 mm wider than the probe.
"""

import math
from pathlib import Path

import numpy as np

import kanefe as kf
from kanefe_fem.sramss import add_probe, spatial_gear, spatial_scene

SPAN, ICE = 20.0, 0.03
GAP, STIFFNESS = 0.025, 2e6  # radial play, m, and of the trap, N/m

gear = spatial_gear(Path(__file__).parents[1] / "meshes" / "skid_gear.msh")
print(gear)

# a deck that begins to roll, heave and pitch
times = np.linspace(0.0, SPAN, round(20 * SPAN) + 1)
x = np.clip(times / 10.0, 0.0, 1.0)
grown = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
roll = math.radians(6.0) * grown * np.sin(2.0 * math.pi * times / 11.0)
pitch = math.radians(2.0) * grown * np.sin(2.0 * math.pi * times / 7.0)
heave = 0.6 * grown * np.sin(2.0 * math.pi * times / 8.0)
turns = [kf.euler_angles("xyz", angles) for angles in zip(roll, pitch, 0.0 * roll, strict=True)]
deck = kf.PoseTable(times, np.column_stack((0.0 * heave, 0.0 * heave, heave)), turns)

scene = spatial_scene(gear, deck, mu=ICE)
add_probe(scene, gap=GAP, stiffness=STIFFNESS)

rest = kf.equilibrium(scene, steady=False)  # the deck still rests at the start
result = scene.simulate((0.0, SPAN), start=rest.state, rtol=1e-5, output_step=0.02)
print(result)
probe = result.contact("probe")
print(f"the probe pulls by up to {probe.normal.max():.0f} N, first at {result.events['probe touch'][0]:.2f} s")
result.plot("contacts", "probe", "port shoe 1", path=Path("out") / "helicopter_in_a_trap.png")

# the offset of the probe from the middle of the trap is the gap plus the deflection of the trap
farthest = GAP + float(probe.penetration.max())
checked = (farthest, GAP + float(probe.normal.max()) / STIFFNESS, 2e-3)
print(f"it goes {1e3 * farthest:.2f} mm off the middle, {1e3 * GAP:g} mm of it free")
