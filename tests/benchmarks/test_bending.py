"""`bending.py`: bodies that bend far, in a short run; what is chosen among runs; tables and the picture."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks import bending_scenes as scenes
from benchmarks.bending import LOAD, Point, best, hung, over_bending, rows_of, rows_over_bending
from benchmarks.bending_picture import picture
from kanefe.errors import SimulationError


def test_elastica_by_each_body() -> None:
    """Segments of order 2, stiffened ones of 3; functions of strains exponentially; a linear body is of no use."""
    exact = scenes.shot(LOAD)
    error = {(kind, size): hung(kind, size, exact).error for kind in scenes.KINDS for size in (4, 8)}
    assert error[scenes.LINEAR, 4] > 0.5
    for kind, ratio in ((scenes.SEGMENTS, 4.0), (scenes.IECS, 4.0), (scenes.STIFF_SEGMENTS, 8.0)):
        assert error[kind, 4] / error[kind, 8] == pytest.approx(ratio, rel=0.25)
    assert error[scenes.LEGENDRE, 8] < 1e-7
    assert error[scenes.SPLINES, 8] < 1e-6


def test_link_by_each_body() -> None:
    exact, coordinates = scenes.run(scenes.link(scenes.LEGENDRE, 8)[0], "dop853", 1e-6)[0], {}
    assert scenes.turned(exact) > 0.5
    error = {}
    for kind, size in ((scenes.LINEAR, 2), (scenes.SEGMENTS, 4), (scenes.SEGMENTS, 8), (scenes.SPLINES, 6)):
        model, coordinates[kind, size] = scenes.link(kind, size)
        found = scenes.run(model, "radau5", 1e-5)[0]
        error[kind, size] = float(np.linalg.norm(found[:, :2] - exact[:, :2], axis=1).max())
    assert error[scenes.LINEAR, 2] > 0.1
    assert error[scenes.SEGMENTS, 4] / error[scenes.SEGMENTS, 8] == pytest.approx(4.0, rel=0.5)
    assert error[scenes.SPLINES, 6] < 1e-4
    assert coordinates == {(scenes.LINEAR, 2): 5, (scenes.SEGMENTS, 4): 12, (scenes.SEGMENTS, 8): 24} | {
        (scenes.SPLINES, 6): 6
    }


def test_the_cheapest_run_near_the_finest_is_taken() -> None:
    def gives(error: float, seconds: float):
        return lambda: (np.array([[error, 0.0]]), seconds)

    def fails():
        raise SimulationError("no balance")

    exact = np.zeros((1, 2))
    trials = [("b 1", gives(1e-4, 3.0)), ("a 1", gives(1e-2, 1.0)), ("a 2", gives(1.1e-4, 2.0)), ("b 2", fails)]
    assert best("x", 1, 2, trials, exact) == Point("x", 1, 2, 1.1e-4, 2.0, "a 2")
    none = best("x", 1, 2, [("b 2", fails)], exact)
    assert math.isinf(none.error)
    assert rows_of([none])["rows"] == [["x", "1", "2", "fails", "", "b 2: no balance"]]


def test_errors_over_bending_and_picture(tmp_path) -> None:
    bodies = ((scenes.Kind("linear", (2,), ("radau5",)), 2), (scenes.Kind("segments", (4,), ("radau5",)), 4))
    found = over_bending(bodies, (scenes.ANGLE / 64, scenes.ANGLE / 8))
    assert found["linear, 2"][0][1] < found["linear, 2"][1][1]
    assert found["segments, 4"][1][1] < found["linear, 2"][1][1]
    assert len(rows_over_bending(found)["rows"][0]) == 3
    points = [Point("linear", 2, 5, 0.1, 0.01, ""), Point("segments", 4, 12, 0.01, 0.02, "")]
    picture(points, points, found, LOAD, "", tmp_path / "bending.png")
    assert (tmp_path / "bending.png").stat().st_size > 10_000
