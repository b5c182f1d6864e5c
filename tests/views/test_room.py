"""What the first view of a run holds: what moves, and where it travels the room about it."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.views import thumbnail
from kanefe.views.player.page import page_of
from kanefe.views.player.room import Room, room_of
from kanefe.views.player.skins import skin_of
from kanefe.views.player.tracks import Tracks
from kanefe.views.still import GROUND, picture_of_run
from player_pages import read_page
from png_files import read_png
from result_scenes import four_bar, pendulum, robot

SIDE = 1.0  # m, of the boxes that move
INERTIA = SIDE**2 / 6.0


def room(result: kf.Result) -> Room:
    frames = np.arange(len(result.times))
    skins = {name: skin_of(result.body(name)) for name in result.bodies if result.body(name).is_flexible}
    return room_of(result, Tracks(result, frames), skins, result.load_lines(frames))


def sleds(*speeds: float, road: float = 100.0, joint: str = "x") -> kf.Result:
    """Boxes that slide beside each other on a road with low waves."""
    scene = kf.System()
    x, y = np.linspace(-2.0, road - 2.0, 101), np.linspace(-2.0, 2.0, 5)
    heights = 0.02 * np.sin(x)[:, None] * np.ones(5)
    scene.add_surface("road", scene.ground, kf.shapes.HeightField(x, y, heights), at=(0, 0, -0.6))
    for number, speed in enumerate(speeds):
        box = {"at": (0.0, 1.5 * number, 0.0), "joint": kf.Prismatic(joint, speed=speed)}
        scene.add_rigid_body(f"sled {number}", 1.0, INERTIA, **box)
    return scene.simulate((0.0, 1.0), output_step=0.02)


def test_the_view_goes_with_what_travels():
    found = room(sleds(60.0, 60.0))
    assert found.path is not None
    np.testing.assert_allclose(found.path[:, 0], np.linspace(0.0, 60.0, 51), atol=1e-9)
    np.testing.assert_array_equal(np.ptp(found.path[:, 1:], axis=0), 0.0)
    np.testing.assert_allclose(found.about.high - found.about.low, (SIDE, SIDE + 1.5, SIDE), rtol=1e-9)
    # a road of 100 m is in the view of all of it
    assert found.is_whole
    assert (found.box.high - found.box.low)[0] == pytest.approx(100.0)
    assert found.size == pytest.approx(np.linalg.norm((SIDE, SIDE + 1.5, SIDE)))
    np.testing.assert_allclose(found.around(50).mean(axis=0), found.path[50], atol=1e-9)


def test_a_road_much_longer_than_the_way_is_not_in_view():
    found = room(sleds(60.0, road=2000.0))
    assert not found.is_whole
    np.testing.assert_allclose((found.box.high - found.box.low)[0], 60.0 + SIDE, rtol=1e-9)


def test_the_view_stays_where_little_is_passed_through():
    assert room(sleds(2.0)).path is None
    assert room(pendulum()).path is None
    assert room(robot()).path is None
    assert room(four_bar()).path is None


def test_the_view_stays_where_bodies_part():
    assert room(sleds(60.0, -60.0)).path is None
    assert room(sleds(60.0, 0.0)).path is not None  # one that stands is left behind


def test_only_far_ways_are_followed():
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    start = kf.Free(position=(0.0, 0.0, 0.0), velocity=(10.0, 0.0, 1.0))
    scene.add_rigid_body("stone", 1.0, INERTIA, joint=start)
    result = scene.simulate((0.0, 0.5), output_step=0.01)  # so few that it is looked at all
    assert np.ptp(result.position("stone")[:, 2]) > 0.2
    found = room(result)
    np.testing.assert_array_equal(np.ptp(found.path[:, 1:], axis=0), 0.0)
    assert np.ptp(found.path[:, 0]) == pytest.approx(5.0)
    assert found.about.high[2] - found.about.low[2] == pytest.approx(SIDE + np.ptp(result.position("stone")[:, 2]))


def test_of_a_scene_at_rest_all_is_in_view():
    found = room(sleds(0.0))
    assert found.path is None
    assert found.is_whole
    assert (found.box.high - found.box.low)[0] == pytest.approx(100.0)


def test_points_without_size_are_not_followed():
    scene = kf.System()
    scene.add_point("mass", 1.0, joint=kf.Prismatic("x", speed=1.0))
    found = room(scene.simulate((0.0, 1.0)))
    assert found.path is None
    assert found.size == pytest.approx(1.0)


def test_a_rope_that_moves_is_in_view():
    scene = kf.System()
    hook = scene.add_point("hook", 1.0, at=(0, 0, -1), joint=kf.Prismatic("x", speed=1.0))
    scene.add(kf.Rope("rope", (scene.ground.frame(at=(0, 0, 4)), hook), axial_stiffness=1e3, length=9.0))
    found = room(scene.simulate((0.0, 1.0)))
    assert found.box.high[2] == pytest.approx(4.0)
    assert found.path is None


def test_the_page_is_told_where_to_look():
    result = sleds(60.0)
    told, found = read_page(page_of(result).html), room(result)
    np.testing.assert_allclose(told["travel"]["p"] + told["origin"], found.path, atol=1e-5)  # single precision
    np.testing.assert_allclose(told["travel"]["high"], found.about.high, rtol=1e-9)
    np.testing.assert_allclose(np.add(told["low"], told["origin"]), found.box.low, atol=1e-9)
    assert told["size"] == pytest.approx(found.size)
    assert told["reach"] == pytest.approx(found.box.size)
    assert "travel" not in read_page(page_of(pendulum()).html)


def test_a_still_is_of_what_travels():
    image = read_png(picture_of_run(sleds(60.0)))
    is_ground = np.ptp(image[..., :3].astype(int), axis=2) < 30
    is_box = (image[..., 3] > 0) & ~is_ground
    assert is_box.mean() > 0.15  # of the whole road it was less than one pixel of a thousand


def test_large_triangles_are_cut_for_a_small_view():
    far = 1e4
    ground = thumbnail.Piece(
        np.array([(-far, -far, 0.0), (far, -far, 0.0), (far, far, 0.0), (-far, far, 0.0)]),
        np.array([(0, 1, 2), (0, 2, 3)]),
        np.array([(0, 1)]),
        GROUND,
    )
    around = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    image = read_png(thumbnail.thumbnail([ground], around=around))
    assert image.shape[:2] == thumbnail.SIZE[::-1]
    assert (image[..., 3] == 255).all()  # it fills the picture, without gaps


def test_a_view_in_which_nothing_is_becomes_that_of_all():
    ball = thumbnail.Piece(np.eye(3), np.array([(0, 1, 2)]), np.zeros((0, 2), dtype=int), GROUND)
    assert thumbnail.thumbnail([ball], around=np.eye(3) + 50.0) == thumbnail.thumbnail([ball])
