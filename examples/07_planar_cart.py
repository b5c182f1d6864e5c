"""A planar scene: a cart with friction and a spring carries a pendulum of three links. Each body has three speeds."""

import numpy as np

import kanefe as kf

track = kf.CoordinateForce(stiffness=200.0, rest=-0.3, friction=4.0)  # N/m, m, N
pins = kf.CoordinateForce(damping=0.02)  # N m s

scene = kf.System(gravity=(0, -9.81, 0))
cart = scene.add_rigid_body("cart", 5.0, 0.1, joint=kf.Prismatic("x", forces=track))
link, place = cart, (0.0, 0.0, 0.0)
for i in range(3):
    # each link hangs along its -y axis; the first is deflected
    joint = kf.Revolute("z", position=1.2 if i == 0 else 0.0, forces=pins)
    link = scene.add_rigid_body(f"link {i}", 1.0, 0.4**2 / 12, com=(0, -0.2, 0), parent=link, at=place, joint=joint)
    place = (0.0, -0.4, 0.0)
result = scene.simulate((0.0, 10.0), rtol=1e-7)

x = result.joint_coordinates("cart")[:, 0]
energy = result.energy
print(f"the cart travels between {x.min():+.4f} and {x.max():+.4f} m and is left at {x[-1]:+.4f} m")
print(f"{energy.total[0] - energy.total[-1]:.6f} J are gone, friction and dampers took {energy.dissipated[-1]:.6f} J")
print(f"the energy balance is exact to {np.abs(energy.balance_error).max():.1e} J")

checked = (energy.dissipated[-1], energy.total[0] - energy.total[-1], 1e-4)  # J
