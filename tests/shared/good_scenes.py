"""Good calls of scenes and their methods."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import kanefe as kf
import kanefe_fem as fem
from good_call import CALLS, WRITERS, Call, Good, call, on
from steel_beams import STEEL, steel_beam


@cache
def beam() -> kf.FlexibleBody:
    return fem.beam_body(steel_beam(4), {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=2))


WRITERS["body.h5"] = lambda path: beam().save(path)
WRITERS["body.sid"] = lambda path: kf.write_sid(beam(), path)


@cache
def loaded_body() -> kf.FlexibleBody:
    mesh = fem.box_mesh((0.2, 0.1, 0.1), (2, 1, 1))
    return fem.solid_body(mesh, STEEL, {"left": "clamped"}, reduction=kf.CraigBampton(modes=2), surfaces=["right"])


def scene() -> kf.System:
    """Return a fresh scene of two rods and a beam."""
    made = kf.System(gravity=(0.0, -9.81, 0.0))
    one = made.add_rigid_body("one", 1.0, 0.1, com=(0.5, 0.0, 0.0), joint=kf.Revolute("z"))
    made.add_rigid_body("two", 1.0, 0.1, parent=one, at=(1.0, 0.0, 0.0), joint=kf.Revolute("z"))
    made.add_rigid_body("slide", 1.0, 0.1, joint=kf.Prismatic("x"))
    made.add_flexible_body("beam", beam(), joint=kf.Revolute("z"))
    return made


def small() -> kf.System:
    """Return a pendulum with a spring, which runs in no time."""
    made = kf.System(gravity=(0.0, -9.81, 0.0))
    rod = made.add_rigid_body("rod", 1.0, 0.1, com=(0.5, 0.0, 0.0), joint=kf.Revolute("z"))
    made.add_spring("spring", made.ground.frame((0.0, 1.0, 0.0)), rod.frame((0.5, 0.0, 0.0)), stiffness=100.0)
    return made


def hanging() -> kf.System:
    made = kf.System(gravity=(0.0, -9.81, 0.0))
    made.add_rigid_body("rod", 1.0, 0.1, com=(0.0, -0.5, 0.0), joint=kf.Revolute("z"))
    return made


def cantilever() -> kf.System:
    made = kf.System()
    arm = made.add_flexible_body(
        "beam",
        fem.beam_body(
            steel_beam(4), {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=4), stiffening="full"
        ),
    )
    made.add_force(arm.interface("tip"), (-1.0, 0.0, 0.0))
    return made


def adds(name: str, make: Callable[[kf.System], dict[str, Any]], of: Callable[[], kf.System] = scene) -> None:
    def good() -> Good:
        made = of()
        return getattr(made, name.rpartition(".")[2]), make(made)

    CALLS[name] = Call(good)


def lone_frame() -> kf.Frame:
    return scene().body("one")


FRAME = {"parent": None, "joint": kf.Free(), "at": (0.0, 0.0, 0.0), "orientation": (1.0, 0.0, 0.0, 0.0)}
PAIR = {"a": "one", "b": "two"}


def ends(made: kf.System) -> dict[str, Any]:
    return {"name": "n", "a": made.body("one"), "b": made.body("two")}


call("kanefe.System", kf.System, gravity=(0, 0, -9.81), slopes="rotation-vector")
call("kanefe.RobotScene", kf.RobotScene, gravity=(0, 0, -9.81))
adds("kanefe.System.add", lambda s: {"load": kf.Rope("r", (s.ground, s.body("two")), 1e4)})
adds("kanefe.System.add_bushing", lambda s: {**ends(s), "stiffness": (1.0,) * 3, "damping": (1.0,) * 3})
adds(
    "kanefe.System.add_contact",
    lambda s: {
        "name": "c",
        "one": s.add_surface("ball", s.body("two"), kf.shapes.Sphere(0.1)),
        "other": s.add_surface("floor", s.ground, kf.shapes.Plane("y")),
        "normal": kf.HuntCrossley(1e5),
        "friction": kf.Coulomb(0.3),
        "surface_velocity": (0.0, 0.0, 0.0),
    },
)
adds(
    "kanefe.System.add_contacts",
    lambda s: {
        "among": [
            s.add_surface("ball", s.body("two"), kf.shapes.Sphere(0.1)),
            s.add_surface("floor", s.ground, kf.shapes.Plane("y")),
        ],
        "normal": kf.HuntCrossley(1e5),
        "friction": kf.Coulomb(0.3),
        "ignore": (),
    },
)
adds(
    "kanefe.System.add_controller",
    lambda s: {
        "name": "pd",
        "function": lambda t, x, memory: [0.0],
        "every": 0.01,
        "reads": ["joint_coordinates one"],
        "drives": ["torque one z"],
        "delay": 0.0,
    },
)
adds("kanefe.System.add_distance", lambda s: {**ends(s), "length": 1.0, "starts_on": True})
adds(
    "kanefe.System.add_flexible_body",
    lambda s: {
        "name": "f",
        "body": beam(),
        **FRAME,
        "modal_coordinates": None,
        "modal_speeds": None,
        "displacement": None,
        "velocity": None,
        "gravity": True,
    },
)
adds(
    "kanefe.System.add_force",
    lambda s: {"target": s.body("one"), "force": (1.0, 0, 0), "point": (0, 0, 0), "follows": False},
)
adds("kanefe.System.add_frame", lambda s: {"name": "f", **FRAME})
adds(
    "kanefe.System.add_gear",
    lambda s: {
        "name": "g",
        "coefficients": {s.body("one"): 1.0, s.body("two"): 2.0},
        "constant": None,
        "starts_on": None,
    },
)
adds(
    "kanefe.System.add_loop_joint",
    lambda s: {
        "name": "l",
        "joint": kf.Revolute("z"),
        "a": s.body("two"),
        "b": s.ground.frame((1, 0, 0)),
        "starts_on": True,
    },
)
adds("kanefe.System.add_motor", lambda s: {"body": s.body("one"), "force": 1.0, "coordinate": 0})
adds(
    "kanefe.System.add_point", lambda s: {"name": "p", "mass": 1.0, **FRAME, "joint": kf.Translation(), "gravity": True}
)
adds(
    "kanefe.System.add_pressure",
    lambda s: {
        "member": s.add_flexible_body("solid", loaded_body()),
        "surface": "right",
        "pressure": 1.0,
        "follows": True,
    },
)
adds(
    "kanefe.System.add_traction",
    lambda s: {
        "member": s.add_flexible_body("solid", loaded_body()),
        "surface": "right",
        "traction": (1.0, 0, 0),
        "follows": False,
    },
)
adds(
    "kanefe.System.add_rack",
    lambda s: {"name": "r", "pinion": s.body("one"), "rack": s.body("slide"), "radius": 0.1, "starts_on": None},
)
adds(
    "kanefe.System.add_rigid_body",
    lambda s: {"name": "b", "mass": 1.0, "inertia": (1.0, 1.0, 1.0), **FRAME, "com": (0.0, 0.0, 0.0), "gravity": True},
)
adds(
    "kanefe.System.add_rolling_ball",
    lambda s: {
        "name": "r",
        "ball": s.add_rigid_body("ball", 1.0, 1.0, joint=kf.Free((0, 0, 0.1))),
        "radius": 0.1,
        "plane": None,
        "starts_on": None,
    },
)
adds(
    "kanefe.System.add_rolling_wheel",
    lambda s: {
        "name": "r",
        "wheel": s.add_rigid_body("ball", 1.0, 1.0, joint=kf.Free((0, 0, 0.1))),
        "radius": 0.1,
        "plane": None,
        "starts_on": None,
    },
)
adds("kanefe.System.add_rotor", lambda s: {"body": s.body("one"), "axis": "x", "inertia": 1.0, "rate": 1.0})
adds(
    "kanefe.System.add_spring",
    lambda s: {**ends(s), "stiffness": 1.0, "damping": 1.0, "rest_length": 1.0, "force": None},
)
adds(
    "kanefe.System.add_surface",
    lambda s: {
        "name": "s",
        "parent": s.body("one"),
        "shape": kf.shapes.Sphere(0.1),
        "at": (0, 0, 0),
        "orientation": (1, 0, 0, 0),
    },
)
adds("kanefe.System.add_torque", lambda s: {"target": s.body("one"), "torque": (1.0, 0, 0), "follows": False})
adds("kanefe.System.body", lambda s: {"name": "one"})
on("kanefe.System.freeze", small, t=0.0, start=None)
on("kanefe.System.start_report", small, t=0.0)
on(
    "kanefe.System.simulate",
    small,
    t_span=(0.0, 0.01),
    start=None,
    record="kinetic_energy",
    record_file="records.h5",
    method="auto",
    rtol=1e-6,
    atol=1e-7,
    output_step=0.001,
    events=(),
    checkpoint=None,
    checkpoint_seconds=30.0,
    resume=None,
    most_steps=1000,
    most_seconds=5.0,
    progress=False,
)
on(
    "kanefe.System.simulate (accuracy)",
    small,
    t_span=(0.0, 0.01),
    accuracy=0.1,
    of=["kinetic_energy"],
    most_memory=1e12,
    stiffer=(),
    most_seconds=0.1,
)
CALLS["kanefe.System.simulate (times)"] = Call(
    lambda: (small().simulate, {"t_span": (0.0, 0.01), "method": "rk4", "step": 1e-3, "output_times": [0.0, 0.01]})
)
on(
    "kanefe.System.start",
    small,
    t=0.0,
    start=None,
    inputs=None,
    outputs=None,
    every=0.01,
    duration=None,
    method="auto",
    rtol=None,
    atol=None,
    step=None,
    events=(),
)
on(
    "kanefe.System.to_fmu",
    small,
    path="x.fmu",
    fmi="2.0",
    t=0.0,
    start=None,
    inputs=None,
    outputs=None,
    every=0.01,
    duration=None,
    method="auto",
    rtol=None,
    atol=None,
    step=None,
)
on("kanefe.Frame.frame", lone_frame, at=(0, 0, 0), orientation=(1, 0, 0, 0))


@cache
def started() -> kf.Simulation:
    return small().start()


on("kanefe.Simulation.outputs_with", lambda: small().start(), inputs={})
on("kanefe.Simulation.step", lambda: small().start(), dt=0.01, inputs=None)
on("kanefe.Simulation.restore", lambda: started(), saved=started().save())
