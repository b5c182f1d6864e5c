"""Screened runs of the helicopter: in the plane, and in space on the helideck of a ship in a sea."""

import math
from collections.abc import Mapping

import numpy as np
import pytest

import kanefe as kf
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


def check_same(whole: kf.Result, screened: kf.ScreenedRun) -> None:
    """Check that a screened run has the events of the whole one, but for what grazes."""
    wanted, found = beyond_grazing(whole.events), beyond_grazing(screened.events)
    for name, times in wanted.items():
        assert found[name] == pytest.approx(times, abs=SAME_TIME), name


def beyond_grazing(events: Mapping[str, np.ndarray]) -> dict[str, list[float]]:
    """Return the times of events without those that the opposite ones follow before both are known apart.

    A slip of a few ms, or a stick between two, comes and goes with the last digits of a run.
    """
    found: dict[str, list[float]] = {name: list(times) for name, times in events.items()}
    for kind, opposite in (("slip", "stick"), ("touch", "lift")):
        for name in (name.removesuffix(kind) for name in events if name.endswith(f" {kind}")):
            both = sorted((t, name + which) for which in (kind, opposite) for t in events[name + which])
            i = 0
            while i < len(both) - 1:
                if both[i + 1][0] - both[i][0] < 2.0 * SAME_TIME:
                    for t, of in (both.pop(i), both.pop(i)):
                        found[of].remove(t)
                    i = max(i - 1, 0)
                else:
                    i += 1
    return found


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
    assert sum(map(len, beyond_grazing(whole.events).values())) > 100  # 150 of 154
    check_same(whole, screened)
    assert 0.0 < screened.share < 0.9


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
