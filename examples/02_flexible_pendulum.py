"""A flexible pendulum of beam elements, released from the horizontal: numpy and scipy only, no mesh."""

import kanefe as kf
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

aluminium = Material(E=70e9, nu=0.3, rho=2700.0)
# 20 mm deep along z and 5 mm high along y, so that it is soft in bending in the x-y plane
beam = straight_beam(1.0, Rectangle(0.005, 0.020), aluminium, elements=10, planar=True)
body = beam_body(beam, {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=3))

scene = kf.System(gravity=(0, -9.81, 0))
scene.add_flexible_body("rod", body, joint=kf.Revolute("z"))
result = scene.simulate((0.0, 1.0), rtol=1e-8, method="dop853", output_step=0.1)

tip = result.position("rod", interface="tip")
for t, (x, y, _) in zip(result.times, tip, strict=True):
    print(f"{t:4.1f} s   x {x:+.5f} m   y {y:+.5f} m")

# Reference of verification case C01, a geometrically exact beam, at t = 0.5 s: y = -0.995875 m.
checked = (tip[5, 1], -0.995875, 1.5e-4)
