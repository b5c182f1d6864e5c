"""What is asked of a run beside it: forces, reports, files, records, and the rest from which it starts."""

from __future__ import annotations

import tempfile
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np

import kanefe as kf
from benchmarks.clocks import seconds
from benchmarks.goals import Figure, Goal, median
from kanefe_fem import Material, box_mesh, recover, solid_body

SAVE_CAR = Goal("car on tyres: save / run, 1,201 times", 0.3)
SAVE_LINKS = Goal("20 links: save / run, 1,001 times", 1.0)
COUPLING = Goal("car: coupling_force at 6,001 times, ms", 20.0)
REACTION = Goal("20 links: joint_reaction at 24,001 times, ms", 50.0)
REPORT = Goal("car: contact_report, s", 0.1)
OVERVIEW = Goal("car: overview plot, s", 1.0)
REST = Goal("car: kf.equilibrium, s", 0.3)
RECORD_COST = Goal("car: record of 10 channels at each step / run", 1.05)
RECORD_MEMORY = Goal("record of 10 channels at 1e6 times, MB", 50.0)
DAMAGE = Goal("damage map of 100,000 nodes, 10,000 times, 23 modes, s", 5.0)

CORNERS = {"fl": (1.3, 0.5), "fr": (1.3, -0.5), "rl": (-1.3, 0.5), "rr": (-1.3, -0.5)}
SPEED, RADIUS, TUBE = 10.0, 0.25, 0.06  # m/s, m, m


def car() -> kf.System:
    """Return a car of four wheels with a flexible chassis on a rough road."""
    steel = Material(E=210e9, nu=0.3, rho=300.0)
    faces = {
        name: kf.Interface(kind="average", at=kf.InBox((x - 0.11, y - 0.06, -0.051), (x + 0.11, y + 0.06, -0.049)))
        for name, (x, y) in CORNERS.items()
    }
    faces["cab"] = kf.Interface(kind="average", at=kf.InBox((-0.3, -0.56, 0.049), (0.3, 0.56, 0.051)))
    mesh = box_mesh((2.8, 1.1, 0.1), (14, 8, 1), start=(-1.4, -0.55, -0.05))
    frame = solid_body(mesh, steel, faces, order=2, reduction=kf.CraigBampton(modes=8), damping=kf.ModalDamping(0.02))
    rng = np.random.default_rng(1)
    x, y = np.arange(-5.0, 65.0, 0.1), np.linspace(-2.0, 2.0, 9)
    waves = np.arange(0.02, 1.0, 0.02)  # 1/m
    heights = np.sqrt(2.0 * 64e-6 * (waves / 0.1) ** -2 * 0.02)[:, None]  # ISO 8608, class B
    tracks = [
        (heights * np.sin(2.0 * np.pi * waves[:, None] * x + rng.uniform(0.0, 2.0 * np.pi, (len(waves), 1)))).sum(0)
        for _ in range(2)
    ]
    share = (y + 2.0) / 4.0
    road = (tracks[1][:, None] * (1.0 - share) + tracks[0][:, None] * share) * np.clip(x / 2.0, 0.0, 1.0)[:, None]
    scene = kf.System(gravity=(0, 0, -9.81))
    surface = scene.add_surface("road", scene.ground, kf.shapes.HeightField(x, y, road))
    start = kf.Free(position=(-2.0, 0.0, RADIUS + TUBE + 0.25), velocity=(SPEED, 0.0, 0.0))
    chassis = scene.add_flexible_body("chassis", frame, joint=start)
    scene.add_rigid_body("body", 800.0, (200.0, 700.0, 800.0), com=(0, 0, 0.3), parent=chassis.interface("cab"))
    load = (800.0 + frame.mass) * 9.81 / 4.0
    for name, (_, side) in CORNERS.items():
        spring = kf.CoordinateForce(stiffness=25e3, damping=1800.0, rest=-load / 25e3)
        hub = scene.add_rigid_body(
            f"{name} hub",
            15.0,
            0.3,
            parent=chassis.interface(name),
            at=(0.0, 0.15 * np.sign(side), -0.2),
            joint=kf.Prismatic("z", forces=spring),
        )
        spin = kf.Revolute("y", speed=SPEED / (RADIUS + TUBE))
        wheel = scene.add_rigid_body(f"{name} wheel", 15.0, (0.5, 0.9, 0.5), parent=hub, joint=spin)
        tyre = scene.add_surface(f"{name} tyre", wheel, kf.shapes.Torus(RADIUS, TUBE, axis="y"))
        law = kf.KelvinVoigt(2e5, damping=200.0)
        scene.add_contact(f"{name} road", tyre, surface, normal=law, friction=kf.Coulomb(0.9))
    return scene


def links() -> kf.System:
    """Return a chain of 20 links on hinges."""
    scene = kf.System(gravity=(0, 0, -9.81))
    body = scene.ground
    for i in range(20):
        at = (0.1 if i else 0.0, 0.0, 0.0)
        body = scene.add_rigid_body(
            f"link {i}", 1.0, 0.01, com=(0.05, 0, 0), parent=body, at=at, joint=kf.Revolute("y")
        )
    return scene


def asked_of_a_car(rounds: int) -> list[Figure]:
    """Measure what is asked of a run of the car."""
    scene = car()
    scene.simulate((0.0, 0.1))
    runs, saves, couplings, reports, overviews, rests = [], [], [], [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(rounds):
            result, took = _timed(lambda: scene.simulate((0.0, 6.0), output_step=0.005))
            runs.append(took)
            saves.append(seconds(lambda run=result: run.save(Path(folder) / "car.h5")) / took)  # type: ignore[misc]
            fine = scene.simulate((0.0, 6.0), output_step=0.001)
            couplings.append(1e3 * seconds(lambda run=fine: run.coupling_force("chassis", "cab")))  # type: ignore[misc]
            result = scene.simulate((0.0, 6.0), output_step=0.005)
            reports.append(seconds(lambda run=result: str(run.contact_report())))  # type: ignore[misc]
            result = scene.simulate((0.0, 6.0), output_step=0.005)
            overviews.append(seconds(lambda run=result: run.plot(path=Path(folder) / "car.png")))  # type: ignore[misc]
            rests.append(seconds(lambda: kf.equilibrium(scene)))
    return [
        SAVE_CAR.figure(median(saves), f"run {median(runs):.2f} s"),
        COUPLING.figure(median(couplings)),
        REPORT.figure(median(reports)),
        OVERVIEW.figure(median(overviews)),
        REST.figure(median(rests)),
    ]


def asked_of_links(rounds: int) -> list[Figure]:
    """Measure the file and the reactions of a chain."""
    scene = links()
    scene.simulate((0.0, 0.1))
    saves, reactions, took = [], [], 0.0
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(rounds):
            result, took = _timed(lambda: scene.simulate((0.0, 1.0), output_step=1e-3))
            saves.append(seconds(lambda run=result: run.save(Path(folder) / "links.h5")) / took)  # type: ignore[misc]
            fine = scene.simulate((0.0, 1.0), output_step=1.0 / 24000.0)
            reactions.append(1e3 * seconds(lambda run=fine: run.joint_reaction("link 0")))  # type: ignore[misc]
    return [SAVE_LINKS.figure(median(saves), f"run {1e3 * took:.1f} ms"), REACTION.figure(median(reactions))]


def recorded(rounds: int) -> list[Figure]:
    """Measure what a record costs beside a run, and its memory."""
    scene, channels = (
        car(),
        [
            "position chassis",
            "velocity chassis",
            *(f"joint_coordinates {name} hub" for name in CORNERS),
        ],
    )
    steps = scene.simulate((0.0, 6.0)).statistics["steps"]
    record = kf.Record(channels, step=6.0 / steps)
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(rounds):
            plain = seconds(lambda: scene.simulate((0.0, 6.0), output_step=0.5))
            beside = seconds(
                lambda: scene.simulate((0.0, 6.0), output_step=0.5, record=record, record_file=Path(folder) / "car.h5")
            )
            ratios.append(beside / plain)
        rod = kf.System(gravity=(0, 0, -9.81))
        rod.add_rigid_body("rod", 1.0, 0.02, com=(0.25, 0, 0), joint=kf.Free(angular_velocity=(1.0, 2.0, 3.0)))
        many = kf.Record(["position rod", "velocity rod", "rotation rod"], step=1e-3)
        rod.simulate((0.0, 1.0), record=many)
        tracemalloc.start()
        rod.simulate((0.0, 1000.0), output_step=10.0, record=many, record_file=Path(folder) / "rod.h5")
        peak = tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()
    return [RECORD_COST.figure(median(ratios), f"{steps} steps"), RECORD_MEMORY.figure(peak)]


def damage_map(rounds: int) -> list[Figure]:
    """Measure the damage of von Mises' stress at the nodes of the surface of a large mesh."""
    steel = Material(E=210e9, nu=0.3, rho=7850.0)
    faces = {"root": "clamped", "tip": kf.Interface(kind="average")}
    body = solid_body(
        box_mesh((1.0, 0.1, 0.05), (100, 40, 24), kind="tetra"),
        steel,
        faces,
        reduction=kf.CraigBampton(modes=14, loads=("tip", "gravity")),
        damping=kf.ModalDamping(0.02),
        order=1,
    )
    scene = kf.System(gravity=(0, 0, -9.81))
    bar = scene.add_flexible_body("bar", body)
    scene.add_rigid_body("weight", 40.0, 0.1, parent=bar.interface("tip"))
    rng = np.random.default_rng(0)
    phases, rates = rng.uniform(0.0, 2.0 * np.pi, 20), 2.0 * np.pi * rng.uniform(2.0, 300.0, 20)
    scene.add_force(bar.interface("tip"), lambda t: (0.0, 0.0, 1e3 * float(np.sin(rates * t + phases).sum())))
    result = scene.simulate((0.0, 2.0), output_step=2e-4)
    curve = kf.fatigue.SNCurve(amplitude=160e6, cycles=1e6, slope=5, slope_below=9)
    times = [seconds(lambda: recover(result, "bar").damage(curve)) for _ in range(rounds)]
    return [DAMAGE.figure(median(times), f"{len(body.nodes)} nodes")]


def _timed(run: Callable[[], kf.Result]) -> tuple[kf.Result, float]:
    begun = time.perf_counter()
    result = run()
    return result, time.perf_counter() - begun


GROUPS = {
    asked_of_a_car: [SAVE_CAR, COUPLING, REPORT, OVERVIEW, REST],
    asked_of_links: [SAVE_LINKS, REACTION],
    recorded: [RECORD_COST, RECORD_MEMORY],
    damage_map: [DAMAGE],
}
"""Goals of each group, which stand in its place where it cannot be measured."""
