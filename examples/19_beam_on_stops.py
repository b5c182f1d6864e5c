"""A hinged arm from a mesh falls on two rubber stops, bounces, and comes to rest on both; its stress at the impact.

The hinge and two stops are statically indeterminate: the bending of the arm determines how they share its weight. The
end of the run is compared with the rest found by `kf.equilibrium`. Needs dolfinx; the picture of the stress also needs
pyvista.
"""

import math
from pathlib import Path

import kanefe as kf
from kanefe import shapes
from kanefe_fem import Material, recover, solid_body

HALF = 0.02  # of the arm's thickness, m
STOPS = {"near": 0.45, "far": 0.95}  # m from the hinge

places = {name: kf.InBox((x - 0.02, -1.0, -HALF - 1e-6), (x + 0.02, 1.0, -HALF + 1e-6)) for name, x in STOPS.items()}
arm_body = solid_body(
    Path(__file__).parents[1] / "meshes" / "arm.msh",
    {"arm": Material(E=70e9, nu=0.33, rho=2700.0)},
    {"root": "clamped"},
    reduction=kf.CraigBampton(modes=10, loads=tuple(kf.PatchCase(place, most=4) for place in places.values())),
    damping=kf.ModalDamping(0.02),
)


def dropped(angle: float) -> kf.System:
    """Return the scene with the arm raised by an angle, rad."""
    scene = kf.System(gravity=(0, 0, -9.81))
    arm = scene.add_flexible_body("arm", arm_body, joint=kf.Revolute("y", position=-angle))
    for name, place in places.items():
        block = shapes.Box((0.06, 0.2, 0.04))
        stop = scene.add_surface(name, scene.ground, block, at=(STOPS[name], 0.0, -HALF - 0.02))
        rubber = kf.KelvinVoigt(4e5, damping=800.0)
        scene.add_contact(f"{name} stop", arm.patch(place, most=4), stop, normal=rubber, friction=kf.Coulomb(0.5))
    return scene


result = dropped(math.radians(3.0)).simulate((0.0, 2.0))
print(result)
print(result.contact_report())
result.plot("contacts", path=Path("out") / "beam_on_stops.png")

fields = recover(result, "arm")
worst = fields.envelope("von_mises")
print(f"largest von Mises stress: {worst.peak / 1e6:.1f} MPa at {worst.peak_time:.4f} s")
try:
    fields.picture(Path("out") / "beam_on_stops_stress.png", title="largest von Mises stress")
except kf.MissingDependency as missing:
    print(f"no picture: {missing}")

rest = kf.equilibrium(dropped(0.0))
for name in STOPS:
    ran, found = (float(of.contact(f"{name} stop").normal.flat[-1]) for of in (result, rest.history))
    print(f"the {name} stop carries {ran:.4f} N; the equilibrium says {found:.4f} N")
checked = (ran, found, 2e-3 * found)  # friction keeps some of what it held where the arm came to rest
