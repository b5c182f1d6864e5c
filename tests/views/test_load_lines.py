"""Lines of ropes and springs in views: they go where the laws of the loads have them."""

from functools import cache

import numpy as np
import pytest

import kanefe as kf
from kanefe.results.load_lines import GONE, SLACK, TAUT
from kanefe.views.dashes import dashes
from kanefe.views.player.page import page_of
from kanefe.views.still import picture_of_run
from player_pages import read_page
from result_scenes import beam_arm
from vtk_files import read_grid, read_series

GRAVITY = (0.0, 0.0, -9.81)


@cache
def hoist() -> kf.Result:
    """A rope from a driven drum over a pulley on the tip of a bending jib to a load, and a winch to a bobbing block."""
    scene = kf.System(gravity=GRAVITY)
    jib = scene.add_flexible_body("jib", beam_arm())
    drum = scene.add_frame("drum", at=(-0.2, 0, 0.1), joint=kf.Prismatic("x", motion=kf.Motion.steady(-0.5)))
    hook = scene.add_point("hook", 0.5, at=(1, 0, -1), joint=kf.Translation())
    pulley = jib.interface("tip").frame(at=(0, 0.05, 0.02))
    scene.add(kf.Rope("hoist", (drum, pulley, hook), axial_stiffness=2e4, damping=50.0, preload=4.9))
    spring = kf.CoordinateForce(stiffness=1e3, damping=3.0)
    block = scene.add_point("block", 5.0, at=(0, 1, 1), joint=kf.Prismatic("z", forces=spring))
    over = scene.ground.frame(at=(0, 2, 0))
    scene.add(kf.Winch("cable", (scene.ground, over, block), tension=20.0, stiffness=1e5, speed=1.0, damping=200.0))
    return scene.simulate((0.0, 0.5), output_step=0.01)


@cache
def thrown() -> kf.Result:
    """A ball thrown up on a loose rope, which jerks, breaks and is gone; a spring stays."""
    scene = kf.System(gravity=GRAVITY)
    ball = scene.add_point("ball", 1.0, joint=kf.Prismatic("z", speed=5.0), at=(0.0, 0.0, 0.5))
    rope = {"axial_stiffness": 1e4, "damping": 10.0, "length": 2.5, "breaking_load": 100.0}
    scene.add(kf.Rope("leash", (scene.ground.frame(at=(1, 0, 0)), scene.ground, ball), **rope))
    scene.add_spring("spring", scene.ground.frame(at=(0.5, 0, 0)), ball, stiffness=1.0)
    return scene.simulate((0.0, 0.5), output_step=0.01)


def test_a_rope_is_as_long_as_its_law_says_at_every_instant():
    result = hoist()
    rows = np.arange(0, len(result.times), 3)
    lines = {line.name: line for line in result.load_lines(rows)}
    assert lines["hoist"].points.shape == (len(rows), 3, 3)
    for name in ("hoist", "cable"):
        lengths = np.linalg.norm(np.diff(lines[name].points, axis=1), axis=2).sum(axis=1)
        np.testing.assert_allclose(lengths, result.load(name, "length")[rows], rtol=1e-9)
    assert np.ptp(lines["hoist"].points[:, 1], axis=0).max() > 1e-3  # the pulley moves with the jib


def test_a_slack_rope_is_told_and_a_broken_one_is_gone():
    result = thrown()
    rows = np.arange(len(result.times))
    leash, spring = result.load_lines(rows)
    (broke,) = result.events["leash breaks"]
    before = result.times < broke
    np.testing.assert_array_equal(leash.states[before], np.where(result.load("leash", "slack")[before], SLACK, TAUT))
    assert set(leash.states[before].tolist()) == {SLACK, TAUT}
    assert set(leash.states[~before].tolist()) == {GONE}
    assert not spring.states.any()


def test_a_winch_tells_where_its_cable_is_slack():
    scene = kf.System(gravity=GRAVITY)
    block = scene.add_point("block", 5.0, at=(0, 0, 1), joint=kf.Prismatic("z", speed=-3.0))
    scene.add(kf.Winch("cable", (scene.ground, block), tension=20.0, stiffness=1e5, speed=1.0, damping=200.0))
    result = scene.simulate((0.0, 0.1), output_step=0.01)
    slack = result.load("cable", "slack") > 0.0
    np.testing.assert_array_equal(slack, result.load("cable", "tension") == 0.0)
    assert slack[-1]
    assert not slack[0]
    (line,) = result.load_lines()
    np.testing.assert_array_equal(line.states == SLACK, slack)


class Pull(kf.Load):
    """A load of three ends that is no line over them."""

    columns = ()

    def __init__(self, name: str, *ends: object) -> None:
        self.name, self.ends = name, ends

    def action(self, t: float, ends: object, states: object) -> kf.Action:
        return kf.Action(np.zeros((len(self.ends), 6)))


class Way(Pull):
    runs_over_ends = True


def test_loads_of_three_ends_are_drawn_where_they_say_so():
    scene = kf.System()
    ball = scene.add_point("ball", 1.0, at=(0, 0, 1))
    ends = (scene.ground, scene.ground.frame(at=(1, 0, 0)), ball)
    for load in (Pull("pull", *ends), Way("way", *ends), Pull("pair", *ends[:2])):
        scene.add(load)
    result = scene.simulate((0.0, 0.1))
    assert [line.name for line in result.load_lines([0])] == ["way", "pair"]


def test_the_page_has_the_points_and_the_states():
    result = thrown()
    told = read_page(page_of(result).html)
    leash, spring = told["links"]
    exact, _ = result.load_lines()
    np.testing.assert_allclose(leash["p"] + told["origin"], exact.points, atol=1e-6)  # single precision
    np.testing.assert_array_equal(leash["states"], exact.states)
    assert "states" not in spring


def test_lines_come_back_from_a_file(tmp_path):
    result = thrown()
    result.save(tmp_path / "run.h5", forces=False)
    loaded = kf.load_result(tmp_path / "run.h5")
    for one, two in zip(result.load_lines(slice(5, 40, 5)), loaded.load_lines(slice(5, 40, 5)), strict=True):
        assert one.name == two.name
        np.testing.assert_array_equal(one.points, two.points)
        np.testing.assert_array_equal(one.states, two.states)
    first, second = (read_page(page_of(run).html)["links"] for run in (result, loaded))
    np.testing.assert_array_equal(first[0]["p"], second[0]["p"])


def test_an_instant_has_its_lines_without_the_axis_of_times():
    result = hoist()
    for one, two in zip(result.load_lines([20]), result.at(float(result.times[20])).load_lines(), strict=True):
        np.testing.assert_array_equal(one.points[0], two.points)
        assert one.states[0] == two.states


def test_one_instant_may_be_asked_for_alone():
    result = thrown()
    leash, _ = result.load_lines(-1)
    assert leash.points.shape == (1, 3, 3)
    assert leash.states.tolist() == [GONE]
    with pytest.raises(kf.ModelError, match="must be numbers of output times"):
        result.load_lines(len(result.times))


def test_paraview_gets_lines_that_say_what_is_slack(tmp_path):
    result = thrown()
    entries = [
        one for one in read_series(result.to_vtk(tmp_path / "run.pvd", every=1)) if one[1] == "loads along lines"
    ]
    exact, _ = result.load_lines()
    assert len(entries) == len(result.times)
    for row, (_, _, path) in enumerate(entries):
        grid, is_gone = read_grid(path), exact.states[row] == GONE
        assert grid["load"].tolist() == ([1] if is_gone else [0, 0, 1])
        assert grid["slack"][:-1].tolist() == ([] if is_gone else [int(exact.states[row] == SLACK)] * 2)
        if not is_gone:
            np.testing.assert_array_equal(grid["points"][:3], exact.points[row])
            assert grid["connectivity"].tolist() == [0, 1, 1, 2, 3, 4]


def test_a_series_of_a_rope_that_is_gone_is_written(tmp_path):
    scene = kf.System(gravity=GRAVITY)
    ball = scene.add_point("ball", 1.0, at=(0, 0, -1), joint=kf.Prismatic("z", speed=-1.0))
    scene.add(kf.Rope("leash", (scene.ground, ball), axial_stiffness=1e4, breaking_load=20.0))
    result = scene.simulate((0.0, 0.2))
    entries = read_series(result.to_vtk(tmp_path / "run.pvd", every=20))
    times = [time for time, name, _ in entries if name == "loads along lines"]
    (broke,) = result.events["leash breaks"]
    assert times == [time for time, name, _ in entries if name == "rigid bodies" and time < broke]


def test_dashes_lie_on_the_line_with_gaps_between_them():
    points = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.5, 0.0)])
    found = dashes(points, 0.05)
    lengths = np.linalg.norm(found[:, 1] - found[:, 0], axis=1)
    np.testing.assert_allclose(lengths, 0.05, rtol=1e-12)
    assert (((found[..., 1] == 0.0) | (found[..., 0] == 1.0)) & (found[..., 2] == 0.0)).all()


def test_stills_show_a_rope_until_it_breaks(monkeypatch):
    seen = []
    monkeypatch.setattr("kanefe.views.still.thumbnail", lambda pieces, up, around: seen.append(pieces) or b"")
    result = thrown()
    states = result.load_lines()[0].states
    lengths = result.load("leash", "length")
    for state, share in ((TAUT, 1.0), (SLACK, 0.5), (GONE, None)):
        row = int(np.flatnonzero(states == state)[0])
        picture_of_run(result, row)
        ropes = [piece for piece in seen.pop() if not len(piece.triangles)]
        assert len(ropes) == (1 if share is None else 2)  # the spring, and the rope
        if share is not None:
            ends = ropes[0].points[ropes[0].creases]
            drawn = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
            np.testing.assert_allclose(drawn, share * lengths[row], rtol=1e-9)
