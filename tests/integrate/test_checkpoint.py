"""Checkpoints: a run that goes on from one ends where it would have ended, also after a kill; none fits another run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kanefe as kf
import killed_run
from kanefe.integrate.methods.table import METHODS
from kanefe.integrate.run import integrate
from kanefe.integrate.trajectory import Trajectory
from kanefe.storage.digest import Unhashable, digest, digest_of_scene
from loop_scenes import four_bar
from run_scenes import double_pendulum, falling_ball, floor, height_of_ball, soft_arm
from scenes import lattice_body


def unreduced_arm() -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    damping = kf.RayleighDamping(0.0, 1e-4)
    scene.add_flexible_body("arm", lattice_body(1, reduction=None, damping=damping), joint=kf.Revolute("y"))
    return scene


FLOOR = floor(0.8)
RUNS: dict[str, tuple[Any, dict[str, Any]]] = {
    **{
        f"pendulum, {name}": (double_pendulum, {"method": name} | ({} if row.has_error_control else {"step": 1e-3}))
        for name, row in METHODS.items()
        if not (row.is_plugged or row.steps_over_impacts)
    },
    "arm, radau5": (soft_arm, {"method": "radau5"}),
    "four-bar, radau5": (four_bar, {"method": "radau5"}),
    "arm, generalised-alpha": (soft_arm, {"method": "generalised-alpha"}),
    "four-bar, dop853": (four_bar, {"method": "dop853"}),
    "four-bar, generalised-alpha": (four_bar, {"method": "generalised-alpha", "rtol": 1e-4}),
    "four-bar, generalised-alpha, fixed steps": (four_bar, {"method": "generalised-alpha", "step": 2e-3}),
    "unreduced arm": (unreduced_arm, {"rtol": 1e-4}),
    "bouncing ball": (falling_ball, {"events": [FLOOR], "method": "dop853"}),
}


def same(one: Trajectory, other: Trajectory) -> None:
    """Everything a run tells is equal to 1e-12; in fact to the bit, but for what a library adds up in another order."""
    assert one.status == other.status
    np.testing.assert_array_equal(one.times, other.times)
    for name in ("coordinates", "speeds", "dissipated", "work"):
        a, b = getattr(one, name), getattr(other, name)
        np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12 * max(np.abs(b).max(), 1.0), err_msg=name)
    assert set(one.events) == set(other.events)
    for event, times in one.events.items():
        np.testing.assert_allclose(times, other.events[event], rtol=1e-12, atol=0)
    if other.accelerations is not None and one.accelerations is not None:
        largest = np.abs(other.accelerations).max()
        np.testing.assert_allclose(one.accelerations, other.accelerations, rtol=0, atol=1e-12 * largest)


@pytest.mark.parametrize("name", RUNS)
def test_a_run_in_pieces_is_the_run_in_one(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make, options = RUNS[name]
    if "unreduced" in name:
        monkeypatch.setattr("kanefe.reduction.build.LARGEST_DENSE", 0)
        assert make().freeze().has_unreduced
    span = (0.0, 0.3) if "unreduced" in name else (0.0, 1.0)
    whole = integrate(make().freeze(), span, **options)
    assert whole.status is not None
    assert whole.status.is_finished
    steps, path = int(whole.statistics["steps"]), tmp_path / "run.npz"
    piece = integrate(make().freeze(), span, checkpoint=path, most_steps=max(steps // 3, 1), **options)
    assert piece.status is not None
    assert piece.status.kind == "stopped"
    pieces = 1
    while not piece.status.is_finished:
        piece = integrate(make().freeze(), span, checkpoint=path, resume=path, most_steps=max(steps // 3, 1), **options)
        assert piece.status is not None
        pieces += 1
        assert pieces < 10
    assert pieces >= 3
    same(piece, whole)
    if METHODS[whole.statistics["method"]].takes_atol and not make().freeze().constraints:  # one of the kernels
        np.testing.assert_array_equal(piece.coordinates, whole.coordinates)
        np.testing.assert_array_equal(piece.speeds, whole.speeds)
    assert piece.statistics["steps"] == steps
    # a finished run is read back without a step
    again = integrate(make().freeze(), span, resume=path, **options)
    same(again, whole)


def test_a_killed_run_goes_on(tmp_path: Path) -> None:
    """The process kills itself in the middle of a step, as the system does where memory is short."""
    path = tmp_path / "run.npz"
    command = [sys.executable, killed_run.__file__, str(path)]
    environment = os.environ | {"KANEFE_TEST_KILL": "1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == -signal.SIGKILL, done.stderr
    whole, resumed = killed_run.run(), killed_run.run(resume=path)
    assert whole.run is not None
    assert resumed.run is not None
    same(resumed.run.trajectory, whole.run.trajectory)
    assert resumed.statistics["steps"] == whole.statistics["steps"]
    # it did not begin anew: the calls of the event's function are those of the rest
    calls = killed_run.calls["count"]
    killed_run.run()
    assert calls < killed_run.calls["count"] - 100


@pytest.mark.parametrize("problem", [KeyboardInterrupt, LookupError])
def test_what_was_computed_before_an_error_is_kept(
    problem: type[BaseException], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.npz"
    seen: list[float] = []

    def load(t: float, state: kf.SceneState) -> tuple[float, float, float]:  # functions of time are looked at before
        seen.append(t)
        if "KANEFE_TEST_BREAK" in os.environ and t > 0.6:
            raise problem
        return (0.0, 0.0, np.sin(t))

    def simulate(**options: Any) -> kf.Result:
        seen.clear()
        scene = kf.System()
        wheel = scene.add_rigid_body("wheel", 1.0, 0.5, joint=kf.Revolute("z"))
        scene.add_torque(wheel, load)
        return scene.simulate((0.0, 1.0), output_step=0.01, method="dop853", **options)

    monkeypatch.setattr("kanefe.integrate.loop.CHUNK_SECONDS", 0.0)
    whole = simulate()
    monkeypatch.setenv("KANEFE_TEST_BREAK", "1")
    if problem is KeyboardInterrupt:
        with pytest.warns(kf.SimulationWarning, match=r"stopped at t = 0\.\d+ s: by Ctrl-C\. Remedy: .*add_controller"):
            stopped = simulate(checkpoint=path, checkpoint_seconds=1e6)
        assert 0.5 < stopped.times[-1] <= 0.6
        there = whole.joint_coordinates("wheel")[: len(stopped.times) - 1]
        np.testing.assert_array_equal(stopped.joint_coordinates("wheel")[:-1], there)
    else:
        with pytest.warns(kf.SimulationWarning, match=r"torque on 'wheel' at t = 0\.6\d* s raised LookupError"):
            simulate(checkpoint=path, checkpoint_seconds=1e6)
    monkeypatch.delenv("KANEFE_TEST_BREAK")
    again = simulate(resume=path)
    # it goes on where it was: the start is asked three times, whether it still gives what it gave
    assert sorted(seen)[3] > 0.1
    np.testing.assert_array_equal(again.joint_coordinates("wheel"), whole.joint_coordinates("wheel"))


def test_a_run_goes_on_with_a_function_that_was_mended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.npz"

    def load(t: float) -> tuple[float, float, float]:
        if "KANEFE_TEST_BREAK" in os.environ and t > 0.6:
            raise LookupError
        return (0.0, 0.0, float(0.8 < t < 0.82))

    def simulate(**options: Any) -> kf.Result:
        scene = kf.System()
        wheel = scene.add_rigid_body("wheel", 1.0, 0.5, joint=kf.Revolute("z"))
        scene.add_torque(wheel, load)
        return scene.simulate((0.0, 1.0), output_step=0.1, method="dop853", **options)

    monkeypatch.setenv("KANEFE_TEST_BREAK", "1")
    with pytest.warns(kf.SimulationWarning, match="raised LookupError"):
        simulate(checkpoint=path)
    monkeypatch.delenv("KANEFE_TEST_BREAK")
    assert simulate(resume=path).status.kind == "finished"


def test_a_failed_run_leaves_a_checkpoint_and_a_terminal_event_comes_again(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    ends = kf.Event("floor", height_of_ball, terminal=True)
    first = falling_ball().simulate((0.0, 1.0), events=[ends], checkpoint=path)
    again = falling_ball().simulate((0.0, 1.0), events=[ends], resume=path)
    assert str(again.status) == str(first.status)
    np.testing.assert_array_equal(again.times, first.times)
    storm = kf.Event("floor", FLOOR.function, direction=-1, action=FLOOR.action)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", kf.SimulationWarning)
        first = falling_ball().simulate((0.0, 6.0), events=[storm], checkpoint=path)
        again = falling_ball().simulate((0.0, 6.0), events=[storm], resume=path)
    assert first.status.kind == again.status.kind == "failed"
    assert again.status.time == pytest.approx(first.status.time, rel=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rtol": 1e-7}, r"another option, rtol: 1e-06 there, 1e-07 here.*Remedy: the options"),
        ({"method": "generalised-alpha"}, "another option, method: 'dop853' there, 'generalised-alpha' here"),
        ({"t_span": (0.0, 2.0)}, r"another option, t_span: \[0\.0, 1\.0\] there, \[0\.0, 2\.0\] here"),
        ({"output_step": 0.25}, "another option, output times"),
        ({"events": [FLOOR]}, "another option, events"),
        ({"scene": "heavier"}, "is of another scene: bodies, joints, loads"),
    ],
)
def test_a_checkpoint_of_another_run_is_refused(change: dict[str, Any], message: str, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    options: dict[str, Any] = {"t_span": (0.0, 1.0), "rtol": 1e-6, "method": "dop853", "output_step": 0.5}
    double_pendulum().simulate(**options, checkpoint=path, most_steps=2)
    double_pendulum().simulate(**options, resume=path)
    scene = double_pendulum()
    if change.pop("scene", None):
        scene.add_rigid_body("third", 1.0, 0.1, joint=kf.Revolute("z"))
    with pytest.raises(kf.FileError, match=message):
        scene.simulate(**(options | change), resume=path)


def test_a_longer_span_is_told_before_what_follows_from_it(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    falling_ball().simulate((0.0, 1e-3), checkpoint=path, method="dop853", most_steps=1)
    with pytest.raises(kf.FileError, match="another option, t_span"):
        falling_ball().simulate((0.0, 1e3), resume=path, method="radau5", rtol=1e-5)


def test_a_checkpoint_of_another_version_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.npz"
    double_pendulum().simulate((0.0, 1.0), checkpoint=path, most_steps=2)
    with monkeypatch.context() as other:
        other.setattr("kanefe.integrate.checkpoint.__version__", "9.9")
        with pytest.raises(
            kf.FileError, match=r"was written by kanefe .* this is 9\.9 .*Remedy: go on with that version"
        ):
            double_pendulum().simulate((0.0, 1.0), resume=path)
    assert double_pendulum().simulate((0.0, 1.0), resume=path).status.is_finished


def test_damaged_and_missing_files_are_named(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    with pytest.raises(kf.FileError, match=r"there is no checkpoint .*run\.npz\. Remedy"):
        double_pendulum().simulate((0.0, 1.0), resume=path)
    path.write_bytes(b"PK nothing")
    with pytest.raises(kf.FileError, match=r"run\.npz is damaged or not a checkpoint .*Remedy: start the run again"):
        double_pendulum().simulate((0.0, 1.0), resume=path)
    double_pendulum().simulate((0.0, 1.0), checkpoint=path, most_steps=3)
    whole = path.read_bytes()
    for part in (whole[: len(whole) // 2], whole[:-7], whole[:300] + b"\0" * 50 + whole[350:]):
        path.write_bytes(part)
        with pytest.raises(kf.FileError, match=r"run\.npz"):
            double_pendulum().simulate((0.0, 1.0), resume=path)
    np.savez(path, header=np.array('{"format": "other"}'))
    with pytest.raises(kf.FileError, match="not a checkpoint"):
        double_pendulum().simulate((0.0, 1.0), resume=path)


def test_a_place_that_cannot_be_written_is_refused_before_the_run_and_forgiven_in_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(kf.FileError, match="cannot write"):
        double_pendulum().simulate((0.0, 1.0), checkpoint=tmp_path / "file" / "run.npz")
    written: list[int] = []

    def write(*arguments: Any) -> None:
        written.append(1)
        if len(written) > 1:
            raise kf.FileError("the disk is full")

    monkeypatch.setattr("kanefe.integrate.checkpoint.write_arrays", write)
    with pytest.warns(kf.SimulationWarning, match="no checkpoint at t = 1 s: the disk is full"):
        result = double_pendulum().simulate((0.0, 1.0), checkpoint=tmp_path / "run.npz")
    assert result.status.is_finished


def test_files_are_written_as_often_as_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    times: list[float] = []
    monkeypatch.setattr("kanefe.integrate.loop.CHUNK_SECONDS", 0.0)
    monkeypatch.setattr("kanefe.integrate.checkpoint.LEAST_SHARE", 0.0)  # a slow machine leaves files out
    monkeypatch.setattr("kanefe.integrate.checkpoint.write_arrays", lambda path, text, arrays: times.append(1.0))
    event = kf.Event("never", lambda t, state: t - 9.0)  # one step in a go
    double_pendulum().simulate((0.0, 1.0), events=event, checkpoint=tmp_path / "run.npz", checkpoint_seconds=1e6)
    assert len(times) == 2  # at the start and at the end
    times.clear()
    run = double_pendulum().simulate((0.0, 1.0), events=event, checkpoint=tmp_path / "run.npz", checkpoint_seconds=0.0)
    assert len(times) > 2
    assert len(times) <= run.statistics["steps"] + 2


class Gain:
    def __init__(self, value: float) -> None:
        self.value = value

    def __call__(self, t: float) -> float:
        return self.value * t


def test_objects_count_by_their_attributes_where_a_scene_is_told_from_another() -> None:
    assert digest_of_scene(f=Gain(1.0)) == digest_of_scene(f=Gain(1.0))
    assert digest_of_scene(f=Gain(1.0)) != digest_of_scene(f=Gain(2.0))
    table = kf.Motion.table(np.linspace(0, 1, 5), np.arange(5.0))
    other = kf.Motion.table(np.linspace(0, 1, 5), np.arange(5.0) ** 2)
    assert digest_of_scene(f=table) != digest_of_scene(f=other)
    with pytest.raises(Unhashable):
        digest(f=Gain(1.0))  # what goes into the cache is stricter
    loop = Gain(1.0)
    loop.value = loop  # type: ignore[assignment]
    assert len(digest_of_scene(f=loop)) == 32


def test_a_scene_that_cannot_be_told_from_another_is_refused(tmp_path: Path) -> None:
    numbers = iter(range(10**6))
    scene = kf.System()
    wheel = scene.add_rigid_body("wheel", 1.0, 0.5, joint=kf.Revolute("z"))
    scene.add_torque(wheel, lambda t: (0.0, 0.0, min(float(next(numbers)), 0.0)))
    with pytest.raises(
        kf.ModelError, match=r"cannot be distinguished from that of another scene: .*range_iterator.*Remedy"
    ):
        scene.simulate((0.0, 1.0), checkpoint=tmp_path / "run.npz")
