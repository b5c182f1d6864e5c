"""Starts of random loops against the same motion reached by a run: what is given stays, what follows is the same."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import scipy.linalg

import kanefe as kf
import kanefe_fem as fem
from kanefe.equations.model import Model
from kanefe.equations.start_report import StartWarning
from kanefe.joints.base import AxisJoint
from kanefe.kane.assemble import held_accelerations
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.states.constraints import constraint_rates, place_rows
from kanefe.states.state import State
from kanefe.tree.scales import displacement_scales
from random_loops import LoopScene
from random_scenes import Recipe

LARGEST = 1e-9
"""Largest error of coordinates and speeds at a start, and of what loops leave of them."""

LARGEST_FORCE = 1e-8
"""The same of accelerations and forces: loops close to 1e-12 of their size, which modes of 1e4 rad/s magnify."""

DURATION = 0.02
"""Of the run, s."""

KINDS = ("rigid", "flexible", "exact", "tree", "flexible tree")


@dataclass(frozen=True)
class StartErrors:
    """Largest errors of a start against the state of a run.

    Attributes
    ----------
    coordinates, speeds : float
        In rad, m, and per s.
    rows : float
        Rates of the rows of loops, relative to what the largest could be at such speeds.
    accelerations, forces : float
        Relative to the largest: rates of speeds in the scales of their displacements, multipliers of loops.
    kept : bool
        Whether all that is given is kept to the bit.
    """

    coordinates: float
    speeds: float
    rows: float
    accelerations: float
    forces: float
    kept: bool

    @property
    def is_right(self) -> bool:
        """Whether all is kept that is given, and no error is too large."""
        slow = max(self.coordinates, self.speeds, self.rows)
        return self.kept and slow < LARGEST and max(self.accelerations, self.forces) < LARGEST_FORCE


def random_start(seed: int, kind: str) -> StartErrors | None:
    """Return how a random scene starts in the middle of a motion; None: its loops lock, or bend bodies to move."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of bodies that bend far, and of the guesses of trees
        scene = linkage(seed, kind) if kind in KINDS[:3] else tree(seed, kind)
        if scene is None:
            return None
        result = scene.simulate((0.0, DURATION), rtol=1e-8, output_step=DURATION)
        if not result.status.is_finished:
            return None
        there = result.at(DURATION)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", StartWarning)
        return errors_of(scene.copy(), there.model, there.q, there.u, there.z, seed)


def errors_of(
    scene: kf.System, model: Model, q: np.ndarray, u: np.ndarray, z: np.ndarray, seed: int
) -> StartErrors | None:
    """Return how the scene starts if as many joints are given as its loops leave free."""
    state = State(model, DURATION, q, u, z)
    du, forces, _ = held_accelerations(state)
    given = independent(state)
    if given is None:
        return None
    give(scene, model, q, u, given, np.random.default_rng(seed))
    started = scene.freeze(DURATION)
    ours = State(started, DURATION, started.initial_coordinates, started.initial_speeds, z)
    found, pushed, _ = held_accelerations(ours)
    rows = constraint_rates(ours)
    largest_row = max(float(rows.sizes(ours.full[: rows.J.shape[1]]).max()), 1e-6)  # per s: less is rest
    scales = displacement_scales(model)
    largest = max(float(np.abs(du / scales).max()), 1.0)
    return StartErrors(
        coordinates=float(np.abs(ours.q - q).max()),
        speeds=float(np.abs(ours.u - u).max()),
        rows=float(np.abs(rows.open_rates(ours.full)).max()) / largest_row,
        accelerations=float(np.abs((found - du) / scales).max()) / largest,
        forces=float(np.abs(pushed - forces).max()) / max(float(np.abs(forces).max()), 1.0),
        kept=bool(np.all(ours.u[given] == u[given])),
    )


def independent(state: State) -> np.ndarray | None:
    """Return speeds that may be given together: elastic ones, and of joints those that the others follow well.

    None: bodies bend, or it is near a singular position.
    """
    model, n = state.model, state.model.free_count
    scales = displacement_scales(model)
    J = constraint_rates(state).J[:, :n] * scales
    joints = np.concatenate([body.speeds[body.speeds < n] for body in model.bodies])
    rank = int(np.linalg.matrix_rank(J, tol=1e-6))
    if not len(joints) or int(np.linalg.matrix_rank(J[:, joints], tol=1e-6)) < rank:
        return None
    order = scipy.linalg.qr(J[:, joints], pivoting=True, mode="r")[1]
    following = joints[order[:rank]]
    lengths = np.linalg.svd(J[:, following], compute_uv=False)
    if rank and lengths[-1] < NEAR_SINGULAR * lengths[0]:
        return None
    return np.setdiff1d(np.arange(n), following)


def give(
    scene: kf.System, model: Model, q: np.ndarray, u: np.ndarray, given: np.ndarray, rng: np.random.Generator
) -> None:
    """Give some speeds of a scene and their coordinates; for others a guess of the coordinates, and no speed."""
    state = State(model, DURATION, q, u)
    J, turning = (
        constraint_rates(state).J[:, : model.free_count],
        [b for b in model.bodies if b.joint.rotation_at is not None],
    )
    # rolling holds no places, and of a rotation none or all is given
    whole = len(place_rows(state)) == len(J) and all(
        len(np.intersect1d(b.speeds[-3:], given)) in (0, 3) for b in turning
    )
    for i, body in enumerate(model.bodies):
        at, _ = body.free_coordinates()
        keeps = np.isin(body.speeds, given).tolist()
        rates = [float(u[s]) if k else None for s, k in zip(body.speeds, keeps, strict=True)]
        places: list[Any] = []
        if body.joint.rotation_at is None:
            beside = 1e-3 * rng.standard_normal(len(body.speeds)) if whole else np.zeros(len(body.speeds))
            places = [
                None if c < 0 else float(q[c]) if k else kf.Guess(float(q[c] + e))
                for c, k, e in zip(body.coordinates, keeps, beside, strict=True)
            ]
        entry = scene._entries[i]
        joint = started(entry.joint, q[at], places, rates, keeps)
        bent = {} if body.flexible is None else {"eta": q[body.flexible.eta], "deta": u[body.flexible.speeds]}
        scene._entries[i] = replace(entry, joint=joint, **bent)


def started(joint: Any, q: np.ndarray, places: list[Any], rates: list[Any], keeps: list[bool]) -> kf.Joint:
    """Return a joint with another start."""
    if joint.is_fixed or not len(q):
        return joint
    if isinstance(joint, (AxisJoint, kf.PointOnCurve)):
        return replace(joint, position=places[0], speed=rates[0])
    if isinstance(joint, (kf.Cylindrical, kf.Universal)):
        return replace(joint, position=places, speed=rates)
    if isinstance(joint, kf.Translation):
        return replace(joint, position=places, velocity=rates)
    if isinstance(joint, kf.Planar):
        return replace(joint, position=places[:2], angle=places[2], velocity=rates[:2], rate=rates[2])
    turn: Any = q[-4:] if all(keeps[-3:]) else kf.Guess(q[-4:])
    if isinstance(joint, kf.Spherical):
        return replace(joint, orientation=turn, angular_velocity=rates)
    position = [float(x) if k else kf.Guess(float(x)) for x, k in zip(q[:3], keeps, strict=False)]
    return replace(joint, position=position, orientation=turn, velocity=rates[:3], angular_velocity=rates[3:])


def tree(seed: int, kind: str) -> kf.System | None:
    """Return a random tree with loops."""
    made = LoopScene(Recipe(seed, bodies=6, elastic=0.4 if kind == "flexible tree" else 0.0), loops=2)
    model = made.frozen()
    return made.scene.copy() if model is not None and model.constraints and model.free_count else None


@cache
def slender(kind: str) -> kf.FlexibleBody:
    """Return a bar of 0.35 m along x."""
    steel, section = fem.Material(E=210e9, nu=0.3, rho=7850.0), fem.Rectangle(0.02, 0.006)
    if kind == "exact":
        return fem.exact_beam(0.35, section, steel, basis=3, planar=True, interfaces={"root": 0.0, "tip": 0.35})
    line = fem.straight_beam(0.35, section, steel, elements=4, planar=True)
    return fem.beam_body(line, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=2), kf.ModalDamping(0.02))


def linkage(seed: int, kind: str) -> kf.System:
    """Return a six-bar of random lengths with a geared wheel and a mimic, its coupler rigid, linear or exact."""
    rng = np.random.default_rng(seed)
    arm, base, up = (size * rng.uniform(0.9, 1.1) for size in (0.1, 0.4, 0.3))
    scene = kf.System(gravity=(0, -9.81, 0))
    angle = rng.uniform(-3, 3)
    crank = scene.add_rigid_body("crank", 0.5, 1e-3, joint=kf.Revolute("z", position=angle, speed=rng.uniform(-9, 9)))
    joint = kf.Revolute("z", position=kf.Guess(1.0 - angle))
    where: dict[str, Any] = {"parent": crank, "at": (arm, 0, 0), "joint": joint}
    if kind == "rigid":
        bar = scene.add_rigid_body("coupler", 0.3, 4e-3, com=(0.17, 0, 0), **where)
        end = bar.frame(at=(0.35, 0, 0))
    else:
        end = scene.add_flexible_body("coupler", slender(kind), **where).interface("tip")
    rocker = scene.add_rigid_body(
        "rocker", 1.0, 0.03, com=(0.15, 0, 0), at=(base, 0, 0), joint=kf.Revolute("z", position=kf.Guess(1.8))
    )
    scene.add_loop_joint("pin", kf.Revolute("z"), end, rocker.frame(at=(up, 0, 0)))
    rod = scene.add_rigid_body(
        "rod",
        0.6,
        0.0125,
        com=(0.25, 0, 0),
        parent=rocker,
        at=(up, 0, 0),
        joint=kf.Revolute("z", position=kf.Guess(-1.6)),
    )
    slider = scene.add_rigid_body("slider", 3.0, at=(0, up, 0), joint=kf.Prismatic("x", position=kf.Guess(0.8)))
    scene.add_loop_joint("slider pin", kf.Revolute("z"), rod.frame(at=(0.5, 0, 0)), slider)
    wheel = scene.add_rigid_body("wheel", 0.2, 1e-4, at=(0, 0, 0.1), joint=kf.Revolute("z"))
    scene.add_gear("gear", {crank: rng.uniform(1, 3), wheel: rng.uniform(1, 2)}, rng.uniform(-1, 1))
    finger = scene.add_rigid_body("finger", 0.1, 1e-4, parent=wheel, at=(0.1, 0, 0), joint=kf.Revolute("z"))
    scene.add_gear("mimic", {finger: 1.0, rocker: -rng.uniform(0.5, 2)}, rng.uniform(-1, 1))
    return scene
