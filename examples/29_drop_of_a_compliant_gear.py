"""Drop test of a helicopter on a compliant skid gear of exact beams, and where a linear gear departs from it.

Two arched leaf springs of glass-fibre composite carry the fuselage on two saddles each, a hinge at port and one that
slides across at starboard. Each is three exact beams; two skids of aluminium, linear bodies, close the loops between
them. At the lowest point the feet have turned by 0.36 rad: the skids spread by 0.2 m each, so that the ground bends the
springs by longer arms and they give way further than the linear gear, whose springs keep the arms they have at rest
and stretch. The ground is soft: it yields by 2 cm.
"""

import math
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
from kanefe_fem import Material, Rectangle, Tube, beam_model, exact_beam

GRAVITY, MASS = 9.81, 1500.0
LIFT = 2 / 3 * MASS * GRAVITY  # of the rotor, as in the limit drop test of 14 CFR 27.725
SPAN = 0.16  # s
STATIONS = {"forward": 0.9, "aft": -0.9}  # x of the springs from the centre of mass, m
SIDES = {"starboard": -1.0, "port": 1.0}  # sign of y
HALF, BELLY = 0.45, -0.8  # y and z of a saddle, m
RADIUS, ARC = 0.65, math.radians(85)  # of a leg, from the saddle down to the skid, m and rad
FOOT = np.array((HALF + RADIUS * math.sin(ARC), BELLY - RADIUS * (1 - math.cos(ARC))))  # y and z, m
SKID = np.linspace(1.4, -1.4, 29)  # x of the nodes of a skid, m
SHOES = (0, 6, 11, 17, 22, 28)  # nodes that touch the ground
ENDS = {name: int(np.abs(SKID - x).argmin()) for name, x in STATIONS.items()}

glass = Material(E=45e9, nu=0.3, rho=2000.0)
aluminium = Material(E=71.7e9, nu=0.33, rho=2810.0)
leaf, tube = Rectangle(0.14, 0.034), Tube(0.0762, 0.00635)  # m
viscous = kf.RayleighDamping(0.0, 2e-4)


def airframe_over_ground(height: float) -> tuple:
    """Return a scene, its airframe after a fall from a height (m), 1 mm before touch-down, and the ground."""
    scene = kf.System(gravity=(0, 0, -GRAVITY))
    falling = kf.Free(position=(0, 0, 1e-3 - FOOT[1]), velocity=(0, 0, -math.sqrt(2 * GRAVITY * height)))
    airframe = scene.add_rigid_body("airframe", MASS, (700.0, 2400.0, 2600.0), joint=falling)
    scene.add_force(airframe, (0, 0, LIFT))
    return scene, airframe, scene.add_surface("ground", scene.ground, kf.shapes.Plane("z"))


def stand(scene: kf.System, side: str, shoes: list, ground: object) -> None:
    """Let a skid touch the ground with its shoes."""
    normal, friction = kf.HuntCrossley(2e6, 0.3), kf.Coulomb(0.3, stiffness=4e5, damping=2e3)
    scene.add_contact(f"{side} skid", shoes, ground, normal=normal, friction=friction)


def exact_gear(height: float, functions: int = 4) -> kf.System:
    """Return the aircraft on springs of exact beams with so many functions of the bending in their plane."""
    scene, airframe, ground = airframe_over_ground(height)
    basis = {"twist": 2, "curvature_y": functions, "curvature_z": 2}
    out = {side: np.array(((0, -sign, 0), (sign, 0, 0), (0, 0, 1.0))) for side, sign in SIDES.items()}  # along the beam
    made = {"basis": basis, "damping": viscous}
    across = exact_beam(
        2 * HALF, leaf, glass, axes=out["starboard"], interfaces={"port": 0.0, "starboard": 2 * HALF}, **made
    )
    legs = {
        side: exact_beam(RADIUS * ARC, leaf, glass, curvature=(0, 1 / RADIUS, 0), axes=axes, **made)
        for side, axes in out.items()
    }
    feet = {}
    for name, x in STATIONS.items():
        middle = scene.add_flexible_body(
            f"{name} middle", across, parent=airframe, at=(x, HALF, BELLY), joint=kf.Revolute("x")
        )
        block = scene.add_rigid_body(
            f"{name} block", 2.0, 0.01, parent=airframe, at=(x, -HALF, BELLY), joint=kf.Prismatic("y")
        )
        scene.add_loop_joint(f"{name} saddle", kf.Spherical(), block, middle.interface("starboard"))
        for side, leg in legs.items():
            member = scene.add_flexible_body(f"{name} {side} leg", leg, parent=middle.interface(side))
            feet[name, side] = member.interface("tip")
    nodes = [(x - STATIONS["forward"], 0, 0) for x in SKID]
    model = beam_model(nodes, [(i, i + 1) for i in range(len(nodes) - 1)], tube, aluminium, groups=ENDS)
    body = kf.flexible_body(
        model,
        {"forward": "clamped", "aft": "rigid"},
        reduction=kf.CraigBampton(modes=4, loads=("gravity",)),
        damping=viscous,
    )
    for side in SIDES:
        skid = scene.add_flexible_body(f"{side} skid", body, parent=feet["forward", side])
        scene.add_loop_joint(f"{side} foot", kf.Fixed(), feet["aft", side], skid.interface("aft"))
        stand(scene, side, [skid.node(node) for node in SHOES], ground)
    return scene


def linear_gear(height: float) -> tuple[kf.System, int]:
    """Return the aircraft on the same gear as one linear body, and the number of nodes of a spring."""
    scene, airframe, ground = airframe_over_ground(height)
    turns = np.linspace(ARC, 0, 17)
    leg = np.column_stack((HALF + RADIUS * np.sin(turns), BELLY - RADIUS * (1 - np.cos(turns))))
    across = np.column_stack((np.linspace(HALF, -HALF, 9)[1:-1], np.full(7, BELLY)))
    profile = np.vstack((leg, across, leg[::-1] * (-1, 1)))  # y and z, from port to starboard
    nodes, elements, tips, held = [], [], {}, {}
    for name, x in STATIONS.items():
        first = len(nodes)
        tips |= {(name, "port"): first, (name, "starboard"): first + len(profile) - 1}
        held |= {f"{name} hinge": first + 16, f"{name} slide": first + 24}
        nodes += [(x, *place) for place in profile]
        elements += [(first + i, first + i + 1) for i in range(len(profile) - 1)]
    springs, shoes = len(elements), {}
    for side, sign in SIDES.items():
        line = {ENDS[name]: tips[name, side] for name in STATIONS}
        for i, x in enumerate(SKID):
            if i not in line:
                line[i] = len(nodes)
                nodes.append((x, sign * FOOT[0], FOOT[1]))
        elements += [(line[i], line[i + 1]) for i in range(len(SKID) - 1)]
        shoes[side] = [line[node] for node in SHOES]
    skids = len(elements) - springs
    model = beam_model(
        nodes,
        elements,
        [leaf] * springs + [tube] * skids,
        [glass] * springs + [aluminium] * skids,
        theory="euler-bernoulli",
        groups=held,
    )
    hinge, slide = kf.Interface(("x", "y", "z", "ry", "rz")), kf.Interface(("x", "z"))
    saddles = {name: hinge if name.endswith("hinge") else slide for name in held}
    body = kf.flexible_body(model, saddles, reduction=kf.CraigBampton(modes=16), damping=viscous)
    gear = scene.add_flexible_body("gear", body, parent=airframe)
    for side, at in shoes.items():
        stand(scene, side, [gear.node(node) for node in at], ground)
    return scene, len(profile)


def dropped(scene: kf.System) -> tuple[kf.Result, int, float]:
    """Return a run, its lowest output, and the way of the airframe until then (m)."""
    result = scene.simulate((0.0, SPAN), method="radau5", rtol=1e-4, output_step=1e-3)
    height = result.position("airframe")[:, 2]
    lowest = int(height.argmin())
    return result, lowest, float(height[0] - height[lowest])


figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained", width_ratios=(1.5, 1))
heights, turned, ways = (0.05, 0.15, 0.4), [], []
for height in heights:
    scene, count = linear_gear(height)
    linear, at, way = dropped(scene)
    result, lowest, exact_way = dropped(exact_gear(height))
    turned.append(2 * math.acos(float(result.rotation("forward port leg", "tip")[lowest, 0])))
    ways.append((way, exact_way))
    print(f"dropped from {height:.2f} m: feet turn by {turned[-1]:.2f} rad; way {exact_way:.4f} m, linear {way:.4f} m")
more = dropped(exact_gear(heights[-1], functions=6))[2]
print(f"way with 4 and 6 functions of the bending: {exact_way:.5f}, {more:.5f} m")

BEAMS = ("starboard leg", "middle", "port leg")
for run, frame, colour, label in ((result, 0, "0.7", "at touch-down"), (result, lowest, "tab:blue", "exact beams")):
    for part in BEAMS:
        y, z = run.nodal_positions(f"forward {part}", frames=[frame])[0].T[1:]
        left.plot(y, z, color=colour, label=label if part == "middle" else None)
y, z = linear.nodal_positions("gear", frames=[at])[0][:count].T[1:]
left.plot(y, z, "--", color="tab:red", label="linear gear")
left.axhline(0.0, color="0.4", linewidth=0.8)
left.set(xlabel="y [m]", ylabel="z [m]", title=f"forward spring at its lowest, dropped from {heights[-1]:.1f} m")
left.set_aspect("equal")
left.set_ylim(-0.1, 0.9)
left.legend(loc="upper center", ncols=3, fontsize="small")
way, exact_way_of = np.array(ways).T
right.plot(turned, exact_way_of, "o-", color="tab:blue", label="exact beams")
right.plot(turned, way, "s--", color="tab:red", label="linear gear")
right.set(xlabel="turn of the feet [rad]", ylabel="way of the airframe to its lowest [m]", xlim=0, ylim=0)
right.grid(color="0.9")
right.legend()
out = Path("out")
out.mkdir(exist_ok=True)
figure.savefig(out / "drop_of_a_compliant_gear.png", dpi=120)

energy = result.energy
moved = float((energy.dissipated + energy.elastic)[lowest])
off = float(np.abs(energy.balance_error).max())
print(f"at the lowest: strain {energy.elastic[lowest]:.0f} J, friction and damping {energy.dissipated[lowest]:.0f} J")
print(f"the energy is off by {off:.1e} J")
checked = (off / moved, 0.0, 1e-6)
