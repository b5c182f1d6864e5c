"""A rotating blade from a mesh: its frequencies against the speed, compared with the theory of rotating beams.

Needs dolfinx. Without `stiffening` the blade would soften with the speed and become unstable at 3.5 rad/s.
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
from kanefe.checks.verification.references import load_references
from kanefe_fem import Material, solid_body
from kanefe_fem.mesh.simple import box_mesh

side = 1 / 150  # of the square section; the blade is 1 m long, and EI = rho A = 1
mesh = box_mesh((1, side, side), (75, 1, 1), "hexahedron", start=(0, -side / 2, -side / 2))
material = Material(E=12 / side**4, nu=0.0, rho=1 / side**2)


def frequencies(stiffening: str, speeds: list[float]) -> np.ndarray:
    """Return the lowest four frequencies at each speed, seen from the frame that spins with the blade, in rad/s."""
    blade = solid_body(mesh, material, {"root": "clamped"}, reduction=kf.CraigBampton(modes=20), stiffening=stiffening)
    rows = []
    for speed in speeds:
        scene = kf.System()
        scene.add_flexible_body("blade", blade, joint=kf.Revolute("z", motion=kf.Motion.steady(speed)))
        rows.append(2 * np.pi * kf.equilibrium(scene).linearise().modes().frequencies[:4])
    return np.array(rows)


reference = load_references()["D03a"].values
speeds = [float(name.split("gamma=")[1]) for name in reference]
exact = np.array([np.sort(case["chord"] + case["flap"])[:4] for case in reference.values()])
stiff = frequencies("inertial", speeds)
soft = frequencies("none", speeds)

plt.plot(speeds, exact, "k-", linewidth=0.8)
plt.plot(speeds, stiff, "o", color="tab:blue", fillstyle="none")
plt.plot(speeds, soft, "--", color="tab:red")
plt.plot([], [], "k-", label="theory (flap and chord)")
plt.plot([], [], "o", color="tab:blue", fillstyle="none", label='mesh, stiffening="inertial"')
plt.plot([], [], "--", color="tab:red", label='mesh, stiffening="none"')
plt.xlabel("speed [rad/s]")
plt.ylabel("frequency [rad/s]")
plt.legend()
out = Path("out")
out.mkdir(exist_ok=True)
plt.savefig(out / "rotating_blade.png", dpi=120)

worst = np.abs(stiff / exact - 1).max()
print(f"first two flap and chord frequencies to {max(speeds):g} rad/s: worst error {worst:.1e}")

checked = (worst, 0.0, 1e-3)
