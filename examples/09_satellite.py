"""A satellite turns by 30 degrees. Its two flexible panels keep vibrating, without any angular momentum."""

import math

import numpy as np

import kanefe as kf
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

blanket = Material(E=3e8, nu=0.3, rho=60.0)  # a folding panel, homogenised over its thickness
panel_length, hub_radius = 5.0, 0.6  # m
angle, duration = math.radians(30.0), 12.0  # of the turn about y; s

model = straight_beam(panel_length, Rectangle(width=1.2, height=0.03), blanket, elements=10)
panel = beam_body(
    model,
    {"root": "clamped", "tip": kf.Interface(fixed=("x", "y", "rz"))},
    reduction=kf.CraigBampton(modes=2),
    damping=kf.ModalDamping(0.005),
)

scene = kf.System()
hub = scene.add_rigid_body("hub", mass=400.0, inertia=(110.0, 90.0, 120.0), joint=kf.Free())
scene.add_flexible_body("right", panel, parent=hub, at=(hub_radius, 0, 0))
scene.add_flexible_body("left", panel, parent=hub, at=(-hub_radius, 0, 0), orientation=(0, 0, 0, 1))

reach = hub_radius**2 + 2 * hub_radius * panel.center_of_mass[0]
J = 90.0 + 2 * (panel.inertia[1, 1] + panel.mass * reach)  # about y, kg m2
torque = 2 * math.pi * J * angle / duration**2  # one period of a sine of it turns a rigid satellite by the angle
scene.add_torque(hub, lambda t: (0, torque * math.sin(2 * math.pi * t / duration) if t < duration else 0.0, 0))
result = scene.simulate((0.0, 2 * duration), rtol=1e-8, output_step=duration / 100)

attitude = 2 * np.arctan2(result.rotation("hub")[:, 2], result.rotation("hub")[:, 0])
tip = result.deflection("right", "tip")[:, 2]
momentum = result.momentum.angular[:, 1]
turned, swing = math.degrees(attitude[100]), math.degrees(np.ptp(attitude[100:]))
print(f"the hub turns by {turned:.3f} degrees, then swings within {swing:.3f} degrees")
print(f"the panels bend by {1e3 * np.abs(tip).max():.1f} mm, {1e3 * np.abs(tip[100:]).max():.1f} mm after the turn")
print(f"angular momentum {momentum[50]:.6f} N m s half way, {np.abs(momentum[100:]).max():.1e} N m s after the turn")

# Half way the angular momentum is the impulse of half a sine, whatever the panels do.
checked = (momentum[50], torque * duration / math.pi, 1e-5)  # N m s
