"""A tapered, twisted blade from a mesh, cut into 12 linear segments: it bends by half its length.

Needs dolfinx. One linear body would stretch as it bends; how many segments an accuracy takes, `accuracy=` finds.
"""

from dataclasses import replace
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import kanefe as kf
from kanefe.fe_model.skin import skin
from kanefe_fem import Material, box_mesh, recover, segmented, solid_body

length, chord, thickness = 10.0, 0.6, 0.08  # m, at the root
glass = Material(E=40e9, nu=0.3, rho=2000.0)
ends = {"root": "clamped", "tip": "average"}

mesh = box_mesh((length, chord, thickness), (60, 4, 2), start=(0, -chord / 2, -thickness / 2))
x, y, z = mesh.nodes.T
taper, twist = 1 - 0.6 * x / length, np.radians(12) * (1 - x / length)
y, z = taper * (y * np.cos(twist) - z * np.sin(twist)), taper * (y * np.sin(twist) + z * np.cos(twist))
mesh = replace(mesh, nodes=np.column_stack([x, y, z]))

chain = segmented(mesh, ends, glass, segments=12)
print(chain)


def at_rest(force: float, gravity: float = 9.81) -> kf.Equilibrium:
    """Return the blade under a force up at its tip, in N."""
    scene = kf.System(gravity=(0, 0, -gravity))
    blade = scene.add_segmented_body("blade", chain)
    scene.add_force(blade.interface("tip"), (0, 0, force))
    return kf.equilibrium(scene)


figure = plt.figure(figsize=(8, 4.5), layout="constrained")
axes = figure.add_subplot(projection="3d")
whole = at_rest(0.0).body("blade")
faces = np.concatenate([block.nodes[:, :4] for block in skin(whole.cells)])
for force in (0.0, 4e3, 15e3):
    bent = at_rest(force)
    every = np.arange(len(whole.nodes))  # with the second nodes of the cuts
    stress = recover(bent, "blade").von_mises[0]
    colours = plt.cm.viridis(np.clip(stress[faces].mean(axis=1) / 200e6, 0, 1))
    axes.add_collection3d(Poly3DCollection(bent.nodal_positions("blade", nodes=every)[faces], facecolors=colours))
    tip = bent.position("blade", "tip")
    print(f"{force:6.0f} N: tip at {np.round(tip, 3)} m, largest stress {1e-6 * np.nanmax(stress):.0f} MPa")
colour_bar = figure.colorbar(
    plt.cm.ScalarMappable(plt.Normalize(0, 200), "viridis"), ax=axes, shrink=0.6, location="left"
)
colour_bar.set_label("von Mises stress [MPa]")
axes.set(xlim=(0, 10), ylim=(-1, 1), zlim=(-1, 6), xlabel="x [m]", zlabel="z [m]", yticks=(-1, 0, 1))
axes.set_box_aspect((10, 2, 7), zoom=1.1)
axes.view_init(18, -65)
out = Path("out")
out.mkdir(exist_ok=True)
figure.savefig(out / "blade_cut_in_twelve.png", dpi=120, bbox_inches="tight")

one = kf.System()
one.add_flexible_body("blade", solid_body(mesh, glass, ends, reduction=kf.CraigBampton(modes=8)))
frequencies = [rest.linearise().modes().frequencies[:3] for rest in (kf.equilibrium(one), at_rest(0.0, gravity=0.0))]
print(
    f"first frequencies of one body and of the chain: {np.round(frequencies[0], 3)}, {np.round(frequencies[1], 3)} Hz"
)

checked = (float(np.abs(frequencies[1] / frequencies[0] - 1).max()), 0.0, 0.01)
