"""Events of loads that a run asks for by name: slack and taut of ropes, and ends and actions at events of loads."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.loads.by_kernel import EventByKernel

G, SPEED, K = 9.81, 2.0, 1e6
TAUT = 2.0 * SPEED / G
OMEGA = math.sqrt(K / 2.0)


def thrown(speed: float = SPEED, **rope: Any) -> kf.System:
    """Return a weight of 2 kg on a rope of 1 m, thrown up from where the rope is just slack."""
    scene = kf.System(gravity=(0, 0, -G))
    weight = scene.add_point("weight", 2.0, joint=kf.Prismatic("z", position=-1.0, speed=speed))
    scene.add(kf.Rope("hoist", (scene.ground, weight), axial_stiffness=K, length=1.0, **rope))
    return scene


@pytest.mark.parametrize(
    ("method", "options", "near"),
    [
        ("auto", {"rtol": 1e-9}, 1e-8),
        ("dop853", {"rtol": 1e-9}, 1e-8),
        ("dopri5", {"rtol": 1e-9}, 1e-8),
        ("vern9", {"rtol": 1e-9}, 1e-8),
        ("radau5", {"rtol": 1e-9}, 1e-8),
        # of second order: (h omega)^2 / 12 of the time that it holds
        ("generalised-alpha", {"step": 2e-5}, 1e-6),
        ("energy-momentum", {"step": 1e-5}, 1e-6),
        ("rk4", {"step": 1e-5}, 1e-6),
    ],
)
def test_a_thrown_weight_makes_its_rope_taut_and_slack(method: str, options: dict[str, float], near: float) -> None:
    """After ``2 v/g``, and again where ``g (1 - cos wt)/w^2 + v sin wt/w = 0``."""
    v = 0.2
    flight, held = 2.0 * v / G, 2.0 / OMEGA * (math.pi - math.atan(v * OMEGA / G))
    result = thrown(v).simulate((0.0, 0.1), method=method, events=["hoist *"], **options)
    taut, slack = result.events["hoist taut"], result.events["hoist slack"]
    assert taut[0] == pytest.approx(flight, abs=near)
    assert slack[0] - taut[0] == pytest.approx(held, abs=near)
    assert taut[1] - slack[0] == pytest.approx(flight, abs=3 * near)
    told = result.load("hoist", "slack") == 1.0
    is_held = [(result.times >= a) & (result.times < b) for a, b in zip(taut, slack, strict=True)]
    assert np.array_equal(told[1:], ~np.any(is_held, axis=0)[1:])


def test_a_run_that_does_not_ask_looks_at_nothing() -> None:
    """Neither from Python nor compiled; the steps are those of a scene without events."""
    model = thrown().freeze()
    assert model.loads[0].events == ()
    assert model.loads[0].kernel.watch is None
    assert model.route.watching.columns == {}
    assert thrown().simulate((0.0, 1.0)).events == {}
    detailed = model.loads[0].in_detail()
    assert detailed.told == ("slack", "taut")
    assert detailed.kernel.watch is not None
    assert model.loads[0].told == ()


def test_what_ropes_do_is_looked_at_in_compiled_code(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, call = [], EventByKernel.__call__
    monkeypatch.setattr(EventByKernel, "__call__", lambda self, t, *at: asked.append(t) or call(self, t, *at))
    result = thrown(breaking_load=1e5).simulate((0.0, 1.0), events=["hoist slack", "hoist taut"])
    assert [len(times) for times in result.events.values()] == [2, 2, 0]
    assert set(asked) <= {0.0}  # loads are checked at the start


def test_a_cable_is_slack_where_its_end_comes_faster_than_the_winch_draws_in() -> None:
    """Its stretch e falls by ``de/dt = -v - (k e - T)/D`` from ``T/k``."""
    T, k, D, v = 100.0, 1e5, 400.0, 0.5
    scene = kf.System()
    cart = scene.add_frame("cart", at=(1, 0, 0), joint=kf.Prismatic("x", motion=kf.Motion.steady(-v)))
    scene.add(kf.Winch("winch", (scene.ground, cart), tension=T, stiffness=k, damping=D, speed=2.0))
    result = scene.simulate((0.0, 0.05), rtol=1e-9, events=["winch slack"])
    assert result.events["winch slack"] == pytest.approx([-D / k * math.log(1.0 - T / (v * D))], abs=1e-9)
    # then it is drawn in at T/D = 0.25 m/s, and stays slack
    assert len(result.events["winch taut"]) == 0


def test_a_rope_that_breaks_is_slack_no_more() -> None:
    """It breaks at the end of its pull: ``v sqrt(k m)`` is 2.8 kN."""
    result = thrown(breaking_load=2000.0).simulate((0.0, 1.0), rtol=1e-9, events=["hoist slack", "hoist taut"])
    assert result.events["hoist taut"] == pytest.approx([TAUT], abs=1e-8)
    assert len(result.events["hoist slack"]) == 0
    # m dv/dt = m g - k x: 2000 N at sin wt = 2000 / (v sqrt(k m)) but for the weight of 20 N, 1 % of that
    breaks = TAUT + math.asin(2000.0 / (SPEED * math.sqrt(2.0 * K))) / OMEGA
    assert result.events["hoist breaks"] == pytest.approx([breaks], abs=2e-5)


def test_a_run_ends_at_an_event_of_a_load() -> None:
    result = thrown().simulate((0.0, 1.0), rtol=1e-9, events=kf.Event("hoist taut", terminal=True))
    assert result.times[-1] == pytest.approx(TAUT, abs=1e-9)
    assert str(result.status).endswith("by the event 'hoist taut'")
    assert result.events["hoist taut"] == pytest.approx([TAUT], abs=1e-9)


def test_an_action_of_the_user_follows_that_of_the_load() -> None:
    """A rope that breaks, and then the weight is caught: it hangs there for good, but for gravity."""

    def caught(t: float, state: kf.SceneState) -> np.ndarray:
        y = state.vector
        assert y[2] == 0.0  # the rope is gone
        y[1] = 0.0
        return y

    caught_at = kf.Event("hoist breaks", action=caught)
    result = thrown(breaking_load=2000.0).simulate((0.0, 0.5), rtol=1e-9, events=caught_at)
    (t,) = result.events["hoist breaks"]
    assert result.velocity("weight")[-1, 2] == pytest.approx(-G * (0.5 - t), rel=1e-9)


def test_a_contact_ends_a_run_too() -> None:
    for normal in (kf.KelvinVoigt(1e6), kf.Rigid(0.5)):
        scene = kf.System(gravity=(0, 0, -G))
        floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
        ball = scene.add_point("ball", 1.0, joint=kf.Prismatic("z", position=0.5))
        scene.add_contact("c", ball, floor, normal=normal)
        result = scene.simulate((0.0, 1.0), rtol=1e-9, events=kf.Event("c touch", terminal=True))
        assert result.times[-1] == pytest.approx(math.sqrt(2.0 * 0.5 / G), abs=1e-8)
        assert result.status.kind == "stopped"
    with pytest.raises(kf.ModelError, match=r"'c touch' is one of a rigid contact.*Remedy: terminal=True"):
        scene.simulate((0.0, 1.0), events=kf.Event("c touch", action=lambda t, state: None))


def test_a_scene_that_is_stepped_asks_as_a_run_does() -> None:
    stopped = thrown().start(events=kf.Event("hoist taut", terminal=True))
    stopped.step(0.6)
    assert stopped.time == pytest.approx(TAUT, abs=1e-6)


def test_states_of_the_start_are_kept() -> None:
    """A rope that is broken at the start stays so in a run that asks for more."""
    scene = thrown(breaking_load=2000.0)
    end = scene.simulate((0.0, 0.5)).at(0.5)
    assert len(scene.simulate((0.5, 0.9), start=end, events=["hoist taut"]).events["hoist taut"]) == 0
    fresh = scene.simulate((0.5, 1.5), events=["hoist taut"])
    assert len(fresh.events["hoist taut"]) == 1


@pytest.mark.parametrize(
    ("events", "message"),
    [
        (["hoist slck"], r"event 'hoist slck' has no function, .* Did you mean 'hoist slack'\? .*: hoist slack"),
        (["* touch"], r"event '\* touch' has no function"),
        ([kf.Event(f"hoist {what}", terminal=True) for what in ("*", "taut")], "'hoist taut' is requested twice"),
        ([3.0], "events must be a list of kanefe.Event or of names of events of loads, not of float"),
    ],
)
def test_what_there_is_not_is_told(events: list[Any], message: str) -> None:
    with pytest.raises(kf.ModelError, match=message):
        thrown().simulate((0.0, 1.0), events=events)


def test_an_event_without_a_function_has_the_direction_of_the_load() -> None:
    with pytest.raises(kf.ModelError, match="event 'hoist slack' is one of a load or contact, which has its direction"):
        kf.Event("hoist slack", direction=1)
    with pytest.raises(kf.ModelError, match=r"no event called 'hoist slack'.*simulate\(events=\['hoist slack'\]\)"):
        thrown().simulate((0.0, 0.1)).events["hoist slack"]
