"""Where the python snippets of a page are, and which of them are run: see `snippets.py`."""

from __future__ import annotations

import re

SNIPPET = re.compile(
    r"^<!-- run\n(?P<hidden>.*?)^-->$"
    r"|^(?:<!-- (?P<kind>not run: [^\n]*|raises \w+|quiet) -->\n)?^```python\n(?P<code>.*?)^```$",
    flags=re.DOTALL | re.MULTILINE,
)


def snippets_of(text: str) -> list[dict[str, str]]:
    """Return what of a page is run: code and kind."""
    found = []
    for match in SNIPPET.finditer(text):
        kind = match["kind"] or ""
        if not kind.startswith("not run"):
            found.append({"code": match["hidden"] or match["code"], "kind": kind})
    return found
