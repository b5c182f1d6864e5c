"""Fields of heights in views: they have the heights of the field, their grid, and low places in the dark."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.views.player.page import page_of
from kanefe.views.relief import relief
from kanefe.views.still import picture_of_run
from player_pages import body_of, placed, read_page

X, Y = np.linspace(-1.0, 1.0, 9), np.linspace(0.0, 1.0, 5)


def hills(heights: np.ndarray, **place: object) -> kf.Result:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_surface("hills", scene.ground, kf.shapes.HeightField(X, Y, heights), **place)
    scene.add_rigid_body("ball", 1.0, 4e-3, joint=kf.Prismatic("z"), at=(0.0, 0.5, 1.0))
    return scene.simulate((0.0, 0.1))


BUMPS = 0.2 * np.sin(4.0 * X)[:, None] * np.cos(3.0 * Y)


def test_the_page_has_the_heights_of_the_field_as_contacts_feel_them():
    told = read_page(page_of(hills(BUMPS)).html)
    (part,) = body_of(told, "ground")["parts"]
    field, points = kf.shapes.HeightField(X, Y, BUMPS), placed(told, part, 0)
    # the nearest place of the surface is the point itself, to single precision
    assert max(abs(field.distance(point)[0]) for point in points) < 1e-6
    assert len(points) > len(X) * len(Y)  # a coarse grid is drawn finer
    for i, x in enumerate(X):
        for j, y in enumerate(Y):
            at = np.argmin(np.linalg.norm(points[:, :2] - (x, y), axis=1))
            np.testing.assert_allclose(points[at], (x, y, BUMPS[i, j]), atol=1e-6)


def test_its_lines_are_those_of_the_grid():
    told = read_page(page_of(hills(BUMPS)).html)
    (part,) = body_of(told, "ground")["parts"]
    ends = placed(told, part, 0)[part["grid"]]
    along_y = ends[..., 0][np.abs(np.diff(ends[..., 0], axis=1)).ravel() < 1e-6]
    along_x = ends[..., 1][np.abs(np.diff(ends[..., 1], axis=1)).ravel() < 1e-6]
    np.testing.assert_allclose(np.unique(along_y.round(5)), X, atol=1e-5)
    np.testing.assert_allclose(np.unique(along_x.round(5)), Y, atol=1e-5)
    assert len(along_x) + len(along_y) == len(ends)
    lengths = np.linalg.norm(np.diff(ends, axis=1)[..., :2], axis=2)
    assert lengths.sum() == pytest.approx(np.ptp(X) * len(Y) + np.ptp(Y) * len(X), rel=1e-5)


@pytest.mark.parametrize("place", [{}, {"at": (3, 2, 1), "orientation": kf.rotation_about("x", 0.7)}])
def test_low_places_are_dark(place):
    result = hills(BUMPS, **place)
    (surface,) = result.surfaces
    light = relief(surface)
    assert (light.min(), light.max()) == (0.0, 1.0)
    told = read_page(page_of(result).html)
    (part,) = body_of(told, "ground")["parts"]
    np.testing.assert_allclose(part["shades"] / 255.0, light, atol=0.5 / 255.0)


def test_a_hump_on_a_slope_is_told_from_the_slope():
    hump = np.zeros((9, 5))
    hump[4, 2] = 0.02
    (surface,) = hills(0.5 * X[:, None] + hump).surfaces
    light = relief(surface)
    top = surface.vertices[np.argmax(light)]
    np.testing.assert_allclose(top[:2], (X[4], Y[2]), atol=0.07)  # to a step of what is drawn
    assert light[np.argmin(surface.vertices[:, 0])] < 0.5


def test_flat_ground_is_light():
    (surface,) = hills(np.full((9, 5), 0.3)).surfaces
    np.testing.assert_allclose(relief(surface), 1.0, rtol=0, atol=1e-13)  # round-off of unit normals
    low = np.full((9, 5), 0.3)
    low[4, 2] -= 1e-3  # m, on 2 m2
    (surface,) = hills(low).surfaces
    assert 0.8 < relief(surface).min() < 0.9


def test_lines_of_surfaces_are_in_files(tmp_path):
    result = hills(BUMPS)
    result.save(tmp_path / "run.h5")
    (first,), (second,) = result.surfaces, kf.load_result(tmp_path / "run.h5").surfaces
    np.testing.assert_array_equal(first.lines, second.lines)
    assert len(first.lines)


def test_stills_shade_fields(monkeypatch):
    seen = []
    monkeypatch.setattr("kanefe.views.still.thumbnail", lambda pieces, up, around: seen.append(pieces) or b"")
    picture_of_run(hills(BUMPS))
    (pieces,) = seen
    shades = [piece.shades for piece in pieces if piece.shades is not None]
    assert len(shades) == 1
    assert (shades[0].min(), shades[0].max()) == (0.5, 1.0)
