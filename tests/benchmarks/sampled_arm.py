"""An arm of two flexible links that a controller sampled at 1 kHz moves, against the peer with a Python function."""

from __future__ import annotations

from typing import Any

import numpy as np

import kanefe as kf
from benchmarks.arm_torque import torque
from benchmarks.clocks import Race, check_agreement, coarsest, seconds
from benchmarks.goals import Figure, Goal
from benchmarks.peer_process import Peers
from kanefe.equations.model import Model
from kanefe.integrate.run import integrate
from kanefe.result import Result
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

ERROR = 1e-4
"""Of the place of the tool amid the motion, m, which both sides have to reach: each against its own finest run."""

GOAL = Goal("PD arm, controller at 1 kHz: CPU time for 1e-4 m / Exudyn's with a Python function", 0.05)

ALUMINIUM = Material(E=70e9, nu=0.33, rho=2700.0)
END, EVERY, SECONDS = 0.5, 1e-3, 0.6
DAMPING = 1e-4
"""Of K, s: 3 % at 100 Hz."""

ELEMENTS, PEER_ELEMENTS, MODES = 10, 4, 4
ELBOW = {"mass": 1.5, "inertia": 2e-3, "at": 0.05}
TOOL = {"mass": 2.0, "inertia": 5e-3}
GRAVITY = 9.81
LINKS = (
    {"length": 0.6, "angle": 0.3, "to": 1.2, "kp": 1000.0, "kd": 40.0},
    {"length": 0.5, "angle": -0.8, "to": -0.2, "kp": 200.0, "kd": 8.0},
)
SECTIONS = (Rectangle(width=0.08, height=0.06), Rectangle(width=0.06, height=0.045))

SAME = 2e-3
"""Difference of the two sides' finest runs, of the arm's length: four elements bend by some percent less."""

TOLERANCES = tuple(10.0 ** (-0.5 * i) for i in range(6, 13))
FINEST = 1e-9
PEER_STEPS = tuple(EVERY / 2**i for i in range(6))


def arm_scene() -> kf.System:
    """Return the arm without its controller."""
    scene = kf.System(gravity=(0.0, -GRAVITY, 0.0))
    bodies = [_body(link["length"], section) for link, section in zip(LINKS, SECTIONS, strict=True)]
    one = scene.add_flexible_body("one", bodies[0], joint=kf.Revolute("z", position=LINKS[0]["angle"]))
    elbow = scene.add_rigid_body("elbow", ELBOW["mass"], ELBOW["inertia"], parent=one.interface("tip"))
    joint = kf.Revolute("z", position=LINKS[1]["angle"])
    two = scene.add_flexible_body("two", bodies[1], parent=elbow, at=(ELBOW["at"], 0.0, 0.0), joint=joint)
    scene.add_rigid_body("tool", TOOL["mass"], TOOL["inertia"], parent=two.interface("tip"))
    return scene


def arm() -> Model:
    """Return our side."""

    def control(t: float, reads: np.ndarray, memory: dict[str, Any]) -> tuple[float, float]:
        shoulder = torque(t, LINKS[0], SECONDS, reads[0], reads[2])
        return shoulder, torque(t, LINKS[1], SECONDS, reads[1], reads[3])

    return controlled(arm_scene(), control).freeze()


def controlled(scene: kf.System, function: Any) -> kf.System:
    """Return the scene with a controller of its two joints."""
    reads = [f"joint_{what} {name}" for what in ("coordinates", "speeds") for name in ("one", "two")]
    scene.add_controller("pd", function, every=EVERY, reads=reads, drives=("motor one", "motor two"))
    return scene


def _body(length: float, section: Rectangle) -> kf.FlexibleBody:
    beam = straight_beam(length, section, ALUMINIUM, elements=ELEMENTS, planar=True)
    ends = {"root": "clamped", "tip": "rigid"}
    return beam_body(
        beam, ends, reduction=kf.CraigBampton(modes=MODES), damping=kf.RayleighDamping(mass=0.0, stiffness=DAMPING)
    )


def told() -> dict[str, Any]:
    """Return what the peer needs to build the same."""
    links = [{**link, **_numbers(section)} for link, section in zip(LINKS, SECTIONS, strict=True)]
    return {
        "links": links,
        "elbow": ELBOW,
        "tool": TOOL,
        "gravity": GRAVITY,
        "elements": PEER_ELEMENTS,
        "damping": DAMPING,
        "every": EVERY,
        "time": SECONDS,
    }


def _numbers(section: Rectangle) -> dict[str, float]:
    """Return the stiffness and inertia of a section that bends in the plane of the arm."""
    area, second = section.width * section.height, section.height * section.width**3 / 12.0
    G = ALUMINIUM.E / (2.0 * (1.0 + ALUMINIUM.nu))
    return {
        "line_mass": ALUMINIUM.rho * area,
        "line_inertia": ALUMINIUM.rho * second,
        "bending": ALUMINIUM.E * second,
        "axial": ALUMINIUM.E * area,
        "shear": 5.0 / 6.0 * G * area,
    }


def run(model: Model, rtol: float, method: str = "auto") -> np.ndarray:
    """Return the place of the tool at the end."""
    found = integrate(model, (0.0, END), method=method, rtol=rtol, output_step=END, progress=False)
    return Result(model, found).position("tool")[-1, :2]


def sampled_arm(peers: Peers, rounds: int) -> list[Figure]:
    """Compare runs of both sides, each with the largest tolerance or step from which on its error is small enough."""
    model = arm()
    peers.ask("build_arm", name="arm", arm=told())

    def theirs(h: float) -> dict[str, Any]:
        return peers.ask("solve", name="arm", steps=round(END / h), h=h)

    places = [np.array(theirs(h)["end"]) for h in PEER_STEPS]
    # its error falls with the step, as the torques jump at samples
    limit = 2.0 * places[-1] - places[-2]
    exact = run(model, FINEST, "dop853")
    check_agreement("arm", exact, limit, SAME)
    rtol = coarsest(TOLERANCES, lambda rtol: float(np.linalg.norm(run(model, rtol) - exact)), ERROR)
    error_of = dict(zip(PEER_STEPS, (float(np.linalg.norm(place - limit)) for place in places), strict=True))
    h = coarsest(PEER_STEPS, error_of.__getitem__, ERROR)
    race = Race(lambda: seconds(lambda: run(model, rtol)), lambda: float(theirs(h)["seconds"]), rounds)
    remark = (
        f"rtol {rtol:.2g} in {1e3 * race.ours:.3g} ms; Exudyn, {PEER_ELEMENTS} elements a link, steps of {h:.3g} s in "
        f"{1e3 * race.theirs:.3g} ms"
    )
    return [GOAL.figure(race.ratio, remark)]


GROUPS = {sampled_arm: [GOAL]}
