"""Good calls of results, and small motions."""

from __future__ import annotations

from functools import cache

import numpy as np

import kanefe as kf
from good_call import WRITERS, call, files, first, on
from good_scenes import beam, cantilever, hanging, small


@cache
def result() -> kf.Result:
    made = small()
    made.add_flexible_body("beam", beam(), joint=kf.Revolute("y"))
    made.add_rigid_body("driven", 1.0, 0.1, joint=kf.Revolute("z", motion=kf.Motion.steady(1.0)))
    bar = made.add_rigid_body("bar", 1.0, 0.1, joint=kf.Free((0.0, 0.0, 3.0)))
    made.add_loop_joint("loop", kf.Spherical(), bar, made.ground.frame((0.0, 0.0, 3.0)))
    made.add_gear("gear", {made.add_rigid_body("wheel", 1.0, 0.1, joint=kf.Revolute("z")): 1.0}, starts_on=False)
    made.add_contact(
        "stop",
        made.add_surface("ball", bar, kf.shapes.Sphere(0.1)),
        made.add_surface("floor", made.ground, kf.shapes.Plane("z")),
        normal=kf.HuntCrossley(1e5),
    )
    return made.simulate((0.0, 0.01), output_step=0.002)


def recorded(path: str) -> kf.Result:
    return small().simulate((0.0, 0.01), record="kinetic_energy", record_file=path)


WRITERS["run.h5"] = lambda path: result().save(path, forces=False)
WRITERS["records.h5"] = recorded


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
    on(f"kanefe.{reader}.contact_points", of, name="stop")
    on(f"kanefe.{reader}.driving_force", of, name="driven")
    on(f"kanefe.{reader}.loop_force", of, name="loop")
    on(f"kanefe.{reader}.gear_force", of, name="gear")
    on(f"kanefe.{reader}.load", of, name="spring", column="tension")
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
    on(f"kanefe.{reader}.load_lines", of, frames=None)
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
for method in ("to_dataframe", "to_xarray"):
    on(f"kanefe.Result.{method}", result, channels=["position beam/tip", "kinetic_energy"])
for method, name in (("to_csv", "a.csv"), ("to_matlab", "a.mat")):
    on(f"kanefe.Result.{method}", result, path=name, channels={"tip": "position beam/tip"})
on("kanefe.Result.to_vtk", result, path="a.pvd", fps=None, every=2, scale=1.0)
files("kanefe.load_result", kf.load_result, path="run.h5")
files("kanefe.load_records", kf.load_records, path="records.h5")
call(
    "kanefe.Quantity",
    kf.Quantity,
    what="position rod",
    relative=1e-3,
    absolute=1e-3,
    over="largest",
    name="place",
)
first(
    "kanefe.certify",
    kf.certify,
    cantilever,
    analysis=kf.buckling,
    of=lambda found: found.factors[:1],
    accuracy=0.1,
    most_seconds=0.1,
    most_memory=1e12,
    progress=False,
)
call("kanefe.Record", kf.Record, channels="position rod", step=0.1, at=(), keep="values")
call("kanefe.Record (events)", kf.Record, channels={"x": "position rod"}, at=["floor touch"])

AT = {"t": None, "start": None}
first("kanefe.linearise", kf.linearise, hanging, **AT, inputs=None, outputs=None)
call("kanefe.linearise (scene)", kf.linearise, scene=hanging())
first("kanefe.equilibrium", kf.equilibrium, hanging, **AT, speeds=None, find=(), steady=True)
call("kanefe.equilibrium (scene)", kf.equilibrium, scene=hanging())
first("kanefe.floquet", kf.floquet, hanging, period=1.0, **AT)
first("kanefe.buckling", kf.buckling, cantilever, loads=None, count=2, **AT)
call("kanefe.buckling (scene)", kf.buckling, scene=cantilever())
PATH = {"to": 2.0, "down_to": -2.0, "longest": 0.1, "points": 500}
first("kanefe.equilibrium_path", kf.equilibrium_path, cantilever, loads=None, **PATH, **AT)
call("kanefe.equilibrium_path (scene)", kf.equilibrium_path, scene=cantilever(), branch=None)
first("kanefe.stability_limit", kf.stability_limit, cantilever, loads=None, up_to=None, **AT)


def turning(speed: float, stiffness: float = 0.0) -> kf.System:
    made = hanging()
    made.add_frame("rotor", joint=kf.Revolute("z", motion=kf.Motion.steady(speed)))
    spring = kf.CoordinateForce(stiffness + 10.0, damping=0.1)
    made.add_rigid_body("cart", 1.0, joint=kf.Prismatic("x", forces=spring))
    return made


def controlled() -> kf.System:
    made = turning(1.0)
    made.add_controller("brake", lambda t, r, m: -r[0], every=0.1, reads="joint_speeds cart", drives="motor cart")
    return made


call("kanefe.campbell", kf.campbell, build=turning, speeds=[0.0, 1.0], modes=1, balance=True)
call("kanefe.stability_map", kf.stability_map, build=turning, speeds=[0.0, 1.0], values=[0.0, 1.0], balance=True)
first("kanefe.sampled_loop", kf.sampled_loop, controlled, **AT, inputs="force cart x", outputs="position cart x")


@cache
def linear() -> kf.Linearisation:
    return kf.linearise(hanging(), inputs=["torque rod z"])


@cache
def both_ways() -> kf.Linearisation:
    """Return a damped hanging rod with a torque and its angle."""
    scene = kf.System(gravity=(0, 0, -9.81))
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(damping=0.1))
    scene.add_rigid_body("rod", 1.0, 0.1, com=(0, 0, -0.5), joint=hinge)
    return kf.linearise(scene, inputs="motor rod", outputs="joint_coordinates rod")


@cache
def modes() -> kf.Modes:
    return kf.linearise(cantilever()).modes()


@cache
def diagram() -> kf.Campbell:
    return kf.campbell(turning, [0.0, 1.0], modes=1)


@cache
def buckled() -> kf.Buckling:
    return kf.buckling(cantilever(), count=2)


@cache
def path() -> kf.EquilibriumPath:
    """Return the path of a rod that buckles at 100 N."""
    made = kf.System()
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=100.0))
    rod = made.add_rigid_body("rod", 1.0, 0.1, com=(0, 0, 0.5), joint=hinge)
    made.add_force(rod, (0, 0, -1), point=(0, 0, 1))
    return kf.equilibrium_path(made, to=150.0)


on("kanefe.EquilibriumPath.at", path, factor=50.0, crossing=0)
on("kanefe.EquilibriumPath.branch", path, at=0, side=1, mode=0, **{**PATH, "to": 150.0})
on("kanefe.EquilibriumPath.plot", path, path="p.png", of="rod", axis="x", branches=())
on("kanefe.EquilibriumPath.point", path, number=1)
on("kanefe.EquilibriumPath.position", path, name="rod", interface=None)
on("kanefe.EquilibriumPath.read", path, quantity="position", name="rod", interface=None, of=None)
on("kanefe.Equilibrium.linearise", lambda: kf.equilibrium(hanging()), inputs=None, outputs=None)
on("kanefe.Linearisation.frequency_response", linear, frequencies=[1.0, 2.0])
on("kanefe.Linearisation.h2_norm", linear, output=None, input=None)
on("kanefe.Linearisation.margins", both_ways, output=None, input=None, gain=1.0, controller=None)
on("kanefe.Linearisation.to_control", linear, modal=False)
on("kanefe.Linearisation.moved", linear, x=[0.1, 0.0])
on("kanefe.Linearisation.to_fmu", linear, path="l.fmu", fmi="2.0")
on("kanefe.Campbell.critical_speeds", diagram, order=1.0, damped=True)


@cache
def loop() -> kf.SampledLoop:
    return kf.sampled_loop(controlled(), inputs="force cart x", outputs=("position cart x", "velocity cart x"))


@cache
def response() -> kf.FrequencyResponse:
    return loop().frequency_response([1.0, 2.0])


on("kanefe.SampledLoop.frequency_response", loop, frequencies=[1.0, 2.0])
on("kanefe.FrequencyResponse.receptance", response, output="position cart x", input="force cart x")
on("kanefe.FrequencyResponse.transmissibility", response, output="velocity cart x", over="position cart x", input=None)
on("kanefe.FrequencyResponse.plot", response, path="r.png")
on("kanefe.StabilityMap.plot", lambda: kf.stability_map(turning, [0.0, 1.0], [0.0]), path="s.png", name="stiffness")
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


first("kanefe.simulate_many", kf.simulate_many, hanging, t_span=(0.0, 0.01), starts=[[0.1, 0.0]], threads=1)
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
