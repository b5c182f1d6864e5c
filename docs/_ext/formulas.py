"""Formulas drawn by KaTeX, of which a copy is put into the site: pages show them without a network."""

from __future__ import annotations

import html
import shutil
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

KATEX = Path("/usr/share/javascript/katex")  # Debian's libjs-katex, which `.ci/docs` installs

NOTICE = Path("/usr/share/doc/libjs-katex/copyright")


def _inline(self, node: nodes.math) -> None:
    self.body.append(f'<span class="math tex notranslate">{html.escape(node.astext())}</span>')
    raise nodes.SkipNode


def _display(self, node: nodes.math_block) -> None:
    self.body.append(self.starttag(node, "div", CLASS="math tex notranslate"))
    self.body.append(html.escape(node.astext().strip()) + "</div>\n")
    raise nodes.SkipNode


def _copy(app: Sphinx, error: Exception | None) -> None:
    if error is not None or app.builder.format != "html":
        return
    target = Path(app.outdir) / "_static" / "katex"
    (target / "fonts").mkdir(parents=True, exist_ok=True)
    for name in ("katex.min.js", "katex.min.css"):
        shutil.copy(KATEX / name, target / name)
    shutil.copy(NOTICE, target / "LICENSE")
    for font in (KATEX / "fonts").glob("*.woff2"):
        shutil.copy(font, target / "fonts" / font.name)


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the renderer; `html_math_renderer` names it."""
    if not (KATEX / "katex.min.js").exists():
        raise ExtensionError(f"{KATEX} has no katex.min.js; remedy: apt-get install libjs-katex")
    app.add_html_math_renderer("katex", (_inline, None), (_display, None))
    app.config.html_math_renderer = "katex"
    app.add_css_file("katex/katex.min.css")
    app.add_js_file("katex/katex.min.js")
    app.add_js_file("formulas.js")
    app.connect("build-finished", _copy)
    return {"parallel_read_safe": True}
