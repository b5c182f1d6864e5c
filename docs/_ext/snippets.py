"""Every python snippet of a page is run, and what it prints and draws stands under it.

The snippets of a page share their names, in the order of the page, in an empty folder that has `meshes` and `examples`.
A comment before a snippet changes that:

    <!-- not run: REASON -->        it is shown only
    <!-- raises ModelError -->      it must raise that error, whose message is shown
    <!-- quiet -->                  it is run, what it prints is not shown
    <!-- run                        the comment itself is run, and is not seen
    code
    -->
"""

from __future__ import annotations

import json
import re
import shutil
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from pathlib import Path

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util import logging

import cached
import kanefe
import kanefe_fem
from page_snippets import SNIPPET, snippets_of

logger = logging.getLogger(__name__)


def _run_pages(app: Sphinx) -> None:
    app.snippets = {}
    pages = {path: snippets_of(path.read_text(encoding="utf-8")) for path in sorted(Path(app.srcdir).rglob("*.md"))}
    pages = {path: snippets for path, snippets in pages.items() if snippets and "_ext" not in path.parts}

    def outcome(path: Path) -> Path | str:
        try:
            return cached.run("run_page.py", json.dumps(pages[path]))
        except RuntimeError as error:
            return str(error)

    with ThreadPoolExecutor(cpu_count()) as pool:
        for path, found in zip(pages, pool.map(outcome, pages), strict=True):
            name = path.relative_to(app.srcdir).with_suffix("").as_posix()
            if isinstance(found, str):
                logger.warning("a snippet of %s failed:\n%s", name, found)
            else:
                app.snippets[name] = found
    told = sum(map(len, pages.values()))
    logger.info("%d snippets of %d pages ran", told, len(pages))


def _show(app: Sphinx, name: str, source: list[str]) -> None:
    if name not in app.snippets:
        return
    found = app.snippets[name]
    outcomes = iter(json.loads((found / "done.json").read_text(encoding="utf-8")))
    pictures = Path(app.srcdir) / "_generated" / name.replace("/", "-")
    shutil.rmtree(pictures, ignore_errors=True)
    up = "../" * name.count("/")

    def shown(match: re.Match[str]) -> str:
        if (match["kind"] or "").startswith("not run"):
            return "```python\n" + match["code"] + "```"
        outcome = next(outcomes)
        parts = [] if match["hidden"] else ["```python\n" + match["code"] + "```"]
        if outcome["printed"].strip() and not match["hidden"] and match["kind"] != "quiet":
            parts.append(":::{div} output\n```text\n" + outcome["printed"].rstrip() + "\n```\n:::")
        for picture in outcome["pictures"]:
            pictures.mkdir(parents=True, exist_ok=True)
            shutil.copy(found / picture, pictures / picture)
            parts.append(f"![{Path(picture).stem}]({up}_generated/{pictures.name}/{picture})")
        return "\n\n".join(parts)

    source[0] = SNIPPET.sub(shown, source[0])


def _link_names(app: Sphinx, tree: nodes.document) -> None:
    """Link names such as `kf.System` in the text to the reference."""
    for literal in list(tree.findall(nodes.literal)):
        text = literal.astext()
        match = re.fullmatch(r"(kf|kanefe|kanefe_fem)\.(\w+(?:\.\w+)?)(?:\(.*\))?", text)
        if not match or isinstance(literal.parent, pending_xref | nodes.reference | nodes.title):
            continue
        package = kanefe_fem if match[1] == "kanefe_fem" else kanefe
        if match[1] != "kf" and match[2].split(".")[0] not in package.__all__:
            continue  # a module, such as kanefe_fem.sramss
        target = f"{package.__name__}.{match[2]}"
        link = pending_xref(
            "", refdomain="py", reftype="obj", reftarget=target, refexplicit=True, refdoc=app.env.docname, refwarn=True
        )
        literal.replace_self(link)
        link += literal


def _missing(app: Sphinx, env, node: pending_xref, content) -> nodes.Node | None:
    """Leave types in signatures as text; a name that a page mentions must be in the reference."""
    if node.get("refdomain") == "py" and node.get("refdoc", "").startswith("reference/"):
        return content
    return None


def setup(app: Sphinx) -> dict[str, bool]:
    """Run the pages before they are read, and put the outcomes into their sources."""
    if not (Path(__file__).parents[2] / "meshes").is_dir():
        raise ExtensionError("the pages are built from a checkout of kanefe, with its meshes")
    app.connect("builder-inited", _run_pages)
    app.connect("source-read", _show)
    app.connect("doctree-read", _link_names)
    app.connect("missing-reference", _missing)
    return {"parallel_read_safe": True}
