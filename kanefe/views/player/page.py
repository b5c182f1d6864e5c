"""The page of a run: as text, as a file, in a notebook and in a browser."""

from __future__ import annotations

import json
import re
import tempfile
import webbrowser
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.results.reader import Reader
from kanefe.results.selection import spread_frames
from kanefe.storage.files import ready_path, write_whole
from kanefe.storage.watched import is_notebook
from kanefe.views.player.drawn_modes import StressField
from kanefe.views.player.scene_data import SceneData

MOST_FRAMES = 1000
"""Default number of output times shown; between them the browser interpolates."""

COLOURS = ("displacement", "stress", "none")
SUFFIXES = (".html", ".htm")
HEIGHT = 620
"""Height of the page in a notebook, pixels."""


@dataclass(frozen=True, eq=False)
class Page:
    """A run as an animated page of HTML; notebooks display it.

    Attributes
    ----------
    html : str
        The complete page, without external files.
    path : Path or None
        The file that it was written to.
    """

    html: str
    path: Path | None = None

    def __repr__(self) -> str:
        return f"Page({len(self.html) / 1e6:.2f} MB" + (f", {self.path})" if self.path is not None else ")")

    def _repr_html_(self) -> str:
        style = f"width:100%;height:{HEIGHT}px;border:1px solid #d5d9de;border-radius:6px"
        return f'<iframe srcdoc="{escape(self.html)}" style="{style}" allowfullscreen></iframe>'


def page_of(
    result: Reader,
    *,
    colour: str | None = None,
    stress: StressField | Sequence[StressField] = (),
    forces: bool = False,
    fps: float | None = None,
    every: int | None = None,
    scale: float = 1.0,
    title: str | None = None,
) -> Page:
    """Return the page of a run; see `Result.to_html`."""
    fields = _checked_stresses(result, stress)
    first = colour if colour is not None else "stress" if fields else "displacement"
    if first not in COLOURS:
        raise ModelError(f"colour of a page must be one of {', '.join(COLOURS)}, not {colour!r}")
    if first == "stress" and not fields:
        raise ModelError(
            "colour='stress' needs the stress. Remedy: stress=kanefe_fem.recover(result, name), of each body that "
            "has one"
        )
    if numbers(scale).shape != () or not np.isfinite(numbers(scale)):
        raise ModelError(f"scale of the displacements must be finite, not {scale!r}")
    if title is not None and not isinstance(title, str):
        raise ModelError(f"title of a page must be a text, not {title!r}")
    data = SceneData(result, spread_frames(result.times, fps, every, MOST_FRAMES), fields, forces)
    content = data.content | {"title": title or "kanefe", "colour": first, "scale": float(scale)}
    content["stress_name"] = _stress_name(data)
    return Page(_filled(content["title"], json.dumps(content, separators=(",", ":")), data.arrays.encoded()))


def write_page(page: Page, path: str | Path) -> Path:
    """Write a page to a file; if that fails, the file is as it was before.

    Raises
    ------
    ModelError, FileError
        If the name does not end in .html, or the file cannot be written.
    """
    target = checked_path(path)
    write_whole(ready_path(target), lambda file: file.write(page.html.encode("utf-8", "xmlcharrefreplace")))
    return target


def checked_path(path: str | Path) -> Path:
    """Return the path of a page; raise a ModelError unless its name ends in .html."""
    target = Path(path)
    if target.suffix.lower() not in SUFFIXES:
        raise ModelError(f"cannot write a page to {str(path)!r}: its name must end in .html")
    return target


def shown(page: Page) -> Page:
    """Show a page in the browser, from a temporary file whose path is printed; notebooks display the returned page."""
    if is_notebook():
        return page
    target = write_page(page, Path(tempfile.mkdtemp(prefix="kanefe-view-")) / "run.html")
    is_open = webbrowser.open(target.as_uri())
    print(f"shown in the browser: {target}" if is_open else f"there is no browser to open: the page is {target}")
    return Page(page.html, target)


def _checked_stresses(result: Reader, stress: StressField | Sequence[StressField]) -> dict[str, StressField]:
    given: Sequence[Any] = stress if isinstance(stress, (list, tuple)) else [stress]
    for field in given:
        if not hasattr(field, "stress_of") or not isinstance(getattr(field, "name", None), str):
            raise ModelError(f"stress must be what kanefe_fem.recover(result, name) returns, not {field!r}")
        result.body(field.name)
        if field.result is not result:
            raise ModelError(f"the stress of {field.name!r} is of another run. Remedy: recover(...) of this run")
    parts = [part for field in given for part in (field.segments() if field.name in result.segmented else [field])]
    return {field.name: field for field in parts}


def _stress_name(data: SceneData) -> str:
    """Return the name of the stress in colours: for beams it is the normal stress, else with the error of the mesh."""
    if not data.beams_stressed:
        error = "" if np.isnan(data.mesh_error) else f" (error of mesh {100.0 * data.mesh_error:.2g} %)"
        return f"von Mises stress{error}"
    return "normal stress" if data.beams_stressed == data.stressed else "stress, normal in beams"


def _filled(title: str, content: str, arrays: str) -> str:
    """Return the page with its parts inserted."""
    web = files("kanefe.views.player") / "web"
    parts = {name: (web / name).read_text(encoding="utf-8") for name in ("page.html", "page.css", "player.js")}
    filled = {
        "<!-- title -->": escape(title),
        "/* style */": parts["page.css"],
        "/* scene */": content.replace("<", "\\u003c"),
        "/* arrays */": arrays,
        "/* player */": parts["player.js"],
    }
    # in one pass: an inserted part such as a title may look like a mark
    return re.sub("|".join(map(re.escape, filled)), lambda mark: filled[mark[0]], parts["page.html"])
