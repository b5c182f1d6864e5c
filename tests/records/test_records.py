"""Records: channels that are kept while a run goes on, in memory and in files."""

from __future__ import annotations

import re
import subprocess
import sys
import textwrap
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import FileError, ModelError, SimulationWarning
from kanefe.integrate import state_rows
from kanefe.storage import growing_file

SPAN = (0.0, 1.5)
CHANNELS = ["position body", "rotation body", "joint_reaction rod", "kinetic_energy", "velocity body x"]


def thrown(normal: Any = None) -> kf.System:
    """Return a ball that bounces on a floor beside a rod on a hinge."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    body = scene.add_rigid_body("body", 1.0, 4e-3, joint=kf.Free(position=(0.0, 0.0, 0.4), velocity=(1.0, 0.0, 0.0)))
    skin = scene.add_surface("skin", body, kf.shapes.Sphere(0.1))
    scene.add_contact("tap", skin, floor, normal=normal or kf.HuntCrossley(1e5, 0.1), friction=kf.Coulomb(0.3))
    scene.add_rigid_body("rod", 1.0, 0.02, com=(0.25, 0.0, 0.0), joint=kf.Revolute("y", speed=1.0))
    return scene


def turned_by(controller_rate: float | None) -> kf.System:
    """Return a body and a rod without contacts, whose rod is braked by a sampled controller."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_rigid_body("body", 1.0, (1.0, 2.0, 3.0), joint=kf.Free(angular_velocity=(9.0, 0.1, 8.0)))
    scene.add_rigid_body("rod", 1.0, 0.02, com=(0.25, 0.0, 0.0), joint=kf.Revolute("y", speed=1.0))
    if controller_rate is not None:
        scene.add_controller(
            "brake",
            lambda t, reads, memory: -0.1 * reads,
            every=1.0 / controller_rate,
            reads="joint_speeds rod",
            drives="motor rod",
        )
    return scene


SCENES: dict[str, tuple[Callable[[], kf.System], dict[str, Any]]] = {
    "bounces on a soft floor": (thrown, {}),
    "bounces, radau5": (thrown, {"method": "radau5"}),
    "bounces on a rigid floor": (lambda: thrown(kf.Rigid(restitution=0.5)), {}),
    "fixed steps": (thrown, {"method": "generalised-alpha", "step": 1e-3}),
    "spins": (lambda: turned_by(None), {}),
    "spins, rk4": (lambda: turned_by(None), {"method": "rk4", "step": 7e-3}),
    "is sampled": (lambda: turned_by(90.0), {}),
    "is sampled, fixed steps": (lambda: turned_by(90.0), {"method": "rk4", "step": 3e-3}),
}


@pytest.mark.parametrize("rows", [3, 17, 10**6])
@pytest.mark.parametrize("name", SCENES)
def test_records_are_the_channels_of_a_run_that_keeps_all_states(
    name: str, rows: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, options = SCENES[name]
    monkeypatch.setattr(state_rows, "SHORTEST_WINDOW", rows)
    monkeypatch.setattr(state_rows, "WINDOW_BYTES", 0)
    whole = made().simulate(SPAN, output_step=2e-3, **options)
    run = made().simulate(SPAN, output_step=0.1, record=kf.Record(CHANNELS, step=2e-3), **options)
    for counted in ("steps", "evaluations"):  # a record changes nothing
        assert run.statistics[counted] == whole.statistics[counted]
    np.testing.assert_array_equal(run.at(SPAN[1]).state, whole.at(SPAN[1]).state)
    assert len(run.times) == 16
    for times, events in ((run.events[event], whole.events[event]) for event in whole.events):
        np.testing.assert_array_equal(times, events)
    columns = np.hstack(
        [
            whole.position("body"),
            whole.rotation("body"),
            whole.joint_reaction("rod"),
            whole.energy.kinetic[:, None],
            whole.velocity("body")[:, :1],
        ]
    )
    assert len(run.records) == columns.shape[1]
    for recorded, column in zip(run.records.values(), columns.T, strict=True):
        np.testing.assert_array_equal(recorded.times, whole.times)
        # what is left of interpolation: the rows of a step that a window cuts are found one by one
        np.testing.assert_allclose(recorded.values, column, rtol=0, atol=1e-11 * max(np.abs(column).max(), 1.0))


@pytest.mark.parametrize("made", [thrown, lambda: thrown(kf.Rigid(restitution=0.5))])
def test_states_before_events_are_recorded(made: Callable[[], kf.System]) -> None:
    record = kf.Record({"speed": "velocity body z", "spin": "angular_velocity body y"}, at=["tap touch", "tap lift"])
    run = made().simulate(SPAN, record=[record, kf.Record("position body z", at="tap touch")])
    touches, lifts = run.events["tap touch"], run.events["tap lift"]
    assert len(touches) > 1
    np.testing.assert_array_equal(run.records["speed"].times, np.sort(np.concatenate((touches, lifts))))
    np.testing.assert_array_equal(run.records["position body z"].times, touches)
    np.testing.assert_allclose(run.records["position body z"].values, 0.1, atol=1e-9)
    first = run.records["speed"].values[0]
    assert first == pytest.approx(-np.sqrt(2.0 * 9.81 * 0.3), rel=1e-6)  # before the impact, of a fall by 0.3 m


def test_extremes_are_those_of_all_values(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(state_rows, "SHORTEST_WINDOW", 50)
    monkeypatch.setattr(state_rows, "WINDOW_BYTES", 0)
    whole = turned_by(None).simulate(SPAN, output_step=1e-3).angular_velocity("body")
    record = kf.Record("angular_velocity body", step=1e-3, keep="extremes")
    for file in (None, tmp_path / "r.h5"):
        run = turned_by(None).simulate(SPAN, record=record, record_file=file)
        for recorded, column in zip(run.records.values(), whole.T, strict=True):
            assert recorded.is_extremes
            np.testing.assert_allclose(recorded.values, (column.min(), column.max()), atol=1e-11)
            assert recorded.least.time == pytest.approx(1e-3 * column.argmin(), abs=1e-12)
            assert recorded.largest == (recorded.values[1], recorded.times[1])


def test_a_file_of_records_is_that_of_memory(tmp_path: Path) -> None:
    asked = ["position body", kf.Record("velocity body", at="tap touch")]
    kept = thrown().simulate(SPAN, record=asked).records
    run = thrown().simulate(SPAN, record=asked, record_file=tmp_path / "r.h5")
    found = kf.load_records(tmp_path / "r.h5")
    assert found.status == run.status
    assert list(found) == list(run.records) == list(kept)
    for name, recorded in kept.items():
        assert found[name].unit == recorded.unit
        np.testing.assert_array_equal(found[name].values, recorded.values)
        np.testing.assert_array_equal(run.records[name].times, recorded.times)
    assert "position body x [m]: 501 recorded values" in str(found)


def test_saved_results_have_the_records_of_memory(tmp_path: Path) -> None:
    run = thrown().simulate(SPAN, record=kf.Record("position body", step=0.01))
    run.save(tmp_path / "run.h5")
    found = kf.load_result(tmp_path / "run.h5").records
    assert list(found) == list(run.records)
    np.testing.assert_array_equal(found["position body x"].values, run.records["position body x"].values)


LONG = """
    import sys, kanefe as kf
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_rigid_body("rod", 1.0, 0.02, com=(0.25, 0.0, 0.0), joint=kf.Revolute("y", speed=1.0))
    record = kf.Record("joint_coordinates rod", step=1e-3)
    scene.simulate((0.0, 5e4), output_step=1e3, record=record, record_file=sys.argv[1])
"""


def test_a_file_is_read_while_it_is_written_and_after_a_kill(tmp_path: Path) -> None:
    path = tmp_path / "long.h5"
    run = subprocess.Popen([sys.executable, "-c", textwrap.dedent(LONG), str(path)])
    try:
        seen = _rows_in(path, 1)
        assert kf.load_records(path).status is None
    finally:
        run.kill()
        run.wait()
    assert _rows_in(path, seen) >= seen
    recorded = kf.load_records(path)["joint_coordinates rod"]
    np.testing.assert_allclose(np.diff(recorded.times), 1e-3, rtol=1e-5)
    assert np.isfinite(recorded.values).all()


def _rows_in(path: Path, least: int) -> int:
    for _ in range(600):
        try:
            count = len(kf.load_records(path)["joint_coordinates rod"].times)
        except FileError:
            count = 0
        if count >= least:
            return count
        time.sleep(0.1)
    raise AssertionError(f"{path} has not {least} rows after a minute")


def test_a_full_disk_ends_the_record_and_not_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    resource = pytest.importorskip("resource")
    monkeypatch.setattr(state_rows, "SHORTEST_WINDOW", 100)
    monkeypatch.setattr(state_rows, "WINDOW_BYTES", 0)
    asked: Any = {"record": kf.Record("position body", step=1e-3), "record_file": tmp_path / "r.h5"}
    thrown().simulate(SPAN, **asked)  # all that it compiles is there
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
    try:
        with pytest.warns(SimulationWarning, match=r"r\.h5 cannot grow: .* The run goes on") as told:
            run = thrown().simulate(SPAN, **asked)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert len(told) == 1
    assert run.status.kind == "finished"
    recorded = run.records["position body x"]
    assert 0 < len(recorded.times) < 1500
    np.testing.assert_allclose(recorded.times, 1e-3 * np.arange(len(recorded.times)), atol=1e-12)


def test_without_room_for_an_hdf5_file_the_records_are_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = ["position body", kf.Record("velocity body", keep="extremes")]
    kept = thrown().simulate(SPAN, record=asked).records
    usage = growing_file.shutil.disk_usage(tmp_path)
    monkeypatch.setattr(growing_file.shutil, "disk_usage", lambda path: usage._replace(free=1000))
    with pytest.warns(SimulationWarning, match=r"r\.h5 does not become an HDF5 file: its disk has 0\.000954 MB left"):
        run = thrown().simulate(SPAN, record=asked, record_file=tmp_path / "r.h5")
    found = kf.load_records(tmp_path / "r.h5")
    assert found.status == run.status
    for name, recorded in kept.items():
        np.testing.assert_array_equal(found[name].values, recorded.values)
        np.testing.assert_array_equal(run.records[name].times, recorded.times)


def test_runs_that_end_early_have_their_records(tmp_path: Path) -> None:
    high = kf.Event("low", lambda t, state: state.position("rod")[2] + t - 0.7, terminal=True)
    run = turned_by(None).simulate(SPAN, record=kf.Record("position body", step=0.01), events=high)
    assert run.status.kind == "stopped"
    times = run.records["position body x"].times
    assert times[-1] <= run.times[-1] < times[-1] + 0.01


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ("positon body", "there is no 'positon'. Did you mean 'position'"),
        ("position bdy", "'bdy'"),
        (["position body", "position body x"], "'position body x' is (given|recorded) twice"),
        (["position body", kf.Record("position body x")], "'position body x' is recorded twice"),
        (
            kf.Record("position body", at="tap tuch"),
            "record at 'tap tuch': there is no such event. Did you mean 'tap touch'",
        ),
        (7, "record must be channels"),
        ([7], "record must list channels"),
    ],
)
def test_what_cannot_be_recorded_is_named(asked: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        thrown().simulate(SPAN, record=asked)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"channels": "position body", "step": 0.0}, "step of a record must be above zero"),
        ({"channels": "position body", "step": 0.1, "at": "tap touch"}, "step= or at=, not both"),
        ({"channels": "position body", "keep": "mean"}, "keep of a record must be one of values, extremes"),
        ({"channels": []}, "without channels"),
        ({"channels": [3]}, "must be a text"),
        ({"channels": "position body", "at": [3]}, "names of events"),
        ({"channels": "position body", "at": 0.5}, "at of a record must be names of events, not 0.5"),
    ],
)
def test_records_that_make_no_sense_are_named(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        kf.Record(**arguments)


def test_files_that_cannot_be_are_named(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="record_file was given, and nothing to record"):
        thrown().simulate(SPAN, record_file=tmp_path / "r.h5")
    with pytest.raises(ModelError, match="record and checkpoint"):
        thrown().simulate(SPAN, record="position body", checkpoint=tmp_path / "c")
    (tmp_path / "text").write_text("no records")
    with pytest.raises(FileError, match=re.escape(f"{tmp_path / 'text'} is damaged, or no file of records")):
        kf.load_records(tmp_path / "text")
    thrown().simulate(SPAN).save(tmp_path / "run.h5")
    with pytest.raises(FileError, match="is no file of records"):
        kf.load_records(tmp_path / "run.h5")
    with pytest.raises(FileError):
        kf.load_records(tmp_path / "none.h5")
    for path in ({}, b"r.h5", 3, thrown()):
        with pytest.raises(ModelError, match="path= of load_records must be a text or a path"):
            kf.load_records(path)  # type: ignore[arg-type]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        thrown().simulate((0.0, 0.1), record="position body", record_file=tmp_path / "new" / "r.h5")
