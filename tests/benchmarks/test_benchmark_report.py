"""The machinery of the benchmarks: medians, ratios, the table and its file. What they measure is not tested."""

import json
import math

import pytest

from benchmarks.clocks import Disagreement, Race, check_agreement
from benchmarks.goals import Figure, Goal, median, median_ratio, table, write_json

FIGURES = [
    Goal("a step / the peer's", 0.3).figure(0.12345, "1 us against 8 us"),
    Goal("growth", 11.0).figure(12.0),
    Goal("right-hand side", 1.05).skipped("dolfinx is not there"),
]


def test_median() -> None:
    assert median([3.0, 1.0, 2.0]) == 2.0
    assert median([4.0, 1.0, 2.0, 3.0]) == 2.5


@pytest.mark.parametrize("values", [[], [1.0, math.nan, 2.0]])
def test_no_median_of_nothing_and_of_a_failed_clock(values: list[float]) -> None:
    with pytest.raises(ValueError, match="no median"):
        median(values)


def test_ratio_compares_runs_made_side_by_side() -> None:
    # the machine slowed down by 10 during the second and third pair: the medians alone would give 2
    assert median_ratio([1.0, 20.0, 20.0], [2.0, 10.0, 40.0]) == 0.5
    with pytest.raises(ValueError, match="no ratio"):
        median_ratio([1.0, 2.0], [1.0])
    with pytest.raises(ValueError, match="no ratio"):
        median_ratio([1.0], [0.0])


def test_goals() -> None:
    assert [figure.met for figure in FIGURES] == [True, False, False]
    assert Goal("the limit itself", 0.5).figure(0.5).met
    assert not Goal("not a number", 0.5).figure(math.nan).met


def test_table() -> None:
    lines = table(FIGURES).splitlines()
    assert lines[0].split() == ["what", "value", "goal", "met"]
    assert lines[1].split()[-4:] == ["0.123", "<=", "0.3", "yes"]
    assert lines[2] == "    1 us against 8 us"
    assert lines[3].endswith("NO")
    assert lines[4].split()[-4:] == ["skipped", "<=", "1.05", "NO"]
    assert lines[5].startswith("    dolfinx is not there")
    assert len({line.index("<=") for line in (lines[1], lines[3], lines[4])}) == 1  # columns stand below each other
    assert lines[-1] == "1 of 3 goals met"


def test_json(tmp_path) -> None:
    write_json(FIGURES, tmp_path / "figures.json")
    found = json.loads((tmp_path / "figures.json").read_text())
    assert found[0] == {"what": "a step / the peer's", "value": 0.12345, "goal": "<= 0.3", "met": True}
    assert [set(figure) for figure in found] == [{"what", "value", "goal", "met"}] * 3
    assert found[2]["value"].startswith("skipped: ")


def test_figures_are_data() -> None:
    with pytest.raises(AttributeError):
        Figure("a", 1.0, "<= 2", True).met = False  # type: ignore[misc]


def test_what_is_compared_must_agree() -> None:
    check_agreement("chain", [1.0, 2.0], [1.0, 2.0 + 1e-7])
    with pytest.raises(Disagreement, match="chain: the two sides differ"):
        check_agreement("chain", [1.0, 2.0], [1.0, 2.001])
    with pytest.raises(Disagreement):
        check_agreement("chain", [1.0, math.nan], [1.0, 2.0])


def test_a_race_runs_in_turn_and_drops_the_first_round() -> None:
    times = {"ours": iter([9.0, 1.0, 2.0, 3.0]), "theirs": iter([1.0, 2.0, 2.0, 2.0])}
    order = []

    def clock(side: str) -> float:
        order.append(side)
        return next(times[side])

    race = Race(lambda: clock("ours"), lambda: clock("theirs"), rounds=3)
    assert order == ["ours", "theirs"] * 4
    assert (race.ours, race.theirs, race.ratio) == (2.0, 2.0, 1.0)
