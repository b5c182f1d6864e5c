"""A blade on a driven shaft: the coupling force at its root, computed after the run."""

import numpy as np

import kanefe as kf
from kanefe_fem import Material, Tube, beam_body, straight_beam

steel = Material(E=210e9, nu=0.3, rho=7850.0)
section = Tube(outer_diameter=0.04, thickness=0.004)
blade_body = beam_body(
    straight_beam(0.8, section, steel, elements=8),
    {"root": "clamped", "tip": "rigid"},
    reduction=kf.CraigBampton(modes=4),
    damping=kf.ModalDamping(0.05),
)

speed, up = 30.0, 1.0  # rad/s, reached after 1 s
ramp = kf.Motion(
    position=lambda t: speed * (t**3 / up**2 - 0.5 * t**4 / up**3) if t < up else speed * (t - 0.5 * up),
    velocity=lambda t: speed * (3 * (t / up) ** 2 - 2 * (t / up) ** 3) if t < up else speed,
    acceleration=lambda t: speed * (6 * t / up**2 - 6 * t**2 / up**3) if t < up else 0.0,
)

scene = kf.System()
shaft = scene.add_rigid_body("shaft", mass=2.0, inertia=0.01, joint=kf.Revolute("z", motion=ramp))
scene.add_flexible_body("blade", blade_body, parent=shaft, at=(0.05, 0, 0))
result = scene.simulate((0.0, 2.0), rtol=1e-6)

force = result.coupling_force("blade", "root")
torque = result.driving_force("shaft")
print(f"largest driving torque {np.abs(torque).max():.2f} N m, root force at the end {force[-1, 0]:.2f} N")

# The root gives the centripetal force m r w^2 of the centre of mass (the blade stretches by 2e-5 of r).
checked = (force[-1, 0], -blade_body.mass * (0.05 + 0.4) * speed**2, 1.0)  # N, of some 2290 N
