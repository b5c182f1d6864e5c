"""Carts released on a ramp: friction in their wheel bearings, proportional to the loads on the bearings.

A wheel rolls on its contact and is braked by its journal with the moment mu r times the load on its bearing, which
depends on the weight, the position and the deceleration of the payload. With enough friction the cart stands for ever.
"""

import math
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import fsolve

import kanefe as kf
from kanefe import shapes

G, TILT = 9.81, math.radians(5.0)
BODY, WHEEL, ROUND = 60.0, 6.0, 0.07  # kg, kg, kg m2
RIM, TUBE, JOURNAL = 0.12, 0.03, 0.02  # m: of the tyres, which touch with their outsides, and of the bearings
BASE, HEIGHT = 0.5, 0.25  # of an axle from the middle, and of the load above the axles, m
RADIUS, STIFFNESS = RIM + TUBE, 1e6


def cart(mu: float) -> kf.System:
    """Return a cart on a ramp, x down it and y away from it; each axle has one wheel."""
    scene = kf.System(gravity=(G * math.sin(TILT), -G * math.cos(TILT), 0))
    ramp = scene.add_surface("ramp", scene.ground, shapes.Plane("y"))
    pressed = 0.5 * (BODY + 2 * WHEEL) * G * math.cos(TILT) / STIFFNESS
    joint = kf.Planar(position=(0.0, RADIUS - pressed))
    body = scene.add_rigid_body("body", BODY, 3.0, com=(0, HEIGHT, 0), joint=joint)
    for name, x in (("front", BASE), ("rear", -BASE)):
        axle = kf.Revolute("z", friction=kf.JointFriction(mu, JOURNAL))
        wheel = scene.add_rigid_body(name, WHEEL, ROUND, parent=body, at=(x, 0, 0), joint=axle)
        tyre = scene.add_surface(f"{name} tyre", wheel, shapes.Torus(RIM, TUBE, axis="z"))
        law = kf.HuntCrossley(STIFFNESS, damping=1.0)
        scene.add_contact(f"{name} on ramp", tyre, ramp, normal=law, friction=kf.Coulomb(0.8))
    return scene


def balance(mu: float) -> np.ndarray:
    """Return acceleration (m/s2) and loads of the front and the rear bearing (N) of a rigid cart that rolls."""
    down, across = G * math.sin(TILT), G * math.cos(TILT)

    def forces(x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        a, up, braking = x[0], x[1:3], x[3:]  # what the axles bear, and the torques of their friction
        along = WHEEL * (a - down) + ROUND * a / RADIUS**2 + braking / RADIUS  # what they push their wheels with
        return along, up, np.hypot(along, up)

    def left_over(x: np.ndarray) -> np.ndarray:
        along, up, loads = forces(x)
        braking = x[3:]
        turning = BASE * (up[0] - up[1]) - HEIGHT * along.sum() - braking.sum()
        rest = BODY * (down - x[0]) - along.sum(), up.sum() - BODY * across, turning
        return np.concatenate((rest, braking - mu * JOURNAL * loads))

    found = fsolve(left_over, (down, *[0.5 * BODY * across] * 2, 1.0, 1.0), xtol=1e-12)
    return np.concatenate((found[:1], forces(found)[2]))


figure, (speeds, loads) = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
results = {}
for mu in (0.0, 0.2, 0.4, 0.9):
    result = results[mu] = cart(mu).simulate((0.0, 4.0))
    speeds.plot(result.times, result.velocity("body")[:, 0], label=f"mu = {mu:g}")
    if mu:
        front, rear = (result.load(f"friction of {name}")[:, -1] for name in ("front", "rear"))
        print(f"mu {mu:g}: the bearings carry {front[-1]:.1f} and {rear[-1]:.1f} N; {result.statistics['method']}")
for name in ("front", "rear"):
    loads.plot(results[0.2].times, results[0.2].load(f"friction of {name}")[:, -1], label=f"{name} bearing")
speeds.set(xlabel="t [s]", ylabel="speed of the cart [m/s]")
loads.set(xlabel="t [s]", ylabel="load, mu = 0.2 [N]")
for axes in (speeds, loads):
    axes.legend()
    axes.grid(alpha=0.3)
Path("out").mkdir(exist_ok=True)
figure.savefig(Path("out") / "carts_on_a_ramp.png", dpi=120)

standing = cart(0.9).simulate((0.0, 10.0))
late = standing.times > 8.0
print(f"with mu = 0.9 it stands: it moves by {np.ptp(standing.position('body')[late, 0]):.1e} m in two seconds")
print(f"energy is balanced to {abs(results[0.2].energy.balance_error).max():.1e} J")

wanted, *bearings = balance(0.2)
rolling = results[0.2]
t, v = rolling.times, rolling.velocity("body")[:, 0]
acceleration = float(np.polyfit(t[t > 1.0], v[t > 1.0], 1)[0])
carried = [float(rolling.load(f"friction of {name}")[-1, -1]) for name in ("front", "rear")]
print(f"bearings {carried[0]:.2f} and {carried[1]:.2f} N; of a rigid cart {bearings[0]:.2f} and {bearings[1]:.2f} N")
checked = (acceleration, float(wanted), 1e-4)
print(f"it goes down with {acceleration:.5f} m/s2; a rigid cart with {wanted:.5f} m/s2")
