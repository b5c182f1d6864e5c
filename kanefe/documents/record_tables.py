"""Tables of records that JSON can hold, such as provenance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from kanefe.documents.blocks import Block, Paragraph, Table

MOST_ROWS = 30


def record_tables(record: Any) -> list[Block]:
    """Return a record as tables: its single values first, then a table for each list of records."""
    if not isinstance(record, Mapping):
        return [Paragraph(_shown(record))]
    rows: list[list[str]] = []
    tables: list[Block] = []
    for name, value in _leaves(record):
        if _is_table(value):
            columns = list(dict.fromkeys(key for entry in value for key in entry))
            shown = [[_shown(entry.get(key, "")) for key in columns] for entry in value[:MOST_ROWS]]
            tables += [Paragraph(f"{_words(name)}:"), Table([_words(key) for key in columns], shown)]
            if len(value) > MOST_ROWS:
                tables.append(Paragraph(f"... and {len(value) - MOST_ROWS} more."))
        else:
            rows.append([_words(name), _shown(value)])
    if rows:
        tables.insert(0, Table(("", ""), rows, align_left=True))
    return tables


def _leaves(record: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in record.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{name}, ")
        elif value is not None:
            yield name, value


def _is_table(value: Any) -> bool:
    return (
        isinstance(value, Sequence)
        and not isinstance(value, str)
        and len(value) > 0
        and all(isinstance(entry, Mapping) for entry in value)
    )


def _words(name: str) -> str:
    return str(name).replace("_", " ")


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{_words(key)} {_shown(entry)}" for key, entry in value.items())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(_shown(entry) for entry in value[:MOST_ROWS]) + (", ..." if len(value) > MOST_ROWS else "")
    return str(value)
