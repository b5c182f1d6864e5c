"""Screened runs of the helicopter: in the plane, and in space on the helideck of a ship in a sea."""

import math

import numpy as np

import kanefe as kf
from kanefe.screening.sticking import Sticking
from kanefe_fem.mesh_files import read_mesh
from kanefe_fem.sramss import (
    Deck,
    from_level,
    level_rest,
    planar_scene,
    resting_on,
    spatial_gear,
    spatial_scene,
)
from repository import ROOT

SAME_TIME = 5e-3
"""s: what runs at rtol 1e-5 differ by where a skid creeps to its limit."""


GRAZING = 0.02
"""s: a slip, or a stick between two, that is shorter comes and goes with the last digits of a run."""

OPPOSITE = {"slip": "stick", "stick": "slip", "touch": "lift", "lift": "touch"}


def check_same(whole: kf.Result, screened: kf.ScreenedRun) -> None:
    """Check that a screened run has the events of the whole one; what one of them has alone may only graze."""
    runs = whole.events, screened.events
    count, alone = 0, 0
    for name in whole.events:
        for one, other in (runs, runs[::-1]):
            for t in one[name]:
                count += 1
                if _nearest(other[name], t) < SAME_TIME:
                    continue
                alone += 1
                contact, _, kind = name.rpartition(" ")
                assert _nearest(one[f"{contact} {OPPOSITE[kind]}"], t) < GRAZING, f"{name} at {t} s"
    assert alone <= 0.05 * count


def _nearest(times: np.ndarray, t: float) -> float:
    """Return how far the nearest of some times is from t, s."""
    return float(np.abs(times - t).min(initial=np.inf))


def test_events_in_the_plane() -> None:
    rest, _ = level_rest()
    scene = planar_scene(Deck(amplitude=math.radians(7.6), span=12.0), skids="rough", mu=0.15)
    options = {"start": from_level(scene, rest), "rtol": 1e-5, "output_step": 1.0}
    whole, screened = scene.simulate((0.0, 12.0), **options), kf.screen(scene, 12.0, **options)
    assert len(whole.events["port skid slip"]) > 0
    check_same(whole, screened)
    assert screened.share < 0.9


def test_dry_skids_ask_for_no_window() -> None:
    rest, _ = level_rest("hinged")
    scene = planar_scene(Deck(amplitude=math.radians(8.0)), saddles="hinged", skids="rough", mu=0.3)
    screened = kf.screen(scene, 30.0, start=from_level(scene, rest), output_step=2.5)
    assert screened.windows == ()
    whole = scene.simulate((0.0, 30.0), start=from_level(scene, rest), rtol=1e-7, output_step=2.5)
    np.testing.assert_allclose(
        screened.result.contact("port skid").tangential, whole.contact("port skid").tangential, atol=0.1, rtol=0
    )


def test_events_on_a_helideck() -> None:
    gear, span, mu = spatial_gear(read_mesh(ROOT / "meshes" / "skid_gear.msh"), modes=8), 30.0, 0.3
    rest = kf.equilibrium(spatial_scene(gear, mu=mu))
    ship = kf.Ship(kf.example_rao(), kf.Sea.state(6, spreading=2, seed=1), heading_deg=90.0)
    motion = ship.at((-45.0, 0.0, 6.0), duration=span, ramp=10.0)
    scene = spatial_scene(gear, motion, mu=mu)
    options = {"start": resting_on(scene, rest, motion), "rtol": 1e-6, "output_step": 3.0}
    whole, screened = scene.simulate((0.0, span), **options), kf.screen(scene, span, **options)
    assert sum(map(len, whole.events.values())) > 100
    check_same(whole, screened)
    assert 0.0 < screened.share < 0.9


def test_what_is_superposed_is_within_its_bound_where_a_ramp_ends() -> None:
    gear, span, mu = spatial_gear(read_mesh(ROOT / "meshes" / "skid_gear.msh"), modes=8), 20.0, 0.8
    rest = kf.equilibrium(spatial_scene(gear, mu=mu))
    ship = kf.Ship(kf.example_rao(), kf.Sea.state(4, spreading=2, seed=1), heading_deg=90.0)
    for ramp in (5.0, 10.0):
        motion = ship.at((-45.0, 0.0, 6.0), duration=span, ramp=ramp)
        scene = spatial_scene(gear, motion, mu=mu)
        options = {"start": resting_on(scene, rest, motion), "output_step": 0.05}
        whole, screened = scene.simulate((0.0, span), rtol=1e-8, **options), kf.screen(scene, span, **options)
        assert screened.windows == ()
        model = scene.freeze(0.0, options["start"])
        sticking = Sticking(model)
        watched = [sticking.watched(model, result.times, result.run.states) for result in (whole, screened.result)]
        bound = np.array([screened.bound[name] for name in sticking.names])
        ratio = (np.abs(watched[0] - watched[1]) / bound).max()
        assert 0.1 < ratio < 1.0  # 2.3 by splines that end a piece where the ramp ends, and without the start


def test_the_aircraft_starts_at_rest_on_a_deck_that_moves_already() -> None:
    gear = spatial_gear(read_mesh(ROOT / "meshes" / "skid_gear.msh"), modes=8)
    rest = kf.equilibrium(spatial_scene(gear))
    times = np.linspace(0.0, 1.0, 21)
    turns = [kf.euler_angles("xyz", (0.05 + 0.1 * t, 0.02 * t, 0.3)) for t in times]
    motion = kf.PoseTable(times, np.column_stack((0.5 * times, 2.0 + 0.0 * times, 0.2 * times)), turns)
    scene = spatial_scene(gear, motion)
    model = scene.freeze(0.0, resting_on(scene, rest, motion))
    deck, airframe = (model.kinematics(name, 0.0, model.initial_state) for name in ("deck", "airframe"))
    arm = deck.rotation.T @ (airframe.position - deck.position)
    np.testing.assert_allclose(arm, rest.position("airframe"), atol=1e-12)
    back = deck.rotation.T @ airframe.rotation
    np.testing.assert_allclose(back @ airframe.angular_velocity, deck.angular_velocity, atol=1e-12)
    carried = deck.velocity + np.cross(deck.angular_velocity, arm)
    np.testing.assert_allclose(back @ airframe.velocity, carried, atol=1e-12)
