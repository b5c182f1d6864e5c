"""A rotor on a flexible shaft: Campbell diagrams in two frames, critical speeds, and instability due to damping.

A disc sits near one end of a shaft of beams in two bearings. Its tilt couples to the spin, so that the whirl splits
into backward and forward. In the ground frame an unbalance turns once per revolution: the critical speeds are where a
frequency crosses the line of order 1. In the frame that spins with the shaft an unbalance is at rest, and a frequency
falls to zero there. An unbalance excites the forward whirl only: crossing the backward whirl has no effect.

Damping of the shaft acts in the frame in which its material is at rest: if the shaft spins, the forward whirl grows
above its critical speed.
"""

from pathlib import Path

import numpy as np

import kanefe as kf
from kanefe_fem import Material
from kanefe_fem.beams.body import beam_body, beam_model
from kanefe_fem.beams.sections import SolidCircle

steel = Material(E=210e9, nu=0.3, rho=7850.0)
places = np.linspace(0.0, 1.0, 13)
shaft_model = beam_model(
    np.column_stack((places, 0 * places, 0 * places)),
    [(i, i + 1) for i in range(12)],
    SolidCircle(0.03),
    steel,
    groups={"left": 0, "disc": 2, "right": 12},
)
bearings = {"left": kf.Interface(fixed=("x", "y", "z", "rx")), "right": kf.Interface(fixed=("y", "z"))}
shaft_body = beam_body(
    shaft_model,
    {**bearings, "disc": "rigid"},
    reduction=kf.CraigBampton(modes=8),
    damping=kf.ModalDamping(0.002),
    stiffening="full",
)
disc = {"mass": 12.0, "inertia": (0.15, 0.08, 0.08)}


def seen_from_the_ground(speed: float) -> kf.System:
    """Return a disc that spins on a shaft that does not."""
    scene = kf.System()
    shaft = scene.add_flexible_body("shaft", shaft_body)
    spin = kf.Revolute("x", motion=kf.Motion.steady(speed))
    scene.add_rigid_body("disc", **disc, parent=shaft.interface("disc"), joint=spin)
    return scene


def seen_from_the_shaft(speed: float) -> kf.System:
    """Return shaft and disc in the frame that spins with both."""
    scene = kf.System()
    shaft = scene.add_flexible_body("shaft", shaft_body, joint=kf.Revolute("x", motion=kf.Motion.steady(speed)))
    scene.add_rigid_body("disc", **disc, parent=shaft.interface("disc"))
    return scene


print(kf.linearise(seen_from_the_ground(0.0)).modes())

speeds = np.linspace(0.0, 600.0, 31)
ground = kf.campbell(seen_from_the_ground, speeds, modes=5)
ground.plot(Path("out") / "campbell.png", orders=(1,))
backward, forward = ground.critical_speeds(order=1)[:2]
print(backward, forward, sep="\n")

shaft = kf.campbell(seen_from_the_shaft, speeds, modes=5)
shaft.plot(Path("out") / "campbell_spinning.png", orders=(0,))
(critical,) = shaft.critical_speeds(order=0)
(unstable,) = shaft.stability_limits()
print(f"seen from the shaft the forward whirl stands still at {critical.speed:.2f} rad/s; {unstable}")

# the shaft's own spin, which only one of the scenes has, is a part in 10,000
checked = (forward.speed / critical.speed, 1.0, 1e-3)
