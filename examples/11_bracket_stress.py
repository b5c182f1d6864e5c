"""A bracket carries a heavy body on a shaking table: its largest stress, a strain gauge, and a picture.

Needs dolfinx; the picture also needs pyvista (pip install 'kanefe[report]').
"""

import math
from pathlib import Path

import numpy as np

import kanefe as kf
from kanefe_fem import Material, recover, solid_body

steel = Material(E=210e9, nu=0.3, rho=7850.0)
weight, shake, frequency = 6.0, 15.0, 25.0  # kg, m/s2, Hz

body = solid_body(
    Path(__file__).parents[1] / "meshes" / "bracket.msh",
    materials={"bracket": steel},
    interfaces={"foot": "clamped", "eye": kf.Interface(kind="average")},  # the pump does not stiffen the eye
    reduction=kf.CraigBampton(modes=10),
    damping=kf.ModalDamping(0.02),
)

omega = 2 * math.pi * frequency
motion = kf.Motion(
    lambda t: -shake / omega**2 * math.sin(omega * t),
    lambda t: -shake / omega * math.cos(omega * t),
    lambda t: shake * math.sin(omega * t),
)
scene = kf.System(gravity=(0, 0, -9.81))
table = scene.add_rigid_body("table", mass=50.0, joint=kf.Prismatic("z", motion=motion))
bracket = scene.add_flexible_body("bracket", body, parent=table)
scene.add_rigid_body("pump", mass=weight, inertia=5e-3, parent=bracket.interface("eye"))
result = scene.simulate((0.0, 0.2), rtol=1e-6, output_step=5e-4)

fields = recover(result, "bracket")
worst = fields.envelope("von_mises")
x, y, z = 1e3 * worst.peak_position
print(f"largest von Mises stress: {worst.peak / 1e6:.1f} MPa at {worst.peak_time:.4f} s")
print(f"there: ({x:.1f}, {y:.1f}, {z:.1f}) mm, in the fillet")

place = (0.06, 0.0, 0.01)  # on top of the arm, halfway to the eye
strain = fields.gauge(place, direction=(1, 0, 0))
print(f"strain gauge on the arm: {1e6 * strain.min():.0f} to {1e6 * strain.max():.0f} microstrain")

out = Path("out")
recover(result, "bracket", times=np.linspace(0.1, 0.14, 9)).to_vtk(out / "bracket.pvd", scale=50.0)
body.report().to_html(out / "bracket.html", pictures=False)
try:
    fields.picture(out / "bracket.png", title="largest von Mises stress on the shaking table", view=(1.0, -0.9, -0.35))
except kf.MissingDependency as missing:
    print(f"no picture: {missing}")

# Bernoulli: the moment at the gauge is due to the body in the eye and to weight and inertia of the outer arm.
width, thickness, density = 0.04, 0.01, steel.rho
force, moment = np.split(result.coupling_force("bracket", "eye"), 2, axis=1)
eye, end = 0.105, 0.12
beyond = density * width * thickness * (end - place[0])
pull = -beyond * (9.81 + result.acceleration("bracket")[:, 2])
bending = -(moment[:, 1] - (eye - place[0]) * force[:, 2] - (end - place[0]) / 2 * pull)
hand = -bending / (width * thickness**2 / 6) / steel.E
at = int(np.argmax(abs(strain)))
print(f"at {result.times[at]:.4f} s: gauge {1e6 * strain[at]:.1f}, beam theory {1e6 * hand[at]:.1f} microstrain")

checked = (strain[at], hand[at], 0.05 * abs(hand[at]))  # the arm is four times as long as wide: 5 %
