"""Blocks that rock on their edges to rest, alone and in stacks, cams with followers, and tossed cubes, all rigid."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from kanefe.checks.robustness.case import KNOWN_LIMIT, Effort, Finding, StressCase
from kanefe.checks.robustness.runs import ended
from kanefe.contact import Coulomb, Rigid
from kanefe.contact.shapes import Box, Convex, Plane, Sphere
from kanefe.frames import rotation_about
from kanefe.joints import CoordinateForce, Free, Motion, Prismatic, Revolute
from kanefe.system import System

GRAVITY = 9.81


def shaken_floor(rng: np.random.Generator) -> Motion | None:
    """Return no motion of a floor, a sine, or one whole sine of its acceleration."""
    kind, period, size = int(rng.integers(3)), rng.uniform(0.2, 1.0), rng.uniform(0.5, 6.0)
    w = 2.0 * math.pi / period
    if kind == 0:
        return None
    if kind == 1:
        stroke = size / w**2
        return Motion(
            lambda t: stroke * math.sin(w * t),
            lambda t: stroke * w * math.cos(w * t),
            lambda t: -stroke * w * w * math.sin(w * t),
        )
    return Motion(
        lambda t: size / w * (min(t, period) - math.sin(w * min(t, period)) / w),
        lambda t: size / w * (1.0 - math.cos(w * min(t, period))),
        lambda t: size * math.sin(w * min(t, period)),
    )


def rocking_block(seed: int) -> tuple[System, float]:
    """Return a tilted block above a floor, of any slenderness, and the end of its run, s."""
    rng = np.random.default_rng(seed)
    half = rng.uniform(0.02, 0.3)
    height, mass = half * rng.uniform(0.4, 8.0), 10.0 ** rng.uniform(-1.0, 2.0)
    scene, motion = System(gravity=(0.0, 0.0, -GRAVITY)), shaken_floor(rng)
    base = scene.ground if motion is None else scene.add_frame("base", joint=Prismatic("x", motion=motion))
    floor = scene.add_surface("floor", base, Plane("z"))
    lean = math.atan2(half, height) * rng.choice((0.0, rng.uniform(0.05, 0.95), -rng.uniform(0.05, 0.95)))
    above = half * abs(math.sin(lean)) + height * math.cos(lean) + rng.choice((0.0, rng.uniform(0.0, 0.3 * height)))
    inertia = mass / 3.0 * np.array((height**2, half**2 + height**2, half**2))
    start = Free(position=(0.0, 0.0, above), orientation=rotation_about("y", lean))
    block = scene.add_rigid_body("block", mass, inertia.tolist(), joint=start)
    feet = [block.frame(at=(x, 0.0, z)) for x in (-half, half) for z in (-height, height)]
    law = Rigid(rng.choice((0.0, rng.uniform(0.0, 0.9))), str(rng.choice(("newton", "poisson"))))
    # below 4/3: from there on a block can have no force, or several, in Painleve's paradox
    scene.add_contact("feet", feet, floor, normal=law, friction=Coulomb(rng.uniform(0.1, 1.3)))
    return scene, 1.0


def stack(seed: int) -> tuple[System, float]:
    """Return two to six blocks on each other on a floor, of any widths, and the end of their run, s."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 7))
    scene, motion = System(gravity=(0.0, 0.0, -GRAVITY)), shaken_floor(rng)
    base = scene.ground if motion is None else scene.add_frame("base", joint=Prismatic("x", motion=in_table(motion)))
    restitution = (0.0, rng.uniform(0.0, 0.5), None)[int(rng.integers(3))]
    are_equal, equal = rng.random() < 0.3, rng.uniform(0.02, 0.2)
    below, half_below, height_below, top = None, np.inf, 0.0, 0.0
    for k in range(count):
        half = equal if are_equal else rng.uniform(0.02, 0.2)
        height, depth, mass = half * rng.uniform(0.3, 3.0), half * rng.uniform(0.7, 1.4), 10.0 ** rng.uniform(-1.0, 1.0)
        inertia = mass / 3.0 * np.array((height**2 + depth**2, half**2 + height**2, half**2 + depth**2))
        top += rng.choice((0.0, rng.uniform(0.0, 0.02)))
        off = rng.uniform(-0.3, 0.3) * min(half, half_below) if k else 0.0
        block = scene.add_rigid_body(f"{k}", mass, inertia.tolist(), joint=Free(position=(off, 0.0, top + height)))
        e = rng.uniform(0.0, 0.5) if restitution is None else restitution
        if below is None:
            surface = scene.add_surface("floor", base, Plane("z"))
        elif half <= half_below:
            surface = scene.add_surface(f"top {k}", below, Plane("z"), at=(0.0, 0.0, height_below))
        else:  # the narrower one has the points
            lower = (0.0, 1.0, 0.0, 0.0)
            surface = scene.add_surface(f"base {k}", block, Plane("z"), at=(0.0, 0.0, -height), orientation=lower)
        if below is None or half <= half_below:
            points = [block.frame(at=(x, 0.0, -height)) for x in (-half, half)]
        else:
            points = [below.frame(at=(x, 0.0, height_below)) for x in (-half_below, half_below)]
        scene.add_contact(f"under {k}", points, surface, normal=Rigid(e), friction=Coulomb(rng.uniform(0.1, 1.0)))
        below, half_below, height_below, top = block, half, height, top + 2.0 * height
    return scene, 1.0


def in_table(motion: Motion) -> Motion:
    """Return a motion as a table, for compiled code."""
    times = np.linspace(0.0, 1.25, 1001).tolist()
    return Motion.table(times, [motion.position(t) for t in times])


def cam(seed: int) -> tuple[System, float]:
    """Return a cam, round or with some edges, with a follower on a spring, about the speed at which that floats."""
    rng = np.random.default_rng(seed)
    mass, radius, stiffness, force = 10.0 ** rng.uniform(-2.0, 0.0), rng.uniform(0.01, 0.03), 2e4, rng.uniform(0, 200.0)
    off = radius * rng.uniform(0.1, 0.5)
    speed = rng.uniform(0.3, 1.4) * math.sqrt((force + 2.0 * stiffness * off + mass * GRAVITY) / (mass * off))
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    shaft = scene.add_rigid_body("cam", 0.5, 1e-3, joint=Revolute("y", motion=Motion.steady(speed)))
    if rng.random() < 0.5:
        nose = scene.add_surface("nose", shaft, Sphere(radius), at=(0.0, 0.0, -off))
    else:
        angles = np.linspace(0.0, 2.0 * math.pi, int(rng.integers(5, 40)), endpoint=False)
        points = [(radius * math.sin(a), y, radius * math.cos(a) - off) for a in angles.tolist() for y in (-5e-3, 5e-3)]
        nose = scene.add_surface("nose", shaft, Convex(np.array(points)))
    spring = CoordinateForce(stiffness=stiffness, rest=-force / stiffness)
    valve = scene.add_rigid_body("valve", mass, 1e-4, at=(0.0, 0.0, radius - off), joint=Prismatic("z", forces=spring))
    face = scene.add_surface("face", valve, Plane("z"), orientation=(0.0, 1.0, 0.0, 0.0))
    scene.add_contact("tappet", nose, face, normal=Rigid(rng.choice((0.0, rng.uniform(0.0, 0.8)))))
    return scene, 4.0 * math.pi / speed


def tossed_cube(seed: int) -> tuple[System, float]:
    """Return a cube tossed onto a board, with no restitution or a little."""
    rng = np.random.default_rng(seed)
    scene = System(gravity=(0.0, 0.0, -GRAVITY))
    board = scene.add_surface("board", scene.ground, Plane("z"))
    start = Free(
        position=(0.0, 0.0, rng.uniform(0.1, 0.17)),
        orientation=tuple((q := rng.normal(size=4)) / np.linalg.norm(q)),
        velocity=tuple(rng.normal(size=3) * (1.0, 1.0, 0.3)),
        angular_velocity=tuple(3.0 * rng.normal(size=3)),
    )
    cube = scene.add_rigid_body("cube", 0.37, 8.1e-4, joint=start)
    box = scene.add_surface("box", cube, Box((0.1048, 0.1048, 0.1048)))
    scene.add_contact("lands", box, board, normal=Rigid((0.0, 0.125)[seed % 2]), friction=Coulomb(0.18))
    return scene, 0.7


def settling(effort: Effort) -> Iterator[Finding]:
    """Let blocks rock, followers float and cubes tumble, from random starts."""
    # by 0.3 s all have met; the stack of seed 4 has some 800 events by then
    count, first, longest = effort.count(1000, 3), effort.count(0, 4), 0.3 if effort.is_quick else math.inf
    scenes: tuple[tuple[str, Callable[[int], tuple[System, float]], float, int, str], ...] = (
        ("rocking blocks", rocking_block, 0.0, 1, "events end"),
        ("cams", cam, 0.01, 1, f"{KNOWN_LIMIT}corners that dip in between two looks at a step"),
        ("tossed cubes", tossed_cube, 0.0, 1, "events end"),
        ("stacks", stack, 0.05, 20, f"{KNOWN_LIMIT}slips of several contacts that run into Painleve's paradox"),
    )
    for what, build, share, fewer, reason in scenes:
        failed, runs = 0, max(count // fewer, 1)
        for seed in range(first, first + runs):
            scene, end = build(seed)
            status = ended(scene.freeze(), min(end, longest)).status
            failed += status is not None and not status.is_finished
        yield Finding(what, runs, "runs that failed", float(failed), share * runs, reason)


CASES = (StressCase("rigid bodies come to rest", "blocks and stacks rock, followers float, cubes tumble", settling),)
