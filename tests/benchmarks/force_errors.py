"""Errors of forces over the tolerance: random flexible trees, linkages and contacts, by methods with error control.

    python tests/benchmarks/force_errors.py --scenes 200 --rtol 1e-4 1e-6 1e-8

Bodies keep the static shapes of inertial loads, whose frequencies are far above those of the motion. What is driven
moves smoothly from rest, so that hardly anything vibrates. The error of a force is the largest difference to a run at a
tolerance of 1e-10 in the second half, over the tolerance and the largest force of its channel.
"""

from __future__ import annotations

import argparse
import math
import time
import warnings
from typing import Any, NamedTuple

import numpy as np

import kanefe as kf
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)

SHAPES = ("slider-crank", "four-bar", "six-bar", "tree", "hoop", "stop", "floor")

ALLOWED = 100.0
"""Largest error of a force, over rtol and the largest force of its channel."""

REFERENCE = 1e-10
"""Relative tolerance of the run that others are compared with."""


class Drawn(NamedTuple):
    """A scene that was drawn.

    Attributes
    ----------
    scene : System
    seconds : float
        How long it runs, s.
    shape : str
        What it is.
    """

    scene: kf.System
    seconds: float
    shape: str


class _Drawing:
    """A scene as it is drawn; lengths are of its size, m, and the crank turns at its rate, rad/s."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng([20261129, seed])
        self.shape = SHAPES[seed % len(SHAPES)]
        falls = self.shape in ("stop", "floor")
        self.scene = kf.System(gravity=(0.0, -9.81 if falls else 0.0, 0.0))
        self.rate, self.size = self.number(5.0, 40.0), self.number(0.3, 3.0)

    def number(self, least: float, most: float) -> float:
        """Return a number of any order of magnitude between two."""
        return float(10.0 ** self.rng.uniform(math.log10(least), math.log10(most)))

    def body(self, length: float) -> kf.FlexibleBody:
        """Return a damped beam along x with static shapes of inertial loads."""
        section = Rectangle(length * self.number(0.03, 0.1), length * self.number(0.03, 0.1))
        loads = ("tip", "angular acceleration", "centrifugal")[: int(self.rng.integers(1, 4))]
        reduction = kf.CraigBampton(modes=int(self.rng.integers(2, 7)), loads=loads)
        shape, damping = straight_beam(length, section, STEEL, elements=6), kf.ModalDamping(self.number(0.01, 0.05))
        return beam_body(shape, {"root": "clamped", "tip": "rigid"}, reduction, damping=damping)

    def crank(self) -> Any:
        """Add a crank that swings to and fro, as smoothly from its rest as at any time."""
        swing, w = 2.5, 0.5 * self.rate
        motion = kf.Motion(
            lambda t: swing * math.sin(w * t) ** 4,
            lambda t: 4.0 * swing * w * math.sin(w * t) ** 3 * math.cos(w * t),
            lambda t: 4.0 * swing * w**2 * math.sin(w * t) ** 2 * (3.0 - 4.0 * math.sin(w * t) ** 2),
        )
        joint = kf.Revolute("z", motion=motion.compiled())
        return self.scene.add_rigid_body("crank", 0.5, (1e-4, 1e-3, 1e-3), joint=joint)

    def bar(self, parent: Any, at: float, length: float, angle: float) -> Any:
        """Add the flexible body on a hinge at x of its parent."""
        joint = kf.Revolute("z", position=angle)
        return self.scene.add_flexible_body("bar", self.body(length), parent=parent, at=(at, 0, 0), joint=joint)

    def slider_crank(self) -> None:
        """Add a slider on a flexible rod, that begins at its dead centre."""
        radius, length = 0.1 * self.size, 0.35 * self.size
        bar = self.bar(self.crank(), radius, length, 0.0)
        joint = kf.Prismatic("x", position=radius + length)
        slider = self.scene.add_rigid_body("slider", self.number(0.3, 5.0), joint=joint)
        self.scene.add_loop_joint("pin", kf.Revolute("z"), bar.interface("tip"), slider)

    def four_bar(self, *, is_six: bool) -> None:
        """Add a rocker on a flexible coupler; and another slider, that it drives."""
        s = self.size
        radius, length, rocker, ground = 0.1 * s, 0.35 * s, 0.3 * s, 0.4 * s
        reach = ground - radius
        a = math.acos((reach**2 + length**2 - rocker**2) / (2.0 * reach * length))
        b = math.pi - math.acos((reach**2 + rocker**2 - length**2) / (2.0 * reach * rocker))
        bar = self.bar(self.crank(), radius, length, a)
        mass = self.number(0.3, 5.0)
        arm = self.scene.add_rigid_body(
            "rocker",
            mass,
            mass * rocker**2 / 12.0,
            com=(0.5 * rocker, 0, 0),
            at=(ground, 0, 0),
            joint=kf.Revolute("z", position=b),
        )
        self.scene.add_loop_joint("pin", kf.Revolute("z"), bar.interface("tip"), arm.frame(at=(rocker, 0, 0)))
        if not is_six:
            return
        x, y, long, high = ground + rocker * math.cos(b), rocker * math.sin(b), 0.5 * s, 0.3 * s
        c = math.asin((high - y) / long)
        link = self.scene.add_rigid_body(
            "rod",
            0.5 * mass,
            0.5 * mass * long**2 / 12.0,
            com=(0.5 * long, 0, 0),
            parent=arm,
            at=(rocker, 0, 0),
            joint=kf.Revolute("z", position=c - b),
        )
        joint = kf.Prismatic("x", position=x + long * math.cos(c))
        slider = self.scene.add_rigid_body("slider", 2.0 * mass, at=(0, high, 0), joint=joint)
        self.scene.add_loop_joint("slider pin", kf.Revolute("z"), link.frame(at=(long, 0, 0)), slider)

    def tree(self) -> None:
        """Add a flexible body on a crank with a load at its end, and a flap on that."""
        s = self.size
        bar = self.bar(self.crank(), 0.1 * s, 0.35 * s, float(self.rng.uniform(-0.5, 0.5)))
        load = self.scene.add_rigid_body("load", self.number(0.3, 5.0), 1e-3, parent=bar.interface("tip"))
        hinge = kf.Revolute("z", forces=kf.CoordinateForce(stiffness=self.number(1.0, 1e3), damping=0.05))
        self.scene.add_rigid_body("flap", 0.5, 2e-3, com=(0.1 * s, 0, 0), parent=load, joint=hinge)

    def hoop(self) -> None:
        """Add a slider-crank in whose loop is a ball joint, so that it moves in space."""
        radius, length = 0.1 * self.size, 0.35 * self.size
        rise = 0.1 * self.size
        away = math.sqrt(length**2 - rise**2)
        crank = self.crank()
        tilt = math.atan2(rise, away)
        joint = kf.Universal("y", "z", position=(-tilt, 0.0))
        bar = self.scene.add_flexible_body("bar", self.body(length), parent=crank, at=(radius, 0, 0), joint=joint)
        slider = self.scene.add_rigid_body(
            "slider", self.number(0.3, 5.0), at=(0, 0, rise), joint=kf.Prismatic("x", position=radius + away)
        )
        self.scene.add_loop_joint("pin", kf.Spherical(), bar.interface("tip"), slider)

    def pressed(self, *, is_floor: bool) -> None:
        """Add a flexible body whose end falls on a stop, or on a floor with friction."""
        s, damping = self.size, kf.CoordinateForce(damping=0.1)
        joint = kf.Revolute("z", position=0.02, forces=damping)
        bar = self.scene.add_flexible_body("bar", self.body(s), joint=joint)
        load = self.scene.add_rigid_body("load", self.number(0.3, 5.0), 1e-3, parent=bar.interface("tip"))
        stiffness = self.number(1e5, 1e7)
        if is_floor:
            floor = self.scene.add_surface("floor", self.scene.ground, kf.shapes.Plane("y"), at=(0.0, -0.05, 0.0))
            skin = self.scene.add_surface("skin", load, kf.shapes.Sphere(0.05))
            law = kf.HuntCrossley(stiffness, 1.0)
            self.scene.add_contact("touch", skin, floor, normal=law, friction=kf.Coulomb(0.3))
        else:
            along = (0.0, stiffness, stiffness)
            shares = tuple(math.sqrt(k) for k in along)
            self.scene.add_bushing(
                "touch", load, self.scene.ground.frame(at=(s, 0, 0)), stiffness=along, damping=shares
            )


def drawn(seed: int) -> Drawn:
    """Return the scene of a seed."""
    drawing = _Drawing(seed)
    shape = drawing.shape
    if shape == "slider-crank":
        drawing.slider_crank()
    elif shape in ("four-bar", "six-bar"):
        drawing.four_bar(is_six=shape == "six-bar")
    elif shape == "tree":
        drawing.tree()
    elif shape == "hoop":
        drawing.hoop()
    else:
        drawing.pressed(is_floor=shape == "floor")
    return Drawn(drawing.scene, 2.0 if shape in ("stop", "floor") else 4.0 * math.pi / drawing.rate, shape)


def forces_of(result: kf.Result) -> dict[str, np.ndarray]:
    """Return forces of a run by their names, (T, components)."""
    found = {f"loop {name}": result.loop_force(name)[:, :3] for name in result.loops}
    found["joint"] = result.joint_reaction("bar")[:, :3]
    found["root"] = result.coupling_force("bar", "root")[:, :3]
    if "crank" in result.bodies:
        found["drive"] = np.reshape(result.driving_force("crank"), (-1, 1))
    for name, columns in result.loads.items():
        wanted = [i for i, column in enumerate(columns) if "force" in column or "[N]" in column]
        found[name] = np.column_stack([result.load(name, columns[i]) for i in wanted])
    return found


def off(found: np.ndarray, right: np.ndarray) -> float:
    """Return the largest difference in the second half over the largest size."""
    late = len(found) // 2
    return float(
        np.linalg.norm((found - right)[late:], axis=1).max() / max(np.linalg.norm(right, axis=1).max(), 1e-300)
    )


class Outcome(NamedTuple):
    """Errors of a run, over rtol: the worst force with its name, and that of positions; seconds it took."""

    force: float
    name: str
    position: float
    seconds: float


def outcome(seed: int, reference: kf.Result, rtol: float, method: str) -> Outcome:
    """Return what comes of one run."""
    scene, seconds, _ = drawn(seed)
    begun = time.perf_counter()
    run = scene.simulate((0.0, seconds), output_step=seconds / 400, rtol=rtol, method=method)
    taken = time.perf_counter() - begun
    run.status.raise_if_failed()
    right, found = forces_of(reference), forces_of(run)
    errors = {name: off(found[name], right[name]) / rtol for name in right}
    worst = max(errors, key=lambda name: errors[name])
    place = off(run.position("bar", "tip"), reference.position("bar", "tip")) / rtol
    return Outcome(errors[worst], worst, place, taken)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--rtol", type=float, nargs="+", default=[1e-4, 1e-5, 1e-6, 1e-7, 1e-8])
    parser.add_argument("--methods", nargs="+", default=["auto", "radau5", "extrapolation"])
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    table: dict[tuple[str, float], list[Outcome]] = {}
    for seed in range(options.first, options.first + options.scenes):
        scene, seconds, shape = drawn(seed)
        reference = scene.simulate((0.0, seconds), output_step=seconds / 400, rtol=REFERENCE, method="radau5")
        reference.status.raise_if_failed()
        for method in options.methods:
            for rtol in options.rtol:
                got = outcome(seed, reference, rtol, method)
                table.setdefault((method, rtol), []).append(got)
                if got.force > ALLOWED:
                    print(
                        f"{seed} {shape} {method} {rtol:g}: {got.name} {got.force:.1f}, place {got.position:.2g}",
                        flush=True,
                    )
    print("method, rtol: scenes, median, largest error of forces / (rtol, largest force), scenes above it; seconds")
    for (method, rtol), found in table.items():
        errors = np.array([got.force for got in found])
        above, spent = int((errors > ALLOWED).sum()), sum(got.seconds for got in found)
        print(f"{method} {rtol:g}: {len(found)}, {np.median(errors):.2g}, {errors.max():.3g}, {above}; {spent:.1f} s")


if __name__ == "__main__":
    main()
