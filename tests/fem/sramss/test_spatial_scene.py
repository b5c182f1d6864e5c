"""The helicopter in space: weight on its shoes, lashings, and a deck that moves."""

import math

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem.mesh_files import read_mesh
from kanefe_fem.sramss import lashing_lengths, spatial, spatial_gear, spatial_scene
from kanefe_fem.sramss import parameters as given
from kanefe_fem.sramss.spatial import SADDLES, SHOES
from repository import ROOT
from result_scenes import beam_arm


@pytest.fixture(scope="module")
def gear():
    return spatial_gear(read_mesh(ROOT / "meshes" / "skid_gear.msh"), modes=8)


def test_the_shoes_carry_the_weight_and_the_lashings(gear):
    lengths = lashing_lengths(gear, 2000.0)
    rest = kf.equilibrium(spatial_scene(gear, lashings=lengths))
    pull = [float(rest.load(f"{name} lashing")[2]) for name in SADDLES]
    assert pull == pytest.approx([2000.0] * 4, rel=1e-8)
    weight = (given.AIRFRAME_MASS + gear.mass) * given.GRAVITY
    normal = sum(float(rest.contact(name).normal) for name in SHOES)
    # each pulls down by its share of the way from the deck to the saddle, near 1 / sqrt(2)
    down = normal - weight
    assert down == pytest.approx(4 * 2000.0 / math.sqrt(2.0), rel=0.02)


def test_lengths_of_lashings_are_found_by_a_few_rests(gear, monkeypatch):
    calls = []

    def counted(scene):
        calls.append(scene)
        return kf.equilibrium(scene)

    monkeypatch.setattr(spatial, "equilibrium", counted)
    lashing_lengths(gear, 2000.0)
    assert len(calls) <= 6  # each of a second; by differences for each length there were 18
    with pytest.raises(kf.ModelError, match="tension of lashings at rest must be above zero N"):
        lashing_lengths(gear, 0.0)


def test_on_a_rolling_deck_friction_holds_what_it_can(gear):
    times = np.linspace(0.0, 6.0, 241)
    angle = math.radians(6.0) * np.sin(np.clip(times / 4.0, 0.0, 1.0) * math.pi / 2.0) ** 4
    turns = [kf.rotation_about("x", a) for a in angle]
    slips = {}
    for mu in (0.3, 0.08):  # tan 6 deg is 0.105
        scene = spatial_scene(gear, kf.PoseTable(times, None, turns), mu=mu)
        result = scene.simulate((0.0, 6.0), start=kf.equilibrium(scene, steady=False).state, rtol=1e-4)
        slips[mu] = [float(result.contact(name).slip[-1]) for name in SHOES]
    assert max(slips[0.3]) == 0.0
    assert min(slips[0.08]) > 0.05


def test_hinged_saddles_let_the_legs_turn(gear):
    """A leg on a hinge gives way by the middle of its cross tube too: more than half as much again."""
    hinged = spatial_gear(read_mesh(ROOT / "meshes" / "skid_gear.msh"), modes=8, saddles="hinged")
    rests = {body: kf.equilibrium(spatial_scene(body, mu=0.0)) for body in (gear, hinged)}
    sunk = [given.CG_HEIGHT - float(rest.position("airframe")[2]) for rest in rests.values()]
    assert 1.5 * sunk[0] < sunk[1]
    with pytest.raises(kf.ModelError, match="saddles are 'fixed' or 'hinged', not 'welded'"):
        spatial_gear(ROOT / "meshes" / "skid_gear.msh", saddles="welded")


def test_a_gear_without_shoes_is_refused():
    with pytest.raises(kf.ModelError, match="no group of points or facets 'aft port saddle'"):
        spatial_scene(beam_arm())


def test_lashings_are_by_saddle(gear):
    with pytest.raises(kf.ModelError, match=r"no saddle 'nose' for a lashing\. There are: aft starboard"):
        spatial_scene(gear, lashings={"nose": 1.0})
