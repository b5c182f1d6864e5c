"""Inputs of units between steps: outputs follow them at once, as they say; steps go on from the unit's own time."""

import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Tree

import numpy as np
import pytest

import kanefe as kf
from fmu_units import ERROR, OK, Unit

START = 0.4
"""Start angle of the pendulum, rad."""

OUTPUTS = {
    "angle": "joint_coordinates pole",
    "acceleration": "angular_acceleration pole z",
    "moment": "joint_reaction pole moment_z",
    "speed of slide": "joint_speeds slide",
    "slide": "acceleration slide x",
    "drive": "driving_force slide",
}
INPUTS = {"torque": "motor pole", "push": "drive slide"}


def pendulum(in_python: bool = False) -> kf.System:
    """A pendulum of 1.5 kg about z, and 2 kg that a motion drives along x."""
    scene = kf.System(gravity=(0, -9.81, 0))
    pole = scene.add_rigid_body("pole", 1.5, 0.2, com=(0, -0.6, 0), joint=kf.Revolute("z", position=START))
    scene.add_rigid_body("slide", 2.0, joint=kf.Prismatic("x", motion=kf.Motion.steady(0.5)))
    if in_python:
        scene.add_force(pole, lambda t: (0.0, 0.0, 0.0 * t))
    return scene


def expected(torque: float, push: float) -> list[float]:
    """Return the outputs at the start in closed form."""
    acceleration = (torque - 1.5 * 9.81 * 0.6 * np.sin(START)) / (0.2 + 1.5 * 0.6**2)
    return [START, acceleration, torque, 0.5, push, 2.0 * push]


@pytest.mark.parametrize(("fmi", "in_python"), [("2.0", False), ("3.0", False), ("2.0", True)])
@pytest.mark.filterwarnings("ignore:the unit .* needs kanefe")
def test_inputs_count_at_once_in_all_outputs(tmp_path: Path, fmi: str, in_python: bool) -> None:
    path = pendulum(in_python).to_fmu(tmp_path / "pendulum.fmu", fmi=fmi, inputs=INPUTS, outputs=OUTPUTS)
    unit = Unit(path)
    assert unit.set("torque", 1.0) == OK  # before the time of the start is known
    assert unit.begin(0.0) == OK
    np.testing.assert_allclose(unit.get(list(OUTPUTS)), expected(1.0, 0.0), rtol=1e-12, atol=1e-12)
    for torque, push in ((5.0, 0.0), (5.0, 3.0), (0.0, -1.0)):
        assert (unit.set("torque", torque), unit.set("push", push)) == (OK, OK)
        np.testing.assert_allclose(unit.get(list(OUTPUTS)), expected(torque, push), rtol=1e-12, atol=1e-12)
    unit.free()


@pytest.mark.parametrize("method", ["radau5", "dop853"])
def test_outputs_that_are_asked_for_between_steps_change_no_step(tmp_path: Path, method: str) -> None:
    options: dict[str, Any] = {"inputs": INPUTS, "outputs": OUTPUTS, "method": method}
    path = pendulum().to_fmu(tmp_path / "pendulum.fmu", **options)
    units, sim = [Unit(path), Unit(path)], pendulum().start(**options)
    for k in range(6):
        asked = {"torque": 0.5 * (k // 2), "push": 0.1 * (k // 2)}
        for unit in units:
            for name, value in asked.items():
                unit.set(name, value)
        wanted = list(sim.outputs_with(asked).values())
        np.testing.assert_allclose(units[0].get(list(OUTPUTS)), wanted, rtol=1e-12, atol=1e-12)
        units[0].set("torque", 7.0)
        units[0].get(list(OUTPUTS))
        units[0].set("torque", asked["torque"])
        sim.step(0.01, asked)
        assert [unit.step(0.01) for unit in units] == [OK, OK]
        np.testing.assert_array_equal(units[0].get(list(OUTPUTS)), units[1].get(list(OUTPUTS)))
        # forces of the state are added up in another order
        np.testing.assert_allclose(units[0].get(list(OUTPUTS)), list(sim.outputs.values()), rtol=1e-12, atol=1e-12)
    for unit in units:
        unit.free()


@pytest.mark.parametrize("begun", [False, True])
def test_what_sticks_slips_in_outputs_as_soon_as_an_input_says_so(tmp_path: Path, begun: bool) -> None:
    """A box of 2 kg with a friction of 0.3, 6 N, under 2 N and 10 N."""

    def box() -> kf.System:
        scene = kf.System(gravity=(0.0, 0.0, -10.0))
        body = scene.add_rigid_body("box", 2.0, 0.02, joint=kf.Free(position=(0.0, 0.0, 0.1)))
        corners = [(x, y, -0.1) for x in (-0.2, 0.2) for y in (-0.1, 0.1)]
        feet = scene.add_surface("feet", body, kf.shapes.Points(corners))
        floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
        scene.add_contact("touch", feet, floor, normal=kf.Rigid(), friction=kf.Coulomb(0.3))
        return scene

    options: dict[str, Any] = {"inputs": {"push": "force box x"}, "outputs": ("acceleration box x", "load touch")}
    sim, unit = box().start(**options), Unit(box().to_fmu(tmp_path / "box.fmu", **options))
    if begun:
        sim.step(0.01)
        assert unit.step(0.01) == OK
    names, state = sim.output_names, unit.state()
    for push, acceleration, force in ((2.0, 0.0, -2.0), (10.0, 2.0, -6.0), (0.0, 0.0, 0.0)):
        assert unit.set("push", push) == OK
        for found in (unit.get(names), list(sim.outputs_with({"push": push}).values())):
            np.testing.assert_allclose(found[:2], [acceleration, force], atol=1e-6)
    assert unit.state() == state
    unit.free()


def test_a_simulation_tells_its_outputs_under_other_inputs() -> None:
    sim = pendulum().start(inputs=INPUTS, outputs=OUTPUTS)
    before = sim.outputs
    np.testing.assert_allclose(list(sim.outputs_with({"torque": 5.0, "push": 3.0}).values()), expected(5.0, 3.0), 1e-12)
    assert sim.outputs_with({}) == sim.outputs == before
    assert sim.inputs == {"torque": 0.0, "push": 0.0}
    with pytest.raises(kf.ModelError, match=r"no input 'torqe'\. Did you mean"):
        sim.outputs_with({"torqe": 1.0})
    other = pendulum().start(inputs=INPUTS, outputs=OUTPUTS)
    for each in (sim, other):
        each.step(0.01, {"push": 1.0})
    assert sim.outputs == other.outputs


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_each_output_lists_what_it_depends_on(tmp_path: Path, fmi: str) -> None:
    unit = Unit(pendulum().to_fmu(tmp_path / "pendulum.fmu", fmi=fmi, inputs=INPUTS, outputs=OUTPUTS))
    root = Tree.parse(tmp_path / "pendulum" / "modelDescription.xml").getroot()
    names = [str(variable.get("name")) for variable in root.find("ModelVariables") or ()]
    key, tag, first = ("index", "Outputs/Unknown", 1) if fmi == "2.0" else ("valueReference", "Output", 0)
    start = "InitialUnknowns/Unknown" if fmi == "2.0" else "InitialUnknown"
    for path in (f"ModelStructure/{tag}", f"ModelStructure/{start}"):
        told = {
            names[int(element.attrib[key]) - first]: [
                names[int(number) - first] for number in element.attrib["dependencies"].split()
            ]
            for element in root.findall(path)
        }
        both = ["torque", "push"]
        at_once = ("acceleration", "moment", "slide", "drive")
        assert told == {name: both if name in at_once else [] for name in OUTPUTS}
    unit.free()


def test_a_linear_unit_lists_the_entries_of_its_matrices(tmp_path: Path) -> None:
    scene = kf.System(gravity=(0, -9.81, 0))
    scene.add_rigid_body("pole", 1.5, 0.2, com=(0, -0.6, 0), joint=kf.Revolute("z"))
    outputs = ("joint_coordinates pole", "angular_acceleration pole z")
    path = kf.linearise(scene, inputs="motor pole", outputs=outputs).to_fmu(tmp_path / "small.fmu", fmi="3.0")
    with zipfile.ZipFile(path) as archive:
        structure = Tree.fromstring(archive.read("modelDescription.xml")).find("ModelStructure")
    assert structure is not None
    # input 0, outputs 1 and 2, time 3, angle 4, speed 5, their rates 6 and 7
    told = [(e.tag, e.get("valueReference"), e.get("dependencies")) for e in structure if e.tag != "InitialUnknown"]
    rates = [("ContinuousStateDerivative", "6", "5"), ("ContinuousStateDerivative", "7", "0 4")]
    assert told == [("Output", "1", "4"), ("Output", "2", "0 4"), *rates]


@pytest.mark.parametrize(("fmi", "in_python"), [("2.0", False), ("3.0", False), ("2.0", True)])
@pytest.mark.filterwarnings("ignore:the unit .* needs kanefe")
def test_a_communication_point_that_is_not_the_units_time_is_an_error(
    tmp_path: Path, fmi: str, in_python: bool
) -> None:
    unit = Unit(pendulum(in_python).to_fmu(tmp_path / "pendulum.fmu", fmi=fmi, inputs=INPUTS, outputs=OUTPUTS))
    names = [*OUTPUTS, "time"]
    assert unit.begin(0.0) == OK
    assert unit.step(0.01) == OK
    before = unit.get(names)
    for t in (7.0, 0.0, -3.0, 0.0101, float("nan")):
        assert unit.step(0.01, t) == ERROR
        assert "the unit is at 0.01 s" in unit.messages[-1]
        assert unit.get(names) == before
    assert unit.step(0.01, 0.01 * (1.0 + 1e-15)) == OK
    unit.free()


def test_times_of_the_importer_do_not_drift_away(tmp_path: Path) -> None:
    """Multiples of 0.1 s as products and as sums are 1.4e-12 s apart after 1,000 steps; here at most a round-off."""
    unit = Unit(pendulum().to_fmu(tmp_path / "pendulum.fmu", inputs=INPUTS, outputs=OUTPUTS, method="dop853"))
    assert [unit.step(0.1, 0.1 * k) for k in range(1000)] == [OK] * 1000
    assert unit.get(["time"])[0] == pytest.approx(100.0, rel=3e-16)
    unit.free()
