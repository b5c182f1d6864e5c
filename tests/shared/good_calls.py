"""A good call of each public function; `bad_input` spoils its arguments one by one."""

from __future__ import annotations

import atexit
import re
import shutil
import tempfile
from collections.abc import Callable
from functools import cache, cached_property, partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
import scipy.stats

import import_writers
import kanefe as kf
import kanefe_fem as fem
from kanefe.fe_model.model import Cells
from repository import ROOT
from steel_beams import STEEL, steel_beam

Good = tuple[Callable[..., Any], dict[str, Any]]


class Call:
    """How a good call is made, each time anew."""

    def __init__(self, good: Callable[[], Good]) -> None:
        self.good = good

    @cached_property
    def arguments(self) -> tuple[str, ...]:
        return tuple(name for name in self.good()[1] if name != "*")


CALLS: dict[str, Call] = {}

FILES = Path(tempfile.mkdtemp(prefix="kanefe-good-calls-"))
atexit.register(shutil.rmtree, FILES, ignore_errors=True)


@cache
def file(name: str) -> Path:
    """Return a file of the kind that its name says, written when it is first asked for."""
    path = FILES / name
    if name == "body.h5":
        beam().save(path)
    elif name == "run.h5":
        result().save(path, forces=False)
    elif name == "model.npz":
        kf.write_matrices(steel_beam(2), path)
    elif name == "body.sid":
        kf.write_sid(beam(), path)
    elif name == "solid.stl":
        path.write_text(STL)
    elif name == "robot.xml":
        path.write_text(MJCF)
    elif name == "mass.mtx":
        scipy.io.mmwrite(path, steel_beam(2).mass)
    elif name == "stiffness.mtx":
        scipy.io.mmwrite(path, steel_beam(2).stiffness)
    elif name == "store":
        study().run("serial", path, progress=False)
    elif name == "seas.csv":
        path.write_text(EXAMPLE_RAO.read_text())
    return path


CORNERS = ("0 0 0", "1 0 0", "0 1 0", "0 0 1")
STL = (
    "solid s\n"
    + "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {CORNERS[i]}\n" for i in face) + "endloop\nendfacet\n"
        for face in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
    )
    + "endsolid s\n"
)
MJCF = """<mujoco><worldbody><body name="rod"><joint name="hinge" type="hinge" axis="0 1 0"/>
<geom type="box" size="0.1 0.1 0.5" mass="1"/></body></worldbody></mujoco>"""
EXAMPLE_RAO = next((ROOT / "kanefe" / "environment" / "data").glob("*.csv"))


def call(name: str, function: Callable[..., Any], /, **arguments: Any) -> None:
    """Add a call of a function; arguments that are themselves made anew each time are `Made`."""
    CALLS[name] = Call(lambda: (function, arguments))


def on(name: str, thing: Callable[[], Any], /, **arguments: Any) -> None:
    """Add a call of a method of what a function returns."""
    CALLS[name] = Call(lambda: (getattr(thing(), name.rpartition(".")[2]), arguments))


def files(name: str, function: Callable[..., Any], /, **arguments: Any) -> None:
    """Add a call of a function that reads files, which are named by what is written into them."""
    names = {"path", "store", "stiffness", "mass"}
    CALLS[name] = Call(lambda: (function, {k: file(v) if k in names else v for k, v in arguments.items()}))


def first(name: str, function: Callable[..., Any], thing: Callable[[], Any], /, **arguments: Any) -> None:
    """Add a call of a function whose first argument is what another returns, and is not spoiled."""
    CALLS[name] = Call(lambda: (partial(function, thing()), arguments))


# --- scenes ---------------------------------------------------------------------------------------------------------


@cache
def beam() -> kf.FlexibleBody:
    return fem.beam_body(steel_beam(4), {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=2))


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
    lambda s: {"member": s.add_flexible_body("solid", loaded_body()), "surface": "right", "pressure": 1.0},
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
on(
    "kanefe.System.simulate",
    small,
    t_span=(0.0, 0.01),
    start=None,
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


on("kanefe.Simulation.step", lambda: small().start(), dt=0.01, inputs=None)
on("kanefe.Simulation.restore", lambda: started(), saved=started().save())

# --- frames, joints, motions ----------------------------------------------------------------------------------------

call("kanefe.rotation_about", kf.rotation_about, axis="z", angle=1.0)
call("kanefe.euler_angles", kf.euler_angles, order="XYZ", angles=(0.1, 0.2, 0.3))
AXIS = {"axis": "z", "position": 0.0, "speed": 0.0, "motion": None, "forces": None}
call("kanefe.Revolute", kf.Revolute, **AXIS, friction=None)
call("kanefe.Prismatic", kf.Prismatic, **AXIS, friction=None)
call("kanefe.Screw", kf.Screw, **AXIS, friction=None, lead=0.01)
call(
    "kanefe.Cylindrical",
    kf.Cylindrical,
    axis="z",
    position=(0, 0),
    speed=(0, 0),
    motion=(None, None),
    forces=(None, None),
    friction=None,
)
call(
    "kanefe.Free",
    kf.Free,
    position=(0, 0, 0),
    orientation=(1, 0, 0, 0),
    velocity=(0, 0, 0),
    angular_velocity=(0, 0, 0),
    motion=None,
)
call("kanefe.Spherical", kf.Spherical, orientation=(1, 0, 0, 0), angular_velocity=(0, 0, 0), motion=None, friction=None)
call(
    "kanefe.Planar",
    kf.Planar,
    position=(0, 0),
    angle=0.0,
    velocity=(0, 0),
    rate=0.0,
    motion=(None,) * 3,
    forces=(None,) * 3,
)
call(
    "kanefe.Translation", kf.Translation, position=(0, 0, 0), velocity=(0, 0, 0), motion=(None,) * 3, forces=(None,) * 3
)
call(
    "kanefe.Universal",
    kf.Universal,
    first="x",
    second="y",
    position=(0, 0),
    speed=(0, 0),
    motion=(None, None),
    forces=(None, None),
)
call(
    "kanefe.PointOnCurve",
    kf.PointOnCurve,
    points=[(0, 0, 0), (1, 0, 0), (2, 1, 0)],
    closed=False,
    turns=False,
    up=None,
    position=0.0,
    speed=0.0,
    motion=None,
    forces=None,
)
call(
    "kanefe.CoordinateForce",
    kf.CoordinateForce,
    stiffness=1.0,
    damping=1.0,
    rest=0.0,
    friction=0.1,
    static_friction=0.2,
    friction_stiffness=10.0,
    friction_damping=1.0,
    limits=(-1.0, 1.0),
    limit_stiffness=1e3,
    limit_damping=1.0,
)
call(
    "kanefe.CoordinateForce.backlash",
    kf.CoordinateForce.backlash,
    play=0.1,
    stiffness=1e3,
    damping=1.0,
    rest=0.0,
    friction=0.0,
)
call(
    "kanefe.JointFriction",
    kf.JointFriction,
    mu=0.1,
    radius=0.01,
    static=0.2,
    preload=0.0,
    stiffness=1e6,
    damping=10.0,
    load_time=0.01,
)
call(
    "kanefe.Motion",
    kf.Motion,
    position=lambda t: t,
    velocity=lambda t: 1.0,
    acceleration=lambda t: 0.0,
    span=(0.0, 1.0),
)
call("kanefe.Motion.steady", kf.Motion.steady, rate=1.0, start=0.0)
call("kanefe.Motion.table", kf.Motion.table, times=[0, 1, 2, 3], positions=[0, 1, 0, 1])
call("kanefe.PoseTable", kf.PoseTable, times=[0, 1, 2, 3], positions=np.zeros((4, 3)))
call(
    "kanefe.PoseMotion",
    kf.PoseMotion,
    position=lambda t: (t, 0, 0),
    velocity=lambda t: (1.0, 0, 0),
    acceleration=lambda t: (0.0, 0, 0),
    span=(0.0, 1.0),
)
call("kanefe.Event", kf.Event, name="e", function=lambda t, s: t - 1.0, direction=0, terminal=False, action=None)

# --- laws, shapes, loads --------------------------------------------------------------------------------------------

LAW = {"stiffness": 1e5, "damping": 1.0, "exponent": 1.5}
for law in (kf.HuntCrossley, kf.Hertz, kf.KelvinVoigt):
    call(f"kanefe.{law.__name__}", law, **(LAW if law is not kf.KelvinVoigt else LAW | {"exponent": 1.0}))
call(
    "kanefe.Hertz.of_sphere", kf.Hertz.of_sphere, radius=0.1, E=210e9, nu=0.3, other_E=210e9, other_nu=0.3, damping=0.0
)
call("kanefe.Restitution", kf.Restitution, stiffness=1e5, restitution=0.5, exponent=1.0, least_speed=1e-3)
call("kanefe.Rigid", kf.Rigid, restitution=0.5, impact="newton")
call(
    "kanefe.Coulomb",
    kf.Coulomb,
    mu=0.3,
    static=0.4,
    stribeck_speed=0.1,
    stiffness=1e5,
    damping=1.0,
    along="x",
    torsional=0.0,
    rolling=0.0,
)
call("kanefe.LuGre", kf.LuGre, sigma0=1e5, sigma1=1.0, sigma2=0.1, coulomb=0.3, static=0.4, stribeck_speed=0.1)
call("kanefe.TableLaw", kf.TableLaw, depths=[0, 0.1, 0.2], forces=[0, 1, 3], damping=0.0)
S = kf.shapes
call("kanefe.shapes.Box", S.Box, size=(1, 1, 1), inside=False)
call("kanefe.shapes.Capsule", S.Capsule, radius=0.1, length=1.0, axis="x")
call("kanefe.shapes.Convex", S.Convex, points=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
call("kanefe.shapes.Cylinder", S.Cylinder, radius=0.1, length=1.0, axis="z", inside=False)
call("kanefe.shapes.HeightField", S.HeightField, x=[0, 1, 2], y=[0, 1, 2], heights=np.zeros((3, 3)))
call(
    "kanefe.shapes.Mesh",
    S.Mesh,
    vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    triangles=[(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)],
)
call("kanefe.shapes.Plane", S.Plane, normal="z")
call("kanefe.shapes.Points", S.Points, points=[(0, 0, 0), (1, 0, 0)], radius=0.0, share=0.5)
call("kanefe.shapes.Sphere", S.Sphere, radius=0.1, inside=False)
call("kanefe.shapes.Torus", S.Torus, radius=0.5, tube=0.1, axis="y")
for shape in (S.Box((1, 1, 1)), S.Capsule(0.1, 1.0), S.Cylinder(0.1, 1.0), S.Torus(0.5, 0.1)):
    call(f"kanefe.shapes.{type(shape).__name__}.sampled", shape.sampled, spacing=0.2)
files("kanefe.shapes.Mesh.from_stl", S.Mesh.from_stl, path="solid.stl", scale=1.0)
files("kanefe.shapes.Convex.from_stl", S.Convex.from_stl, path="solid.stl", scale=1.0)
G = kf.System().ground
ENDS = (G, G.frame((1, 0, 0)))
call("kanefe.Rope", kf.Rope, name="r", ends=ENDS, axial_stiffness=1e5, damping=1.0, length=1.0, breaking_load=1e5)
call(
    "kanefe.Winch", kf.Winch, name="w", ends=ENDS, tension=1e3, stiffness=1e4, speed=1.0, damping=1.0, breaking_load=1e5
)
call(
    "kanefe.Oleo",
    kf.Oleo,
    name="o",
    ends=ENDS,
    area=0.01,
    pressure=1e6,
    volume=0.01,
    orifice=1.0,
    rebound=2.0,
    exponent=1.3,
    ambient=1e5,
    extended=1.0,
)
call(
    "kanefe.Oleo.orifice_coefficient",
    kf.Oleo.orifice_coefficient,
    density=850.0,
    area=0.01,
    orifice=1e-4,
    discharge=0.7,
)
call(
    "kanefe.PeriodicLoad",
    kf.PeriodicLoad,
    name="p",
    on=G,
    rate=10.0,
    mean=[0.0] * 6,
    harmonics={1: ([1.0] * 6, [0.0] * 6)},
    azimuth=0.0,
    share=None,
)
WIND = kf.Wind((10.0, 0.0, 0.0))
call("kanefe.Wind", kf.Wind, velocity=(10, 0, 0), gusts=(), turbulence=None)
call("kanefe.Gust", kf.Gust, velocity=(1, 0, 0), start=1.0, duration=2.0)
call("kanefe.Turbulence", kf.Turbulence, intensity=0.1, length=100.0, seed=0, count=10)
call(
    "kanefe.Aerodynamics",
    kf.Aerodynamics,
    name="a",
    on=G,
    wind=WIND,
    angles=np.linspace(-3.1, 3.1, 9),
    areas=np.ones((9, 6)),
    is_symmetric=False,
    flat_area=0.0,
    density=1.2,
)

# --- environment ----------------------------------------------------------------------------------------------------

call("kanefe.RollDamping", kf.RollDamping, ratio=0.1, frequency=0.5, ratio_of_rao=0.05)
SEA = {"seed": 1, "duration": 60.0, "count": 30}
call(
    "kanefe.Sea.bretschneider",
    kf.Sea.bretschneider,
    Hs=2.0,
    Tp=9.0,
    spreading=None,
    spreading_deg=30.0,
    **SEA,
    depth=np.inf,
    gravity=9.81,
)
call("kanefe.Sea.jonswap", kf.Sea.jonswap, Hs=2.0, Tp=9.0, gamma=3.3, spreading=2.0, **SEA)
call("kanefe.Sea.pierson_moskowitz", kf.Sea.pierson_moskowitz, wind=10.0, spreading=2.0, **SEA)
call("kanefe.Sea.state", kf.Sea.state, number=4, spreading=2.0, **SEA)
call("kanefe.Sea.measured", kf.Sea.measured, frequencies=[0.3, 0.5, 0.8, 1.0], densities=[0.0, 1.0, 1.0, 0.0], **SEA)


@cache
def sea() -> kf.Sea:
    return kf.Sea.bretschneider(2.0, 9.0, **SEA)


@cache
def ship() -> kf.Ship:
    return kf.Ship(kf.example_rao(), sea(), speed=0.0, heading_deg=30.0)


on("kanefe.Sea.elevation", sea, times=[0.0, 1.0], x=0.0, y=0.0)
on("kanefe.Sea.kept", sea, order=0)
first("kanefe.Ship", kf.Ship, kf.example_rao, sea=sea(), speed=0.0, heading_deg=30.0, slowest_hz=0.03)
on("kanefe.Ship.at", ship, point=(1, 0, 0), duration=60.0, start=0.0, ramp=10.0, rotations="exact")
on("kanefe.Ship.motions", ship, times=[0.0, 1.0])
on("kanefe.Ship.motions_std", ship, point=(0, 0, 0))
on("kanefe.Ship.response_spectra", ship, omega=[0.5, 0.6])
on("kanefe.Ship.plot_rao", ship, path="x.png")
on("kanefe.MotionRao.at", kf.example_rao, omega=np.array([0.5]), heading_deg=30.0, speed=0.0)
on("kanefe.MotionRao.with_wave_at", kf.example_rao, x=1.0, y=0.0)
files("kanefe.read_rao", kf.read_rao, path="seas.csv", wave_at=(0.0, 0.0), symmetric=None)

# --- bodies from matrices -------------------------------------------------------------------------------------------

call("kanefe.ModalDamping", kf.ModalDamping, ratio=0.01)
call("kanefe.RayleighDamping", kf.RayleighDamping, mass=0.1, stiffness=1e-5)
call("kanefe.RayleighDamping.fit", kf.RayleighDamping.fit, frequencies=(1.0, 10.0), ratios=(0.01, 0.01))
on("kanefe.RayleighDamping.ratio", lambda: kf.RayleighDamping(0.1, 0.1), frequency=1.0)
on("kanefe.ModalDamping.ratios", lambda: kf.ModalDamping(0.1), count=3)
call("kanefe.InBox", kf.InBox, low=(0, 0, 0), high=(1, 1, 1))
call("kanefe.InCylinder", kf.InCylinder, start=(0, 0, 0), end=(1, 0, 0), radius=1.0, inner_radius=0.5)
call("kanefe.Near", kf.Near, point=(0, 0, 0), distance=1.0)
call("kanefe.OnPlane", kf.OnPlane, point=(0, 0, 0), normal=(0, 0, 1), distance=0.1)
call(
    "kanefe.Interface",
    kf.Interface,
    fixed=("x",),
    kind="rigid",
    weights=None,
    position=None,
    axes=None,
    released=(),
    groups=None,
    at=None,
)
on("kanefe.Interface.group_names", kf.Interface, name="root")
call("kanefe.CraigBampton", kf.CraigBampton, modes=2, tol=1e-3, loads=(), error_up_to=None)
CALLS["kanefe.CraigBampton (frequency)"] = Call(lambda: (kf.CraigBampton, {"up_to_frequency": 100.0}))
call("kanefe.FreeInterface", kf.FreeInterface, modes=2, attachment=True, loads=(), error_up_to=None)
call("kanefe.Krylov", kf.Krylov, frequencies=(0.0,), order=2, loads=(), error_up_to=None)
call("kanefe.Enriched", kf.Enriched, reduction=kf.CraigBampton(modes=2))
call("kanefe.LoadCase", kf.LoadCase, name="l", forces=np.ones(30))
call("kanefe.PatchCase", kf.PatchCase, place="tip", most=4)
call(
    "kanefe.flexible_body",
    kf.flexible_body,
    model=steel_beam(4),
    interfaces={"root": "clamped"},
    reduction=kf.CraigBampton(modes=2),
    damping=kf.ModalDamping(0.01),
    stiffening="none",
)
on("kanefe.FiniteElementModel.group", lambda: steel_beam(4), name="root")
on("kanefe.FiniteElementModel.rigid_modes", lambda: steel_beam(4), about=(0.0, 0.0, 0.0))
on("kanefe.FlexibleBody.interface", beam, name="tip")
on("kanefe.FlexibleBody.load_pattern", loaded_body, name="right")
on("kanefe.FlexibleBody.node_displacements", beam, eta=np.zeros(2 + 6))
on("kanefe.FlexibleBody.node_frame", beam, node=0)
on("kanefe.FlexibleBody.save", beam, path="body.h5")
files("kanefe.FlexibleBody.load", kf.FlexibleBody.load, path="body.h5")
call("kanefe.FlexibleLink", kf.FlexibleLink, body=beam(), at=(0, 0, 0), orientation=(1, 0, 0, 0), interfaces={})

EXPECTED = {"expected_mass": None, "expected_center": None, "expected_inertia": None}


def small_matrices() -> Good:
    model = steel_beam(2)
    return kf.model_from_matrices, {
        "mass": model.mass,
        "stiffness": model.stiffness,
        "nodes": model.nodes,
        "components": model.components,
        "damping": None,
        "groups": {"root": 0},
        "cells": (),
        "load_patterns": None,
        "geometric_stiffness": None,
        "stress_stiffness": None,
        "order": "nodes",
        "generalised": 0,
        **EXPECTED,
        "source": "test",
    }


CALLS["kanefe.model_from_matrices"] = Call(small_matrices)
call("kanefe.write_matrices", kf.write_matrices, model=steel_beam(2), path="m.npz")
call("kanefe.write_sid", kf.write_sid, body=beam(), path="b.sid", nodes=())
files("kanefe.read_matrices", kf.read_matrices, path="model.npz", **EXPECTED)
files("kanefe.read_sid", kf.read_sid, path="body.sid", names=None, fixed=None, expected_mass=None)
files(
    "kanefe.read_matrix_market",
    kf.read_matrix_market,
    nodes=steel_beam(2).nodes,
    stiffness="stiffness.mtx",
    mass="mass.mtx",
    components=("x", "y", "z", "rx", "ry", "rz"),
    order="nodes",
    damping=None,
    groups=None,
    units="m, kg, s",
    **EXPECTED,
)
URDF = ROOT / "tests" / "robots" / "arm.urdf"
call(
    "kanefe.read_urdf",
    kf.read_urdf,
    path=URDF,
    base=None,
    gravity=(0, 0, -9.81),
    flexible=None,
    positions=None,
    limit_stiffness=None,
    limit_damping=0.0,
    joint_forces=True,
)
files(
    "kanefe.read_mjcf",
    kf.read_mjcf,
    path="robot.xml",
    gravity=None,
    flexible=None,
    positions=None,
    limit_stiffness=None,
    limit_damping=0.0,
    joint_forces=True,
)

# --- results and small motions --------------------------------------------------------------------------------------


@cache
def result() -> kf.Result:
    made = small()
    made.add_flexible_body("beam", beam(), joint=kf.Revolute("y"))
    made.add_rigid_body("driven", 1.0, 0.1, joint=kf.Revolute("z", motion=kf.Motion.steady(1.0)))
    bar = made.add_rigid_body("bar", 1.0, 0.1, joint=kf.Free((0.0, 0.0, 3.0)))
    made.add_loop_joint("loop", kf.Spherical(), bar, made.ground.frame((0.0, 0.0, 3.0)))
    made.add_contact(
        "stop",
        made.add_surface("ball", bar, kf.shapes.Sphere(0.1)),
        made.add_surface("floor", made.ground, kf.shapes.Plane("z")),
        normal=kf.HuntCrossley(1e5),
    )
    return made.simulate((0.0, 0.01), output_step=0.002)


def instant() -> kf.Instant:
    return result().at(0.004)


for reader, of in (("Result", result), ("Instant", instant)):
    for method in ("acceleration", "angular_acceleration", "angular_velocity", "position", "rotation", "velocity"):
        on(f"kanefe.{reader}.{method}", of, name="beam", interface="tip")
    for method in ("body", "interfaces", "modal_coordinates", "modal_speeds"):
        on(f"kanefe.{reader}.{method}", of, name="beam")
    for method in ("joint_coordinates", "joint_reaction", "joint_speeds", "center_of_mass"):
        on(f"kanefe.{reader}.{method}", of, name="rod")
    on(f"kanefe.{reader}.contact", of, name="stop")
    on(f"kanefe.{reader}.driving_force", of, name="driven")
    on(f"kanefe.{reader}.loop_force", of, name="loop")
    on(f"kanefe.{reader}.load", of, name="spring")
    on(f"kanefe.{reader}.load_force", of, name="spring", end=0)
    on(f"kanefe.{reader}.coupling_force", of, name="beam", interface="tip")
    on(f"kanefe.{reader}.neighbours", of, name="beam", interface="tip")
    on(f"kanefe.{reader}.deflection", of, name="beam", interface="tip")
    on(
        f"kanefe.{reader}.in_axes_of",
        of,
        name="beam",
        vectors=np.ones(3) if reader == "Instant" else np.ones((6, 3)),
        interface="tip",
    )
    for method in ("nodal_displacements", "nodal_positions"):
        on(f"kanefe.{reader}.{method}", of, name="beam", frames=None, nodes=[0, 1])
    on(f"kanefe.{reader}.parts", of, quantity="position", name="rod")
    on(f"kanefe.{reader}.read", of, quantity="position", name="beam", interface="tip")
    on(f"kanefe.{reader}.units", of, quantity="position", name="rod")
on("kanefe.Instant.struck", instant, body="rod", impulse=(0, 1, 0), interface="", point=(0, 0, 0), moment=(0, 0, 0))
on("kanefe.Instant.to_vtk", instant, path="a.pvd", scale=1.0)
on("kanefe.Result.at", result, t=0.004)
on("kanefe.Result.plot", result, what="energy", path="a.png")
on("kanefe.Result.save", result, path="a.h5", forces=False)
PAGE = {"colour": None, "stress": (), "forces": False, "fps": None, "every": 2, "scale": 1.0, "title": "x"}
on("kanefe.Result.to_html", result, path="a.html", **PAGE)
on("kanefe.Result.view", result, **PAGE)
on("kanefe.Result.to_vtk", result, path="a.pvd", fps=None, every=2, scale=1.0)
files("kanefe.load_result", kf.load_result, path="run.h5")

AT = {"t": None, "start": None}
first("kanefe.linearise", kf.linearise, hanging, **AT, inputs=None, outputs=None)
call("kanefe.linearise (scene)", kf.linearise, scene=hanging())
first("kanefe.equilibrium", kf.equilibrium, hanging, **AT, speeds=None, find=(), steady=True)
call("kanefe.equilibrium (scene)", kf.equilibrium, scene=hanging())
first("kanefe.floquet", kf.floquet, hanging, period=1.0, **AT)
first("kanefe.buckling", kf.buckling, cantilever, loads=None, count=2, **AT)
call("kanefe.buckling (scene)", kf.buckling, scene=cantilever())
first("kanefe.stability_limit", kf.stability_limit, cantilever, loads=None, up_to=None, **AT)
call("kanefe.campbell", kf.campbell, build=lambda w: hanging(), speeds=[0.0, 1.0], modes=1, balance=True)


@cache
def linear() -> kf.Linearisation:
    return kf.linearise(hanging(), inputs=["torque rod z"])


@cache
def modes() -> kf.Modes:
    return kf.linearise(cantilever()).modes()


@cache
def diagram() -> kf.Campbell:
    return kf.campbell(lambda w: hanging(), [0.0, 1.0], modes=1)


@cache
def buckled() -> kf.Buckling:
    return kf.buckling(cantilever(), count=2)


on("kanefe.Equilibrium.linearise", lambda: kf.equilibrium(hanging()), inputs=None, outputs=None)
on("kanefe.Linearisation.frequency_response", linear, frequencies=[1.0, 2.0])
on("kanefe.Linearisation.moved", linear, x=[0.1, 0.0])
on("kanefe.Linearisation.to_fmu", linear, path="l.fmu", fmi="2.0")
on("kanefe.Campbell.critical_speeds", diagram, order=1.0)
on("kanefe.Campbell.plot", diagram, path="c.png", orders=(1.0,))
for kind, of in (("Modes", modes), ("Buckling", buckled)):
    on(f"kanefe.{kind}.describe", of, mode=0)
    on(f"kanefe.{kind}.displacements", of, body="beam", mode=0)
    on(f"kanefe.{kind}.shape", of, body="beam", interface="tip")
    on(f"kanefe.{kind}.shown", of, mode=0, size=1.0)


def deck() -> kf.System:
    made = kf.System(gravity=(0.0, 0.0, -9.81))
    ground = made.add_frame("deck", joint=kf.Free(motion=kf.PoseTable([0, 1, 2, 3], np.zeros((4, 3)))))
    made.add_rigid_body(
        "box", 1.0, 0.1, parent=ground, joint=kf.Revolute("x", forces=kf.CoordinateForce(stiffness=100.0, damping=5.0))
    )
    return made


first("kanefe.screen", kf.screen, deck, duration=1.0, start=None, rtol=None, output_step=None, spacing=0.25)


@cache
def frozen() -> kf.Model:
    return small().freeze()


on("kanefe.Model.index", frozen, name="rod")


@cache
def state() -> kf.SceneState:
    seen: list[kf.SceneState] = []
    hanging().simulate((0.0, 0.001), events=kf.Event("look", lambda t, s: seen.append(s) or 1.0))
    return seen[0]


for method in ("angular_velocity", "position", "rotation", "velocity"):
    on(f"kanefe.SceneState.{method}", state, name="rod")
for method in ("joint_coordinates", "joint_speeds"):
    on(f"kanefe.SceneState.{method}", state, name="rod")

# --- studies --------------------------------------------------------------------------------------------------------


def pendulum(length: float, angle: float = 0.0) -> kf.System:
    return small()


call(
    "kanefe.Study",
    kf.Study,
    build=pendulum,
    outputs=kf.studies.peak("position", "rod"),
    duration=0.01,
    rtol=None,
    simulate=None,
    length=[1.0, 2.0],
)
call(
    "kanefe.Study.sampled",
    kf.Study.sampled,
    build=pendulum,
    outputs=kf.studies.peak("position", "rod"),
    samples=2,
    sampling="latin hypercube",
    sampling_seed=0,
    duration=0.01,
    rtol=None,
    simulate=None,
    length=scipy.stats.norm(10.0, 0.5),
)
study = cache(lambda: kf.Study(pendulum, kf.studies.peak("position", "rod"), duration=0.01, length=[1.0, 2.0]))
on("kanefe.Study.key", study, number=0)
on("kanefe.Study.result", study, parameters={"length": 1.0})
on("kanefe.Study.run", study, executor="serial", store="store", workers=1, retry_failed=False, progress=False)
files("kanefe.StudyTable", kf.StudyTable, store="store")
fit = cache(lambda: kf.studies.GumbelFit.of(np.array([1.0, 2.0, 3.0, 2.5, 1.5])))
call("kanefe.studies.GumbelFit.of", kf.studies.GumbelFit.of, maxima=np.array([1.0, 2.0, 3.0, 2.5]))
on("kanefe.studies.GumbelFit.exceedance", fit, limit=2.0)
on("kanefe.studies.GumbelFit.exceedance_band", fit, limit=2.0, band=0.9)
on("kanefe.studies.GumbelFit.quantile", fit, probability=0.1)
on("kanefe.studies.GumbelFit.quantile_band", fit, probability=0.1, band=0.9)
call("kanefe.studies.events", kf.studies.events, after=0.0, lift="lift*")
R = {"component": None, "after": 0.0, "name": "x"}
call("kanefe.studies.exceedances", kf.studies.exceedances, quantity="position", level=1.0, **R)
call(
    "kanefe.studies.interruptions",
    kf.studies.interruptions,
    body="deck",
    at=(0, 0, 0),
    lateral=0.2,
    longitudinal=0.2,
    sliding=0.2,
    after=0.0,
    name="crew",
)
call("kanefe.studies.peak", kf.studies.peak, quantity="position", kind="absolute", **R)
call("kanefe.studies.spectrum", kf.studies.spectrum, quantity="position", segment=None, **R)

# --- finite elements ------------------------------------------------------------------------------------------------

call("kanefe_fem.Material", fem.Material, E=210e9, nu=0.3, rho=7850.0, name="steel")
call(
    "kanefe_fem.Orthotropic",
    fem.Orthotropic,
    E1=1e11,
    E2=1e10,
    E3=1e10,
    nu12=0.3,
    nu13=0.3,
    nu23=0.3,
    G12=5e9,
    G13=5e9,
    G23=4e9,
    rho=1600.0,
    name="cfrp",
)
call(
    "kanefe_fem.Orthotropic.transversely_isotropic",
    fem.Orthotropic.transversely_isotropic,
    E1=1e11,
    E2=1e10,
    nu12=0.3,
    nu23=0.3,
    G12=5e9,
    rho=1600.0,
    name="cfrp",
)
call("kanefe_fem.Anisotropic", fem.Anisotropic, stiffness=np.eye(6) * 1e9, rho=1000.0, name="a")
call("kanefe_fem.Ply", fem.Ply, material=STEEL, thickness=0.01, angle=0.1)
call("kanefe_fem.Laminate", fem.Laminate, plies=[fem.Ply(STEEL, 0.01)], name="l")
call("kanefe_fem.Oriented", fem.Oriented, material=STEEL, axes=np.eye(3))


def energy(strain: Any) -> Any:
    import ufl

    return 1e9 * ufl.inner(strain, strain)


call("kanefe_fem.UserEnergy", fem.UserEnergy, energy=energy, rho=1000.0, of="strain", name="u")
call("kanefe_fem.axes_at_angle", fem.axes_at_angle, angle=0.1, axis=(0, 0, 1), along=(1, 0, 0))
call("kanefe_fem.cylindrical_axes", fem.cylindrical_axes, origin=(0, 0, 0), axis=(0, 0, 1), first="outward")
call("kanefe_fem.spherical_axes", fem.spherical_axes, origin=(0, 0, 0), pole=(0, 0, 1), first="outward")
call("kanefe_fem.Box", fem.Box, width=0.1, height=0.1, thickness=0.01, nu=0.3)
call("kanefe_fem.Rectangle", fem.Rectangle, width=0.1, height=0.1, nu=0.3)
call("kanefe_fem.SolidCircle", fem.SolidCircle, diameter=0.1, nu=0.3)
call("kanefe_fem.Tube", fem.Tube, outer_diameter=0.1, thickness=0.01, nu=0.3)
call("kanefe_fem.Section", fem.Section, A=1e-4, I_y=1e-9, I_z=1e-9, J=1e-9, shear_y=0.8, shear_z=0.8)
call(
    "kanefe_fem.Section.from_stiffness",
    fem.Section.from_stiffness,
    EA=1e7,
    EI_y=1e3,
    EI_z=1e3,
    GJ=1e3,
    GA_y=1e7,
    GA_z=1e7,
    rho_A=1.0,
    rho_I=1e-4,
    centre_of_mass=(0.0, 0.0),
)
call("kanefe_fem.LumpedMass", fem.LumpedMass, at="tip", mass=1.0, inertia=(1.0, 1.0, 1.0), position=None)
call("kanefe_fem.LumpedSpring", fem.LumpedSpring, at="tip", stiffness=(1.0,) * 6, to=None, position=None)
call("kanefe_fem.attach", fem.attach, model=steel_beam(4), lumped=[fem.LumpedMass("tip", 1.0)])
BEAM = {"theory": "timoshenko", "planar": False, "orientation": None, "rotary_inertia": True}
SECTION = fem.Rectangle(0.02, 0.02)
call(
    "kanefe_fem.straight_beam",
    fem.straight_beam,
    length=1.0,
    section=SECTION,
    material=STEEL,
    elements=2,
    direction=(1, 0, 0),
    start=(0, 0, 0),
    **BEAM,
)
call(
    "kanefe_fem.beam_model",
    fem.beam_model,
    nodes=[(0, 0, 0), (1, 0, 0), (2, 0, 0)],
    elements=[(0, 1), (1, 2)],
    section=SECTION,
    material=STEEL,
    **BEAM,
    groups={"root": 0, "tip": -1},
    lines=None,
)
call(
    "kanefe_fem.beam_body",
    fem.beam_body,
    model=steel_beam(4),
    interfaces={"root": "clamped"},
    reduction=kf.CraigBampton(modes=2),
    damping=kf.ModalDamping(0.01),
    stiffening="none",
    lines=None,
)
call(
    "kanefe_fem.box_mesh",
    fem.box_mesh,
    size=(1.0, 1.0, 1.0),
    counts=(1, 1, 1),
    kind="hexahedron",
    start=(0.0, 0.0, 0.0),
)
call("kanefe_fem.cylinder_mesh", fem.cylinder_mesh, length=1.0, radius=0.5, counts=(1, 1, 8), inner_radius=0.2, order=2)
call("kanefe_fem.rectangle_mesh", fem.rectangle_mesh, length=1.0, height=1.0, counts=(1, 1), start=(0.0, 0.0))
box = cache(lambda: fem.box_mesh((1.0, 1.0, 1.0), (1, 1, 1)))
on("kanefe_fem.Mesh.with_groups", box, places={"a": kf.OnPlane((0, 0, 0), (1, 0, 0))})
on("kanefe_fem.Mesh.with_order", box, order=2)
call("kanefe_fem.read_mesh", fem.read_mesh, path=ROOT / "meshes" / "arm.msh", order=None, names=None, cells=None)
call("kanefe_fem.rosette_principal", fem.rosette_principal, strains=np.zeros((2, 3)), angles=(0.0, 0.8, 1.6))
call("kanefe_fem.recover", fem.recover, result=result(), name="beam", times=None, frames=None, material=None)
SOLID = {
    "order": 1,
    "plane": None,
    "thickness": None,
    "surfaces": (),
    "cells": None,
    "densities": None,
    "lumped": (),
    "preload": None,
}
call("kanefe_fem.solid_model", fem.solid_model, mesh=box(), materials=STEEL, **SOLID)
call(
    "kanefe_fem.solid_body",
    fem.solid_body,
    mesh=box(),
    materials=STEEL,
    interfaces={"left": "clamped"},
    reduction=kf.CraigBampton(modes=2),
    damping=kf.ModalDamping(0.01),
    stiffening="none",
    **SOLID,
    cache=False,
    progress=None,
)
call(
    "kanefe_fem.Preload",
    fem.Preload,
    held={"left": ("x", "y", "z")},
    forces={"right": (1.0, 0, 0)},
    tractions={},
    pressures={},
    acceleration=(0, 0, 0),
    angular_velocity=(0, 0, 0),
    center=(0, 0, 0),
    thermal_strain=0.0,
)

# --- what needs files of other programs, a compiler or a whole study ------------------------------------------------


@cache
def job(kind: str) -> list[Path]:
    """Return the files of a job of Abaqus, Ansys or Nastran."""
    made: list[Path] = getattr(import_writers, f"{kind}_job")(FILES, steel_beam(2), np.arange(1, 4))
    return made


READING = {"groups": None, "units": "m, kg, s", **EXPECTED}


def reads(kind: str, names: tuple[str, ...], /, **more: Any) -> None:
    function = getattr(kf, f"read_{kind}")
    CALLS[f"kanefe.read_{kind}"] = Call(
        lambda: (function, {**dict(zip(names, job(kind), strict=True)), **READING, **more})
    )


reads("abaqus", ("nodes", "stiffness", "mass"), damping=None, substructure=None, trusted=False)
reads("ansys", ("nodes", "stiffness", "mass", "mapping"), damping=None, generalised=())
if find_spec("pyyeti"):
    reads("nastran", ("bulk", "matrices"), names=None, freedoms=None, generalised=())


@cache
def compiled() -> Any:
    from numba import cfunc, types

    numbers = types.CPointer(types.float64)

    @cfunc(types.void(types.float64, types.float64, numbers, numbers))
    def spring(d: float, rate: float, c: Any, out: Any) -> None:
        out[0] = out[1] = c[0] * d
        out[2] = 0.5 * c[0] * d**2

    return spring


CALLS["kanefe.CompiledLaw"] = Call(
    lambda: (kf.CompiledLaw, {"function": compiled(), "depth": 1e-3, "constants": (1e5,), "slopes": False})
)
on("kanefe.Study.table", study, store="store")


def turned(heading_deg: float, seed: int) -> kf.System:
    scene = kf.System()
    scene.add_rigid_body("mass", 1.0, joint=kf.Prismatic("x", position=1.0 + seed))
    return scene


@cache
def table() -> kf.StudyTable:
    cases = {"heading_deg": [0.0, 90.0, 180.0], "seed": [0, 1, 2, 3]}
    made = kf.Study(turned, kf.studies.peak("position", "mass", component="x"), duration=0.01, **cases)
    return made.run("serial", FILES / "table", progress=False)


on("kanefe.StudyTable.case", table, key=0)
on("kanefe.StudyTable.column", table, name="seed")
on("kanefe.StudyTable.save", table, path="table.csv")
on("kanefe.StudyTable.operability", table, limit=1.0, over="seed", band=0.9)
chances = cache(lambda: table().operability(1.0))
on("kanefe.studies.Operability.to_html", chances, path="chances.html")
on("kanefe.studies.Operability.plot", chances, angle="heading_deg", radius=None, output=None, path="chances.png")
files(
    "kanefe.Ship.from_rao", kf.Ship.from_rao, path="seas.csv", sea=sea(), speed=0.0, heading_deg=30.0, slowest_hz=0.03
)


@cache
def spectrum() -> Any:
    import xarray

    values = 0.01 * np.outer(np.ones(4), [0.1, 1.0, 0.1, 0.0])
    return xarray.DataArray(values, coords={"freq": [0.1, 0.2, 0.3, 0.4], "dir": [0.0, 90.0, 180.0, 270.0]})


CALLS["kanefe.Sea.from_wavespectra"] = Call(lambda: (kf.Sea.from_wavespectra, {"spectrum": spectrum(), **SEA}))


def lined() -> kf.FiniteElementModel:
    return fem.straight_beam(1.0, SECTION, STEEL, elements=2)


adds(
    "kanefe.System.add_line_load",
    lambda s: {
        "member": s.add_flexible_body(
            "lined", fem.beam_body(lined(), {"root": "clamped"}, reduction=kf.CraigBampton(modes=2))
        ),
        "line": "span",
        "load": (0.0, 1.0, 0.0),
        "follows": False,
    },
)
call(
    "kanefe_fem.preloaded",
    fem.preloaded,
    model=steel_beam(2),
    preload=fem.Preload(held={"root": ("x", "y", "z", "rx", "ry", "rz")}, forces={"tip": (1.0, 0.0, 0.0)}),
)
call(
    "kanefe_fem.beam_model_from_mesh",
    fem.beam_model_from_mesh,
    mesh=fem.Mesh(
        nodes=np.array([[0, 0, 0], [0, 0, 1.0], [1.0, 0, 1.0]]),
        dimension=1,
        cells={},
        lines={"leg": (Cells("line", np.array([[0, 1], [1, 2]])),)},
        points={"foot": np.array([0])},
        source="portal",
    ),
    sections={"leg": SECTION},
    materials=STEEL,
    **BEAM,
)

QUICK = {
    name: made
    for name, made in CALLS.items()
    if re.match(
        r"kanefe\.(System\.add_(?!pressure|traction)|Interface|Near|InBox|InCylinder|OnPlane|Krylov|FreeInterface|Event)",
        name,
    )
    or re.match(r"kanefe_fem\.(?!solid|recover|beam|attach|straight|read|UserEnergy|Mesh)", name)
    or re.match(r"kanefe\.(Result|Instant|Modes|Buckling)\.(?!plot|save|to_|view)", name)
}
"""Those that take some milliseconds."""
