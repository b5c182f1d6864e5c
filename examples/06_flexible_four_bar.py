"""A horizontal crank-rocker whose coupler and rocker are flexible: swing of the rocker and bending of the bars."""

import math

import numpy as np

import kanefe as kf
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

aluminium = Material(E=70e9, nu=0.3, rho=2700.0)
base, crank_length, coupler_length, rocker_length = 0.40, 0.10, 0.35, 0.30  # m
spin, up = 4 * math.pi, 0.2  # rad/s, s


def bar(length: float) -> kf.FlexibleBody:
    """Return a bar of 15 mm x 3 mm that bends in the plane of the linkage and keeps its length."""
    model = straight_beam(length, Rectangle(width=0.003, height=0.015), aluminium, elements=8, planar=True)
    return beam_body(model, {"root": "clamped", "tip": kf.Interface(fixed=("x",))}, reduction=kf.CraigBampton(modes=0))


ramp = kf.Motion(
    position=lambda t: spin * (t**3 / up**2 - 0.5 * t**4 / up**3) if t < up else spin * (t - 0.5 * up),
    velocity=lambda t: spin * (3 * (t / up) ** 2 - 2 * (t / up) ** 3) if t < up else spin,
    acceleration=lambda t: spin * (6 * t / up**2 - 6 * t**2 / up**3) if t < up else 0.0,
)
scene = kf.System()
crank = scene.add_rigid_body("crank", 0.1, 1e-4, joint=kf.Revolute("z", motion=ramp))
coupler = scene.add_flexible_body(
    "coupler",
    bar(coupler_length),
    parent=crank,
    at=(crank_length, 0, 0),
    joint=kf.Revolute("z", position=kf.Guess(1.0)),
)
rocker = scene.add_flexible_body(
    "rocker", bar(rocker_length), at=(base, 0, 0), joint=kf.Revolute("z", position=kf.Guess(1.8))
)
scene.add_loop_joint("pin", kf.Revolute("z"), coupler.interface("tip"), rocker.interface("tip"))
result = scene.simulate((0.0, 0.6), rtol=1e-5, method="dop853", output_step=0.003)

angle = result.joint_coordinates("rocker")[:, 0]
bending = np.abs(result.deflection("coupler", "tip")[:, 1]).max()
force = np.linalg.norm(result.loop_force("pin")[:, :2], axis=1).max()
print(f"the rocker swings from {math.degrees(angle.min()):.3f} to {math.degrees(angle.max()):.3f} degrees")
print(f"the coupler bends by {1e3 * bending:.4f} mm at most, the pin carries {force:.3f} N at most")
print(f"the energy balances to {np.abs(result.energy.balance_error).max():.1e} J")


def rocker_angle(reach: float) -> float:
    """Return the angle of a rigid rocker when its pin is at a distance from the crank's bearing (law of cosines)."""
    return math.pi - math.acos((base**2 + rocker_length**2 - reach**2) / (2 * base * rocker_length))


# The rocker reverses where crank and coupler are collinear; the bars bend by about 1e-3 rad.
rigid = rocker_angle(coupler_length - crank_length) - rocker_angle(coupler_length + crank_length)
checked = (angle.max() - angle.min(), rigid, 1e-3)  # rad
