"""The notebooks of `docs/notebooks`, kept there as text: each is run, shown as a page, and can be downloaded."""

from __future__ import annotations

import base64
import json
import re
import shutil
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.util import logging

import cached

logger = logging.getLogger(__name__)

INDEX = """# Notebooks

Each page is a notebook that was run when this site was built; what a cell shows is what it showed. The scenes can be
turned with the mouse. They need `pip install jupyterlab` beside kanefe.

{rows}

```{{toctree}}
:hidden:

{pages}
```
"""
FENCE = "`" * 8


def _text(value: str | list[str]) -> str:
    return value if isinstance(value, str) else "".join(value)


def _shown(output: dict[str, Any], pictures: Path, name: str) -> str:
    """Return an output as Markdown: HTML and pictures before text."""
    if output["output_type"] == "stream":
        return ":::{div} output\n" + f"{FENCE}text\n{_text(output['text']).rstrip()}\n{FENCE}\n:::"
    data = output.get("data", {})
    if "text/html" in data:
        return f'{FENCE}{{raw}} html\n<div class="notebook-output">{_text(data["text/html"])}</div>\n{FENCE}'
    if "image/png" in data:
        pictures.mkdir(parents=True, exist_ok=True)
        (pictures / f"{name}.png").write_bytes(base64.b64decode(_text(data["image/png"])))
        return f"![{name}](pictures/{name}.png)"
    return ":::{div} output\n" + f"{FENCE}text\n{_text(data.get('text/plain', '')).rstrip()}\n{FENCE}\n:::"


def _page(notebook: dict[str, Any], pictures: Path, stem: str) -> str:
    parts = []
    for number, cell in enumerate(notebook["cells"]):
        source = _text(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
            continue
        parts.append("```{code-block} python\n" + source + "\n```")
        parts += [_shown(out, pictures, f"{stem}-{number}-{i}") for i, out in enumerate(cell["outputs"])]
    parts.append(f"---\n\nThis notebook: {{download}}`{stem}.ipynb`.")
    return "\n\n".join(parts) + "\n"


def _write(app: Sphinx) -> None:
    folder = Path(app.srcdir) / "notebooks"
    shutil.rmtree(folder / "pictures", ignore_errors=True)
    rows, pages = [], []
    for path in sorted(folder.glob("[0-9]*.py")):
        text = path.read_text(encoding="utf-8")
        try:
            ran = cached.run("run_notebook.py", text)
        except RuntimeError as error:
            logger.warning("notebook %s failed:\n%s", path.name, error)
            continue
        shutil.copy(ran / "notebook.ipynb", folder / f"{path.stem}.ipynb")
        told = json.loads((ran / "notebook.ipynb").read_text(encoding="utf-8"))
        (folder / f"{path.stem}.md").write_text(_page(told, folder / "pictures", path.stem), encoding="utf-8")
        lead = re.search(r"# # .*\n#\n((?:# .*\n)+)", text)
        what = " ".join(line.removeprefix("# ") for line in lead[1].splitlines()) if lead else ""
        rows.append(f"- [{re.search(r'# # (.*)', text)[1]}]({path.stem}.md): {what}")
        pages.append(path.stem)
    (folder / "index.md").write_text(INDEX.format(rows="\n".join(rows), pages="\n".join(pages)), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Run the notebooks and write their pages before sources are looked for."""
    app.connect("builder-inited", _write, priority=200)
    return {"parallel_read_safe": True}
