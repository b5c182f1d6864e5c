"""`bench.py`: what is refused, references, curves and their files, figures from known times, skips that agree."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.bench import arguments
from benchmarks.clocks import Disagreement, use_one_core
from benchmarks.goals import Goal
from benchmarks.peer_process import NoPeers
from benchmarks.work_precision import catalogue, curves, equal_error, good_enough, long_runs, references, rigid_chain
from benchmarks.work_precision.bodies import Trial, refined
from benchmarks.work_precision.curves import Limits, curve, settled
from benchmarks.work_precision.machine import Machine
from benchmarks.work_precision.measured import measured
from benchmarks.work_precision.options import Options, check
from benchmarks.work_precision.peer_curves import PEER, PeerScene, sampled
from benchmarks.work_precision.pictures import bodies_picture
from benchmarks.work_precision.runs import OURS, Point, TookTooLong, run
from benchmarks.work_precision.runs import point as run_point
from benchmarks.work_precision.scene import BenchScene, Setting
from benchmarks.work_precision.settings import settings_of
from benchmarks.work_precision.skipped import compared, skips_table
from benchmarks.work_precision.spinning_arm import peak
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.integrate.methods.table import METHODS
from kanefe.joints import Prismatic
from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.system import System
from kanefe_fem.mesh.simple import box_mesh
from repository import surroundings


def short_chain() -> BenchScene:
    """Return S1 with two links and less time."""
    return replace(rigid_chain.chain(2, "S1"), end=0.4, quantity="tip position at 0.4 s")


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> BenchScene:
    """Return the short chain, which is S1 in the test, with a folder of references of its own."""
    monkeypatch.setattr(references, "cache_folder", lambda: tmp_path / "cache")
    monkeypatch.setitem(catalogue.SCENES, "S1", short_chain)
    monkeypatch.setattr(curves, "LONGEST_QUICK", 0.02 if IS_COMPILED else 2.0)
    return short_chain()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"scenes": ("S1", "S9")}, ("S9", "S3-16")),
        ({"methods": ("rk5",)}, ("rk5", "rk4")),
        ({"bodies": True, "scenes": ("S1",)}, ("S1", "S3, demo")),
        ({"skips": True, "figures": True}, ("--skips", "--figures")),
        ({"figures": True, "png": Path("a.png")}, ("--png", "--figures")),
        ({"tests": Path()}, ("--tests", "--figures")),
        ({"only": "deck"}, ("--only", "--figures")),
        ({"figures": True, "tests": Path("/nowhere")}, ("/nowhere",)),
    ],
)
def test_what_cannot_be_done_is_refused_before_anything_is_measured(options: dict, words: tuple[str, ...]) -> None:
    with pytest.raises(ModelError) as error:
        check(Options(**options))
    assert all(word in str(error.value) for word in words)


def test_every_method_of_the_table_has_settings_from_coarse_to_fine() -> None:
    scene = short_chain()
    for name, method in METHODS.items():
        sizes = [s.step or s.rtol for s in settings_of(scene, name)]
        assert sizes == sorted(sizes, reverse=True)
        assert all((s.step is None) == method.has_error_control for s in settings_of(scene, name))


def test_a_core_that_is_not_there_is_refused() -> None:
    if not hasattr(os, "sched_getaffinity"):
        pytest.skip("processes cannot be pinned here")
    with pytest.raises(SystemExit, match="4096"):
        use_one_core(4096)


def test_the_command_line_is_read() -> None:
    words = ["--scenes", "S1, S3", "--quick", "--json", "a.json", "--core", "1"]
    assert arguments(words) == Options(scenes=("S1", "S3"), quick=True, json=Path("a.json"), core=1)
    assert arguments([]) == Options()


def test_curves_are_measured_against_a_reference_and_written(short: BenchScene, tmp_path: Path) -> None:
    files = {kind: tmp_path / f"out.{kind}" for kind in ("json", "csv", "png")}
    assert measured(Options(scenes=("S1",), methods=("rk4", "dop853"), quick=True, **files), set()) == 0
    kept = json.loads(files["json"].read_text())
    assert kept["about"]["kanefe"]
    (told,) = kept["scenes"]
    assert told["agreement"] <= short.agreement
    runs = kept["runs"]
    assert {run["method"] for run in runs} == {"rk4", "dop853"}
    assert all(run["seconds"] > 0.0 and run["side"] == OURS for run in runs)
    steps = [run for run in runs if run["method"] == "rk4" and run["error"] > 1e-11]
    rates = np.diff(np.log([run["error"] for run in steps])) / np.diff(np.log([run["step"] for run in steps]))
    assert len(rates) >= 2
    np.testing.assert_allclose(rates, 4.0, atol=0.5)  # the order of the method, of steps of finite size
    rows = list(csv.DictReader(files["csv"].open()))
    assert [float(row["error"]) for row in rows] == [run["error"] for run in runs]
    assert files["png"].read_bytes().startswith(b"\x89PNG")


def test_references_are_made_once_and_again_when_the_scene_changes(
    short: BenchScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    plain = references.run

    def counted(model: Any, scene: BenchScene, setting: Setting) -> Any:
        made.append(setting.text)
        return plain(model, scene, setting)

    monkeypatch.setattr(references, "run", counted)
    first = references.reference(short, short.build())
    again = references.reference(short, short.build())
    np.testing.assert_array_equal(first.values, again.values)
    assert len(made) == 2
    # a scene of the same name and numbers that falls in another way
    heavier = replace(short, build=rigid_chain.chain(3, "S1").build)
    references.reference(heavier, heavier.build())
    assert len(made) == 4


def test_a_reference_is_refined_until_it_changes_no_more(short: BenchScene) -> None:
    coarse = replace(short, reference=Setting("rk4", step=0.02), agreement=1e-6)
    found = references.reference(coarse, coarse.build())
    first, last = (float(text.split()[-2]) for text in (coarse.reference.text, found.methods[0]))
    assert last < first
    assert found.methods[1] == f"rk4, h {2 * last:.3g} s"
    exact = references.reference(short, short.build())
    assert found.agreement <= coarse.agreement
    assert short.error(found.values, exact.values) < found.agreement / 10  # 15 by the fourth order of the method
    strict = replace(short, reference=Setting("rk4", step=0.05), agreement=1e-14)
    with pytest.raises(Disagreement, match=r"S1 has no reference: rk4, h 0.00156 s and rk4, h 0.0031\d s differ by"):
        references.reference(strict, strict.build())


def point(error: float, seconds: float, method: str = "rk4") -> Point:
    return Point("S1", OURS, method, "", None, None, error, seconds, method, {})


def test_a_run_that_is_good_by_luck_is_not_taken() -> None:
    curves = [point(1e-3, 1.0), point(1e-7, 2.0), point(1e-4, 3.0), point(1e-6, 4.0), point(1e-8, 9.0)]
    assert settled(curves, 1e-5) is curves[3]
    slow = [point(1e-9, 5.0, "dop853")]
    assert settled([*curves, *slow], 1e-5) is curves[3]
    assert settled([*curves, *slow], 1e-8) is slow[0]
    assert settled(curves, 1e-10) is None
    failed = point(np.nan, np.nan)
    assert settled([*curves, failed], 1e-5) is None


def test_a_method_that_a_scene_cannot_have_leaves_its_curve_empty(
    short: BenchScene, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    exact = references.reference(short, short.build())

    def refuse(*arguments: Any, **options: Any) -> Any:
        raise ModelError("not for this scene")

    monkeypatch.setattr(curves, "point", refuse)
    assert list(curve(short, settings_of(short, "dop853"), exact, Limits(quick=True))) == []
    assert "not for this scene" in capsys.readouterr().err


def test_what_was_ended_for_its_time_is_neither_a_result_nor_a_failure(short: BenchScene) -> None:
    model, setting = short.build(), Setting("rk4", step=1e-6)
    run(model, short, Setting("rk4", step=1e-2))  # compiles
    with pytest.raises(TookTooLong, match="limit"):
        run(model, short, setting, most_seconds=1e-3)


def test_a_run_that_fails_is_no_point_of_a_curve(short: BenchScene) -> None:
    def build() -> Model:
        scene = System()
        mass = scene.add_rigid_body("mass", 1.0, joint=Prismatic("x", position=1.0))
        scene.add_motor(mass, lambda t: 0.0 if t < 0.2 else np.nan)
        return scene.freeze()

    breaking = replace(short, build=build, measure=lambda model, t, q: q)
    found = run_point(build(), breaking, Setting("rk4", step=0.1), np.ones((1, 1)))
    assert not found.is_good
    assert found.remark


class KnownPeer:
    """A peer that takes the same time for every run."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds

    def ask(self, do: str, **request: Any) -> dict[str, Any]:
        assert do == "solve"
        return {"seconds": self.seconds, "end": [], "samples": []}


@pytest.mark.parametrize(("seconds", "is_met"), [(100.0, True), (1e-9, False)])
def test_a_figure_is_the_ratio_to_the_peer_at_equal_error(
    short: BenchScene, monkeypatch: pytest.MonkeyPatch, seconds: float, is_met: bool
) -> None:
    peer_scene = PeerScene("S1", [Setting("rk4", step=h) for h in (0.1, 0.05)], lambda answer: 1e-7)
    monkeypatch.setattr(equal_error, "peer_scenes", lambda *arguments: [peer_scene])
    machine = Machine(KnownPeer(seconds), "", Limits(quick=True))  # type: ignore[arg-type]
    goals = {1e-6: Goal("time / peer's", 0.5), 1e-9: Goal("out of the peer's reach", 0.5)}
    near, out = equal_error._against_peer(machine, short, goals)
    assert near.met is is_met
    ours = float(near.value) * seconds
    assert 1e-6 < ours < 1.0  # of a run of some steps
    assert PEER in near.remark
    assert not out.met
    assert out.value == f"skipped: {PEER} does not reach it"


def test_without_a_peer_every_goal_that_needs_it_is_missed_with_the_reason() -> None:
    machine = Machine(None, "no network", Limits(quick=True))
    with pytest.raises(NoPeers, match="no network"):
        equal_error.chains(machine)
    (figure,) = long_runs.suite_time(machine)
    assert not figure.met
    assert "--tests" in str(figure.value)


def test_the_coarsest_setting_that_is_good_enough_is_not_one_by_luck() -> None:
    settings = [Setting("rk4", step=h) for h in (0.8, 0.4, 0.2, 0.1)]
    errors = dict(zip(settings, (1.0, 1e-9, 1.0, 1e-9), strict=True))

    def error(setting: Setting) -> float:
        if setting.step == 0.8:
            raise NoPeers("it fails")
        return errors[setting]

    assert good_enough.coarsest(settings, error, 1e-6)[0] is settings[3]
    with pytest.raises(NoPeers, match="no setting"):
        good_enough.coarsest(settings, error, 1e-12)


def test_the_suite_is_timed_and_must_pass(tmp_path: Path) -> None:
    tests = tmp_path / "tests"
    tests.mkdir()
    file = tests / "test_one.py"
    machine = Machine(None, "", Limits(quick=True), tests=tmp_path)
    file.write_text("def test_one():\n    pass\n")
    (figure,) = long_runs.suite_time(machine)
    assert figure.met
    assert "1 passed" in figure.remark
    file.write_text("def test_one():\n    raise ValueError\n")
    (figure,) = long_runs.suite_time(machine)
    assert not figure.met
    assert "1 failed" in str(figure.value)


def test_the_peak_between_samples() -> None:
    t = np.linspace(0.0, 1.0, 21)
    top = 0.5 - 0.3 * (t - 0.512) ** 2
    assert peak(-top[:, None]) == pytest.approx(0.5, rel=1e-12)  # a parabola is found exactly


def test_samples_of_the_peer_are_taken_to_our_times() -> None:
    scene = replace(short_chain(), end=1.0, outputs=4)
    t = np.concatenate(([0.0], np.linspace(0.0, 1.0, 30)))  # the peer gives the first sample twice
    rows = np.column_stack((t, t**3))
    np.testing.assert_allclose(sampled({"samples": rows.tolist()}, scene)[:, 0], scene.times**3, atol=1e-13)


def test_halved_tetrahedra_fill_the_same_room() -> None:
    mesh = box_mesh((1.0, 2.0, 3.0), (2, 1, 1), "tetra")
    halved = refined(mesh)
    assert halved.cell_count == 8 * mesh.cell_count

    def volumes(of: Any) -> np.ndarray:
        corners = np.concatenate([of.nodes[block.nodes[:, :4]] for block in of.cell_blocks])
        return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0

    assert volumes(halved).min() > 0.0
    np.testing.assert_allclose(volumes(halved).sum(), 6.0, rtol=1e-14)
    np.testing.assert_allclose(volumes(halved), np.full(halved.cell_count, 6.0 / halved.cell_count), rtol=1e-12)


def test_pictures_of_bodies(tmp_path: Path) -> None:
    trials = [Trial("S3", "meshes", f"{n}", n, 14, 0.1 * n, 0.01, 1.0 / n) for n in (1, 2, 4)]
    path = tmp_path / "bodies.png"
    bodies_picture([("S3", "error [m]", {"meshes": trials})], "here, today", path)
    assert path.read_bytes().startswith(b"\x89PNG")


def test_a_skip_tells_what_it_saves_and_whether_the_results_agree() -> None:
    clocks: tuple[Callable[[], float], Callable[[], float]] = (lambda: 1e-6, lambda: 4e-6)
    same = compared("this", "a step", clocks, ([1.0, 2.0], [1.0, 2.0 + 1e-12]), 3)
    assert same.told()["saved"] == pytest.approx(0.75)
    assert same.agrees
    other = compared("that", "a step", clocks, ([1.0, 2.0], [1.0, 2.1]), 3)
    assert not other.agrees
    lines = skips_table([same, other]).splitlines()
    assert "75 %" in lines[1]
    assert lines[2].endswith("NO")


SKIPS_IN_PYTHON = """
from benchmarks.work_precision import skipped
skipped.STEPS, skipped.LINKS = 2, 3
print(skipped.SKIPS["planar"](1).difference)
"""


def test_skipping_changes_nothing() -> None:
    # in plain Python, where no kernels are compiled
    environment = surroundings(KANEFE_JIT="0")
    command = [sys.executable, "-c", SKIPS_IN_PYTHON]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert float(done.stdout) < 1e-14  # round-off of two steps


@pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")
def test_the_arm_that_spins_up_stays_in_compiled_code() -> None:
    model = catalogue.SCENES["S2"]().build()
    assert model.route.is_autonomous
