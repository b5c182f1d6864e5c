"""Channels of a run by text, as tables: ``"position arm/tip x"``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from kanefe.errors import ModelError, did_you_mean
from kanefe.results.quantities import OF_CONNECTIONS, OF_SCENE, QUANTITIES, WITH_OWN_NAMES
from kanefe.results.quantity_reader import QuantityReader
from kanefe.scene.targets import Named, asked_for

Parts = tuple[tuple[str, str, tuple[str, ...]], ...]
"""Label, unit and column names of the columns of a quantity, see `kanefe.results.quantities.resolved_parts`."""


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
    place : (str, str, str)
        Quantity, body or load, and interface.
    numbers : tuple of int
        Of the columns among those of the quantity.
    """

    name: str
    labels: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray
    place: tuple[str, str, str]
    numbers: tuple[int, ...]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(f"{self.name} {label}" for label in self.labels) or (self.name,) * len(self.units)

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
    found = [channel_of(run, name, text) for name, text in asked]
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


def channel_of(
    run: QuantityReader,
    name: str,
    text: str,
    kind: str = "channel",
    parts_of: Callable[[str, str], Parts] | None = None,
) -> Channel:
    """Return the channel of a text, as a script names it; messages call it a `kind`.

    `parts_of` returns label, unit and column names of a quantity of a body or load; default: ``run.parts``.
    """
    what, _, rest = text.strip().partition(" ")
    if what not in QUANTITIES:
        did = did_you_mean(what, QUANTITIES)
        raise ModelError(f"{kind} {text!r}: there is no {what!r}. {did}Remedy: one of {', '.join(QUANTITIES)}")
    rest = rest.strip()
    head, _, last = rest.rpartition(" ")
    failure: ModelError | None = None
    for given, component in ((rest, ""), (head.strip(), last)):
        try:
            place = _place(what, given)
            values = np.asarray(run.read(what, place[1], place[2] or None)).reshape(len(run.times), -1)
            columns = _columns(what, (parts_of or run.parts)(what, place[1]))
        except ModelError as error:
            failure = failure or error
            continue
        labels, units, numbers = _chosen(f"{kind} {text!r}", component, columns)
        return Channel(name or text.strip(), labels, units, values[:, numbers], place, numbers)
    raise ModelError(f"{kind} {text!r}: {failure}") from failure


def _place(what: str, place: str) -> tuple[str, str, str]:
    if what in OF_SCENE and place:
        raise ModelError(f"{what} is that of the whole scene, not of {place!r}")
    of, _, interface = (place, "", "") if what in OF_CONNECTIONS else place.partition("/")
    return what, of, interface


def _columns(what: str, parts: Parts) -> list[tuple[str, str]]:
    """Return label and unit of each column of a quantity."""
    return [
        (column or label if what in WITH_OWN_NAMES or len(parts) == 1 else f"{label} {column}", unit)
        for label, unit, names in parts
        for column in names or ("",)
    ]


def _chosen(
    asked: str, component: str, columns: list[tuple[str, str]]
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[int, ...]]:
    """Return labels, none if there is one column, units and numbers of the columns that are a component, or of all."""
    labels = [label.replace(" ", "_") for label, _ in columns]
    chosen = tuple(i for i, label in enumerate(labels) if component in ("", label, columns[i][0], str(i)))
    if not chosen:
        raise ModelError(f"{asked}: there is no component {component!r}. There are: {', '.join(labels)}")
    one = bool(component) or len(columns) == 1
    return () if one else tuple(labels[i] for i in chosen), tuple(columns[i][1] for i in chosen), chosen
