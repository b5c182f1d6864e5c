"""Motion-induced interruptions against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.studies import interruptions

G, PERIOD, SPAN = 9.81, 4.0, 24.0


def run(angle: float = 0.0, sway: float = 0.0) -> kf.Result:
    """Return a run of a deck that rolls and sways as cosines, with a bob that hangs from it."""
    times = np.linspace(0.0, SPAN, 961)
    wave = np.cos(2.0 * math.pi * times / PERIOD)
    turns = [kf.rotation_about("x", angle * x) for x in wave]
    motion = kf.PoseTable(times, np.column_stack((0.0 * wave, sway * wave, 0.0 * wave)), turns)
    scene = kf.System(gravity=(0.0, 0.0, -G))
    deck = scene.add_frame("deck", joint=kf.Free(motion=motion))
    scene.add_rigid_body("bob", 1.0, 1.0, parent=deck, com=(0.0, 0.0, -1.0), joint=kf.Revolute("y"))
    return scene.simulate((0.0, SPAN), rtol=1e-4, output_step=0.05)


def test_a_deck_that_sways_tips_people_twice_a_period() -> None:
    w2 = (2.0 * math.pi / PERIOD) ** 2
    result = run(sway=0.30 * G / w2)
    found = interruptions("deck", sliding=0.28)(result)
    assert found["crew tipping"] == pytest.approx(2.0 * 60.0 / PERIOD)
    assert found["crew sliding"] == pytest.approx(2.0 * 60.0 / PERIOD)
    rice = 2.0 * 60.0 / PERIOD * math.exp(-0.5 * (0.25 / (0.30 / math.sqrt(2.0))) ** 2)
    assert found["crew tipping by Rice"] == pytest.approx(
        rice, rel=5e-3
    )  # 24 s hold a period more or less by half a step
    calm = interruptions("deck", lateral=0.31, sliding=0.31, name="post")(result)
    assert (calm["post tipping"], calm["post sliding"]) == (0.0, 0.0)


def test_what_is_felt_is_that_of_the_place() -> None:
    angle, height = 0.2, 5.0
    result = run(angle=angle)
    # across at the ends of the roll, g sin(angle) with what its acceleration adds at a height, over g cos(angle)
    w2 = (2.0 * math.pi / PERIOD) ** 2
    share = (G * math.sin(angle) + height * w2 * angle) / (G * math.cos(angle))
    for limit, wanted in ((0.995 * share, 2.0 * 60.0 / PERIOD), (1.005 * share, 0.0)):
        assert interruptions("deck", (0.0, 0.0, height), lateral=limit)(result)["crew tipping"] == pytest.approx(wanted)


def test_a_process_like_a_sea_passes_as_often_as_rice_says() -> None:
    from kanefe.studies.statistics.crew import _rate_by_rice, _rises

    random, times = np.random.default_rng(1), np.arange(0.0, 3600.0, 0.1)
    rates, phases = random.uniform(0.5, 1.0, 200), random.uniform(0.0, 2.0 * math.pi, 200)
    record = 0.1 * math.sqrt(2.0 / 200) * sum(np.cos(w * times + p) for w, p in zip(rates, phases, strict=True))
    counted = _rises(np.abs(record) - 0.2) / 60.0
    expected = _rate_by_rice(record, times, 0.2)
    # clumps of passages scatter by some more than those of Poisson
    assert counted == pytest.approx(expected, abs=4.0 * math.sqrt(expected / 60.0))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"lateral": 0.0}, "lateral of interruptions must be above zero"),
        ({"sliding": -1.0}, "sliding of interruptions must be above zero"),
        ({"at": (0.0, 1.0)}, "the place of interruptions"),
    ],
)
def test_bad_numbers_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(kf.ModelError, match=message):
        interruptions("deck", **given)


def test_runs_that_cannot_tell_are_refused(tmp_path: Any) -> None:
    result = run()
    with pytest.raises(kf.ModelError, match="fewer than three output times"):
        interruptions("deck", after=SPAN)(result)
    result.save(tmp_path / "run.h5")
    with pytest.raises(kf.ModelError, match="result from a file"):
        interruptions("deck")(kf.load_result(tmp_path / "run.h5"))
    with pytest.raises(kf.ModelError, match="its z axis upward"):
        interruptions("deck")(run(angle=math.pi))
