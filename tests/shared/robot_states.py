"""Robots in any state, by names of joints: states at random that keep couplings, and accelerations of the scene."""

from __future__ import annotations

from typing import Any

import numpy as np

import kanefe as kf

Asked = dict[str, Any]


def asked_state(scene: kf.RobotScene, seed: int) -> Asked:
    """Return positions and speeds at random of the joints with one coordinate, and of a floating base.

    What is coupled to other joints follows them.
    """
    rng = np.random.default_rng(seed)
    entries = {entry.name: entry for entry in scene._entries}
    names = [name for name, body in scene.joints.items() if len(entries[body].joint.speed_names) == 1]
    asked: Asked = {
        "gravity": scene.gravity.tolist(),
        "positions": {name: float(rng.uniform(-1.0, 1.0)) for name in names},
        "speeds": {name: float(rng.uniform(-1.0, 1.0)) for name in names},
        "couplings": [],
    }
    bodies = {number: name for name, body in scene.joints.items() for number, e in enumerate(entries) if e == body}
    for constraint in scene._constraints:
        (row,) = constraint.rows
        terms = {bodies[number]: c for number, _, c in row.terms}
        follower, *leaders = terms
        asked["couplings"].append(terms)
        for what, constant in (("positions", row.constant), ("speeds", 0.0)):
            others = sum(terms[name] * asked[what][name] for name in leaders)
            asked[what][follower] = (constant - others) / terms[follower]
    if any(entry.joint.is_free and entry.parent < 0 for entry in entries.values()):
        e = rng.normal(size=4)
        asked["base"] = {
            "position": rng.uniform(-1, 1, 3).tolist(),
            "orientation": (e / np.linalg.norm(e)).tolist(),
            "velocity": rng.uniform(-1, 1, 3).tolist(),
            "angular_velocity": rng.uniform(-1, 1, 3).tolist(),
        }
    return asked


def accelerations(scene: kf.RobotScene, asked: Asked) -> Asked:
    """Return the acceleration of each joint by name, and of a floating base, of what `asked_state` asks for."""
    model = scene.copy().freeze()
    names = {name: place for place, name in enumerate(model.state_names)}
    units = {name.rpartition(": ")[0]: name.rpartition("[")[2] for name in names if "rate" not in name}
    y = model.initial_state.copy()
    at_rate = {}
    for joint, body in scene.joints.items():
        if joint not in asked["positions"]:
            continue
        angle = units[body] == "rad]"
        y[names[f"{body}: {'angle [rad]' if angle else 'distance [m]'}"]] = asked["positions"][joint]
        at_rate[joint] = names[f"{body}: {'rate [rad/s]' if angle else 'rate [m/s]'}"]
        y[at_rate[joint]] = asked["speeds"][joint]
    base = asked.get("base")
    at_base = []
    if base is not None:
        (body,) = {entry.name for entry in scene._entries if entry.joint.is_free}
        values = [*base["position"], *base["orientation"]]
        for name, value in zip(kf.Free.coordinate_names, values, strict=True):
            y[names[f"{body}: {name}"]] = value
        at_base = [names[f"{body}: {name}"] for name in kf.Free.speed_names]
        y[at_base] = [*base["velocity"], *base["angular_velocity"]]
    rates = model.rhs(0.0, y)
    found: Asked = {"joints": {joint: float(rates[place]) for joint, place in at_rate.items()}}
    return found if base is None else {**found, "base": rates[at_base].tolist()}


def difference(found: Asked, expected: Asked) -> float:
    """Return the largest difference of accelerations, of the largest of them; of rotors on a post all are zero."""
    ours = np.array([*(found["joints"][name] for name in expected["joints"]), *found.get("base", ())])
    theirs = np.array([*expected["joints"].values(), *expected.get("base", ())])
    return float(abs(ours - theirs).max() / max(abs(theirs).max(), 1e-3))
