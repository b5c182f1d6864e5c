"""Stress of a skid gear meshed as solids, at the instant of the largest force in a saddle, on a deck in a rough sea.

The gear consists of thin-walled tubes, arched where they leave the saddles (`meshes/skid_gear_solid.py`); gmsh and
dolfinx take half a minute once. The other loads are those of example 25. The stress of the walls includes what a beam
lacks: ovalisation of tubes in their bends, rings held by saddles, and the corners where tubes meet.
"""

from pathlib import Path

import numpy as np

import kanefe as kf
from kanefe_fem import recover
from kanefe_fem.sramss import add_haul_down, add_rotors, add_wind, solid_gear, spatial_scene
from kanefe_fem.sramss import parameters as given
from kanefe_fem.sramss.spatial import SADDLES, SHOES

SPAN = 24.0  # s

gear = solid_gear(Path(__file__).parents[1] / "meshes" / "skid_gear_solid.py")
print(f"the gear: {len(gear.nodes)} nodes, {gear.mass:.1f} kg, {gear.free_count} modes")
sea = kf.Sea.state(5, seed=1)
deck = kf.Ship(kf.example_rao(), sea, heading_deg=60).at((-40, 0, 6), ramp=10.0, duration=SPAN)
wind = kf.Wind((2.0, 12.0, 0.0), gusts=[kf.Gust((0, 8, 0), 14.0, 6.0)], turbulence=kf.Turbulence(1.5, 60.0, seed=1))

scene = spatial_scene(gear, deck, mu=0.3, shoe_points=2)
add_rotors(scene, 1500.0, rate=24.0)  # N and rad/s, at idle
add_wind(scene, wind)
add_haul_down(scene, 6000.0)
rest = kf.equilibrium(scene, steady=False)
result = scene.simulate((0.0, SPAN), start=rest.state, rtol=1e-4, output_step=0.02)
print(result)

# the largest force of a saddle on the gear, in axes of the aircraft
forces = {name: result.coupling_force("gear", name) for name in SADDLES}
sizes = {name: np.linalg.norm(force[:, :3], axis=1) for name, force in forces.items()}
worst = max(SADDLES, key=lambda name: sizes[name].max())
frame = int(sizes[worst].argmax())
t = result.times[frame]
print(f"largest force of a saddle: {sizes[worst][frame]:.0f} N, {worst}, at {t:.2f} s")
print(f"the shoes slid by {1e3 * max(result.contact(name).slip[-1] for name in SHOES):.1f} mm")

fields = recover(result, "gear", frames=[frame])
most = fields.envelope("von_mises")
x, y, z = most.peak_position
print(f"largest von Mises stress {1e-6 * most.peak:.1f} MPa at ({x:.2f}, {y:.2f}, {z:.2f}) m from the centre of mass")
out = Path("out")
out.mkdir(exist_ok=True)
title = f"von Mises stress at {t:.2f} s, largest force at the {worst}"
try:
    fields.picture(out / "solid_gear.png", frame=0, scale=10.0, title=title, view=(1.0, -1.2, 0.7))
except kf.MissingDependency as missing:
    print(f"no picture: {missing}")

# strain gauges above and below the leg of that saddle measure the bending moment of the saddle
side = 1.0 if "port" in worst else -1.0
slope = 0.9013  # rad, of the leg between its bend and the skid
place = next(group.shares @ gear.nodes[group.nodes] for group in gear.groups if group.name == worst)
along = np.array((0.0, side * np.cos(slope), -np.sin(slope)))
across = np.array((0.0, side * np.sin(slope), np.cos(slope)))
axis = np.array((place[0], side * 1.10, -1.3579)) - 0.4 * along  # 0.4 m up the leg from the skid
top, bottom = (float(fields.gauge(axis + h * across, along)[0]) for h in (given.DIAMETER / 2, -given.DIAMETER / 2))
second = given.SECOND_MOMENT / 2  # of one tube
measured = abs(top - bottom) * given.YOUNG * second / given.DIAMETER
force, moment = np.split(forces[worst][frame], 2)
by_hand = abs(float((moment + np.cross(place - axis, force))[0]))
print(f"bending moment in the leg {measured:.0f} N m by the gauges, {by_hand:.0f} N m by the equations of motion")
checked = (measured, by_hand, 0.06 * by_hand)  # the leg's own inertia, and what 16 modes leave out
