"""Stress of a helicopter's skids at the instant of the largest force in a saddle, on a frigate's deck in a rough sea.

The gear comes from a mesh of beams (`meshes/skid_gear.py`). Rotors turn at idle and shake the airframe with their
harmonics; a gusty wind from starboard pushes the fuselage; a haul-down cable of 6 kN presses the skids on a wet deck.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
import kanefe_fem
from kanefe_fem.sramss import add_haul_down, add_rotors, add_wind, spatial_gear, spatial_scene
from kanefe_fem.sramss import parameters as given
from kanefe_fem.sramss.spatial import SADDLES, SHOES

SPAN = 18.0  # s

gear = spatial_gear(Path(__file__).parents[1] / "meshes" / "skid_gear.msh")
sea = kf.Sea.state(5, seed=1)
deck = kf.Ship(kf.example_rao(), sea, heading_deg=60).at((-40, 0, 6), ramp=10.0, duration=SPAN)
wind = kf.Wind((2.0, 12.0, 0.0), gusts=[kf.Gust((0, 8, 0), 11.0, 6.0)], turbulence=kf.Turbulence(1.5, 60.0, seed=1))

scene = spatial_scene(gear, deck, mu=0.3)
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
then = result.at(t)
down = then.in_axes_of("deck", then.load_force("haul-down"))
print(f"the cable pulls by {np.linalg.norm(down[:3]):.0f} N, in axes of the deck {np.round(down[:3])}")
slid = max(result.contact(name).slip[-1] for name in SHOES)
print(f"the skids slid by {1e3 * slid:.1f} mm")

# von Mises stress of the tubes from axial force and bending at the outermost fibre, and torsion
cut = kanefe_fem.recover(result, "gear", frames=[frame]).section_forces(stations=5)
area, second = given.AREA / 2, given.SECOND_MOMENT / 2  # of one tube
bending = np.hypot(cut["My"], cut["Mz"]) * given.DIAMETER / 2 / second
normal = np.abs(cut["N"]) / area + bending
shear = cut["T"] * given.DIAMETER / 2 / (2 * second)
stress = np.sqrt(normal**2 + 3 * shear**2)[0]  # (elements, stations)
peak = np.unravel_index(stress.argmax(), stress.shape)
x, y, z = cut.positions[peak]
print(f"largest stress {1e-6 * stress.max():.1f} MPa at ({x:.2f}, {y:.2f}, {z:.2f}) m from the centre of mass")

figure = plt.figure(figsize=(8.0, 7.0), layout="constrained")
space = figure.add_subplot(3, 1, (1, 2), projection="3d")
ends = cut.positions
colours = plt.cm.viridis(stress / stress.max())
for line, shades in zip(ends, colours, strict=True):
    for a, b, shade in zip(line[:-1], line[1:], shades, strict=False):
        space.plot(*np.array((a, b)).T, color=shade, linewidth=4)
space.scatter(x, y, z, color="crimson", s=40)
space.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]", box_aspect=(2.8, 2.2, 0.9))
space.view_init(elev=22, azim=-58)
space.set_zticks((-1.4, -1.1, -0.8))
space.set_title(f"{1e-6 * stress.max():.0f} MPa at {t:.2f} s, at the {worst}", fontsize="medium")
scale = plt.cm.ScalarMappable(norm=plt.Normalize(0.0, 1e-6 * stress.max()), cmap="viridis")
figure.colorbar(scale, ax=space, label="von Mises' stress [MPa]", shrink=0.6, pad=0.15)
history = figure.add_subplot(3, 1, 3)
for name in SADDLES:
    history.plot(result.times, 1e-3 * sizes[name], linewidth=0.8, label=name)
history.axvline(t, color="crimson", linewidth=0.8)
history.set(xlabel="time [s]", ylabel="force of a saddle [kN]", xlim=(0.0, SPAN))
history.legend(fontsize="x-small", ncols=2, loc="lower left")
history.grid(color="0.9")
out = Path("out")
out.mkdir(exist_ok=True)
figure.savefig(out / "stress_of_skids.png", dpi=120)

# the saddle takes the moment of the tube outboard of it: inboard, between two saddles, no load acts
node = next(int(group.nodes[0]) for group in gear.groups if group.name == worst)
is_there = np.linalg.norm(cut.positions - gear.nodes[node], axis=2) < 1e-9
moment = float(np.linalg.norm(cut.forces[0, is_there, 4:], axis=1).max())
given_there = float(np.linalg.norm(forces[worst][frame, 3:]))
print(f"bending moment there {moment:.0f} N m by 16 modes, {given_there:.0f} N m by the equations of motion")
checked = (moment, given_there, 0.04 * given_there)  # the modes leave out some of what single shoes bend
