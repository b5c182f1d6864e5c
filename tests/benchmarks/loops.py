"""Loops: growth with their number, and what they cost over the same tree without them."""

from __future__ import annotations

import kanefe as kf
from benchmarks import engine_scenes as ours
from benchmarks.clocks import Race, microseconds, seconds
from benchmarks.goals import Figure, Goal
from kanefe.equations.model import Model
from loop_scenes import four_bars

ROWS = {
    "apart": Goal("100 four-bars side by side: step / that of 10", 9.0),
    "in a row": Goal("100 four-bars in a row, neighbours share a crank: step / that of 10", 9.0),
    "one on the other": Goal("100 four-bars, each on the coupler of the one before: step / that of 10", 9.0),
}
CAR = Goal("car with four loops, a ball and a rod each (16 rows): step / same tree without loops", 2.0)

SPRING = {"stiffness": 2e3, "damping": 200.0}  # N m/rad, N m s/rad
CORNERS = {"front left": (1.3, 0.6), "front right": (1.3, -0.6), "rear left": (-1.3, 0.6), "rear right": (-1.3, -0.6)}


def car(with_loops: bool, rest: float = 0.0) -> kf.System:
    """Return a car in the air on double wishbones with rods, or what is left without upper balls and rods.

    Its springs push the wheels to an angle `rest`, rad.
    """
    scene = kf.System(gravity=(0, 0, -9.81))
    start = kf.Free(position=(0, 0, 0.5))
    chassis = scene.add_rigid_body("chassis", 1200.0, (300.0, 1500.0, 1700.0), joint=start)
    spring = kf.CoordinateForce(**SPRING, rest=rest)
    for name, (x, y) in CORNERS.items():
        side = 1.0 if y > 0.0 else -1.0
        lower = scene.add_rigid_body(
            f"{name} lower arm",
            5.0,
            (0.1, 0.05, 0.1),
            com=(0, 0.15 * side, 0),
            parent=chassis,
            at=(x, 0.5 * y, -0.1),
            joint=kf.Revolute("x", forces=spring),
        )
        upright = scene.add_rigid_body(
            f"{name} upright",
            15.0,
            0.3,
            com=(0, 0, 0.1),
            parent=lower,
            at=(0, 0.3 * side, 0),
            joint=kf.Universal("x", "z"),
        )
        upper = scene.add_rigid_body(
            f"{name} upper arm",
            3.0,
            (0.05, 0.03, 0.05),
            com=(0, 0.12 * side, 0),
            parent=chassis,
            at=(x, 0.5 * y, 0.1),
            joint=kf.Revolute("x"),
        )
        wheel = kf.Revolute("y", speed=30.0)
        at = (0, 0.05 * side, 0.1)
        scene.add_rigid_body(f"{name} wheel", 18.0, (0.5, 0.9, 0.5), parent=upright, at=at, joint=wheel)
        if with_loops:
            top = upper.frame(at=(0, 0.3 * side, 0)), upright.frame(at=(0, 0, 0.2))
            scene.add_loop_joint(f"{name} ball", kf.Spherical(), *top)
            ends = chassis.frame(at=(x - 0.15, 0.5 * y, 0)), upright.frame(at=(-0.15, 0, 0.1))
            scene.add_distance(f"{name} rod", *ends, 0.3)
    return scene


def rows_of_four_bars(rounds: int) -> list[Figure]:
    """Compare steps of 100 four-bars with those of 10."""
    figures = []
    for layout, goal in ROWS.items():
        race = _steps(four_bars(100, layout).freeze(), four_bars(10, layout).freeze(), (50, 500), rounds)
        remark = f"{microseconds(race.ours)} and {microseconds(race.theirs)} a step of four evaluations"
        figures.append(goal.figure(race.ratio, remark))
    return figures


def car_on_loops(rounds: int) -> list[Figure]:
    """Compare steps of a car with and without its loops."""
    race = _steps(car(True).freeze(), car(False).freeze(), (1000, 4000), rounds)
    remark = f"{microseconds(race.ours)} and {microseconds(race.theirs)} a step of four evaluations"
    return [CAR.figure(race.ratio, remark)]


def _steps(one: Model, other: Model, steps: tuple[int, int], rounds: int) -> Race:
    return Race(
        lambda: seconds(lambda: ours.run(one, steps[0], 1e-4, "rk4")) / steps[0],
        lambda: seconds(lambda: ours.run(other, steps[1], 1e-4, "rk4")) / steps[1],
        rounds,
    )


GROUPS = {rows_of_four_bars: [*ROWS.values()], car_on_loops: [CAR]}
"""Goals of each group, which stand in its place where it cannot be measured."""
