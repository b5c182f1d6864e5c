"""A probe in a trap: it holds the aircraft in the plane of the deck, behind its play."""

import math

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem.mesh_files import read_mesh
from kanefe_fem.sramss import add_probe, spatial_gear, spatial_scene
from repository import ROOT

GAP, SLOPE, ICE = 0.01, math.radians(5.0), 0.02


@pytest.fixture(scope="module")
def gear():
    return spatial_gear(read_mesh(ROOT / "meshes" / "skid_gear.msh"), modes=4)


def slid(gear, spot):
    """Return a run on a deck that tilts about x and stays so, at a spot of it."""
    times = np.linspace(0.0, 4.0, 161)
    x = np.clip(times / 2.0, 0.0, 1.0)
    turns = [kf.rotation_about("x", a) for a in SLOPE * x**3 * (10.0 - 15.0 * x + 6.0 * x**2)]
    scene = spatial_scene(gear, kf.PoseTable(times, None, turns), mu=ICE, at=spot)
    name = add_probe(scene, gap=GAP, at=spot)
    start = kf.equilibrium(scene, steady=False).state
    return name, scene.simulate((0.0, 4.0), start=start, rtol=1e-5, output_step=0.02)


@pytest.mark.parametrize("spot", [(0.0, 0.0), (3.0, -2.0)])
def test_the_probe_holds_what_friction_does_not(gear, spot):
    name, result = slid(gear, spot)
    assert name == "probe"
    assert len(result.events["probe touch"]) > 0
    pushed = result.contact("probe")
    # what weighs across the deck, less what rubs: it creeps to that
    weight = 9.81 * (1500.0 + gear.mass)
    rubs = ICE * weight * math.cos(SLOPE)
    late = result.times > 3.0
    mean = float(pushed.normal[late].mean())
    assert weight * math.sin(SLOPE) - 1.1 * rubs < mean < weight * math.sin(SLOPE) + 1.1 * rubs
    assert float(pushed.penetration.max()) < 0.01


def test_wrong_numbers_and_scenes_are_refused(gear):
    with pytest.raises(kf.ModelError, match="gap of a probe in its trap must be above zero m"):
        add_probe(spatial_scene(gear), gap=0.0)
    with pytest.raises(kf.ModelError, match="stiffness"):
        add_probe(spatial_scene(gear), stiffness=-1.0)
    with pytest.raises(kf.ModelError, match="airframe"):
        add_probe(kf.System())
