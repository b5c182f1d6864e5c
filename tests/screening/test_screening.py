"""Screened runs: the events of whole ones, from windows only where something is near."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.frames import axis_rotation
from kanefe.loads.screened import screening_of
from kanefe.screening import windows
from kanefe.screening.carrier import Carrier, Displacement
from kanefe.screening.sticking import Sticking
from kanefe.screening.superposition import superposed
from kanefe.screening.windows import screen
from screening_scenes import block_on_deck, deck_motion

SPAN = 20.0  # s
SAME_TIME = 2e-3
"""s: events of runs at rtol 1e-6 that take other steps differ by up to 5e-4."""


def rest(**options: Any) -> np.ndarray:
    """Return the rest on the deck before it moves; a state has the same entries where it does."""
    return kf.equilibrium(block_on_deck(None, **options)).state


@pytest.fixture(scope="module")
def start() -> np.ndarray:
    return rest()


def happened(run: kf.Result | kf.ScreenedRun) -> dict[str, list[float]]:
    return {name: times.tolist() for name, times in run.events.items() if len(times)}


def check_same(whole: kf.Result, screened: kf.ScreenedRun) -> None:
    there, here = happened(whole), happened(screened)
    assert {name: len(times) for name, times in here.items()} == {name: len(times) for name, times in there.items()}
    for name, times in there.items():
        assert here[name] == pytest.approx(times, abs=SAME_TIME)
    np.testing.assert_array_equal(whole.times, screened.result.times)


@pytest.mark.parametrize("p", [(0.0, 0.0, 0.0), (1.0, -2.0, 0.5)])
@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_displacement_seen_from_another_frame_moves_its_points_alike(p: tuple[float, ...], angle: float) -> None:
    rng = np.random.default_rng(5)
    x, v, a, w, dw, r = rng.standard_normal((6, 1, 3))
    origin, A, R = np.array(p), axis_rotation((1, 0, 0), angle), axis_rotation((0.6, 0, 0.8), 0.4)
    seen = Displacement(x, v, a, R[None], w, dw).seen_from(origin, A)
    at = origin + A @ r[0]
    spin = np.cross(w, at)
    np.testing.assert_allclose(origin + A @ (seen.x[0] + seen.R[0] @ r[0]), x[0] + R @ at, atol=1e-14)
    moved = seen.v + (seen.R[0] @ np.cross(seen.w, r)[0])
    np.testing.assert_allclose(A @ moved[0], (v + (R @ spin[0]))[0], atol=1e-14)
    pushed = np.cross(seen.dw, r) + np.cross(seen.w, np.cross(seen.w, r))
    wanted = np.cross(dw, at) + np.cross(w, spin)
    np.testing.assert_allclose(A @ (seen.a + (seen.R[0] @ pushed[0]))[0], (a + (R @ wanted[0]))[0], atol=1e-14)


@pytest.mark.parametrize("seed", [1, 3, 4])
def test_events_are_those_of_a_whole_run(seed: int, start: np.ndarray) -> None:
    scene = block_on_deck(deck_motion(seed, SPAN))
    whole = scene.simulate((0.0, SPAN), start=start, output_step=1.0)
    screened = screen(scene, SPAN, start=start, output_step=1.0)
    assert sum(map(len, happened(whole).values())) > 0
    check_same(whole, screened)
    assert 0.0 < screened.share < 0.6
    assert "slip" in screened.reasons[0]
    paths = [result.contact("foot 1").slip[-1] for result in (whole, screened.result)]
    assert paths[0] == pytest.approx(paths[1], rel=1e-3, abs=1e-7)


def test_long_stretches_behind_a_window(start: np.ndarray) -> None:
    span = 150.0
    scene = block_on_deck(deck_motion(6, span), mu=0.28)
    whole = scene.simulate((0.0, span), start=start, output_step=5.0)
    screened = screen(scene, span, start=start, output_step=5.0)
    assert 0 < sum(map(len, happened(whole).values()))
    check_same(whole, screened)
    assert screened.share < 0.5
    # of anchors nothing is off the surface, and their paths and works are those of the whole run
    run, other = screened.result.run, whole.run
    assert run is not None
    assert other is not None
    internal = run.states[:, -run.model.state_count :]
    np.testing.assert_allclose(internal[:, 4::5], 0.0, atol=1e-12)
    np.testing.assert_allclose(internal[:, 0::5], other.states[:, -run.model.state_count :][:, 0::5], atol=1e-6)


def test_nothing_is_integrated_where_nothing_is_near(start: np.ndarray, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[object] = []
    monkeypatch.setattr(windows, "integrate", lambda *given, **_: calls.append(given))
    screened = screen(block_on_deck(deck_motion(0, SPAN, 0.5)), SPAN, start=start)
    assert not calls
    assert (screened.windows, happened(screened)) == ((), {})
    assert str(screened).startswith("0 events; 0 windows integrated, 0 % of 20 s")


def test_without_its_bound_events_are_missed(start: np.ndarray, monkeypatch: pytest.MonkeyPatch) -> None:
    near = windows._Run._near

    def blind(self: Any, *given: Any) -> Any:
        fine, is_near = near(self, *given)
        return fine, np.zeros_like(is_near)

    scene = block_on_deck(deck_motion(1, SPAN))
    monkeypatch.setattr(windows._Run, "_near", blind)
    with pytest.raises(AssertionError):
        check_same(scene.simulate((0.0, SPAN), start=start), screen(scene, SPAN, start=start))


def test_what_is_superposed_is_within_its_bound(start: np.ndarray) -> None:
    scene = block_on_deck(deck_motion(0, SPAN, 0.5))
    # between the times of the superposition too
    options: dict[str, Any] = {"start": start, "output_step": 0.125}
    whole = scene.simulate((0.0, SPAN), rtol=1e-9, **options)
    screened = screen(scene, SPAN, **options)
    for name in ("foot 0", "foot 3"):
        depths = [result.contact(name).penetration for result in (whole, screened.result)]
        apart = np.abs(depths[0] - depths[1]).max()
        assert 0.0 < apart < screened.bound[f"{name} touch"] < 0.02 * depths[0].max()
        drags = [result.contact(name).tangential for result in (whole, screened.result)]
        assert np.abs(drags[0] - drags[1]).max() < screened.bound[f"{name} slip"]


def test_what_is_left_of_the_start_is_in_the_bound(start: np.ndarray) -> None:
    # small motions are superposed as far as they are linear; this one is a quarter of how deep the feet are
    scene, raised = block_on_deck(deck_motion(0, SPAN, 0.5)), start.copy()
    raised[2] += 3e-4
    options: dict[str, Any] = {"start": raised, "output_step": 0.02}
    whole = scene.simulate((0.0, SPAN), rtol=1e-9, **options)
    screened = screen(scene, SPAN, **options)
    assert screened.windows == ()
    for name in ("foot 0", "foot 3"):
        depths = [result.contact(name).penetration for result in (whole, screened.result)]
        # without the start it is 5e-6
        assert 1e-5 < np.abs(depths[0] - depths[1]).max() < screened.bound[f"{name} touch"] < 5e-4


def test_a_rope_that_breaks_is_seen() -> None:
    begun = rest(rope=200.0, breaking=159.0)
    scene = block_on_deck(deck_motion(0, 12.0, 0.5), mu=0.4, rope=200.0, breaking=159.0)
    whole = scene.simulate((0.0, 12.0), start=begun)
    screened = screen(scene, 12.0, start=begun)
    assert len(whole.events["rope breaks"]) == 1
    check_same(whole, screened)
    assert screened.reasons[0] == "rope breaks"


def test_a_scene_in_the_plane() -> None:
    times = np.linspace(0.0, SPAN, 401)
    angle = 0.2 * np.clip(times / 8.0, 0.0, 1.0) ** 3 * np.sin(times)

    def box(motion: kf.Motion | None) -> kf.System:
        scene = kf.System(gravity=(0.0, -9.81, 0.0))
        deck = scene.ground if motion is None else scene.add_frame("deck", joint=kf.Revolute("z", motion=motion))
        body = scene.add_rigid_body("box", 100.0, 8.0, joint=kf.Planar(position=(0.0, 2.2)))
        surface = scene.add_surface("deck", deck, kf.shapes.Plane("y"), at=(0.0, 2.0, 0.0))
        for name, x in (("left", -0.4), ("right", 0.4)):
            law = kf.Coulomb(0.17, stiffness=4e5, damping=2e3)
            foot = body.frame((x, -0.2, 0.0))
            scene.add_contact(name, foot, surface, normal=kf.HuntCrossley(4e5, 0.5), friction=law)
        return scene

    scene, begun = box(kf.Motion.table(times, angle)), kf.equilibrium(box(None)).state
    whole = scene.simulate((0.0, SPAN), start=begun)
    screened = screen(scene, SPAN, start=begun)
    assert sum(map(len, happened(whole).values())) > 4
    check_same(whole, screened)
    assert 0.0 < screened.share < 0.9


def test_a_block_that_is_a_child_of_the_deck_and_carries_a_ball(start: np.ndarray) -> None:
    def with_ball(motion: kf.PoseTable | None, *, is_child: bool) -> kf.System:
        scene = block_on_deck(motion, mu=0.25, is_child=is_child)
        post = scene.add_rigid_body("post", 5.0, (0.1, 0.1, 0.05), parent=scene.body("block"), joint=kf.Spherical())
        spring = {"stiffness": (2e4,) * 3, "damping": (200.0,) * 3}
        for name, at in (("one", (0.2, 0.0, 0.3)), ("other", (-0.2, 0.1, 0.3))):
            scene.add_bushing(name, scene.body("block").frame(at), post.frame(at), **spring)
        return scene

    motion = deck_motion(6, 30.0)
    begun = kf.equilibrium(with_ball(None, is_child=False)).state
    runs = []
    for is_child in (False, True):
        scene = with_ball(motion, is_child=is_child)
        whole = scene.simulate((0.0, 30.0), start=begun, output_step=5.0)
        screened = screen(scene, 30.0, start=begun, output_step=5.0)
        check_same(whole, screened)
        assert screened.share < 0.9
        turned = [result.rotation("post") for result in (whole, screened.result)]
        np.testing.assert_allclose(turned[0], turned[1], atol=1e-5)
        runs.append(screened)
    assert happened(runs[0]).keys() == happened(runs[1]).keys()


def test_what_is_free_to_slide_is_integrated() -> None:
    scene = block_on_deck(deck_motion(0, 4.0, 0.3), mu=None)
    screened = screen(scene, 4.0)
    assert screened.windows == ((0.0, 4.0),)
    assert "free or undamped" in screened.reasons[0]


def test_runs_of_a_study_are_screened(start: np.ndarray) -> None:
    def build(seed: int) -> tuple[kf.System, dict[str, Any]]:
        return block_on_deck(deck_motion(seed, 10.0)), {"start": start}

    def kept(result: kf.Result) -> dict[str, Any]:
        return {"slips": len(result.events["foot 1 slip"]), "method": result.statistics["method"]}

    study = kf.Study(build, kept, duration=10.0, simulate={"screened": True}, seed=[1, 2])
    table = study.run("serial")
    whole = block_on_deck(deck_motion(1, 10.0)).simulate((0.0, 10.0), start=start)
    assert table.column("method").tolist() == ["screened"] * 2
    assert table.column("slips").tolist() == [len(whole.events["foot 1 slip"]), 0]
    assert study.result({"seed": 2}).statistics["windows"] == 0
    finer = kf.Study(build, kept, duration=2.0, simulate={"screened": True, "spacing": 0.2}, seed=2)
    assert finer.run("serial").counts["finished"] == 1
    with pytest.raises(kf.ModelError, match="simulate takes no spacing"):
        kf.Study(build, kept, duration=2.0, simulate={"spacing": 0.2}, seed=2)


def still() -> kf.System:
    return block_on_deck(None)


def with_more(more: str) -> kf.System:
    scene = block_on_deck(deck_motion(0, 4.0))
    block = scene.body("block")
    if more == "post":
        scene.add_rigid_body("post", 1.0, 1.0, joint=kf.Revolute("y"))
    elif more == "drive":
        scene.add_rigid_body("rotor", 1.0, 1.0, parent=block, joint=kf.Revolute("z", motion=kf.Motion.steady(1.0)))
    elif more == "loop":
        scene.add_distance("rod", block, scene.ground, 1.0)
    elif more == "creeps":
        law = kf.LuGre(1e5, 300.0, 0.4, 0.2, 0.3, 1e-3)
        surface = scene.add_surface("other", scene.ground, kf.shapes.Plane("z"), at=(0.0, 0.0, -9.0))
        scene.add_contact("creeper", block, surface, normal=kf.HuntCrossley(4e5, 0.5), friction=law)
    elif more == "rigid":
        surface = scene.add_surface("other", scene.ground, kf.shapes.Plane("z"), at=(0.0, 0.0, -9.0))
        scene.add_contact("hard", block, surface, normal=kf.Rigid(0.5))
    elif more == "winch":
        cable = {"stiffness": 1e5, "damping": 500.0, "speed": 1.0}
        scene.add(kf.Winch("haul-down", (scene.body("deck"), block), tension=500.0, **cable))
    return scene


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("post", "'post' is connected to the ground by a revolute joint"),
        ("drive", "driven here: 'deck', 'rotor'"),
        ("loop", "not supported for scenes with loops"),
        ("creeps", "friction that creeps, as of contact 'creeper'"),
        ("rigid", "not supported for scenes with"),
        ("winch", "loads whose internal states move by themselves, as of winch 'haul-down'"),
    ],
)
def test_what_cannot_be_screened_is_refused(more: str, message: str) -> None:
    with pytest.raises(kf.ModelError, match=message):
        screen(with_more(more), 4.0)


def test_a_rotor_that_turns_faster_than_the_steps_is_refused() -> None:
    scene = block_on_deck(deck_motion(0, 4.0))
    shakes = {4: ((0, 0, 20.0, 0, 0, 0), np.zeros(6)), 9: (np.zeros(6), np.zeros(6))}
    scene.add(kf.PeriodicLoad("rotor", scene.body("block"), 40.0, (0, 0, 500.0, 0, 0, 0), shakes))
    with pytest.raises(kf.ModelError, match=r"'rotor' has harmonics of up to 25.5 Hz.* Remedy: spacing=0.0047"):
        screen(scene, 4.0)
    assert screen(scene, 0.2, spacing=0.0047).result.status.is_finished


def test_bad_numbers_are_refused() -> None:
    with pytest.raises(kf.ModelError, match="driven here: nothing"):
        screen(still(), 4.0)
    scene = block_on_deck(deck_motion(0, 4.0))
    for given, message in (
        ({"duration": 0.0}, "duration of a screened run must be above zero"),
        ({"duration": 1.0, "spacing": 0.0}, "spacing of a screened run must be above zero"),
        ({"duration": 1.0, "spacing": 1e-300}, "GiB for the states alone"),
        ({"duration": 1.0, "rtol": 2.0}, "rtol must lie between 0 and 1"),
        (
            {"duration": 1.0, "events": [kf.Event("half", lambda t, state: t - 0.5)]},
            "screen takes no events=. Remedy: one of scene, duration, start, output_step, spacing, method, rtol",
        ),
        (
            {"duration": 1.0, "output_times": [0.5]},
            "screen takes no output_times=. Remedy: one of scene, duration, start",
        ),
    ):
        with pytest.raises(kf.ModelError, match=message):
            screen(scene, **given)  # type: ignore[arg-type]


def test_an_event_in_python_is_refused() -> None:
    class Fuse(kf.Load):
        def __init__(self, name: str, a: Any, b: Any) -> None:
            self.name, self.ends = name, (a, b)

        def action(self, t: float, ends: Any, states: np.ndarray) -> kf.Action:
            return kf.Action(np.zeros((2, 6)))

        @property
        def events(self) -> tuple[Any, ...]:
            from kanefe.loads.base import LoadEvent

            return (LoadEvent("blows", lambda t, ends, states: 1.0),)

    scene = block_on_deck(deck_motion(0, 4.0))
    scene.add(Fuse("fuse", scene.body("block"), scene.body("deck")))
    with pytest.raises(kf.ModelError, match="event 'fuse blows' is evaluated in Python"):
        screen(scene, 4.0)


@pytest.mark.parametrize(
    ("known", "first", "last"), [((6.0, 9.0), 6.0, 9.0), ((5.25, 9.5), 5.25, 9.5), ((0.0, 20.0), 2.0, 13.0)]
)
def test_around_an_interval_the_motion_is_asked_for_only_where_it_is_known(
    known: tuple[float, float], first: float, last: float, start: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And over no more than 16 steps on each side."""
    model = block_on_deck(deck_motion(0, SPAN, 1e-4)).freeze(0.0, start)  # it stays near where it begins
    sticking, asked, over = Sticking(model), [], Carrier.over

    def asked_over(self: Carrier, times: np.ndarray) -> Any:
        asked.append((times[0], times[-1]))
        return over(self, times)

    monkeypatch.setattr(Carrier, "over", asked_over)
    superposed(sticking, np.arange(6.0, 9.1, 0.25), model.initial_state, known)
    assert (min(begin for begin, _ in asked), max(end for _, end in asked)) == (first, last)


class Strap(kf.Load):
    """A spring that pulls along z, and tells how much."""

    columns = ("tension [N]",)
    screened = kf.ScreenedLoad(pull="tension [N]", strongest=500.0, forcing=2.0)

    def __init__(self, *ends: Any) -> None:
        self.name, self.ends = "strap", ends

    def action(self, t: float, ends: Any, states: np.ndarray) -> kf.Action:
        return kf.Action(np.zeros((2, 6)))

    def tell(self, t: float, ends: Any, states: np.ndarray) -> np.ndarray:
        return np.array((1e3 * (ends[1].p[2] - ends[0].p[2]),))


class EarlierStrap(Strap):
    """The same by single attributes."""

    screened = kf.ScreenedLoad()
    pull_column, strongest_pull, highest_forcing, not_screened = "tension [N]", 500.0, 2.0, ""

    def stuck(self, factor: float) -> Any:
        return self


@pytest.mark.parametrize("kind", [Strap, EarlierStrap])
def test_a_load_of_a_user_says_what_is_screened(kind: type[kf.Load]) -> None:
    scene = block_on_deck(deck_motion(0, 4.0))
    strap = kind(scene.body("block"), scene.body("deck"))
    scene.add(strap)
    said = screening_of(strap)
    assert said[:4] == ("", "tension [N]", 500.0, 2.0)
    assert said.stuck is None or said.stuck(2.0) is strap
    assert Sticking(scene.freeze()).names[-1] == "strap pull"


def test_a_load_with_states_that_move_is_not_screened_unless_it_says_so() -> None:
    class Creep(Strap):
        screened, initial_states = kf.ScreenedLoad(), np.zeros(1)

    refused = screening_of(Creep("a", "b")).refused
    assert refused == "loads whose internal states move by themselves"
    Creep.screened = kf.ScreenedLoad("")
    assert screening_of(Creep("a", "b")).refused == ""
