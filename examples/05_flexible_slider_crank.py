"""A slider-crank at 150 rad/s: the bow of its slender rod relative to the line between its pins."""

import kanefe as kf
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

steel = Material(E=200e9, nu=0.3, rho=7870.0)
crank_length, rod_length, elements, spin = 0.15, 0.3, 20, 150.0  # m, m, -, rad/s
section = Rectangle(0.008, 0.008)
model = straight_beam(rod_length, section, steel, elements=elements, theory="euler-bernoulli", planar=True)
# both ends rotate on their pins and stay on the x axis of G: G follows the line between them
pin = kf.Interface(fixed=("x", "y"))
rod_body = beam_body(model, {"root": pin, "tip": pin}, reduction=kf.CraigBampton(modes=3))

scene = kf.System()
crank = scene.add_rigid_body("crank", mass=1.0, joint=kf.Revolute("z", motion=kf.Motion.steady(spin)))
# the slider is at rest at its dead centre, so that the straight rod rotates about its own end
hinge = kf.Revolute("z", speed=-spin * (1 + crank_length / rod_length))
rod = scene.add_flexible_body("rod", rod_body, parent=crank, at=(crank_length, 0, 0), joint=hinge)
slider = scene.add_rigid_body("slider", 0.075552, at=(crank_length + rod_length, 0, 0), joint=kf.Prismatic("x"))
scene.add_loop_joint("wrist pin", kf.Revolute("z"), rod.interface("tip"), slider)
result = scene.simulate((0.0, 0.01), rtol=1e-6, method="dop853", output_step=1e-4)

place = crank_length + rod_length + result.joint_coordinates("slider")[:, 0]
bow = result.nodal_displacements("rod", nodes=[elements // 2])[:, 0, 1]
for row in range(0, len(result.times), 10):
    print(f"{1e3 * result.times[row]:5.1f} ms   slider at {place[row]:.6f} m   rod bows by {1e3 * bow[row]:+.4f} mm")

# Reference of verification case C06, a linear rod in the frame of its chord, at t = 5 ms, valid to 3 digits.
checked = (bow[50], 0.0015775438621796172, 2e-6)
