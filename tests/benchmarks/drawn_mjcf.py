"""Trees of MJCF drawn at random, with springs, dampers and flags of all kinds, against MuJoCo's accelerations."""

from __future__ import annotations

import tempfile
import warnings
from pathlib import Path

import numpy as np

KINDS = "hinge", "slide", "ball"
"""Of joints below a free one; MuJoCo takes a ball as the last one of a body only."""

FLAGS = "spring", "damper", "gravity"
"""Of which each is disabled in a tenth of the trees."""


def file_of(seed: int) -> str:
    """Return a tree of one to six bodies, each on up to two joints, the first perhaps on a free one."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 7))
    inside: list[list[int]] = [[] for _ in range(count)]
    for body in range(1, count):
        inside[int(rng.integers(0, body))].append(body)
    flags = " ".join(f'{flag}="disable"' for flag in FLAGS if rng.random() < 0.1)
    tree = _body(0, inside, rng, rng.random() < 0.3)
    head = f"<option gravity='{_text(rng, 3, 5.0)}'><flag {flags}/></option>"
    return f"<mujoco>{head}<worldbody>{tree}</worldbody></mujoco>"


def _body(number: int, inside: list[list[int]], rng: np.random.Generator, is_free: bool) -> str:
    gravity = f"gravcomp='{rng.choice((0.4, 1.0, 1.7))}'" if rng.random() < 0.2 else ""
    first = [_joint(rng, str(rng.choice(KINDS[:2])))] if rng.random() < 0.4 else []
    joints = [_joint(rng, "free")] if is_free else [*first, _joint(rng, str(rng.choice(KINDS)))]
    moments = " ".join(f"{x:.3f}" for x in 1.0 + rng.uniform(0.0, 0.8, 3))
    pose = f"pos='{_text(rng, 3)}' quat='{_text(rng, 4)}'"
    inertial = f"<inertial {pose} mass='{rng.uniform(0.5, 3.0):.3f}' diaginertia='{moments}'/>"
    rest = "".join(_body(child, inside, rng, False) for child in inside[number])
    return f"<body pos='{_text(rng, 3)}' quat='{_text(rng, 4)}' {gravity}>{''.join(joints)}{inertial}{rest}</body>"


def _joint(rng: np.random.Generator, kind: str) -> str:
    place = "" if kind == "free" else f"pos='{_text(rng, 3, 0.2)}'"
    if kind in ("hinge", "slide"):
        place += f" axis='{_text(rng, 3)}' ref='{rng.uniform(-0.5, 0.5):.3f}' springref='{rng.uniform(-0.5, 0.5):.3f}'"
    spring, damper = (
        f"{name}='{_text(rng, int(rng.choice((1, 3))), 3.0)}'" if rng.random() < 0.3 else ""
        for name in ("stiffness", "damping")
    )
    return f"<joint type='{kind}' {place} {spring} {damper}/>"


def _text(rng: np.random.Generator, count: int, size: float = 1.0) -> str:
    return " ".join(f"{x:.4f}" for x in size * rng.uniform(-1.0, 1.0, count))


def difference(seed: int) -> float:
    """Return the largest difference of accelerations in a state at random, relative to the largest acceleration."""
    import mujoco

    import kanefe as kf

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drawn.xml"
        path.write_text(file_of(seed), encoding="utf-8")
        peer = mujoco.MjModel.from_xml_path(str(path))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            model = kf.read_mjcf(path).freeze()
    rng, state = np.random.default_rng(seed), mujoco.MjData(peer)
    mujoco.mj_integratePos(peer, state.qpos, rng.uniform(-0.7, 0.7, peer.nv), 1.0)
    state.qvel[:] = rng.uniform(-1.0, 1.0, peer.nv)
    mujoco.mj_forward(peer, state)
    ours = model.rhs(0.0, np.concatenate((state.qpos, state.qvel)))[peer.nq : peer.nq + peer.nv]
    return float(abs(ours - state.qacc).max() / max(1.0, abs(state.qacc).max()))
