"""A rotor on a flexible shaft: equilibrium, modes, and the Campbell diagram with its critical speeds.

A disc sits off the middle of a shaft of beams in two bearings; its tilt couples to the spin, so that whirl splits
into backward and forward. Seen from the frame that spins with the shaft, an unbalance stands still: the critical
speeds are where a frequency falls to zero.
"""

from pathlib import Path

import numpy as np

import kanefe as kf
from kanefe_fem import Material
from kanefe_fem.beams import beam_body, beam_model
from kanefe_fem.sections import SolidCircle

steel = Material(E=210e9, nu=0.3, rho=7850.0)
places = np.linspace(0.0, 1.0, 13)
shaft_model = beam_model(
    np.column_stack((places, 0 * places, 0 * places)),
    [(i, i + 1) for i in range(12)],
    SolidCircle(0.03),
    steel,
    groups={"left": 0, "disc": 4, "right": 12},
)
bearings = {"left": kf.Interface(fixed=("x", "y", "z", "rx")), "right": kf.Interface(fixed=("y", "z"))}
shaft_body = beam_body(
    shaft_model, {**bearings, "disc": "rigid"}, reduction=kf.CraigBampton(modes=8), stiffening="inertial"
)


def rotor(speed: float) -> kf.System:
    """Return the rotor in the frame that spins with it."""
    scene = kf.System()
    shaft = scene.add_flexible_body("shaft", shaft_body, joint=kf.Revolute("x", motion=kf.Motion.steady(speed)))
    scene.add_rigid_body("disc", 12.0, (0.15, 0.08, 0.08), parent=shaft.interface("disc"))
    return scene


print(kf.linearise(rotor(0.0)).modes())
diagram = kf.campbell(rotor, np.linspace(0.0, 600.0, 31), modes=4)
diagram.plot(Path("out") / "campbell.png", orders=())
critical = [speed for speed, _ in diagram.critical_speeds(order=0)]
print(f"critical speeds of an unbalance: {', '.join(f'{speed:.2f}' for speed in critical)} rad/s")

# there the shaft bends without resistance: the stiffness seen from the spinning frame is singular
still, critical_stiffness = (kf.equilibrium(rotor(speed)).linearise().stiffness for speed in (0.0, critical[0]))
softest = abs(np.linalg.eigvalsh(critical_stiffness)).min() / np.linalg.eigvalsh(still).min()
print(f"softest stiffness at {critical[0]:.2f} rad/s, of that at rest: {softest:.1e}")

# the straight line between two speeds of the diagram
checked = (softest, 0.0, 1e-3)
