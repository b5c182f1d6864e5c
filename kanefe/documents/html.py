"""A report as one HTML page: without scripts or external files."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from html import escape
from itertools import groupby

from kanefe.documents.blocks import Block, Heading, Histogram, Listing, Paragraph, Picture, Table

STYLE = """
:root { color-scheme: light dark; --ink: #222; --paper: #fff; --line: #d5d9de; --band: #f5f6f8; --warning: #fdf3ec; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e3e6ea; --paper: #17191d; --line: #3a4048; --band: #20242a; --warning: #38261b; }
}
@media print { :root { --ink: #000; --paper: #fff; --line: #bbb; --band: #f5f6f8; --warning: #fdf3ec; } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); margin: 2rem auto;
       max-width: 66rem; padding: 0 1.2rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.15rem; margin: 2rem 0 .6rem; border-bottom: 1px solid var(--line); }
table { border-collapse: collapse; font-size: .82rem; margin: .6rem 0; display: block; overflow-x: auto; }
td, th { padding: .16rem .45rem; text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
th { border-bottom: 1px solid #888; font-weight: 600; vertical-align: bottom; white-space: normal; }
tr:nth-child(even) td { background: var(--band); }
td:first-child, th:first-child, .left td, .left th { text-align: left; }
.left td { white-space: normal; overflow-wrap: anywhere; } .left td:first-child { white-space: nowrap; }
p.warning { border-left: 4px solid #d55e00; background: var(--warning); padding: .3rem .8rem; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(14rem, 100%), 1fr)); gap: .8rem; }
figure { margin: 0; border: 1px solid var(--line); border-radius: 4px; padding: .3rem; background: #fff; color: #222; }
figure:only-child { grid-column: 1 / -1; max-width: 38rem; }
figure img { width: 100%; display: block; } figcaption { font-size: .82rem; text-align: center; }
pre { font-size: .82rem; overflow-x: auto; background: var(--band); padding: .6rem .8rem; border-radius: 4px; }
svg { max-width: 100%; } svg text { font: 12px system-ui, sans-serif; fill: var(--ink); }
@media print {
  body { font-size: 10pt; margin: 0; max-width: none; padding: 0; }
  table { display: table; font-size: 7pt; } td, th { padding: .08rem .2rem; }
  h2 { break-after: avoid; } figure, tr { break-inside: avoid; } pre { white-space: pre-wrap; }
  figure:only-child { max-width: 12cm; }
}
"""


def page(title: str, blocks: Iterable[Block]) -> str:
    """Return the page with all pictures in it."""
    body = []
    for is_picture, group in groupby(blocks, key=lambda block: isinstance(block, Picture)):
        parts = [_html(block) for block in group]
        body.append('<div class="pictures">' + "".join(parts) + "</div>" if is_picture else "\n".join(parts))
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{escape(title)}</title>\n'
        f'<meta name="viewport" content="width=device-width">\n<style>{STYLE}</style>\n</head>\n<body>\n'
        f"<h1>{escape(title)}</h1>\n" + "\n".join(body) + "\n</body>\n</html>\n"
    )


def _html(block: Block) -> str:
    if isinstance(block, Heading):
        return f"<h2>{escape(block.text)}</h2>"
    if isinstance(block, Paragraph):
        return f'<p class="warning">{escape(block.text)}</p>' if block.warning else f"<p>{escape(block.text)}</p>"
    if isinstance(block, Table):
        head = "<tr>" + "".join(f"<th>{escape(c)}</th>" for c in block.header) + "</tr>" if any(block.header) else ""
        rows = "".join("<tr>" + "".join(f"<td>{escape(c)}</td>" for c in row) + "</tr>\n" for row in block.rows)
        kind = ' class="left"' if block.align_left else ""
        return f"<table{kind}>\n{head}\n{rows}</table>"
    if isinstance(block, Listing):
        return f"<pre>{escape(block.text)}</pre>"
    if isinstance(block, Histogram):
        return _bars(block)
    data = base64.b64encode(block.png).decode("ascii")
    caption = escape(block.caption)
    return (
        f'<figure><img alt="{caption}" src="data:image/png;base64,{data}"><figcaption>{caption}</figcaption></figure>'
    )


def _bars(block: Histogram) -> str:
    most, height, left, length = max(block.counts, default=0) or 1, 20, 110, 420
    bars = []
    for i, (low, high, count) in enumerate(zip(block.edges[:-1], block.edges[1:], block.counts, strict=True)):
        y, width = i * height, length * count / most
        bars.append(
            f'<text x="{left - 8}" y="{y + 14}" text-anchor="end">{low:.2f} to {high:.2f}</text>'
            f'<rect x="{left}" y="{y + 3}" width="{width:.1f}" height="{height - 6}" fill="#0072b2"/>'
            f'<text x="{left + width + 6:.1f}" y="{y + 14}">{count}</text>'
        )
    size = f'width="{left + length + 80}" height="{height * len(block.counts)}"'
    return f"<p>{escape(block.title)}</p>\n<svg {size}>{''.join(bars)}</svg>"
