"""A stiffened panel on a satellite that slews: how far its corner swings, with ribs beside the sheet and without.

The satellite turns by 30 degrees under a torque that first speeds it up and then stops it. The ribs are beams along
lines of the panel's mesh, below its sheet. Needs dolfinx.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
from kanefe_fem import Material, Rectangle, Stiffener, recover, shell_body, surface_mesh

aluminium = Material(E=70e9, nu=0.33, rho=2700.0)
length, width, sheet = 1.6, 0.8, 1.5e-3  # m
ribs_y, ribs_x = (-0.4, -0.2, 0.0, 0.2, 0.4), (0.4, 0.8, 1.2, 1.6)

mesh = surface_mesh(lambda s, r: (length * s, width * (r - 0.5), 0.0 * s), (12, 8))
lines = {f"along {i}": kf.OnPlane((0, y, 0), (0, 1, 0)) for i, y in enumerate(ribs_y)}
lines |= {f"across {i}": kf.OnPlane((x, 0, 0), (1, 0, 0)) for i, x in enumerate(ribs_x)}
corner = kf.Interface(kind="node", position=(length, width / 2, 0.0))
rib = Stiffener(Rectangle(width=1.5e-3, height=15e-3), aluminium, offset="below")


def panel(beams):
    """Return the panel as a body that is clamped at its root."""
    return shell_body(
        mesh.with_groups(lines),
        aluminium,
        {"root": "clamped", "corner": corner},
        sheet,
        kf.CraigBampton(modes=12),
        kf.ModalDamping(0.005),
        beams=beams,
    )


bodies = {"with ribs": panel(dict.fromkeys(lines, rib)), "sheet alone": panel({})}
duration, angle, hub_inertia = 8.0, np.radians(30.0), 60.0
times = np.linspace(0.0, 14.0, 561)
swings, turned = {}, {}
for name, body in bodies.items():
    print(f"{name}: {body}")
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 200.0, (40.0, hub_inertia, 40.0), joint=kf.Revolute("y"))
    arm = scene.add_flexible_body("panel", body, parent=hub, at=(0.5, 0.0, 0.0))
    tip_of_rigid = body.inertia[1, 1] + body.mass * 0.5**2 + 2.0 * 0.5 * body.mass * body.center_of_mass[0]
    torque = angle * 2.0 * np.pi / duration**2 * (hub_inertia + tip_of_rigid)
    scene.add_torque(hub, lambda t, most=torque: most * np.sin(2.0 * np.pi * t / duration) * (t < duration))
    result = scene.simulate((0.0, times[-1]), output_times=times, rtol=1e-6)
    turn = result.joint_coordinates("hub")[:, 0]
    rigid = np.column_stack((0.5 + length) * np.array((np.cos(turn), 0.0 * turn, -np.sin(turn))))
    rigid[:, 1] += width / 2
    away = result.position("panel", "corner") - rigid
    swings[name] = 1e3 * (np.sin(turn) * away[:, 0] + np.cos(turn) * away[:, 2])
    turned[name] = turn
    print(f"  {recover(result, 'panel').envelope()}")
    if body.provenance.get("stiffeners"):
        ribs = recover(result, "panel", material="along 2")
        print(f"  middle rib: {ribs.envelope().peak / 1e6:.2f} MPa, {abs(ribs.section_forces()['My']).max():.3f} N m")

out = Path("out")
out.mkdir(exist_ok=True)
figure = plt.figure(figsize=(9.0, 3.6), layout="constrained")
view = figure.add_subplot(1, 2, 1, projection="3d")
body = bodies["with ribs"]
shape = body.node_displacements(np.eye(body.free_count)[0])
moved = np.asarray(body.nodes) + 0.15 * shape / abs(shape).max()
for block in body.cells:
    color, size = ("tab:red", 1.2) if block.kind == "line3" else ("tab:blue", 0.3)
    for cell in block.nodes:
        corners = cell[[0, 2, 1]] if block.kind == "line3" else cell[[0, 4, 1, 5, 2, 6, 3, 7, 0]]
        view.plot(*moved[corners].T, color=color, linewidth=size)
view.set_box_aspect((length, width, 0.4), zoom=1.15)
view.set_axis_off()
view.set_title(f"first mode, {body.frequencies[0]:.2f} Hz")
axes = figure.add_subplot(1, 2, 2)
for name, swing in swings.items():
    axes.plot(times, swing, label=f"{name}, {bodies[name].mass:.1f} kg")
axes.set_xlabel("time [s]")
axes.set_ylabel("corner beside the rigid panel [mm]")
axes.legend()
figure.savefig(out / "stiffened_panel.png", dpi=120)

print({name: float(abs(swing).max().round(3)) for name, swing in swings.items()}, "mm at most")
checked = (np.degrees(turned["with ribs"][-1]), 30.0, 1e-2)  # as of a rigid satellite, but for what still swings
