"""Cards in notebooks: a picture beside tables, in self-contained HTML."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape

Rows = Sequence[Sequence[str]]

_CELL = "padding:1px 10px 1px 0;text-align:left;vertical-align:top;background:none"


def card(title: str, *parts: str) -> str:
    """Return a card of a title (text) and parts (HTML), side by side if there is space."""
    inner = "".join(f'<div style="max-width:46em">{part}</div>' for part in parts if part)
    return (
        f'<div style="font-size:90%"><div style="font-weight:600;margin-bottom:4px">{escape(title)}</div>'
        f'<div style="display:flex;flex-wrap:wrap;gap:8px 24px;align-items:flex-start">{inner}</div></div>'
    )


def table(rows: Rows, header: Sequence[str] = ()) -> str:
    """Return a table of texts.

    Examples
    --------
    >>> table([("mass", "2 kg")]).count("<td")
    2
    """
    head = "".join(f'<th style="{_CELL};color:#52606d;font-weight:normal">{escape(cell)}</th>' for cell in header)
    body = "".join(
        "<tr style='background:none'>" + "".join(f'<td style="{_CELL}">{escape(cell)}</td>' for cell in row) + "</tr>"
        for row in rows
    )
    return f'<table style="border-collapse:collapse;margin:0">{f"<tr>{head}</tr>" if head else ""}{body}</table>'


def picture(png: bytes, width: int, label: str) -> str:
    """Return a picture (.png), `width` pixels wide."""
    data = base64.b64encode(png).decode("ascii")
    return f'<img width="{width}" alt="{escape(label)}" src="data:image/png;base64,{data}">'
