"""Reducers: numbers of a run against those of its histories."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.studies import events, exceedances, peak, spectrum
from study_scenes import pendulum

SPRING, MASS, START = 40.0, 2.0, 0.3
FREQUENCY = math.sqrt(SPRING / MASS)  # rad/s


@pytest.fixture(scope="module")
def result() -> kf.Result:
    """Return the run of a mass on a spring, of ten seconds."""
    scene = kf.System()
    force = kf.CoordinateForce(stiffness=SPRING)
    scene.add_rigid_body("mass", MASS, joint=kf.Prismatic("x", position=START, forces=force))
    return scene.simulate((0.0, 10.0), rtol=1e-10, output_step=0.01)


def test_peaks_are_those_of_the_history(result: kf.Result) -> None:
    x = result.position("mass")[:, 0]
    assert peak("position", "mass", component="x")(result) == {"peak position mass x": np.abs(x).max()}
    assert peak("position", "mass", component="x", kind="lowest", name="low")(result) == {"low": x.min()}
    late = result.times >= 9.7
    assert peak("position", "mass", component="x", kind="highest", after=9.7)(result) == {
        "highest position mass x": x[late].max()
    }
    assert x[late].max() < x.max()
    assert list(peak("position", "mass")(result)) == [f"peak position mass {c}" for c in "xyz"]
    assert list(peak("joint_reaction", "mass", component="force x")(result)) == ["peak joint reaction mass force x"]
    assert list(peak("kinetic_energy")(result)) == ["peak kinetic energy"]


def twice(result: kf.Result) -> np.ndarray:
    return 2.0 * result.position("mass")[:, 0]


def test_a_function_is_a_quantity(result: kf.Result) -> None:
    assert peak(twice)(result)["peak twice"] == 2.0 * peak("position", "mass")(result)["peak position mass x"]


def test_exceedances_are_those_of_a_cosine(result: kf.Result) -> None:
    found = exceedances("position", "mass", component="x", level=0.5 * START, name="x")(result)
    # above half its amplitude for a third of the time, to the crossings of one output step in ten seconds
    assert found["share x"] == pytest.approx(1.0 / 3.0, abs=0.03)
    crossings = math.floor((FREQUENCY * 10.0 + math.pi / 3.0) / (2.0 * math.pi))
    assert found["rate x"] == pytest.approx(crossings / 10.0, rel=1e-12)


def test_a_spectrum_holds_the_variance(result: kf.Result) -> None:
    found = spectrum("position", "mass", component="x", segment=5.0, name="x")(result)
    density, step = found["spectrum x"], found["spectrum step"]
    frequencies = step * np.arange(len(density))
    assert step == pytest.approx(0.2, rel=2e-3)
    assert frequencies[density.argmax()] == pytest.approx(FREQUENCY / (2.0 * math.pi), abs=step)
    # of a cosine, in segments of 3.5 periods
    assert density.sum() * step == pytest.approx(0.5 * START**2, rel=0.05)


def bouncing(height: float) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_point("ball", 1.0, joint=kf.Prismatic("z", position=height))
    scene.add_contact("ball on floor", ball, floor, normal=kf.Restitution(1e5, 0.8))
    return scene


def test_events_are_counted_by_name() -> None:
    # it falls for sqrt(2 h / g) = 0.45 s, and flies for 0.72 s behind that
    result = bouncing(1.0).simulate((0.0, 1.0), rtol=1e-6)
    assert events(lands="* touch", all="ball on floor *")(result) == {"lands": 1, "all": 2}
    assert events(lands="* touch", after=0.5)(result) == {"lands": 0}
    with pytest.raises(kf.ModelError, match=r"no event '. slip'\. It has: ball on floor touch, ball on floor lift"):
        events(slips="* slip")(result)


def test_how_probable_an_event_is() -> None:
    study = kf.Study(bouncing, events(lands="* touch"), duration=0.5, rtol=1e-6, height=[0.5, 1.0, 2.0, 3.0])
    (cell,) = study.run("serial").operability({"lands": 0}, over="height").cells["lands"]
    assert (cell.exceeded, cell.probability) == (2, 0.5)


BAD: dict[str, tuple[Any, str]] = {
    "no kind": (lambda: peak("position", "mass", kind="mean"), "kind must be"),
    "no quantity": (lambda: peak(3.0), "quantity must be a name or a function"),
    "no time": (lambda: peak("position", "mass", after=math.nan), "after must be a finite number"),
    "no level": (lambda: exceedances("position", "mass", level="high"), "level must be a finite number"),
    "no events": (lambda: events(), "events are by name"),
    "no time of events": (lambda: events(slips="* slip", after=math.inf), "after must be a finite number"),
    "no segment": (lambda: spectrum("position", "mass", segment=-1.0), "segment must be above zero"),
}


@pytest.mark.parametrize(("make", "message"), BAD.values(), ids=BAD)
def test_bad_arguments_are_refused(make: Any, message: str) -> None:
    with pytest.raises(kf.ModelError, match=message):
        make()


def test_what_a_run_has_not_is_told(result: kf.Result) -> None:
    for reducer, message in (
        (peak("position", "mass", component="q"), "position mass has no component 'q'. Remedy: one of x, y, z"),
        (peak("position", "mass", after=20.0), "no output time is after 20 s; the run ends at 10 s"),
        (peak("speed", "mass"), "there is no quantity 'speed'"),
        (peak(lambda result: np.zeros(3), name="three"), r"three has the shape \(3,\)"),
    ):
        with pytest.raises(kf.ModelError, match=message):
            reducer(result)
    uneven = pendulum(1.0, 0.0).simulate((0.0, 1.0), output_times=[0.0, 0.1, 0.5, 1.0])
    with pytest.raises(kf.ModelError, match="a spectrum needs output times at equal steps"):
        spectrum("position", "rod")(uneven)


def test_a_study_takes_several() -> None:
    reducers = [peak("joint_coordinates", "rod"), exceedances("joint_coordinates", "rod", level=0.0)]
    table = kf.Study(pendulum, reducers, duration=0.2, length=1.0, angle=[0.1, 0.2]).run("serial")
    assert table.outputs == (
        "peak joint coordinates rod angle",
        "rate joint coordinates rod angle",
        "share joint coordinates rod angle",
    )
    assert table.counts["finished"] == 2
