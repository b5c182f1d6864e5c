"""A shaken ramp: a block sticks on it for ever, a wheel rolls without slipping, a stop catches a box.

Friction connects a sticking point to an anchor that moves only during slip: the block does not creep, shaken or not.
The wheel touches the ramp with the rim of a torus, and the same friction makes it roll without slipping. A box slides
on a smooth lane against a flexible beam, clamped in the ramp, and stays there.
"""

import math

import numpy as np

import kanefe as kf
from kanefe import shapes
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

TILT, G = math.radians(10.0), 9.81
RADIUS, TUBE, MASS = 0.3, 0.05, 8.0
SHAKEN, HERTZ = 0.02 * G, 2.0  # m/s2 across the slope, Hz

scene = kf.System(gravity=(0, 0, -G))
times = np.linspace(0.0, 3.0, 301)
w = 2.0 * math.pi * HERTZ
along_y = -SHAKEN / w**2 * np.sin(w * times)
ramp = scene.add_rigid_body("ramp", 500.0, 50.0, joint=kf.Prismatic("y", motion=kf.Motion.table(times, along_y)))
tilted = kf.rotation_about("y", TILT)
deck = scene.add_surface("deck", ramp, shapes.Plane("z"), orientation=tilted)
on_deck = ramp.frame(orientation=tilted)  # x down the slope, z away from it

# the block that sticks: 64 % of the friction cone, with the shaking
block = scene.add_rigid_body(
    "block", 20.0, 0.5, joint=kf.Free(position=tuple(on_deck.axes @ (0, 0, 0.1)), orientation=tilted)
)
feet = scene.add_surface("feet", block, shapes.Box((0.4, 0.4, 0.2)))
scene.add_contact("block", feet, deck, normal=kf.HuntCrossley(2e6, damping=2.0), friction=kf.Coulomb(0.28))

# the wheel that rolls: its centre is one radius above the slope
height = (RADIUS + TUBE) / math.cos(TILT)
wheel = scene.add_rigid_body(
    "wheel", MASS, MASS * RADIUS**2 * np.array((0.5, 1.0, 0.5)), joint=kf.Free(position=(0, 2.0, height))
)
tyre = scene.add_surface("tyre", wheel, shapes.Torus(RADIUS, TUBE, axis="y"))
scene.add_contact("tyre", tyre, deck, normal=kf.HuntCrossley(2e6, damping=2.0), friction=kf.Coulomb(0.6))

# the stop: a beam across the smooth lane of a box
beam = straight_beam(0.4, Rectangle(0.03, 0.03), Material(E=70e9, nu=0.3, rho=2700.0), elements=4)
post = beam_body(beam, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=4), kf.ModalDamping(0.05))
stop = scene.add_flexible_body(
    "stop",
    post,
    parent=ramp,
    at=tuple(on_deck.axes @ (0.8, -2.0, 0.0)),
    orientation=kf.rotation_about("y", TILT - math.pi / 2),
)
box = scene.add_rigid_body(
    "box", 5.0, 0.05, joint=kf.Free(position=tuple(on_deck.axes @ (0.0, -2.0, 0.1)), orientation=tilted)
)
sole = scene.add_surface("sole", box, shapes.Box((0.2, 0.2, 0.2)))
scene.add_contact("sole", sole, deck, normal=kf.HuntCrossley(2e6, damping=2.0))
front = scene.add_surface("front", box, shapes.Box((0.2, 0.2, 0.2)))
scene.add_contact("front", stop.node(1), front, normal=kf.HuntCrossley(1e6, damping=1.0))

result = scene.simulate((0.0, 2.0), rtol=1e-6)
print(result)

held, rolled, caught = (result.contact(name) for name in ("block", "tyre", "front"))
settled = result.times > 0.5
creep = float(np.ptp(held.slip[settled]))
print(f"the block slips {creep:g} m after it has settled; it {held.status[-1]}")
print(f"the wheel slips {np.ptp(rolled.slip[settled]):.1e} m while it rolls")
print(f"the box is caught with up to {caught.normal.max():.0f} N, first at {result.events['front touch'][0]:.3f} s")

# rolling without slip: a = g sin(tilt) / (1 + I / (m r^2)), with the distance r from centre to ground
down = np.array((math.cos(TILT), 0.0, -math.sin(TILT)))
way = (result.position("wheel") - result.position("wheel")[0]) @ down
acceleration = G * math.sin(TILT) / (1.0 + (RADIUS / (RADIUS + TUBE)) ** 2)
checked = (float(way[-1]), 0.5 * acceleration * 2.0**2, 2e-3)  # it settles on the ramp first
print(f"the wheel rolls {checked[0]:.4f} m in 2 s; closed form {checked[1]:.4f} m")
