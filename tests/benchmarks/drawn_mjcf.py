"""Models of MJCF drawn at random, with all that is read of them, against MuJoCo's accelerations."""

from __future__ import annotations

import tempfile
import warnings
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.held_mjcf import Held, accelerations, held_by

KINDS = "hinge", "slide", "ball"
"""Of joints below a free one; MuJoCo takes a ball as the last one of a body only."""

FLAGS = "spring", "damper", "gravity", "equality", "frictionloss", "limit", "actuation", "constraint"
"""Of which each is disabled in a tenth of the models."""

EXPECTED = {
    "actuators",
    "actuators that are off",
    "equalities that are off",
    "limits of joints (limit_stiffness= takes them)",
    "shapes, which touch nothing",
}
"""Kinds in `not_taken` of what does not act in these models: actuators without input, shapes without contacts."""


class Drawing:
    """A model of one to six bodies, each on up to two joints, in one tree or several."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.bodies = int(self.rng.integers(1, 7))
        self.off = {flag for flag in FLAGS if self.rng.random() < 0.1}
        self.axes: list[str] = []
        self.numbers = count()
        parents = [-1, *(int(self.rng.integers(-1, body)) for body in range(1, self.bodies))]
        self.inside = [[body for body, parent in enumerate(parents) if parent == of] for of in range(self.bodies)]
        roots = [body for body, parent in enumerate(parents) if parent == -1]
        tree = "".join(self._body(body, self.rng.random() < 0.3) for body in roots)
        flags = " ".join(f'{flag}="disable"' for flag in ("contact", *sorted(self.off)))
        head = f"<option gravity='{self._text(3, 5.0)}'><flag {flags}/></option>"
        self.text = f"<mujoco>{head}<worldbody>{tree}</worldbody>{self._equality()}{self._actuator()}</mujoco>"

    def _body(self, number: int, is_free: bool = False) -> str:
        rng = self.rng
        gravity = f"gravcomp='{rng.choice((0.4, 1.0, 1.7))}'" if rng.random() < 0.2 else ""
        first = [self._joint(str(rng.choice(KINDS[:2])))] if rng.random() < 0.4 and not is_free else []
        joints = [*first, self._joint("free" if is_free else str(rng.choice(KINDS)))]
        rest = "".join(self._body(child) for child in self.inside[number])
        if rng.random() < 0.3:
            rest = f"<frame {self._pose()}>{rest}</frame>"
        mass = self._shapes() if rng.random() < 0.3 else self._inertial()
        return f"<body name='b{number}' {self._pose()} {gravity}>{''.join(joints)}{mass}{rest}</body>"

    def _inertial(self) -> str:
        moments = " ".join(f"{x:.3f}" for x in 1.0 + self.rng.uniform(0.0, 0.8, 3))
        return f"<inertial {self._pose()} mass='{self.rng.uniform(0.5, 3.0):.3f}' diaginertia='{moments}'/>"

    def _shapes(self) -> str:
        kinds = self.rng.choice(("sphere", "box", "capsule", "cylinder", "ellipsoid"), int(self.rng.integers(1, 3)))
        sizes = [" ".join(f"{x:.3f}" for x in self.rng.uniform(0.1, 0.3, 3)) for _ in kinds]
        return "".join(f"<geom type='{k}' size='{s}' {self._pose()}/>" for k, s in zip(kinds, sizes, strict=True))

    def _joint(self, kind: str) -> str:
        rng, name = self.rng, f"j{next(self.numbers)}"
        parts = [f"name='{name}' type='{kind}'"]
        if kind != "free":
            parts.append(f"pos='{self._text(3, 0.2)}'")
        if kind in KINDS[:2]:
            self.axes.append(name)
            ref, springref = rng.uniform(-0.5, 0.5, 2)
            parts.append(f"axis='{self._text(3)}' ref='{ref:.3f}' springref='{springref:.3f}'")
            if rng.random() < 0.3:
                parts.append(f"actuatorfrcrange='-{rng.uniform(0.1, 9.0):.2f} {rng.uniform(0.1, 9.0):.2f}'")
            if self.off & {"limit", "constraint"}:
                parts.append("range='-.1 .1'")
        if self.off & {"frictionloss", "constraint"}:
            parts.append("frictionloss='2'")
        if rng.random() < 0.3:
            parts.append("actuatorgravcomp='true'")
        for name in ("stiffness", "damping"):
            if rng.random() < 0.3:
                parts.append(f"{name}='{self._text(int(rng.choice((1, 3))), 3.0)}'")
        return f"<joint {' '.join(parts)}/>"

    def _equality(self) -> str:
        """Return an equality in half of the models: it holds in the initial pose, or two joints hold it alone."""
        rng, kind = self.rng, str(self.rng.choice(("connect", "weld", "joint", "", "", "")))
        if kind == "joint" and self.axes:
            names = rng.permutation(self.axes)[:2]
            joints = " ".join(f"joint{i}='{name}'" for i, name in enumerate(names, start=1))
            return f"<equality><joint {joints} polycoef='{self._text(2)} 0 0 0'/></equality>"
        if kind not in ("connect", "weld"):
            return ""
        one, *two = rng.permutation(self.bodies)[:2]
        ends = f"body1='b{one}'" + (f" body2='b{two[0]}'" if two and rng.random() < 0.7 else "")
        turns = " torquescale='0'" if kind == "weld" and rng.random() < 0.3 else ""
        return f"<equality><{kind} {ends} anchor='{self._text(3)}'{turns}/></equality>"

    def _actuator(self) -> str:
        has = self.axes and self.rng.random() < 0.5
        return f"<actuator><motor joint='{self.rng.choice(self.axes)}'/></actuator>" if has else ""

    def _pose(self) -> str:
        return f"pos='{self._text(3)}' quat='{self._text(4)}'"

    def _text(self, numbers: int, size: float = 1.0) -> str:
        return " ".join(f"{x:.4f}" for x in size * self.rng.uniform(-1.0, 1.0, numbers))


def difference(seed: int) -> float | None:
    """Return the largest difference of accelerations in a state at random, relative to the largest acceleration.

    None: something of the model is named as not taken.
    """
    import mujoco

    import kanefe as kf
    from kanefe.robots.scene import NotTakenWarning

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drawn.xml"
        path.write_text(Drawing(seed).text, encoding="utf-8")
        peer = mujoco.MjModel.from_xml_path(str(path))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotTakenWarning)
            scene = kf.read_mjcf(path)
    if not set(scene.not_taken) <= EXPECTED:
        return None
    state, held = state_of(peer, np.random.default_rng(seed))
    right = accelerations(peer, state, held)
    ours = scene.freeze().rhs(0.0, np.concatenate((state.qpos, state.qvel)))[peer.nq : peer.nq + peer.nv]
    return float(abs(ours - right).max() / max(1.0, abs(right).max()))


def state_of(peer: Any, rng: np.random.Generator) -> tuple[Any, Held]:
    """Return a state at random that keeps to the equalities, and what holds it: with loops in the initial pose."""
    import mujoco

    state = mujoco.MjData(peer)
    if not any(peer.eq_type[i] != mujoco.mjtEq.mjEQ_JOINT for i in range(peer.neq)):
        mujoco.mj_integratePos(peer, state.qpos, rng.uniform(-0.7, 0.7, peer.nv), 1.0)
    state.qvel[:] = rng.uniform(-1.0, 1.0, peer.nv)
    held = held_by(peer, state)
    state.qvel[:] -= np.linalg.pinv(held.rows, rcond=1e-10) @ (held.rows @ state.qvel)
    return state, held_by(peer, state)
