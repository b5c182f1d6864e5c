"""Chocks round skids: they carry what pulls along the deck, behind their gap, and a skid that lifts gets over them."""

import math

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem.mesh_files import read_mesh
from kanefe_fem.sramss import add_chocks, spatial_gear, spatial_scene, wheeled_scene
from kanefe_fem.sramss import parameters as given
from kanefe_fem.sramss.chocks import HEIGHT
from repository import ROOT

SLOPE, GAP = math.radians(8.0), 0.004


@pytest.fixture(scope="module")
def gear():
    return spatial_gear(read_mesh(ROOT / "meshes" / "skid_gear.msh"), modes=8)


def on_a_slope(gear, axis, angle):
    """The aircraft without friction on a deck that is turned about an axis, and stays."""
    turns = [kf.rotation_about(axis, angle)] * 5
    return spatial_scene(gear, kf.PoseTable(np.linspace(0.0, 2.0, 5), None, turns), mu=0.0)


@pytest.mark.parametrize("angle", [SLOPE, -SLOPE])
@pytest.mark.parametrize("axis", ["x", "y"])
def test_they_carry_the_weight_along_the_slope(gear, axis, angle):
    """On ``W sin(slope)`` in all: without friction nothing else acts along the deck."""
    scene = on_a_slope(gear, axis, angle)
    names = add_chocks(scene, gap=GAP)
    rest = kf.equilibrium(scene, steady=False)
    along = (given.AIRFRAME_MASS + gear.mass) * given.GRAVITY * math.sin(abs(angle))
    # bow down by a turn about +y, starboard down by one about +x; the gear sits down and spreads against both outboard
    # chocks, so that there it is their difference
    ways = {"x": ("starboard", "port"), "y": ("forward", "aft")}[axis]
    low, high = ways if angle > 0.0 else ways[::-1]
    own = [name for name in names if ("outboard" in name) == (axis == "x")]
    held = [sum(float(rest.contact(name).normal) for name in own if way in name) for way in (low, high)]
    # what the search for the equilibrium leaves over
    assert held[0] - held[1] == pytest.approx(along, rel=1e-8)
    if axis == "y":
        assert held[1] == 0.0


def test_they_meet_the_skid_behind_their_gap(gear):
    """Without friction it starts with ``g sin(slope)``; on its gear, which sits down meanwhile, to 1e-5 at first."""
    scene = on_a_slope(gear, "y", SLOPE)
    add_chocks(scene, gap=GAP)
    found = scene.simulate((0.0, 0.1), rtol=1e-6).events["port chock forward touch"]
    assert found[0] == pytest.approx(math.sqrt(2.0 * GAP / (given.GRAVITY * math.sin(SLOPE))), rel=1e-4)


@pytest.mark.parametrize("height", [0.0, HEIGHT + 0.06])
def test_a_skid_that_lifts_gets_over_them(gear, height):
    """In 0.1 s it falls by 0.049 m, and is 0.1 m further forward: into the block, or over it."""
    scene = spatial_scene(gear, mu=0.0)
    add_chocks(scene, gap=GAP)
    model = scene.freeze()
    start = model.initial_state.copy()
    start[model.state_names.index("airframe: z [m]")] += height
    start[model.state_names.index("airframe: vx [m/s]")] = 1.0
    result = scene.simulate((0.0, 0.1), start=start, rtol=1e-5)
    assert (len(result.events["port chock forward touch"]) > 0) == (height == 0.0)


@pytest.mark.parametrize("wrong", [{"gap": -1e-3}, {"gap": math.nan}, {"stiffness": 0.0}])
def test_numbers_that_make_no_sense_are_refused(gear, wrong):
    (name,) = wrong
    with pytest.raises(kf.ModelError, match=f"{name} of chocks must be"):
        add_chocks(spatial_scene(gear), **wrong)


def test_wheels_have_chocks_of_their_own():
    with pytest.raises(kf.ModelError, match="'gear'"):
        add_chocks(wheeled_scene())
