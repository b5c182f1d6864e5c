"""The built site in headless Chromium: formulas are drawn, nothing comes from a network, phones show it whole."""

from __future__ import annotations

from collections.abc import Iterator
from shutil import which
from typing import Any

import pytest

from repository import ROOT

pytestmark = pytest.mark.browser

SITE = ROOT / "build" / "docs" / "html"
PAGES = ["index", "start/first_steps", "gallery/index", "reference/generated/kanefe-system", "figures/benchmarks"]
PAGES += [f"theory/{path.stem}" for path in sorted((ROOT / "docs" / "theory").glob("*.md"))]
NARROW = {"width": 400, "height": 800}  # of a phone


@pytest.fixture(scope="module")
def tab() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=which("chromium"), args=["--no-sandbox"])
        yield browser.new_page(viewport=NARROW)
        browser.close()


@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_whole(tab: Any, name: str) -> None:
    asked: list[str] = []
    tab.on("request", lambda request: asked.append(request.url))
    tab.goto((SITE / f"{name}.html").as_uri())
    tab.wait_for_load_state()
    assert {url for url in asked if not url.startswith(("file:", "data:", "blob:"))} == set()
    told = tab.evaluate(
        """() => ({
            formulas: document.querySelectorAll(".math.tex").length,
            drawn: document.querySelectorAll(".math.tex .katex").length,
            wrong: [...document.querySelectorAll(".katex-error")].map((x) => x.title),
            width: document.documentElement.scrollWidth,
        })"""
    )
    assert told["wrong"] == []
    assert told["drawn"] == told["formulas"]
    assert (told["formulas"] > 0) == (name.startswith("theory/") and name not in ("theory/index",))
    assert told["width"] <= NARROW["width"]
