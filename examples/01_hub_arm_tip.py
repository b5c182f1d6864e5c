"""A rigid hub drives a flexible arm from a mesh with a tip mass; `kanefe demo` shows the same scene with a table.

Needs dolfinx. Run from the repository: python examples/01_hub_arm_tip.py
"""

import math
from pathlib import Path

import kanefe as kf
from kanefe_fem import Material, solid_body

torque, pulse = 40.0, 0.6  # N m, s

arm_body = solid_body(
    Path(__file__).parents[1] / "meshes" / "arm.msh",
    materials={"arm": Material(E=70e9, nu=0.33, rho=2700.0)},
    interfaces={"root": "clamped", "tip": "rigid"},  # facet groups of the mesh
    reduction=kf.CraigBampton(modes=12),
    damping=kf.ModalDamping(0.01),
)

scene = kf.System(gravity=(0, 0, -9.81))
hub = scene.add_rigid_body("hub", mass=4.0, inertia=(0.02, 0.02, 0.03), joint=kf.Revolute("z"))
arm = scene.add_flexible_body("arm", arm_body, parent=hub, at=(0.1, 0, 0))
tip = scene.add_rigid_body("tip", mass=0.5, inertia=2e-4, parent=arm.interface("tip"))
scene.add_torque(hub, lambda t: torque * math.sin(2 * math.pi * t / pulse) if t < pulse else 0.0)

result = scene.simulate((0.0, 2.0), rtol=1e-6)

out = Path("out")
out.mkdir(exist_ok=True)
result.plot(path=out / "overview.png")
result.to_vtk(out / "arm.pvd", every=5)
result.save(out / "run.h5")

# The pulse, integrated twice, turns a rigid arm by torque pulse^2 / (2 pi J); bending changes that by about 1e-5.
mass, com = arm_body.mass, arm_body.center_of_mass[0]
J = 0.03 + arm_body.inertia[2, 2] + mass * (0.1**2 + 2 * 0.1 * com) + 0.5 * 1.1**2 + 2e-4
angle = result.joint_coordinates("hub")[-1, 0]
rigid = torque * pulse**2 / (2 * math.pi * J)
print(f"hub angle at the end: {angle:.6f} rad; of a rigid arm: {rigid:.6f} rad")

checked = (angle, rigid, 1e-4)  # value, reference, tolerance in rad
