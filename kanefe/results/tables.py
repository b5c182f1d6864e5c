"""Channels of a run by text, as tables: ``"position arm/tip x"``."""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from kanefe.errors import ModelError
from kanefe.results.quantities import DRIVES, LOADS, LOOPS, OF_SCENE, POINTS, QUANTITIES
from kanefe.results.quantity_reader import QuantityReader
from kanefe.scene.targets import Named, asked_for

WITH_OWN_NAMES = ("joint_coordinates", "joint_speeds", *DRIVES, *LOADS, *POINTS)
"""Quantities whose columns have names of their own: of the joint or the load."""


class Channel(NamedTuple):
    """A quantity of a body, interface or load over the output times, or one component of it.

    Attributes
    ----------
    name : str
        As the script gives it, else the text.
    labels : tuple of str
        Of the columns; empty if there is one.
    units : tuple of str
        Of the columns.
    values : ndarray, shape (T, columns)
    """

    name: str
    labels: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(f"{self.name} {label}" for label in self.labels) or (self.name,)

    def each(self) -> Iterator[tuple[str, str, np.ndarray]]:
        """Yield name, unit and values (T,) of each column."""
        yield from zip(self.columns, self.units, self.values.T, strict=True)


def channels_of(run: QuantityReader, named: Named | None) -> list[Channel]:
    """Return the requested channels; None: coordinates and speeds of joints, and of the modes of flexible bodies.

    Raises
    ------
    ModelError
        If there is no such channel (the message lists what there is), or two columns have the same name.
    """
    asked = [("", text) for text in _coordinates(run)] if named is None else asked_for(named)
    found = [_channel(run, name, text) for name, text in asked]
    counts = Counter(column for one in found for column in one.columns)
    repeated = [column for column, count in counts.items() if count > 1]
    if repeated:
        raise ModelError(f"the column {repeated[0]!r} is given twice. Remedy: once, or a mapping with other names")
    return found


def _coordinates(run: QuantityReader) -> Iterator[str]:
    shapes = [run.body(name) for name in run.bodies]
    for quantity in ("joint_coordinates", "joint_speeds"):
        yield from (f"{quantity} {shape.name}" for shape in shapes if shape.coordinate_names)
    for quantity in ("modal_coordinates", "modal_speeds"):
        yield from (f"{quantity} {shape.name}" for shape in shapes if shape.basis.shape[1])


def _channel(run: QuantityReader, name: str, text: str) -> Channel:
    what, _, rest = text.strip().partition(" ")
    if what not in QUANTITIES:
        near = difflib.get_close_matches(what, QUANTITIES, 1)
        did = f"Did you mean {near[0]!r}? " if near else ""
        raise ModelError(f"channel {text!r}: there is no {what!r}. {did}Remedy: one of {', '.join(QUANTITIES)}")
    rest = rest.strip()
    head, _, last = rest.rpartition(" ")
    failure: ModelError | None = None
    for place, component in ((rest, ""), (head.strip(), last)):
        try:
            values, columns = _columns(run, what, place)
        except ModelError as error:
            failure = failure or error
            continue
        return _chosen(name or text.strip(), text, component, columns, values)
    raise ModelError(f"channel {text!r}: {failure}") from failure


def _columns(run: QuantityReader, what: str, place: str) -> tuple[np.ndarray, list[tuple[str, str]]]:
    """Return the values of a quantity, and label and unit of each column."""
    if what in OF_SCENE and place:
        raise ModelError(f"{what} is that of the whole scene, not of {place!r}")
    is_whole = what in LOADS or what in LOOPS or what in POINTS
    of, _, interface = (place, "", "") if is_whole else place.partition("/")
    values = np.asarray(run.read(what, of, interface or None))
    parts = run.parts(what, of)
    columns = [
        (column or label if what in WITH_OWN_NAMES or len(parts) == 1 else f"{label} {column}", unit)
        for label, unit, names in parts
        for column in names or ("",)
    ]
    return values.reshape(len(run.times), -1), columns


def _chosen(name: str, text: str, component: str, columns: list[tuple[str, str]], values: np.ndarray) -> Channel:
    labels = [label.replace(" ", "_") for label, _ in columns]
    chosen = [i for i, label in enumerate(labels) if component in ("", label, columns[i][0], str(i))]
    if not chosen:
        raise ModelError(f"channel {text!r}: there is no component {component!r}. There are: {', '.join(labels)}")
    one = bool(component) or len(columns) == 1
    units = tuple(columns[i][1] for i in chosen)
    return Channel(name, () if one else tuple(labels[i] for i in chosen), units, values[:, chosen])
