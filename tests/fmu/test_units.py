"""Functional mock-up units: the numbers of the simulation they are made from, states, no Python, what is refused."""

import re
import shutil
import subprocess
import sys
import threading
import zipfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from fmu_units import ERROR, Unit, simulated
from kanefe.bodies.relaxation import Relaxation
from kanefe.equations.routes import directions_of_loads
from kanefe_fem.beams.body import beam_body
from loop_scenes import four_bar
from steel_beams import steel_beam

DT = 0.01
TORQUES = [{"motor hub": float(torque)} for torque in 0.5 * np.sin(0.9 * np.arange(12)).round(1)]


@cache
def arm_body() -> kf.FlexibleBody:
    modes, damping = kf.CraigBampton(modes=3), kf.ModalDamping(0.02)
    return beam_body(steel_beam(6), {"root": "clamped", "tip": "rigid"}, reduction=modes, damping=damping)


def arm(spin: float = 2.0) -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    hub = scene.add_rigid_body("hub", 2.0, 0.05, joint=kf.Revolute("z"))
    scene.add_rigid_body("box", 0.1, 1e-4, parent=hub, at=(0.0, 0.3, 0.1), orientation=kf.rotation_about("x", 0.4))
    body = scene.add_flexible_body("arm", arm_body(), parent=hub, at=(0.1, 0.0, 0.0))
    scene.add_rigid_body(
        "tip", 0.2, 1e-4, parent=body.interface("tip"), joint=kf.Spherical(angular_velocity=(0.0, 0.5 * spin, spin))
    )
    return scene


OUTPUTS = (
    *("joint_coordinates hub", "joint_speeds hub", "modal_coordinates arm 0", "modal_speeds arm 1"),
    *("position arm/tip", "rotation tip", "velocity arm/tip x'", "angular_velocity tip y'", "acceleration tip y"),
    *("angular_acceleration arm/tip z'", "deflection arm/tip", "acceleration arm/tip"),
    *("position box", "velocity box", "acceleration box y'", "acceleration box x"),
    *("joint_reaction hub", "joint_reaction box force_z", "joint_reaction tip", "coupling_force arm/root"),
    "coupling_force arm/tip",
)
EXACT = 4
"""The first outputs are numbers of the state."""


@pytest.mark.parametrize(("fmi", "method"), [("2.0", "radau5"), ("3.0", "extrapolation"), ("3.0", "generalised-alpha")])
def test_a_unit_has_the_numbers_of_the_simulation(tmp_path: Path, fmi: str, method: str) -> None:
    options: dict[str, Any] = {"inputs": "motor hub", "outputs": OUTPUTS, "method": method}
    sim, unit = arm().start(**options), Unit(arm().to_fmu(tmp_path / "arm.fmu", fmi=fmi, **options))
    first = unit.get(sim.output_names)
    np.testing.assert_allclose(first, list(sim.outputs.values()), rtol=0, atol=1e-12)
    found = unit.run(TORQUES, DT, sim.output_names)
    wanted = []
    for torque in TORQUES:
        sim.step(DT, torque)
        wanted.append(list(sim.outputs.values()))
    np.testing.assert_array_equal(found[:, :EXACT], np.array(wanted)[:, :EXACT])
    # what is computed from the state, in another order
    np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-12)
    unit.free()


def test_a_unit_solves_for_directions_of_loads_as_the_simulation_does(tmp_path: Path) -> None:
    scene = arm()
    scene.add_spring("stay", scene.ground.frame(at=(0.0, 0.0, 1.0)), scene.body("tip"), stiffness=1e4, damping=3.0)
    assert directions_of_loads(scene.freeze()) == 6
    options: dict[str, Any] = {"inputs": "motor hub", "outputs": OUTPUTS[:EXACT], "method": "generalised-alpha"}
    sim, unit = scene.start(**options), Unit(scene.to_fmu(tmp_path / "arm.fmu", **options))
    found, wanted = unit.run(TORQUES, DT, sim.output_names), []
    for torque in TORQUES:
        sim.step(DT, torque)
        wanted.append(list(sim.outputs.values()))
    np.testing.assert_array_equal(found, np.array(wanted))
    unit.free()


@pytest.mark.parametrize("method", ["radau5", "generalised-alpha"])
def test_arms_of_a_viscoelastic_body_are_in_units(tmp_path: Path, method: str) -> None:
    body = arm_body()
    k = body.free_count
    relaxation = Relaxation(np.sqrt(0.3) * np.diag(np.sqrt(np.diag(body.stiffness)[:k])), np.full(k, 0.05))
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    hub = scene.add_rigid_body("hub", 2.0, 0.05, joint=kf.Revolute("z"))
    scene.add_flexible_body("arm", replace(body, relaxation=relaxation), parent=hub)
    outputs = ("joint_coordinates hub", "modal_coordinates arm 0", "modal_speeds arm 1")
    options: dict[str, Any] = {"inputs": "motor hub", "outputs": outputs, "method": method}
    sim, unit = scene.start(**options), Unit(scene.to_fmu(tmp_path / "arm.fmu", **options))
    found, wanted = unit.run(TORQUES, DT, sim.output_names), []
    for torque in TORQUES:
        sim.step(DT, torque)
        wanted.append(list(sim.outputs.values()))
    np.testing.assert_array_equal(found, np.array(wanted))
    unit.free()


def test_states_of_a_unit_are_taken_up_again_by_another(tmp_path: Path) -> None:
    path = arm().to_fmu(tmp_path / "arm.fmu", inputs="motor hub", method="radau5")
    units = [Unit(path), Unit(path)]
    names = ["joint_coordinates hub", "joint_speeds hub", "time"]
    units[0].run(TORQUES[:5], DT, names)
    kept = units[0].state()
    wanted = units[0].run(TORQUES[5:], DT, names)
    for unit in units:
        unit.go_back(kept)
        np.testing.assert_array_equal(unit.run(TORQUES[5:], DT, names), wanted)
        assert unit.call("Reset") == 0
        assert unit.get(["time"]) == [0.0]
        assert unit.begin(3.0) == 0
        assert unit.get(["time"]) == [3.0]
        unit.free()


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_bytes_that_are_no_state_of_the_unit_are_refused(tmp_path: Path, fmi: str) -> None:
    options: dict[str, Any] = {"fmi": fmi, "inputs": "motor hub", "method": "radau5"}
    unit = Unit(arm().to_fmu(tmp_path / "arm.fmu", **options))
    other = Unit(arm(spin=3.0).to_fmu(tmp_path / "other.fmu", **options))
    kept, stranger = unit.state(), other.state()
    assert len(kept) == len(stranger)  # their sizes do not tell them apart
    names = ["joint_coordinates hub", "time"]
    unit.run(TORQUES[:2], DT, names)
    before = unit.get(names)
    turned = bytes([*kept[:-1], kept[-1] ^ 1])
    for wrong, message in [
        (stranger, f"a state of another scene, {re.escape(other.token)}; this unit is {re.escape(unit.token)}"),
        (turned, "bytes of this state are damaged: they are not those that were written"),
        (kept[:-1], "bytes of this state are damaged: they are too few or too many"),
        (b"kanefe state 0" + kept[14:], r"not a state in the format of this unit \(kanefe state 1\)"),
        (b"", "not a state in the format of this unit"),
    ]:
        with pytest.raises(AssertionError):
            unit.go_back(wrong)
        assert re.search(message, unit.messages[-1])
        assert unit.get(names) == before
    unit.go_back(kept)
    assert unit.get(["time"]) == [0.0]
    unit.free()
    other.free()


@pytest.mark.parametrize("method", ["radau5", "dop853"])
def test_loops_driven_joints_and_planes_are_in_units(tmp_path: Path, method: str) -> None:
    scene = four_bar()
    names = [entry.name for entry in scene._entries]
    scene.add_rigid_body("wheel", 1.0, 0.1, joint=kf.Revolute("z", motion=kf.Motion.steady(2.0)))
    friction = kf.CoordinateForce(friction=0.01, static_friction=0.02)
    scene.add_rigid_body("disc", 0.1, 1e-3, joint=kf.Revolute("z", speed=0.7, forces=friction))
    small, large = (scene.add_rigid_body(name, 0.1, 1e-3, joint=kf.Revolute("z")) for name in ("small", "large"))
    scene.add_gear("pair", {small: 1, large: 2})
    scene.add_motor(small, 0.01)
    options: dict[str, Any] = {
        "method": method,
        "inputs": ("drive wheel", f"motor {names[0]}"),
        "outputs": (
            f"joint_coordinates {names[0]}",
            "joint_speeds wheel",
            f"position {names[1]} x",
            "joint_speeds disc",
            "driving_force wheel",
            f"loop_force {scene.freeze().constraints[0].name}",
            "gear_force pair",
        ),
    }
    sim, unit = scene.start(**options), Unit(scene.to_fmu(tmp_path / "bars.fmu", **options))
    for k in range(8):
        inputs = {"drive wheel": 0.5 * k, f"motor {names[0]}": 0.1 * k}
        sim.step(DT, inputs)
        found = unit.run([inputs], DT, sim.output_names)[0]
        # the disc stops within 1e-13 of the assumed duration (s), in which it still gains speed at 10 rad/s2
        np.testing.assert_allclose(found, list(sim.outputs.values()), rtol=0, atol=2e-9)
    assert unit.begin(0.0) == 0
    unit.free()


def rubbing_and_bouncing(normal: Any = None) -> kf.System:
    """A ball that bounces and slips on a floor, beside a wheel with dry friction."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=kf.Free(position=(0.0, 0.0, 0.12), velocity=(1.0, 0.0, 0.0)))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    surface = scene.add_surface("ball", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("touch", surface, floor, normal=normal or kf.HuntCrossley(1e5), friction=kf.Coulomb(0.3))
    scene.add_rigid_body(
        "wheel",
        1.0,
        0.1,
        joint=kf.Revolute("z", speed=0.05, forces=kf.CoordinateForce(friction=0.1, static_friction=0.2)),
    )
    return scene


FORCES = "load touch", "joint_reaction ball", "joint_reaction wheel"


@pytest.mark.parametrize(("fmi", "normal"), [("2.0", None), ("3.0", None), ("2.0", kf.Rigid(0.4))])
def test_contacts_and_dry_friction_need_no_python(tmp_path: Path, fmi: str, normal: Any) -> None:
    options: dict[str, Any] = {
        "inputs": "motor wheel",
        "outputs": (
            "velocity ball",
            "joint_speeds wheel",
            *FORCES,
            *(() if normal is None else ("contact_points touch",)),
        ),
    }
    sim = rubbing_and_bouncing(normal).start(**options)
    unit = Unit(rubbing_and_bouncing(normal).to_fmu(tmp_path / "ball.fmu", fmi=fmi, **options))
    torques = [{"motor wheel": torque} for torque in (0.0, 0.0, 0.05, 0.05, 0.2, 0.2, 0.05, -0.2, 0.0, 0.0, 0.0, 0.0)]
    wanted = []
    for torque in torques:
        sim.step(2.0 * DT, torque)
        wanted.append([sim.outputs[name] for name in sim.output_names])
    never = set() if normal is None else {"touch lift", "touch slip"}  # what is rigid slips from the start, and rests
    assert {name for name, times in sim.events.items() if not len(times)} <= never, sim.events
    half = len(torques) // 2
    found = unit.run(torques[:half], 2.0 * DT, sim.output_names)
    kept = unit.state()
    for _ in range(2):  # what is known of events is part of the state
        rest = unit.run(torques[half:], 2.0 * DT, sim.output_names)
        unit.go_back(kept)
    np.testing.assert_allclose(np.vstack((found, rest)), wanted, rtol=0, atol=1e-13)
    unit.free()


def test_forces_that_corners_share_need_no_python(tmp_path: Path) -> None:
    def scene() -> kf.System:
        scene = kf.System(gravity=(3.0, 0.0, -9.0))
        box = scene.add_rigid_body("box", 2.0, 0.02, com=(0.0, 0.02, 0.05), joint=kf.Free(position=(0.0, 0.0, 0.11)))
        feet = scene.add_surface(
            "feet", box, kf.shapes.Points([(x, y, -0.1) for x in (-0.2, 0.2) for y in (-0.1, 0.1)])
        )
        floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
        scene.add_contact("touch", feet, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.5))
        return scene

    options: dict[str, Any] = {"outputs": ("load touch", "contact_points touch", "joint_reaction box")}
    sim, unit = scene().start(**options), Unit(scene().to_fmu(tmp_path / "box.fmu", **options))
    wanted = []
    for _ in range(8):
        sim.step(DT)
        wanted.append([sim.outputs[name] for name in sim.output_names])
    found = unit.run([{}] * 8, DT, sim.output_names)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-11)
    normals = [i for i, name in enumerate(sim.output_names) if "normal" in name]
    assert np.count_nonzero(np.array(wanted)[:, normals].all(axis=1)) >= 3  # all corners carry
    unit.free()


def test_a_unit_is_the_same_whenever_it_is_written(tmp_path: Path) -> None:
    paths, kept = [], []
    for name in "ab":
        (tmp_path / name).mkdir()
        kept.append(np.empty(100_000))  # memory at other addresses
        paths.append(rubbing_and_bouncing().to_fmu(tmp_path / name / "ball.fmu", inputs="motor wheel"))
    assert paths[0].read_bytes() == paths[1].read_bytes()


def knocking() -> kf.System:
    """A hub whose arm runs on a rigid stop and bounces."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    hub = scene.add_rigid_body("hub", 1.0, 0.1, com=(0.3, 0, 0), joint=kf.Revolute("y"))
    knob = scene.add_surface("knob", hub, kf.shapes.Sphere(0.05), at=(0.5, 0, 0))
    floor = scene.add_surface("floor", scene.ground.frame(at=(0, 0, -0.0505)), kf.shapes.Plane("z"))
    scene.add_contact("touch", knob, floor, normal=kf.Rigid(0.5), friction=kf.Coulomb(0.2))
    return scene


OF_ARM = ("joint_reaction box moment_z", "coupling_force arm/root force_z")


@pytest.mark.parametrize(("scene", "more"), [(arm, OF_ARM), (knocking, ("joint_speeds hub", "angular_velocity hub y"))])
def test_a_unit_needs_no_python(tmp_path: Path, scene: Callable[[], kf.System], more: tuple[str, ...]) -> None:
    options: dict[str, Any] = {
        "inputs": "motor hub",
        "outputs": ("joint_coordinates hub", *more),
        "method": "radau5",
    }
    unit = Unit(scene().to_fmu(tmp_path / "arm.fmu", **options))
    compiler = shutil.which("cc")
    assert compiler is not None
    program = tmp_path / "program"
    source = Path(__file__).with_name("program.c")
    subprocess.run([compiler, str(source), "-o", str(program), "-ldl"], check=True)
    told = subprocess.run(
        [str(program), str(unit.library_path), unit.token], check=True, capture_output=True, text=True, env={}
    )
    sim = scene().start(**options)
    for _ in range(3):
        sim.step(DT, {"motor hub": 0.5})
    angle, *found = map(float.fromhex, told.stdout.split())
    assert angle == sim.outputs["joint_coordinates hub"]
    np.testing.assert_allclose(found, list(sim.outputs.values())[1:], rtol=1e-10)  # the same sums, by other code
    assert all(found)
    assert scene is arm or len(sim.events["touch touch"]) > 1
    unit.free()


def test_a_linear_system_is_a_unit_for_exchange(tmp_path: Path) -> None:
    small = kf.linearise(arm(0.0), inputs="motor hub", outputs=("position arm/tip y", "acceleration arm/tip y"))
    path = small.to_fmu(tmp_path / "small.fmu", fmi="3.0")
    validation = pytest.importorskip("fmpy.validation")
    assert validation.validate_fmu(str(path)) == []
    assert validation.validate_fmu(str(small.to_fmu(tmp_path / "two.fmu"))) == []
    found = simulated(path, stop_time=0.2, start_values={"motor hub": 0.1}, relative_tolerance=1e-9)
    control = pytest.importorskip("control")
    wanted = control.forced_response(small.to_control(), found["time"], 0.1 * np.ones(len(found["time"])))
    place, acceleration = found["position arm/tip y"], found["acceleration arm/tip y"]
    np.testing.assert_allclose(place - small.output_values[0], wanted.outputs[0], rtol=0, atol=1e-8)
    assert acceleration[0] == pytest.approx(small.output_values[1] + 0.1 * small.D[1, 0], rel=1e-12)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_units_are_what_the_standard_asks_for(tmp_path: Path, fmi: str) -> None:
    fmpy, validation = pytest.importorskip("fmpy"), pytest.importorskip("fmpy.validation")
    path = arm().to_fmu(tmp_path / "arm 1.fmu", fmi=fmi, inputs="motor hub", outputs=OUTPUTS, method="extrapolation")
    assert validation.validate_fmu(str(path)) == []
    units = {v.name: v.unit for v in fmpy.read_model_description(str(path)).modelVariables}
    assert (units["motor hub"], units["acceleration tip y"]) == ("N m", "m/s2")
    found = simulated(path, stop_time=0.1, step_size=DT, output_interval=DT, start_values={"motor hub": 0.5})
    sim = arm().start(inputs="motor hub", method="extrapolation")
    for _ in range(10):
        sim.step(DT, {"motor hub": 0.5})
    assert found["joint_coordinates hub"][-1] == pytest.approx(sim.outputs["joint_coordinates hub"], rel=1e-9)


def test_a_step_that_fails_is_told_and_leaves_the_unit_as_it_was(tmp_path: Path) -> None:
    unit = Unit(arm().to_fmu(tmp_path / "arm.fmu", inputs="motor hub", method="dop853"))
    before = unit.state()
    assert unit.step(-1.0) == ERROR
    assert unit.set("motor hub", float("nan")) == ERROR
    assert unit.set("motor hub", 1e200) == 0
    assert unit.step(DT) == ERROR
    assert "no step is small enough" in unit.messages[-1]
    assert unit.set("motor hub", 0.0) == 0
    assert unit.state() == before
    assert unit._made("{another}") is None
    assert "guid" in unit.messages[-1]
    unit.free()


def sampled(scene: kf.System) -> None:
    scene.add_controller("pd", lambda t, reads, memory: 0.0, every=DT, reads="joint_speeds hub", drives="motor hub")


def touching(scene: kf.System) -> None:
    floor = scene.add_surface("floor", scene.ground.frame(at=(0, 0, -1)), kf.shapes.Plane("z"))
    ball = scene.add_surface("ball", scene.body("hub"), kf.shapes.Sphere(0.1))
    scene.add_contact("touch", ball, floor, normal=kf.HuntCrossley(1e5))


IN_PYTHON: dict[str, tuple[Callable[[kf.System], Any], dict[str, Any]]] = {
    "the controller 'pd' is a Python function": (sampled, {}),
    "a load or a motion is a Python function": (
        lambda scene: scene.add_torque(scene.body("hub"), lambda t: 1.0 * t),
        {"method": "dop853"},
    ),
    "the output 'load spring tension' of a spring is computed in Python": (
        lambda scene: scene.add_spring("spring", scene.ground.frame(at=(0, 0, -1)), scene.body("tip"), stiffness=1.0),
        {"outputs": ("joint_coordinates hub", "load spring tension")},
    ),
    "asks for energies. Remedy: method='radau5'": (lambda scene: None, {"method": "energy-momentum", "step": 1e-3}),
}


@pytest.mark.parametrize("reason", IN_PYTHON)
def test_a_scene_in_python_makes_a_unit_that_says_so(tmp_path: Path, reason: str) -> None:
    change, options = IN_PYTHON[reason]
    scene = arm()
    change(scene)
    with pytest.warns(kf.SimulationWarning, match=r"needs kanefe .* where it runs") as told:
        path = scene.to_fmu(tmp_path / "arm.fmu", **options)
    assert reason in str(told[0].message)
    with zipfile.ZipFile(path) as archive:
        text = archive.read("modelDescription.xml").decode()
    assert "which this unit needs" in text
    assert "canGetAndSet" not in text


@pytest.mark.filterwarnings("error")
def test_a_unit_goes_on_from_events_by_extrapolation_without_python(tmp_path: Path) -> None:
    scene = arm()
    touching(scene)
    path = scene.to_fmu(tmp_path / "arm.fmu", method="extrapolation")
    with zipfile.ZipFile(path) as archive:
        assert "which this unit needs" not in archive.read("modelDescription.xml").decode()


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_a_unit_in_python_has_the_numbers_of_the_simulation(
    tmp_path: Path, fmi: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def push(t: float) -> float:
        if t > 0.055:
            raise ValueError("no more")
        return 1.0 + t

    scene = arm()
    scene.add_torque(scene.body("hub"), push)
    options: dict[str, Any] = {
        "inputs": "motor hub",
        "outputs": ("joint_coordinates hub", "joint_reaction tip force_z"),
    }
    with pytest.warns(kf.SimulationWarning, match="needs kanefe"):
        path = scene.to_fmu(tmp_path / "arm.fmu", fmi=fmi, method="dop853", rtol=1e-4, **options)
    monkeypatch.setenv("KANEFE_PYTHON", sys.executable)
    unit, sim = Unit(path), scene.start(method="dop853", rtol=1e-4, **options)
    for torque in TORQUES[:5]:
        sim.step(DT, torque)
        assert unit.run([torque], DT, sim.output_names).tolist() == [list(sim.outputs.values())]
    assert unit.step(DT) == ERROR
    assert "ValueError: no more" in unit.messages[-1]
    assert unit.get(["time"]) == [sim.time]
    assert unit.call("GetFMUstate" if unit.is_two else "GetFMUState", None) == ERROR
    assert unit.call("Reset") == 0
    assert unit.get(["joint_coordinates hub", "time"]) == [0.0, 0.0]
    monkeypatch.setenv("KANEFE_PYTHON", "/bin/true")
    assert unit._made(unit.token) is None
    assert "this unit needs kanefe" in unit.messages[-1]
    unit.free()


def test_what_cannot_be_a_unit_is_named(tmp_path: Path) -> None:
    with pytest.raises(kf.ModelError, match=r"fmi must be '2\.0' or '3\.0', not '1\.0'"):
        arm().to_fmu(tmp_path / "arm.fmu", fmi="1.0")
    for name, message in (("time", "as the time is"), (" ", "cannot be called ' '"), ("a\n", "a printable name")):
        with pytest.raises(kf.ModelError, match=message):
            arm().to_fmu(tmp_path / "arm.fmu", inputs={name: "motor hub"})
    small = kf.linearise(arm(0.0), inputs={"x": "motor hub"}, outputs={"x": "position arm/tip y"})
    with pytest.raises(kf.ModelError, match="two variables of a unit cannot be called 'x'"):
        small.to_fmu(tmp_path / "small.fmu")
    scene, lock = arm(), threading.Lock()
    scene.add_torque(scene.body("hub"), lambda t: 1.0 if lock.locked() else 2.0)
    with pytest.raises(kf.ModelError, match=r"cannot be sent to the process that steps it: .*lock"):
        scene.to_fmu(tmp_path / "arm.fmu", method="dop853")
    assert not list(tmp_path.iterdir())


def test_files_and_compilers_that_are_none_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(kf.FileError, match=r"ends in \.fmu"):
        kf.linearise(arm(0.0), inputs="motor hub").to_fmu(tmp_path / "arm.zip")
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(kf.ModelError, match="to_fmu needs a C compiler"):
        kf.linearise(arm(0.0), inputs="motor hub").to_fmu(tmp_path / "arm.fmu")
