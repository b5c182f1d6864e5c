"""The page of a study in headless Chromium: its picture is large, its tables fit a window, on paper nothing is cut."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from shutil import which
from typing import Any

import pytest

import kanefe as kf

pytestmark = pytest.mark.browser

WINDOW = {"width": 1100, "height": 800}
PAPER = {"width": 700, "height": 1000}  # pixels of A4 between its margins


def falling(heading_deg: float, sea_state: int, seed: int) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    rod = kf.Revolute("y", position=1e-3 * sea_state * (200.0 + heading_deg + 7.0 * seed))
    scene.add_rigid_body("rod", 1.0, 0.1, com=(0, 0, -1.0), joint=rod)
    return scene


def swing(result: kf.Result) -> dict[str, float]:
    return {"swing": float(abs(result.joint_coordinates("rod")).max())}


@pytest.fixture(scope="module")
def tab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    study = kf.Study(falling, swing, duration=0.02, heading_deg=(0, 90, 180), sea_state=(3, 4), seed=range(6))
    path = (
        study.run(executor="serial")
        .operability({"swing": 0.9})
        .to_html(tmp_path_factory.mktemp("study") / "study.html")
    )
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport=WINDOW)
        page.goto(Path(path).as_uri())
        yield page
        browser.close()


def overflow(tab: Any) -> list[int]:
    return list(tab.evaluate("[...document.querySelectorAll('table')].map((t) => t.scrollWidth - t.clientWidth)"))


def test_the_page_fits_a_window(tab: Any) -> None:
    assert max(overflow(tab)) <= 0
    assert tab.evaluate("document.documentElement.scrollWidth") <= WINDOW["width"]
    assert tab.evaluate("document.querySelector('figure img').clientWidth") >= 500


def test_the_page_fits_paper(tab: Any) -> None:
    tab.set_viewport_size(PAPER)
    tab.emulate_media(media="print", color_scheme="dark")
    assert tab.evaluate("document.documentElement.scrollWidth") <= PAPER["width"]
    assert tab.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    tab.emulate_media(media="screen", color_scheme="dark")
    assert tab.evaluate("getComputedStyle(document.body).backgroundColor") != "rgb(255, 255, 255)"
