"""Scenes with closed loops for the tests."""

import numpy as np

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.states.kinematics import sweep_outward
from scenes import lattice_body, random_inertia, unit_axis

ROD = 1.0 / 12.0


def four_bar(speed: float = 2.0, rocker: float = 1.8, **crank: object) -> kf.System:
    """Return a crank-rocker with spatial pins: bars of 1, 2 and 1.8 m over a base of 2 m; its start is to be found."""
    scene = kf.System(gravity=(0, -9.81, 0))
    joint = kf.Revolute("z", **(crank or {"position": 1.0, "speed": speed}))
    first = scene.add_rigid_body("crank", 1, 0.1, com=(0.5, 0, 0), joint=joint)
    coupler = scene.add_rigid_body("coupler", 1, 0.1, parent=first, at=(1, 0, 0), com=(1, 0, 0), joint=kf.Revolute("z"))
    last = scene.add_rigid_body("rocker", 1, 0.1, at=(2, 0, 0), com=(0, 0.9, 0), joint=kf.Revolute("z"))
    scene.add_loop_joint("pin", kf.Revolute("z"), coupler.frame(at=(2, 0, 0)), last.frame(at=(0, rocker, 0)))
    return scene


def parallelogram(angle: float = 0.0) -> kf.System:
    """Return a parallelogram of unit bars whose cranks are `angle` from upright."""
    scene = kf.System(gravity=(0, -9.81, 0))
    cranks = [
        scene.add_rigid_body(
            f"crank{i}", 1, ROD, com=(0, 0.5, 0), at=(i, 0, 0), joint=kf.Revolute("z", position=angle, speed=-1.0)
        )
        for i in range(2)
    ]
    coupler = scene.add_rigid_body(
        "coupler",
        1,
        ROD,
        com=(0.5, 0, 0),
        parent=cranks[0],
        at=(0, 1, 0),
        joint=kf.Revolute("z", position=-angle, speed=1.0),
    )
    scene.add_loop_joint("pin", kf.Revolute("z"), coupler.frame(at=(1, 0, 0)), cranks[1].frame(at=(0, 1, 0)))
    return scene


def spatial_loop(seed: int) -> kf.System:
    """Return a driven crank, a flexible arm and a rigid arm that meet in a ball, a distance to a free body, a gear."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=rng.standard_normal(3))
    a, w = rng.uniform(0.2, 0.4), rng.uniform(1.0, 2.0)
    swing = kf.Motion(
        lambda t: a * np.sin(w * t + 0.5),
        lambda t: a * w * np.cos(w * t + 0.5),
        lambda t: -a * w * w * np.sin(w * t + 0.5),
    )
    crank = scene.add_rigid_body("crank", 2.0, random_inertia(rng), joint=kf.Revolute(unit_axis(rng), motion=swing))
    arm = scene.add_flexible_body("arm", lattice_body(seed), parent=crank, joint=kf.Universal("y", "z"), at=(0.2, 0, 0))
    lever = scene.add_rigid_body(
        "lever", 1.0, random_inertia(rng), at=(1.6, 0, 0.3), com=(0, 0, -0.1), joint=kf.Universal("x", "z")
    )
    ball = scene.add_rigid_body("ball", 0.7, random_inertia(rng), joint=kf.Free(position=(0.3, 0.9, 0.4)))
    disc = scene.add_rigid_body("disc", 0.5, 0.05, parent=lever, joint=kf.Revolute("y"))
    scene.add_loop_joint("knee", kf.Spherical(), arm.interface("tip"), lever.frame(at=(-0.4, 0.05, -0.25)))
    scene.add_distance("strut", arm.interface("tip").frame(at=(0.05, 0, 0)), ball.frame(at=(0.1, -0.1, 0)), 1.2)
    scene.add_gear("gear", {disc: 1.0, (lever, 0): -2.0})
    scene.add_force(ball, (0.3, -0.2, 0.5))
    return scene


def sprung_loop(seed: int) -> Model:
    """Return a loop with a flexible arm, and a spring in a joint."""
    scene = spatial_loop(seed)
    scene.add_rigid_body(
        "weight",
        0.3,
        0.02,
        com=(0.1, 0, 0),
        parent=scene.ground,
        joint=kf.Revolute("z", forces=kf.CoordinateForce(stiffness=200.0)),
    )
    return scene.freeze()


def marker_place(model: Model, name: str, t: float, q: np.ndarray, point: tuple) -> np.ndarray:
    """Return the position in N of a point of a rigid body."""
    speeds = np.zeros(model.free_count + model.driven_count + model.fixed_count)
    frame = sweep_outward(model, t, q, speeds)[model.index(name)]
    return frame.p_NoFo_N + frame.A_NF @ np.array(point)


def four_bars(
    count: int, layout: str, *, base: str = "fixed", closed_by: str = "pins", motion: kf.Motion | None = None
) -> kf.System:
    """Return some four-bars with spatial pins in the plane across y: parallelograms that are closed as they are built.

    Parameters
    ----------
    count : int
    layout : {"apart", "in a row", "one on the other"}
        Each on the base; neighbours share a crank; each stands on the coupler of the one before.
    base : {"fixed", "free"}
        Of the first.
    closed_by : {"pins", "rods"}
        Spatial pins say several times what holds a plane; rods, in place of the last bars, say nothing twice.
    motion : Motion, optional
        Of the first crank, which is 0.3 rad from upright at the start.
    """
    scene = kf.System(gravity=(0, 0, -9.81))
    ground = scene.ground
    if base == "free":
        ground = scene.add_rigid_body(
            "base", 20.0, 2.0, joint=kf.Free(position=(0, 0, 1), angular_velocity=(0, 0.2, 0))
        )

    def crank(name: str, parent: kf.Frame, at: float, angle: float = 0.3) -> kf.Frame:
        is_driven = motion is not None and name == "crank 0"
        joint = kf.Revolute("y", motion=motion) if is_driven else kf.Revolute("y", position=angle, speed=1.0)
        return scene.add_rigid_body(name, 1.0, 1e-2, com=(0, 0, 0.1), joint=joint, parent=parent, at=(at, 0, 0))

    def bar(name: str, parent: kf.Frame, angle: float = -0.3) -> kf.Frame:
        joint = kf.Revolute("y", position=angle)
        return scene.add_rigid_body(name, 1.0, 1e-2, com=(0.25, 0, 0), joint=joint, parent=parent, at=(0, 0, 0.2))

    if layout == "in a row":
        cranks = [crank(f"crank {i}", ground, 0.5 * i) for i in range(count + 1)]
        for i in range(count):
            coupler = bar(f"coupler {i}", cranks[i])
            pin = cranks[i + 1].frame(at=(0, 0, 0.2))
            if closed_by == "rods":
                scene.add_distance(f"rod {i}", coupler.frame(at=(0.5, 0, 0.1)), pin, 0.1)
                continue
            scene.add_loop_joint(f"pin {i}", kf.Revolute("y"), coupler.frame(at=(0.5, 0, 0)), pin)
        return scene
    below = ground
    for i in range(count):
        at = 0.6 * i if layout == "apart" else 0.0
        first = crank(f"crank {i}", below, at)
        coupler = bar(f"coupler {i}", first)
        pin = below.frame(at=(at + 0.5, 0, 0))
        if closed_by == "rods":
            scene.add_distance(f"rod {i}", coupler.frame(at=(0.5, 0, 0)), pin, 0.2)
            below = coupler if layout == "one on the other" else below
            continue
        rocker = scene.add_rigid_body(
            f"rocker {i}",
            1.0,
            1e-2,
            com=(0, 0, -0.1),
            joint=kf.Revolute("y", position=0.3),
            parent=coupler,
            at=(0.5, 0, 0),
        )
        scene.add_loop_joint(f"pin {i}", kf.Revolute("y"), rocker.frame(at=(0, 0, -0.2)), pin)
        if layout == "one on the other":
            below = coupler
    return scene


def nested_loops() -> kf.System:
    """Return a loop through N over a lever on the coupler of a four-bar that closes on a free carrier, and a gear."""
    scene = four_bars(1, "one on the other", base="free")
    coupler = scene.body("coupler 0")
    lever = scene.add_rigid_body("lever", 0.5, 1e-2, com=(0, 0, 0.1), joint=kf.Universal("x", "y"), parent=coupler)
    scene.add_distance("strut", lever.frame(at=(0.1, 0, 0.3)), scene.ground.frame(at=(0.4, 0.5, 1.2)), 0.8)
    wheel = scene.add_rigid_body("wheel", 0.4, 1e-2, joint=kf.Revolute("x"), parent=lever)
    scene.add_gear("gear", {wheel: 1.0, scene.body("rocker 0"): -1.5})
    return scene


def geared_bars(count: int) -> kf.System:
    """Return four-bars side by side on a free body, each geared to the next: the gears join all that they hold."""
    scene = four_bars(count, "apart", base="free")
    for i in range(count - 1):
        # the bars of parallelograms turn by the same angle: the gears leave one motion of all
        scene.add_gear(f"gear {i}", {scene.body(f"crank {i}"): 1.0, scene.body(f"coupler {i + 1}"): 1.0})
    return scene


def bent_four_bars(seed: int) -> kf.System:
    """Return two four-bars with flexible couplers, the second on the tip of the first, over a base that turns."""
    scene = kf.System(gravity=(0.3, 0.2, -9.81))
    base = scene.add_rigid_body("base", 5.0, 1.0, joint=kf.Spherical(angular_velocity=(0.1, 0.2, -0.1)))
    below, foot = base, base
    for i in range(2):
        joint = kf.Revolute("y", position=0.3, speed=0.5)
        crank = scene.add_rigid_body(f"crank {i}", 1.0, 0.1, com=(0, 0, 0.1), joint=joint, parent=below)
        joint = kf.Revolute("y", position=-0.3)
        coupler = scene.add_flexible_body(
            f"coupler {i}", lattice_body(seed + i), parent=crank, at=(0, 0, 0.5), joint=joint
        )
        tip = coupler.interface("tip")
        joint = kf.Universal("y", "x", position=(0.3, 0.0))
        rocker = scene.add_rigid_body(f"rocker {i}", 1.0, 0.1, com=(0, 0, -0.1), joint=joint, parent=tip)
        pin = foot.frame(at=(0.98, 0.05, 0))
        scene.add_loop_joint(f"pin {i}", kf.Spherical(), rocker.frame(at=(0, 0, -0.5)), pin)
        below, foot = tip, tip
    return scene
