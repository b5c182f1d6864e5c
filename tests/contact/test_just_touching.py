"""What just touches as a run begins: whether it does is round-off there, and must not be asked of each step anew."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes

REACH = 0.1
MU, G = 0.3, 9.81


def sliding(shape: str, degrees: float, at: tuple[float, float, float] = (1.3, -2.1, 0.7)) -> kf.System:
    """Return what slides on a slope, from where it just touches; its coordinates in N are no round numbers."""
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    scene = kf.System(gravity=(0.0, 0.0, -G))
    root = scene.ground.frame(at=at, orientation=np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]))
    floor = scene.add_surface("floor", root, shapes.Plane("z"))
    joint = kf.Free(position=(0.0, 0.0, REACH), velocity=(2.0, 0.5, 0.0))
    block = scene.add_rigid_body("block", 2.0, 0.008, parent=root, joint=joint)
    if shape == "ball":
        touching = scene.add_surface("skin", block, shapes.Sphere(REACH))
    elif shape == "box":
        touching = scene.add_surface("skin", block, shapes.Box((2 * REACH,) * 3))
    else:
        touching = [block.frame(at=(x, y, -REACH)) for x in (-REACH, REACH) for y in (-REACH, REACH)]
    friction = kf.Coulomb(MU, stiffness=1e6, damping=2e3)
    scene.add_contact("c", touching, floor, normal=kf.HuntCrossley(2e5, damping=0.5), friction=friction)
    return scene


@pytest.mark.parametrize("shape", ["ball", "box", "feet"])
@pytest.mark.parametrize(
    ("degrees", "span"), [(5.9, 0.3), (11.743589743589743, 0.3), (31.23076923076923, 0.3), (22.0, 1.0)]
)
def test_what_starts_to_slide_where_it_just_touches_goes_on(shape, degrees, span):
    """The sign of its depth is round-off for 1e-8 s: no event is told of that, and no step is short for it."""
    result = sliding(shape, degrees).simulate((0.0, span), rtol=1e-8)
    assert result.status.is_finished, str(result.status)
    early = [name for name, times in result.events.items() if np.any(np.asarray(times) < 1e-6)]
    assert not early


@pytest.mark.parametrize("shape", ["ball", "box", "feet"])
@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
def test_a_block_that_slides_on_a_level_floor_is_not_told_to_stick(shape, rtol):
    """It slides with 2 m/s from the first instant on, and is nowhere near to rest."""
    result = sliding(shape, 0.0, at=(0.0, 0.0, 0.0)).simulate((0.0, 0.02), rtol=rtol)
    assert result.status.is_finished
    assert not any(len(result.events[f"c {what}"]) for what in ("lift", "slip", "stick"))
