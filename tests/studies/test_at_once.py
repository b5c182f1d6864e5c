"""Cases of a study that are alike are evaluated at once on their own accord: what is stored is that of runs alone."""

from __future__ import annotations

import warnings
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.kernels.evaluation.rigid_lanes import lanes_here
from kanefe.studies.workers import at_once, scheduling
from kanefe.studies.workers.work import Case, Work, run_block, stamp

COUNT = 11


def arm(mass: float, angle: float = 0.0, stiffness: float = 0.0) -> Any:
    """Return a spatial arm with a load; a stiffness adds a spring, which is evaluated alone."""
    if mass > 90.0:
        raise ValueError("too heavy")
    if mass > 50.0:
        warnings.warn("it is heavy", stacklevel=1)
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    upper = scene.add_rigid_body("upper", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("y", position=angle, speed=1.0))
    lower = scene.add_rigid_body(
        "lower", mass, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z"), parent=upper, at=(1, 0, 0)
    )
    scene.add_force(lower, (0.0, mass, 0.0), point=(1.0, 0.0, 0.0), follows=True)
    if stiffness:
        scene.add_spring("spring", scene.ground.frame(at=(2, 0, 0)), lower, stiffness=stiffness)
    return scene


def told(result: kf.Result) -> dict[str, Any]:
    assert result.run is not None
    last = result.run.states[-1]
    return {"end": last.tolist(), "lanes": result.statistics.get("lanes", 1), "steps": result.statistics["steps"]}


def rows_of(study: kf.Study, **options: Any) -> dict[str, list[Any]]:
    with ThreadPoolExecutor(1) as executor:  # which takes blocks of cases, as processes do
        table = study.run(executor, **options)
    return {name: list(table.column(name)) for name in ("status", "end", "lanes", "steps", "reason", "warnings")}


def test_cases_that_are_alike_are_evaluated_at_once_and_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scheduling, "BLOCK_SECONDS", 1e9)  # blocks are as long on a busy machine
    options: dict[str, Any] = {"duration": 0.5, "mass": np.linspace(0.5, 1.5, COUNT), "angle": [0.0, 0.4]}
    found = rows_of(kf.Study(arm, told, **options))
    assert found["lanes"].count(lanes_here()) >= 2 * COUNT - 4  # but for the first blocks, of one case each
    monkeypatch.setattr(Work, "may_be_at_once", False)
    alone = rows_of(kf.Study(arm, told, **options))
    assert alone["lanes"] == [1] * 2 * COUNT
    np.testing.assert_array_equal(np.array(found["end"]), np.array(alone["end"]))
    assert found["steps"] == alone["steps"]


def block(*parameters: dict[str, float], **options: Any) -> list[dict[str, Any]]:
    """Return the rows of some cases that are run in one block."""
    import json

    work = Work(arm, told, {"t_span": (0.0, 0.3), **options})
    done = run_block(work, stamp(), [Case(i, str(i), one) for i, one in enumerate(parameters)])
    return [json.loads(line) for line in done.lines.splitlines()]


def test_cases_that_differ_or_fail_are_run_beside_them() -> None:
    given = [
        {"mass": 1.0},
        {"mass": 99.0},
        {"mass": 2.0, "stiffness": 5.0},
        {"mass": 3.0},
        {"mass": -1.0},
        {"mass": 4.0},
    ]
    rows = block(*given)
    assert [row["outputs"].get("lanes") for row in rows] == [lanes_here(), None, 1, lanes_here(), None, lanes_here()]
    assert rows[1]["reason"].startswith("build raised ValueError: too heavy (test_at_once.py")
    assert rows[4]["reason"].startswith("build: mass of body 'lower' must be")
    for row, one in zip(rows, given, strict=True):
        alone = block(one)[0]
        assert alone["outputs"].pop("lanes", 1) in (1, None)
        row["outputs"].pop("lanes", None)
        assert row["outputs"] == alone["outputs"]
        assert row["warnings"] == alone["warnings"]
        assert row["wall"] > 0.0


def test_warnings_are_those_of_each_case() -> None:
    given, options = [{"mass": 1.0}, {"mass": 60.0}, {"mass": 2.0}], {"method": "rk4", "step": 0.1}
    rows, alone = block(*given, **options), [block(one, **options)[0] for one in given]
    assert [row["outputs"]["lanes"] for row in rows] == [lanes_here()] * 3
    assert [row["warnings"] for row in rows] == [row["warnings"] for row in alone]
    assert [any("it is heavy" in text for text in row["warnings"]) for row in rows] == [False, True, False]


def test_cases_with_a_time_limit_or_of_another_kind_are_run_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    begun: list[int] = []
    original = at_once.begun_at_once
    monkeypatch.setattr("kanefe.studies.workers.work.begun_at_once", lambda *given: begun.append(0) or original(*given))
    assert [row["outputs"]["lanes"] for row in block({"mass": 1.0}, {"mass": 2.0}, events=())] == [lanes_here()] * 2
    assert len(begun) == 1
    rows_of(kf.Study(arm, told, duration=0.1, mass=[1.0, 2.0, 3.0, 4.0]), most_seconds=60.0)
    assert len(begun) == 1
    rows = block({"mass": 1.0, "stiffness": 5.0}, {"mass": 2.0, "stiffness": 5.0})
    assert [row["outputs"]["lanes"] for row in rows] == [1, 1]
