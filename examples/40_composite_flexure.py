"""A composite flexure: a stage on a blade of carbon plies that is hit, the stress of each ply, and how near failure is.

The blade is a shell of eight plies, the stage a mass at its end. Stresses at rest under a force are compared with
lamination theory. Needs dolfinx.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import kanefe as kf
from kanefe_fem import Laminate, Orthotropic, Ply, Strengths, recover, shell_body, surface_mesh

carbon = Orthotropic.transversely_isotropic(
    E1=135e9,
    E2=9e9,
    nu12=0.3,
    nu23=0.4,
    G12=5e9,
    rho=1600.0,
    strengths=Strengths(Xt=1500e6, Xc=1200e6, Yt=50e6, Yc=200e6, S=70e6),
)
angles = np.radians((0, 45, -45, 90, 90, -45, 45, 0))
ply = 0.15e-3  # m
length, width, thick = 0.12, 0.03, 8 * ply

mesh = surface_mesh(lambda s, r: (length * s, width * (r - 0.5), 0.0 * s), (16, 6))
blade = shell_body(
    mesh,
    Laminate([Ply(carbon, ply, angle) for angle in angles]),
    {"root": "clamped", "tip": "rigid"},
    reduction=kf.CraigBampton(modes=6),
    damping=kf.ModalDamping(0.01),
)
print(blade)


def scene_with(load):
    """Return a scene in which a force acts on the stage, across the blade."""
    scene = kf.System()
    flexure = scene.add_flexible_body("blade", blade)
    stage = scene.add_rigid_body("stage", 0.2, 2e-5, parent=flexure.interface("tip"))
    scene.add_force(stage, load)
    return scene


# at rest: moments per width m give curvatures d m, and these the strains of each ply
force = 5.0  # N
rest = kf.equilibrium(scene_with((0.0, 0.0, force)))
Q = np.linalg.inv(np.array(((1 / 135e9, -0.3 / 135e9, 0.0), (-0.3 / 135e9, 1 / 9e9, 0.0), (0.0, 0.0, 1 / 5e9))))


def turn(angle):
    """Return the strains 11, 22, 12 in the axes of a ply from those in the axes of the blade."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array(((c * c, s * s, c * s), (s * s, c * c, -c * s), (-2 * c * s, 2 * c * s, c * c - s * s)))


ends = np.linspace(-thick / 2, thick / 2, 9)
D = sum(turn(a).T @ Q @ turn(a) * (z1**3 - z0**3) / 3.0 for a, z0, z1 in zip(angles, ends[:-1], ends[1:], strict=True))
moment = -force * (length / 2) / width  # per width, in the middle of the blade; it stretches the bottom
curvature = np.linalg.solve(D, (moment, 0.0, 0.0))
middle = int(np.linalg.norm(np.asarray(mesh.nodes) - (length / 2, 0.0, 0.0), axis=1).argmin())
theory, found = [], []
for number, angle in enumerate(angles):
    for face, z in (("bottom", ends[number]), ("top", ends[number + 1])):
        theory.append((Q @ turn(angle) @ (z * curvature))[0])
        found.append(recover(rest, "blade", ply=number, face=face).stress_in_layer()[0, middle, 0])
theory, found = np.array(theory), np.array(found)
print("along the fibres in the middle, MPa:", (found / 1e6).round(2), "lamination theory:", (theory / 1e6).round(2))

# hit by a half sine
result = scene_with(lambda t: (0.0, 0.0, 20.0 * np.sin(np.pi * t / 0.01) * (t < 0.01))).simulate(
    (0.0, 0.3), output_step=1e-3
)
fields = recover(result, "blade")
worst = fields.envelope("tsai_wu")
print(worst, f"- the pulse may be {1.0 / worst.peak:.1f} times as strong")
history = fields.scalar("tsai_wu")[:, worst.where]
moved = 1e3 * result.position("stage")[:, 2]

out = Path("out")
out.mkdir(exist_ok=True)
figure = plt.figure(figsize=(10.0, 3.4), layout="constrained")
through = figure.add_subplot(1, 3, 1)
heights = np.repeat(ends, 2)[1:-1] * 1e3
through.fill_betweenx(heights, found / 1e6, alpha=0.3)
through.plot(found / 1e6, heights, label="blade")
through.plot(theory / 1e6, heights, "k.", markersize=4, label="lamination theory")
for z in ends:
    through.axhline(1e3 * z, color="0.8", linewidth=0.6, zorder=0)
through.set_xlabel("stress along the fibres [MPa]")
through.set_ylabel("height [mm]")
through.set_title(f"in the middle, {force:g} N at rest", fontsize=10)
through.legend(fontsize=8, loc="lower left")
over_time = figure.add_subplot(1, 3, 2)
over_time.plot(1e3 * result.times, history, color="tab:red")
over_time.set_xlabel("time [ms]")
over_time.set_ylabel("Tsai-Wu index at the worst place", color="tab:red")
beside = over_time.twinx()
beside.plot(1e3 * result.times, moved, color="tab:blue", linewidth=0.8)
beside.set_ylabel("stage [mm]", color="tab:blue")
view = figure.add_subplot(1, 3, 3, projection="3d")
frame = int(abs(result.times - worst.peak_time).argmin())
shape = np.asarray(blade.nodes) + fields.displacement()[frame]
index = recover(result, "blade", frames=[frame]).scalar("tsai_wu")[0]
table = np.asarray(mesh.connectivity)[:, :4]
colours = plt.cm.turbo(index[table].mean(axis=1) / worst.peak)
view.add_collection3d(Poly3DCollection(1e3 * shape[table], facecolors=colours, edgecolors="0.3", linewidths=0.3))
view.set(xlim=(0.0, 120.0), ylim=(-30.0, 30.0), zlim=(-10.0, 20.0))
view.set_box_aspect((120, 60, 30), zoom=1.1)
view.set_axis_off()
colour = plt.cm.ScalarMappable(plt.Normalize(0.0, worst.peak), "turbo")
figure.colorbar(colour, ax=view, shrink=0.6, label="Tsai-Wu index, worst ply")
view.set_title(f"at {1e3 * worst.peak_time:.0f} ms", fontsize=10)
figure.savefig(out / "composite_flexure.png", dpi=120)

checked = (abs(found - theory).max() / abs(theory).max(), 0.0, 0.02)  # its ends are not free to twist
