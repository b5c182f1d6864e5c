"""Card of a scene: its tree of bodies, and its loads, constraints and controllers."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from kanefe.views.cards.card import card, table

STEP, WIDE, TALL = 26, 118, 30
"""Indentation of a child in the picture of the tree, and width and height of a body, pixels."""

MOST = 40
"""Largest number of bodies that are listed."""

FILLS = {"flexible": "#e3edf7", "rigid": "#eef0f3", "massless": "#ffffff"}


def scene_card(title: str, bodies: Sequence[tuple[int, str, str, str]], others: Sequence[tuple[str, str]]) -> str:
    """Return the card of a scene.

    Parameters
    ----------
    title : str
    bodies : sequence of (int, str, str, str)
        Depth in the tree, name, description, and joint.
    others : sequence of (str, str)
        Kind and description of loads, constraints and controllers.
    """
    shown = bodies[:MOST]
    rows = [(name, what, joint) for _, name, what, joint in shown]
    rows += [("...", f"{len(bodies) - MOST} more bodies", "")] if len(bodies) > MOST else []
    parts = [_tree([(depth, name, what) for depth, name, what, _ in shown])] if shown else []
    parts.append(table(rows, ("body", "what it is", "joint")))
    if others:
        parts.append(table(others[:MOST], ("what acts", "")))
    return card(title, *parts)


def _tree(bodies: Sequence[tuple[int, str, str]]) -> str:
    """Return a picture of the tree: each body below its parent and connected to it."""
    places = [(-1, "ground", "massless"), *bodies]
    lines, boxes, last = [], [], dict[int, int]()
    for row, (depth, name, what) in enumerate(places):
        x, y = STEP * (depth + 1), TALL * row
        last[depth] = row
        if depth >= 0:
            above = TALL * last[depth - 1] + 24
            lines.append(f"M{x - STEP + 10} {above}V{y + 13}H{x}")
        fill = FILLS[what.split(",")[0]]
        label = name if len(name) < 16 else f"{name[:14]}…"
        boxes.append(
            f'<rect x="{x + 0.5}" y="{y + 2.5}" width="{WIDE}" height="22" rx="4" fill="{fill}" stroke="#9aa5b1"/>'
            f'<text x="{x + 8}" y="{y + 18}" fill="#1f2933">{escape(label)}</text>'
        )
    width, height = STEP * (max(depth for depth, _, _ in places) + 1) + WIDE + 2, TALL * len(places)
    joined = f'<path d="{"".join(lines)}" fill="none" stroke="#9aa5b1"/>'
    return (
        f'<svg width="{width}" height="{height}" style="font:12px system-ui,sans-serif" role="img" '
        f'aria-label="tree of the bodies">{joined}{"".join(boxes)}</svg>'
    )
