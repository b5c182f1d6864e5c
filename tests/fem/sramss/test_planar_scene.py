"""SRAMSS-2D: the scene's options; what it must give is in `kanefe verify` (SR1 to SR6)."""

import math

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem.sramss import Deck, from_level, gear_body, level_rest, planar_scene
from kanefe_fem.sramss import parameters as given


def test_the_tubes_are_those_of_the_parameter_set():
    assert pytest.approx(2.786891135e-3, rel=1e-9) == given.AREA
    assert pytest.approx(1.713709871e-6, rel=1e-9) == given.SECOND_MOMENT
    assert given.AIRFRAME_MASS + gear_body().mass == pytest.approx(1544.902791, rel=1e-9)


def test_the_deck_follows_its_formula():
    deck = Deck(amplitude=0.1, span=12.0)
    motion = deck.motion()
    position, acceleration = (motion.at(name, 11.3, "the deck") for name in ("position", "acceleration"))
    w = 0.2 * math.pi
    assert position == pytest.approx(0.1 * math.sin(w * 11.3), abs=1e-12)
    assert acceleration == pytest.approx(-0.1 * w**2 * math.sin(w * 11.3), abs=1e-7)


def test_a_run_begins_at_rest_in_the_middle():
    rest, half = level_rest("hinged")
    scene = planar_scene(saddles="hinged", skids="pinned", half_track=half)
    result = scene.simulate((0.0, 0.5), start=from_level(scene, rest), output_step=0.1)
    assert np.abs(result.joint_coordinates("airframe")[:, 0]).max() < 1e-9
    weight = (given.AIRFRAME_MASS + gear_body("hinged").mass) * given.GRAVITY
    assert result.contact("port skid").normal == pytest.approx(0.5 * weight, rel=1e-8)


@pytest.mark.parametrize("options", [{"saddles": "loose"}, {"skids": "glued"}])
def test_what_there_is_not_is_refused(options):
    with pytest.raises(kf.ModelError, match="are"):
        planar_scene(**options)
