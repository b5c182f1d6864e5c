"""Two fingers grip a soft bar, lift it from a table and hold it by friction alone, without creep.

The bar is meshed with quadratic bricks. Its reduction includes the local compliance of its ends under the fingers
(`PatchCase`), so that the grip deforms the bar itself and not a substitute spring. Needs dolfinx.
"""

from pathlib import Path

import numpy as np

import kanefe as kf
from kanefe import shapes
from kanefe_fem import Material, box_mesh, solid_body

LENGTH, WIDTH, HEIGHT = 0.2, 0.04, 0.02  # m
GRIP, LIFT, G = 8.0, 0.3, 9.81  # N, m, m/s2
SOFT = Material(E=5e6, nu=0.45, rho=1100.0)

bar_body = solid_body(
    box_mesh((LENGTH, WIDTH, HEIGHT), (12, 3, 2), start=(-LENGTH / 2, -WIDTH / 2, -HEIGHT / 2)),
    SOFT,
    {},  # nothing holds it: it floats
    surfaces=["root", "tip"],
    reduction=kf.CraigBampton(modes=10, loads=(kf.PatchCase("root", most=4), kf.PatchCase("tip", most=4))),
    damping=kf.ModalDamping(0.05),
    order=2,
)

times = np.linspace(0.0, 3.0, 301)
x = np.clip(times - 0.5, 0.0, 1.0)
raised = LIFT * x**3 * (10.0 - 15.0 * x + 6.0 * x**2)  # from 0.5 to 1.5 s

scene = kf.System(gravity=(0, 0, -G))
table = scene.add_surface("table", scene.ground, shapes.Plane("z"), at=(0, 0, -HEIGHT / 2))
hand = scene.add_rigid_body("hand", 2.0, 0.01, joint=kf.Prismatic("z", motion=kf.Motion.table(times, raised)))
bar = scene.add_flexible_body("bar", bar_body, joint=kf.Free())
scene.add_contact("table", bar.patch("bottom", most=8), table, normal=kf.KelvinVoigt(2e4, damping=20.0))
for name, side, end in (("left", -1.0, "root"), ("right", 1.0, "tip")):
    slide = kf.Prismatic("x", forces=kf.CoordinateForce(damping=5.0))
    finger = scene.add_rigid_body(f"{name} finger", 0.2, 1e-4, parent=hand, at=(side * LENGTH / 2, 0, 0), joint=slide)
    scene.add_force(finger, (-side * GRIP, 0, 0))
    pad = scene.add_surface(f"{name} pad", finger, shapes.Plane((-side, 0, 0)))
    scene.add_contact(
        f"{name} grip",
        bar.patch(end, most=4),
        pad,
        normal=kf.KelvinVoigt(5e4, damping=20.0),
        friction=kf.Coulomb(0.6, static=0.7),
    )

result = scene.simulate((0.0, 3.0))
print(result)
print(result.contact_report())
result.plot("contacts", path=Path("out") / "gripper.png")
result.to_vtk(Path("out") / "gripper.pvd", fps=50)

left, right = result.contact("left grip"), result.contact("right grip")
lifted = result.times > 2.0
creep = max(np.ptp(grip.slip[lifted]) for grip in (left, right))
sag = result.nodal_positions("bar", frames=[-1])[0]
middle = np.abs(bar_body.nodes[:, 0]) < 1e-6
through = sag[~middle, 2].max() - sag[middle, 2].max()
print(f"the bar hangs through by {1e3 * through:.2f} mm, and slips {creep:g} m in a second")

# the friction forces carry the weight of the bar
carried = float(left.force[-1, 2] + right.force[-1, 2])
weight = bar_body.mass * G
checked = (carried, weight, 1e-3 * weight)
print(f"friction carries {carried:.5f} N; the bar weighs {weight:.5f} N")
