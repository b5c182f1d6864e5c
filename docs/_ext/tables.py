"""Tables from the JSON files of `docs/data`, each with the machine and the date of its figures.

```{figures} benchmarks.json equal-error
```
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import ClassVar

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from kanefe.checks.verification.references import load_references


def markdown(columns: list[str], rows: list[list[str]]) -> list[str]:
    """Return a table as lines of Markdown."""
    lines = [f"| {' | '.join(columns)} |", f"|{'---|' * len(columns)}"]
    return lines + [f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |" for row in rows]


def of_verification(told: dict, name: str) -> dict:
    """Return a table of what `kanefe verify --json` found: cases, definitions or quantities."""
    references, by_case = load_references(), {}
    for found in told["quantities"]:
        by_case.setdefault(found["case"], []).append(found)
    if name == "quantities":
        columns = ["case", "quantity", "value", "reference", "error", "tolerance"]
        forms = {"value": ".10g", "reference": ".10g", "error": ".1e", "tolerance": ".0e"}
        rows = [
            [q["case"], q["quantity"], *(f"{q[k]:{form}}" for k, form in forms.items())] for q in told["quantities"]
        ]
    elif name == "definitions":
        columns = ["case", "what is compared", "reference from"]
        rows = [[case, references[case].definition, references[case].source] for case in by_case]
    else:
        columns = ["case", "", "quantities", "closest to its limit: error", "tolerance", "s"]
        rows = []
        for case, found in by_case.items():
            worst = max(found, key=lambda q: q["error"] / q["tolerance"] if q["tolerance"] else q["error"])
            numbers = f"{worst['error']:.1e}", f"{worst['tolerance']:.0e}", f"{sum(q['seconds'] for q in found):.1f}"
            rows.append([case, references[case].title, str(len(found)), *numbers])
    return {"columns": columns, "rows": rows}


class Figures(SphinxDirective):
    """A table of a file, by its name there."""

    required_arguments = 2
    has_content = False
    option_spec: ClassVar[dict] = {}

    def run(self) -> list[nodes.Node]:
        """Return the table and where its figures are from."""
        file, name = self.arguments
        path = Path(self.env.srcdir) / "data" / file
        self.env.note_dependency(str(path))
        told = json.loads(path.read_text(encoding="utf-8"))
        table = of_verification(told, name) if "quantities" in told else told["tables"][name]
        where = {**told, **table}
        lines = markdown(table["columns"], table["rows"])
        if name != "definitions":
            lines += ["", f"*{where['machine']}; {where['date']}; `{where['command']}`.*"]
        if table.get("note"):
            lines += ["", table["note"]]
        return self.parse_text_to_nodes("\n".join(lines))


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directive."""
    app.add_directive("figures", Figures)
    return {"parallel_read_safe": True}
