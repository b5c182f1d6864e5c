"""The Campbell diagram of a fan blade of sheet metal as a shell, beside its solid.

The blade is curved across and set at an angle. The shell has 6 degrees of freedom at each node of its surface, the
solid two layers of hexahedra through the same thickness. Seen from the blade, whatever stands still around the fan (its
four struts, say) pushes at multiples of the speed: where a frequency crosses such a line is a critical speed. Needs
dolfinx.
"""

from dataclasses import replace
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
from kanefe_fem import Material, box_mesh, shell_body, solid_body, surface_mesh

steel = Material(E=210e9, nu=0.3, rho=7850.0)
length, chord, radius, hub, pitch, thickness = 0.30, 0.10, 0.15, 0.08, np.radians(5.0), 3e-3


def place(s, r, height=0.0):
    """Return points of a cylinder about an axis along the blade, at a height above it, turned by the pitch."""
    angle = (r - 0.5) * chord / radius
    across, up = (radius + height) * np.sin(angle), (radius + height) * np.cos(angle) - radius
    return hub + length * s, np.cos(pitch) * across - np.sin(pitch) * up, np.sin(pitch) * across + np.cos(pitch) * up


surface = surface_mesh(place, (14, 6))
box = box_mesh((1.0, 1.0, 1.0), (30, 12, 2), start=(0.0, 0.0, -0.5)).with_order(2)
s, r, z = np.asarray(box.nodes).T
solid = replace(box, nodes=np.column_stack(place(s, r, thickness * z)))

options = {"reduction": kf.CraigBampton(modes=8, loads=("centrifugal",)), "stiffening": "inertial"}
blades = {
    "shell": shell_body(surface, steel, {"root": "clamped"}, thickness, **options),
    "solid": solid_body(solid, steel, {"root": "clamped"}, **options),
}
speeds = np.linspace(0.0, 300.0, 7)  # rad/s
diagrams = {}
for name, blade in blades.items():
    print(name, blade)

    def spinning(speed, blade=blade):
        """Return the blade at a speed, in the frame that spins with it."""
        scene = kf.System()
        scene.add_flexible_body("blade", blade, joint=kf.Revolute("z", motion=kf.Motion.steady(speed)))
        return scene

    diagrams[name] = kf.campbell(spinning, speeds, modes=4)
frequencies = {name: diagram.frequencies for name, diagram in diagrams.items()}
difference = np.abs(frequencies["shell"] / frequencies["solid"] - 1.0).max(axis=0)
print("largest differences of the first four frequencies", difference)
critical = [(order, found) for order in (1, 2, 3, 4) for found in diagrams["shell"].critical_speeds(order=order)]
for _, found in critical:
    print(f"critical speed: {found}")

out = Path("out")
out.mkdir(exist_ok=True)
turns = speeds * 60.0 / (2.0 * np.pi)
plt.plot(turns, frequencies["shell"], "-", color="tab:blue")
plt.plot(turns, frequencies["solid"], "o", color="black", fillstyle="none")
plt.plot([], [], "-", color="tab:blue", label="shell")
plt.plot([], [], "o", color="black", fillstyle="none", label="solid, two layers")
for order, found in critical:
    plt.plot(found.speed * 60.0 / (2.0 * np.pi), order * found.speed / (2.0 * np.pi), "x", color="tab:red")
plt.plot([], [], "x", color="tab:red", label="critical speeds of the shell")
for order in (1, 2, 3, 4):
    plt.plot(turns, order * turns / 60.0, ":", color="grey", linewidth=0.8)
    plt.annotate(f"{order}", (turns[-1], order * turns[-1] / 60.0))
plt.xlabel("speed [1/min]")
plt.ylabel("frequency [Hz]")
plt.legend()
plt.savefig(out / "fan_blade.png", dpi=120)

checked = (difference.max(), 0.0, 5e-3)
