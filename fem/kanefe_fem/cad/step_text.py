"""What the text of a STEP file says: the units of its shapes, its colours, and names of faces."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

UNITS = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0, "km": 1e3, "in": 0.0254, "ft": 0.3048}
"""Lengths of units, m."""

_ENTITY = re.compile(r"#(\d+)\s*=\s*(.*)", re.DOTALL)
_REFERENCE = re.compile(r"#(\d+)")
_PREFIXES = {"$": 1.0, ".MICRO.": 1e-6, ".MILLI.": 1e-3, ".CENTI.": 1e-2, ".DECI.": 0.1, ".KILO.": 1e3}
_SHAPES = ("ADVANCED_BREP_SHAPE_REPRESENTATION", "MANIFOLD_SURFACE_SHAPE_REPRESENTATION", "SHAPE_REPRESENTATION")
_STRING = re.compile(r"'(?:[^']|'')*'")
_NUMBER = r"([-+0-9.Ee]+)"
_NAMED_FACE = re.compile(r"\bADVANCED_FACE\s*\(\s*'((?:[^']|'')*)'")
_WIDE, _NARROW = re.compile(r"\\X2\\([0-9A-Fa-f]*)\\X0\\"), re.compile(r"\\X\\([0-9A-Fa-f]{2})")
NO_NAME = ("", "NONE", "$")
"""Names that exporters write for a face that has none."""

_COLOUR = re.compile(rf"COLOUR_RGB\s*\([^,]*,\s*{_NUMBER}\s*,\s*{_NUMBER}\s*,\s*{_NUMBER}\s*\)")


def entities(text: str) -> dict[int, str]:
    """Return the entities of a STEP file by their numbers, without the texts in them."""
    found = {}
    for statement in _statements(_STRING.sub("''", re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL))):
        match = _ENTITY.match(statement)
        if match:
            found[int(match[1])] = match[2].strip()
    return found


def _statements(text: str) -> Iterator[str]:
    return (statement.strip() for statement in text.split(";"))


def units_of_shapes(path: Path) -> tuple[float, ...]:
    """Return the lengths of the units in which the shapes of a STEP file are written, m, each once.

    Other contexts, such as those of annotations, may have other units.
    """
    table = entities(path.read_text(encoding="latin-1"))
    of_contexts = {number: length for number, text in table.items() if (length := _of_context(table, text)) is not None}
    found: list[float] = []
    for wanted in (_SHAPES[:2], _SHAPES[2:]):
        for text in table.values():
            if text.startswith(wanted):
                numbers = [int(one) for one in _REFERENCE.findall(text)]
                found += [of_contexts[one] for one in numbers[-1:] if one in of_contexts]
        if found:
            break
    return tuple(dict.fromkeys(found or of_contexts.values()))


def _of_context(table: Mapping[int, str], text: str) -> float | None:
    """Return the unit of length of a context, m; None if it is none, or has none."""
    start = text.find("GLOBAL_UNIT_ASSIGNED_CONTEXT")
    if start < 0:
        return None
    end = text.find("REPRESENTATION_CONTEXT", start)
    for number in _REFERENCE.findall(text[start : end if end > 0 else None]):
        unit = table.get(int(number), "")
        if "LENGTH_UNIT" in unit:
            return _length(table, unit)
    return None


def _length(table: Mapping[int, str], unit: str, depth: int = 0) -> float | None:
    """Return the length of a unit, m: of SI, or converted to one that is."""
    if "SI_UNIT" in unit:
        prefix = re.search(r"SI_UNIT\s*\(\s*([^,\s]+)\s*,\s*\.METRE\.", unit)
        return _PREFIXES.get(prefix[1]) if prefix else None
    conversion = re.search(r"CONVERSION_BASED_UNIT\s*\([^#]*#(\d+)", unit)
    if conversion is None or depth:
        return None
    measure = table.get(int(conversion[1]), "")
    value = re.search(rf"\(\s*{_NUMBER}\s*\)", measure)
    base = re.findall(r"#(\d+)", measure)
    inner = _length(table, table.get(int(base[-1]), ""), depth + 1) if base else None
    return float(value[1]) * inner if value and inner is not None else None


def name_of_unit(length: float) -> str:
    """Return the name of a unit by its length in m."""
    return next((name for name, m in UNITS.items() if abs(m / length - 1.0) < 1e-6), f"{length:g} m")


def colours(path: Path) -> list[tuple[int, int, int]]:
    """Return the colours that a STEP file declares by numbers, 0 to 255."""
    found = _COLOUR.findall(path.read_text(encoding="latin-1"))
    return list(dict.fromkeys(tuple(round(255.0 * float(one)) for one in each) for each in found))  # type: ignore[misc]


def names_of_faces(path: Path) -> tuple[str, ...]:
    """Return the names that a STEP file gives to its faces, each once; none if one name is that of most of them."""
    given = Counter(decoded(name) for name in _NAMED_FACE.findall(path.read_text(encoding="latin-1")))
    most = max(1, given.total() // 2)
    return tuple(name for name, count in given.items() if name.upper() not in NO_NAME and count <= most)


def decoded(name: str) -> str:
    """Return a text of a STEP file with its doubled quotes and coded letters replaced (ISO 10303-21)."""
    name = _WIDE.sub(lambda code: bytes.fromhex(code[1]).decode("utf-16-be"), name.replace("''", "'"))
    return _NARROW.sub(lambda code: bytes.fromhex(code[1]).decode("latin-1"), name).strip()
