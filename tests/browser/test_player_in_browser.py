"""Pages of runs in headless Chromium: they draw, are where the run is, obey their controls and look as they did.

`make docs` brings Debian's chromium and playwright and runs this; ``python tests/browser/test_player_in_browser.py``
makes the stored picture anew.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from shutil import which
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.frames import rotation_matrix
from kanefe.views.player.page import page_of
from kanefe.views.player.skins import skin_of
from repository import ROOT
from result_scenes import beam_arm

pytestmark = pytest.mark.browser

PICTURE = ROOT / "tests" / "browser" / "arm_on_a_floor.png"
SIZE = {"width": 640, "height": 440}
MIDDLE = 0.2  # s
MOST_APART = 0.02  # of the brightness, the mean over all pixels: fonts and edges differ from machine to machine
OPTIONS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox", "--force-device-scale-factor=1"]


@cache
def arm_on_a_floor() -> kf.Result:
    """A flexible arm that swings down from a hinge, and a ball that bounces beside it."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    hub = scene.add_rigid_body("hub", mass=1.0, inertia=0.01, joint=kf.Revolute("y"), at=(0, 0, 0.6))
    arm = scene.add_flexible_body("arm", beam_arm(), parent=hub, at=(0.05, 0, 0))
    scene.add_rigid_body("tip", mass=0.3, inertia=5e-4, parent=arm.interface("tip"))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"), at=(0, 0, -0.7))
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=kf.Free(position=(0.5, -0.4, -0.5)))
    shell = scene.add_surface("shell", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("drop", shell, floor, normal=kf.KelvinVoigt(1e4, damping=40.0))
    return scene.simulate((0.0, 0.4), output_step=0.01)


@cache
def sled_on_a_road() -> kf.Result:
    """A sled that slides 60 m along a road with low waves, with a loose rope of 1 m behind it."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    x, y = np.linspace(-2.0, 98.0, 101), np.linspace(-2.0, 2.0, 5)
    heights = 0.05 * np.sin(x)[:, None] * np.ones(5)
    scene.add_surface("road", scene.ground, kf.shapes.HeightField(x, y, heights), at=(0, 0, -0.6))
    sled = scene.add_rigid_body("sled", 1.0, 1 / 6, joint=kf.Prismatic("x", speed=60.0))
    log = scene.add_rigid_body("log", 1.0, 0.01, at=(-1.5, 0, -0.3), joint=kf.Prismatic("x", speed=60.0))
    eye = sled.frame(at=(0, 0, -0.3))
    scene.add(kf.Rope("rope", (sled, eye, log), axial_stiffness=1e4, length=2.0))
    return scene.simulate((0.0, 1.0), output_step=0.02)


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=which("chromium"), args=OPTIONS)
        yield browser
        browser.close()


@pytest.fixture
def page(chromium: Any, tmp_path: Path) -> Iterator[Any]:
    """The page of the run, halt at the middle of it; anything that it asks of a network fails the test."""
    yield from opened(chromium, tmp_path)


def opened(chromium: Any, folder: Path, result: kf.Result | None = None, address: str = "") -> Iterator[Any]:
    path = (result or arm_on_a_floor()).to_html(folder / "run.html")
    tab = chromium.new_page(viewport=SIZE)
    faults: list[str] = []
    tab.on("pageerror", lambda error: faults.append(str(error)))
    tab.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
    tab.on("request", lambda request: None if request.url.startswith("file:") else faults.append(request.url))
    tab.goto(f"{path.as_uri()}#t={MIDDLE}{address}")
    tab.wait_for_selector("html[data-drawn]", state="attached", timeout=20_000)
    yield tab
    assert faults == []
    tab.close()


def pixels(png: bytes) -> np.ndarray:
    from matplotlib.image import imread

    return np.asarray(imread(io.BytesIO(png)))[:, :, :3]


def test_it_draws(page: Any) -> None:
    assert page.locator("#message").is_hidden()
    drawn = pixels(page.screenshot())
    page.evaluate("document.getElementById('canvas').style.visibility = 'hidden'")
    empty = pixels(page.screenshot())
    assert (np.abs(drawn - empty).max(axis=2) > 0.1).mean() > 0.03


def test_nodes_are_where_the_run_has_them(page: Any) -> None:
    result = arm_on_a_floor()
    frame = int(np.abs(result.times - MIDDLE).argmin())
    shape, skin = result.body("arm"), skin_of(result.body("arm"))
    local = skin.points + skin.motion(shape, result.modal_coordinates("arm")[[frame]])[0]
    there = result.position("arm")[frame] + local @ rotation_matrix(result.rotation("arm")[frame]).T
    shown = np.reshape(page.evaluate("kanefe.positions('arm')"), (-1, 3))
    largest = np.abs(result.nodal_displacements("arm")).max()
    assert np.abs(shown - there).max() < 1e-3 * largest


def test_between_output_times_rotations_go_round(page: Any) -> None:
    page.evaluate(f"kanefe.setTime({MIDDLE + 0.005})")
    page.wait_for_selector(f"html[data-time='{MIDDLE + 0.005}']", state="attached")
    shown = np.reshape(page.evaluate("kanefe.positions('hub')"), (-1, 3))
    # a box keeps its size however it turns: a mean of two rotations as matrices would shrink it
    sides = np.linalg.norm(shown[[1, 3, 4]] - shown[0], axis=1)
    np.testing.assert_allclose(sides, np.sqrt(6.0 * 0.01), rtol=1e-5)


def test_the_slider_moves_the_run(page: Any) -> None:
    before = page.screenshot(clip={"x": 0, "y": 0, "width": 420, "height": 380})
    page.locator("#time").fill("0.9")
    page.wait_for_selector("html[data-time^='0.36']", state="attached")
    assert page.locator("#clock").inner_text().startswith("0.360")
    after = page.screenshot(clip={"x": 0, "y": 0, "width": 420, "height": 380})
    assert (np.abs(pixels(after) - pixels(before)).max(axis=2) > 0.1).mean() > 0.01


def test_it_plays_and_halts(page: Any) -> None:
    page.locator("#play").click()
    page.wait_for_selector(f"html:not([data-time='{MIDDLE}'])", state="attached")
    page.locator("#play").click()
    assert not page.evaluate("kanefe.clock.isPlaying")


def test_bodies_and_colours_come_and_go(page: Any) -> None:
    page.evaluate("document.getElementById('names').style.display = 'none'")
    clip = {"x": 0, "y": 0, "width": 420, "height": 300}

    def changed(before: bytes) -> float:
        return float((np.abs(pixels(page.screenshot(clip=clip)) - pixels(before)).max(axis=2) > 0.05).mean())

    shown = page.screenshot(clip=clip)
    page.locator("#colour").select_option("none")
    assert page.locator("#bar").is_hidden()
    assert changed(shown) > 0.002
    page.locator("#colour").select_option("displacement")
    assert page.locator("#bar").is_visible()
    page.get_by_label("arm", exact=True).uncheck()
    assert changed(shown) > 0.005
    page.get_by_label("arm", exact=True).check()
    page.wait_for_timeout(100)
    assert changed(shown) < 1e-3


def at(tab: Any, t: float) -> np.ndarray:
    """Return what the eye looks at, at a time."""
    tab.evaluate(f"kanefe.setTime({t})")
    tab.wait_for_selector(f"html[data-time='{t}']", state="attached")
    return np.array(tab.evaluate("kanefe.target()"))


def test_the_eye_goes_with_what_travels_until_it_is_told_not_to(chromium: Any, tmp_path: Path) -> None:
    for tab in opened(chromium, tmp_path, sled_on_a_road()):
        clip = {"x": 0, "y": 60, "width": 420, "height": 320}
        sled = (np.ptp(pixels(tab.screenshot(clip=clip)), axis=2) > 0.1).mean()
        assert sled > 0.1  # of all the road it was a speck
        np.testing.assert_allclose(at(tab, 0.75) - at(tab, 0.25), (30.0, 0.0, 0.0), atol=1e-4)
        tab.locator("#follow").select_option(label="nothing")
        np.testing.assert_array_equal(at(tab, 0.75), at(tab, 0.25))
        assert (np.ptp(pixels(tab.screenshot(clip=clip)), axis=2) > 0.1).mean() < 0.1 * sled
        tab.locator("#follow").select_option(label="sled")
        np.testing.assert_allclose(at(tab, 0.75) - at(tab, 0.25), (30.0, 0.0, 0.0), atol=1e-4)
        tab.locator("#follow").select_option(label="what travels")
        tab.evaluate("document.querySelector('[data-view=y]').click()")
        np.testing.assert_allclose(at(tab, 0.75) - at(tab, 0.25), (30.0, 0.0, 0.0), atol=1e-4)


def test_the_address_says_what_is_followed(chromium: Any, tmp_path: Path) -> None:
    for tab in opened(chromium, tmp_path, sled_on_a_road(), "&follow=nothing"):
        assert tab.locator("#follow option:checked").inner_text() == "nothing"
        np.testing.assert_array_equal(at(tab, 0.75), at(tab, 0.25))


def test_a_loose_rope_is_dashed(chromium: Any, tmp_path: Path) -> None:
    for tab in opened(chromium, tmp_path, sled_on_a_road()):
        assert tab.evaluate("kanefe.rods()") > 2  # of one that pulls a rod for each of its two parts
        tab.get_by_label("springs, ropes").uncheck()


def test_it_looks_as_it_did(page: Any) -> None:
    page.mouse.move(5, 5)
    apart = np.abs(pixels(page.screenshot()) - pixels(PICTURE.read_bytes()))
    assert apart.mean() < MOST_APART


def test_a_page_in_a_notebook_runs_in_its_frame(chromium: Any, tmp_path: Path) -> None:
    frame = page_of(arm_on_a_floor())._repr_html_()
    (tmp_path / "cell.html").write_text(f"<!doctype html><body>{frame}</body>", encoding="utf-8")
    tab = chromium.new_page(viewport=SIZE)
    tab.goto((tmp_path / "cell.html").as_uri())
    inner = tab.frame_locator("iframe")
    inner.locator("html[data-drawn]").wait_for(state="attached", timeout=20_000)
    assert inner.locator("#bodies input").count() == 5
    tab.close()


if __name__ == "__main__":
    import tempfile

    from playwright.sync_api import sync_playwright

    with sync_playwright() as play, tempfile.TemporaryDirectory() as name:
        for tab in opened(play.chromium.launch(executable_path=which("chromium"), args=OPTIONS), Path(name)):
            tab.screenshot(path=PICTURE)
