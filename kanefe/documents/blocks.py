"""Blocks of documents: headings, paragraphs, tables, listings, histograms, pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Heading:
    """Opens a section."""

    text: str


@dataclass(frozen=True)
class Paragraph:
    """Text that is wrapped; `warning` highlights it."""

    text: str
    warning: bool = False


@dataclass(frozen=True)
class Table:
    """Rows of formatted strings under a header; the first column is left-aligned, the others right-aligned."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    align_left: bool = False


@dataclass(frozen=True)
class Listing:
    """Lines of code, unchanged."""

    text: str


@dataclass(frozen=True)
class Histogram:
    """Number of cells between consecutive edges of a quantity."""

    title: str
    edges: Sequence[float]
    counts: Sequence[int]


@dataclass(frozen=True)
class Picture:
    """A picture (.png) with a caption."""

    caption: str
    png: bytes = field(repr=False)


Block = Heading | Paragraph | Table | Listing | Histogram | Picture
