"""The gallery: a page an example, with its picture, what it prints, its checked number and its script."""

from __future__ import annotations

import ast
import json
import shutil
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util import logging

import cached

logger = logging.getLogger(__name__)

PAGE = """# {title}

{text}

![{title}](pictures/{stem}.png)
{player}
It prints:

:::{{div}} output
```text
{printed}
```
:::

Its checked number: {value:.10g}, which must be {reference:.10g} within {tolerance:.2g}.

```{{literalinclude}} ../../examples/{stem}.py
:language: python
```
"""
NOT_RUN = """# {title}

{text}

For this site it was not run: {reason}.

```{{literalinclude}} ../../examples/{stem}.py
:language: python
```
"""
PLAYER = """
Turn it with the mouse:

```{{raw}} html
<iframe class="run" src="../_static/runs/{stem}.html" title="{stem}, moving" loading="lazy"></iframe>
```
"""
INDEX = """# Gallery

Each example is a script of the folder `examples/` that runs as it stands and ends in one checked number. The pictures
and the printed lines are of the run that this site was built with.

::::{{grid}} 1 1 2 2
:gutter: 3

{cards}
::::

```{{toctree}}
:hidden:

{pages}
```
"""
CARD = """:::{{grid-item-card}} {title}
:link: {stem}
:link-type: doc
{picture}
{lead}
:::
"""


def words(path: Path) -> tuple[str, str, str]:
    """Return title, first sentence and text of an example."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    lead, _, rest = text.partition("\n\n")
    number, *name = path.stem.split("_")
    lead = " ".join(lead.split())
    return f"{number} {' '.join(name)}", lead, f"{lead}\n\n{rest}"


def _write(app: Sphinx) -> None:
    folder = Path(app.srcdir) / "gallery"
    (folder / "pictures").mkdir(parents=True, exist_ok=True)
    examples = sorted((cached.ROOT / "examples").glob("[0-9]*.py"))
    recipe = (Path(__file__).with_name("drawings.py")).read_text(encoding="utf-8")

    def outcome(path: Path) -> Path | str:
        try:
            return cached.run("run_example.py", path.read_text(encoding="utf-8") + recipe, path.stem)
        except RuntimeError as error:
            return str(error)

    cards, pages, app.players = [], [], {}
    with ThreadPoolExecutor(cpu_count()) as pool:
        found = list(pool.map(outcome, examples))
    for path, ran in zip(examples, found, strict=True):
        if isinstance(ran, str):
            logger.warning("example %s failed:\n%s", path.name, ran)
            continue
        title, lead, text = words(path)
        told = json.loads((ran / "done.json").read_text(encoding="utf-8"))
        pages.append(path.stem)
        if "not run" in told:
            page = NOT_RUN.format(title=title, text=text, stem=path.stem, reason=told["not run"])
            (folder / f"{path.stem}.md").write_text(page, encoding="utf-8")
            cards.append(CARD.format(title=title, stem=path.stem, lead=lead, picture=""))
            continue
        value, reference, tolerance = told["checked"]
        if abs(value - reference) > tolerance:
            logger.warning("example %s misses its number: %s instead of %s", path.name, value, reference)
        shutil.copy(ran / "picture.png", folder / "pictures" / f"{path.stem}.png")
        player = ""
        if (ran / "run.html").exists():
            app.players[path.stem] = ran / "run.html"
            player = PLAYER.format(stem=path.stem)
        page = PAGE.format(
            player=player,
            title=title,
            text=text,
            stem=path.stem,
            printed=told["printed"].rstrip(),
            value=value,
            reference=reference,
            tolerance=tolerance,
        )
        (folder / f"{path.stem}.md").write_text(page, encoding="utf-8")
        picture = f":img-top: pictures/{path.stem}.png\n"
        cards.append(CARD.format(title=title, stem=path.stem, lead=lead, picture=picture))
    index = INDEX.format(cards="\n".join(cards), pages="\n".join(pages))
    (folder / "index.md").write_text(index, encoding="utf-8")


def _copy_players(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        folder = Path(app.outdir) / "_static" / "runs"
        folder.mkdir(parents=True, exist_ok=True)
        for stem, path in app.players.items():
            shutil.copy(path, folder / f"{stem}.html")


def setup(app: Sphinx) -> dict[str, bool]:
    """Run the examples and write their pages before sources are looked for."""
    app.connect("builder-inited", _write, priority=200)
    app.connect("build-finished", _copy_players)
    return {"parallel_read_safe": True}
