"""A report as a list of blocks, written as text and Markdown. HTML: `kanefe.documents.html`."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from kanefe.documents.blocks import Block, Heading, Histogram, Listing, Paragraph, Picture, Table
from kanefe.storage.files import ready_path, write_whole

WIDTH = 100
"""Width of a line of text, characters."""

BAR = 40
"""Length of the longest bar of a histogram, characters."""


@dataclass(frozen=True, eq=False)
class Report:
    """A report in blocks, such as that of a flexible body; ``print(report)`` shows it as text.

    Attributes
    ----------
    title : str
    blocks : tuple of Block
        Without pictures.
    draw : callable
        Returns the pictures by the text of the heading that they follow; raises `MissingDependency` without pyvista.

    Examples
    --------
    >>> report = body.report()                                          # doctest: +SKIP
    >>> print(report)                                                   # doctest: +SKIP
    >>> report.to_html("arm.html")                                      # doctest: +SKIP
    """

    title: str
    blocks: tuple[Block, ...]
    draw: Callable[[], dict[str, list[Picture]]] = field(repr=False, default=dict)

    def __str__(self) -> str:
        lines = [self.title, "=" * len(self.title)]
        for block in self.blocks:
            lines += _text(block)
        return "\n".join(lines).rstrip() + "\n"

    def to_text(self, path: str | Path) -> Path:
        """Write the report as text; its folder is created.

        Raises
        ------
        FileError
            If the file cannot be written.
        """
        return _write(path, str(self))

    def to_markdown(self, path: str | Path, *, pictures: bool | None = None) -> Path:
        """Write the report as Markdown, and its pictures into a folder ``<name>_files`` beside it.

        Parameters
        ----------
        path : path
            Its folder is created.
        pictures : bool, optional
            Thumbnails of the mode shapes, which need pyvista. Default: if it is installed; else a note in the
            report says that they are missing.

        Raises
        ------
        MissingDependency
            With ``pictures=True``, if pyvista is not installed.
        FileError
            If a file cannot be written.
        """
        target = Path(path)
        folder = target.with_name(f"{target.stem}_files")
        lines = [f"# {self.title}", ""]
        number = 0
        for block in self.with_pictures(pictures):
            if isinstance(block, Picture):
                number += 1
                name = f"picture_{number:02d}.png"
                write_whole(folder / name, lambda file, data=block.png: file.write(data))  # type: ignore[misc]
                lines += [f"![{block.caption}]({folder.name}/{name})", f"*{block.caption}*", ""]
            else:
                lines += _markdown(block)
        return _write(target, "\n".join(lines).rstrip() + "\n")

    def to_html(self, path: str | Path, *, pictures: bool | None = None) -> Path:
        """Write the report as one HTML file with its pictures embedded. Arguments and errors: `to_markdown`."""
        from kanefe.documents.html import page

        return _write(path, page(self.title, self.with_pictures(pictures)))

    def with_pictures(self, pictures: bool | None = None) -> list[Block]:
        """Return the blocks with the pictures after the headings they belong to."""
        from kanefe.errors import MissingDependency

        drawn: dict[str, list[Picture]] = {}
        note = ""
        if pictures is not False:
            try:
                drawn = self.draw()
            except MissingDependency as missing:
                if pictures:
                    raise
                note = f"Mode shapes are not drawn: {missing}"
        blocks: list[Block] = []
        for block in self.blocks:
            blocks.append(block)
            if isinstance(block, Heading):
                blocks += drawn.get(block.text, [])
        return [*blocks, Paragraph(note)] if note else blocks


def _write(path: str | Path, text: str) -> Path:
    target = ready_path(path)
    write_whole(target, lambda file: file.write(text.encode("utf-8")))
    return target


def _text(block: Block) -> list[str]:
    if isinstance(block, Heading):
        return ["", block.text, "-" * len(block.text)]
    if isinstance(block, Paragraph):
        return textwrap.wrap(("! " if block.warning else "") + block.text, WIDTH)
    if isinstance(block, Table):
        widths = [max(len(row[i]) for row in (block.header, *block.rows)) for i in range(len(block.header))]
        shown = [block.header, *block.rows] if any(block.header) else list(block.rows)
        return [_aligned(row, widths, block.align_left) for row in shown]
    if isinstance(block, Listing):
        return [f"  {line}" for line in block.text.splitlines()]
    if isinstance(block, Histogram):
        return [block.title, *(f"  {label}  {count:>8d}  {bar}" for label, count, bar in _bars(block))]
    return [f"[{block.caption}]"]


def _aligned(row: Sequence[str], widths: Sequence[int], left: bool) -> str:
    cells = [row[0].ljust(widths[0])]
    cells += [c.ljust(w) if left else c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True)]
    return "  " + "  ".join(cells).rstrip()


def _bars(block: Histogram) -> list[tuple[str, int, str]]:
    most = max(block.counts, default=0) or 1
    return [
        (f"{low:5.2f} to {high:5.2f}", count, "#" * round(BAR * count / most))
        for low, high, count in zip(block.edges[:-1], block.edges[1:], block.counts, strict=True)
    ]


def _markdown(block: Block) -> list[str]:
    if isinstance(block, Heading):
        return [f"## {block.text}", ""]
    if isinstance(block, Paragraph):
        return [f"**{block.text}**" if block.warning else block.text, ""]
    if isinstance(block, Table):
        mark = ":--" if block.align_left else "--:"
        head = [_row(block.header), _row([":--", *[mark] * (len(block.header) - 1)])]
        return [*head, *(_row(row) for row in block.rows), ""]
    if isinstance(block, Listing):
        return ["```", *block.text.splitlines(), "```", ""]
    if isinstance(block, Histogram):
        rows = [_row([label, str(count), f"`{bar}`" if bar else ""]) for label, count, bar in _bars(block)]
        return [block.title, "", _row(["range", "cells", ""]), "| :-- | --: | :-- |", *rows, ""]
    return []


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
