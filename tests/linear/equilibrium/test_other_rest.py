"""Near tipping an equilibrium on contacts tells that another rest is near."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import kanefe as kf
from kanefe.linear.equilibrium.other_rest import OtherRestWarning, other_rest

FEET = [(x, y) for x in (-0.5, 0.5) for y in (-0.3, 0.3)]


def box(tilt: float, normal: kf.Rigid | kf.HuntCrossley, *, apart: bool = True) -> kf.System:
    """A box of 10 kg, as high as wide, on a slope that would tip it beyond 45 degrees; feet apart or in one contact."""
    scene = kf.System(gravity=(9.81 * np.sin(tilt), 0.0, -9.81 * np.cos(tilt)))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    body = scene.add_rigid_body("box", 10.0, 0.5, joint=kf.Free(position=(0, 0, 0.5)))
    friction = kf.Coulomb(3.0)
    if apart:
        for i, (x, y) in enumerate(FEET):
            scene.add_contact(f"foot {i}", body.frame(at=(x, y, -0.5)), floor, normal=normal, friction=friction)
    else:
        soles = scene.add_surface(
            "feet", body, kf.shapes.Points([(x, y, -0.5) for x, y in (*FEET, (-0.5, 0), (0.5, 0))])
        )
        scene.add_contact("sole", soles, floor, normal=normal, friction=friction)
    return scene


@pytest.mark.parametrize(("normal", "apart"), [(kf.Rigid(), False), (kf.HuntCrossley(1e6), True)])
def test_a_box_tells_how_far_it_is_from_tipping(normal: kf.Rigid | kf.HuntCrossley, apart: bool) -> None:
    with pytest.warns(OtherRestWarning, match="another equilibrium is near"):
        near = kf.equilibrium(box(np.deg2rad(43.0), normal, apart=apart))
    assert near.other_rest is not None
    assert near.other_rest.contacts == (("foot 0", "foot 1") if apart else ("sole",))
    # two degrees to go, by which the centre moves by up to 1.4 lengths of the scene
    assert np.deg2rad(1.9) < near.other_rest.distance < 1.45 * np.deg2rad(2.0)
    assert "another equilibrium is near" in str(near)
    with warnings.catch_warnings():
        warnings.simplefilter("error", OtherRestWarning)
        assert kf.equilibrium(box(np.deg2rad(20.0), normal, apart=apart)).other_rest is None


@pytest.mark.parametrize("what", ["box", "ball", "turntable"])
def test_what_stood_and_has_turned_over_is_told_and_what_rolls_or_turns_is_not(what: str) -> None:
    """A search from near tipping may end upside down, where the same feet carry."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    body = scene.add_rigid_body("body", 10.0, 0.5, joint=kf.Free(position=(0, 0, 0.5)))
    normal = kf.HuntCrossley(1e6)
    if what == "ball":
        scene.add_contact("ball", scene.add_surface("round", body, kf.shapes.Sphere(0.5)), floor, normal=normal)
    else:
        feet = scene.add_surface("feet", body, kf.shapes.Points([(x, y, -0.5) for x, y in FEET]))
        scene.add_contact("feet", feet, floor, normal=normal)
    model = scene.freeze()
    q = model.initial_coordinates.copy()
    q[:3], q[3:] = (0.0, 0.0, 0.5), (0.0, 1.0, 0.0, 0.0)  # half a turn about x
    if what == "box":
        q[2] = -0.5 - 1e-4
    elif what == "turntable":
        q[3:] = (0.0, 0.0, 0.0, 1.0)
    found = other_rest(model, 0.0, q, np.zeros(6), model)
    assert (found is not None) == (what == "box")
    if found is not None:
        assert found.turned == pytest.approx(np.pi)
        assert "'feet' carried at the start has turned over, by 180 degrees" in str(found)
