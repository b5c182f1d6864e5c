"""Fields over the places of a body by which loads vary: functions of places, or values at nodes."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.arguments import checked, told
from kanefe.errors import ModelError
from kanefe.frames import numbers

Over = Callable[..., Any] | Any
"""A field, as `over=` of a load takes it: a function of places (n, 3), m, in the mesh frame, or values at the nodes."""


@dataclass(frozen=True, eq=False)
class PlaceField:
    """A field over places, checked when it is asked.

    Attributes
    ----------
    given : callable or ndarray
        A function of places (n, 3) in m -> (n,) or (n, 3), or values at the nodes.
    label : str
        Of the load, for messages.
    component : int or None
        Component of three that is meant.
    """

    given: Over
    label: str
    component: int | None = None

    def at(self, places: np.ndarray, nodes: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the field at places (s, p, 3) of facets with nodes (s, n) and shape functions (s, p, n), (s, p).

        Raises
        ------
        ModelError
            If the field gives another shape, or what is not a finite number; the message names the place.
        """
        if not callable(self.given):
            return np.asarray((values @ self._part(self.given)[nodes][..., None])[..., 0])
        if not places.size:
            return np.zeros(places.shape[:2])
        return self._part(asked(self.given, places.reshape(-1, 3), self.label)).reshape(places.shape[:2])

    def _part(self, values: np.ndarray) -> np.ndarray:
        return values if self.component is None else values[:, self.component]


def asked(function: Callable[..., Any], points: np.ndarray, label: str, *more: Any) -> np.ndarray:
    """Return the values of a field at places (n, 3), shape (n,) or (n, 3); refuse others."""
    try:
        given = function(points.copy(), *more)
    except Exception as error:
        error.add_note(f"over= of {label}, which is asked for {len(points)} places, an array of shape {points.shape}")
        raise
    found = numbers(given)
    if found.shape not in ((len(points),), (len(points), 3)):
        raise ModelError(
            f"over= of {label} must give one number for each place, or three: for places of shape {points.shape} it "
            f"gave shape {found.shape}. Remedy: such as lambda x: 1.0 + x[:, 2], or np.full(len(x), 1.0)"
        )
    wrong = ~np.isfinite(found.reshape(len(points), -1)).all(axis=1)
    if wrong.any():
        at = ", ".join(f"{x:.6g}" for x in points[int(wrong.argmax())])
        raise ModelError(f"over= of {label} is not a finite number at the place ({at}) m")
    return found


def checked_field(over: Over, nodes: np.ndarray, label: str) -> tuple[Over, int]:
    """Return a field of places, or values at nodes, and how many numbers it gives at a place, 1 or 3.

    Parameters
    ----------
    over : callable or array_like
    nodes : ndarray, shape (n, 3)
        Of the body, m.
    label : str
    """
    if callable(over):
        more = (0.0,) if takes_time(over, label) else ()
        return over, asked(over, np.asarray(nodes, dtype=float)[:1], label, *more).reshape(1, -1).shape[1]
    values = numbers(over)
    if values.shape not in ((len(nodes),), (len(nodes), 3)) or not np.isfinite(values).all():
        raise ModelError(
            f"over= of {label} must be a function of places, or finite numbers at the {len(nodes)} nodes of the body "
            f"(one or three each, in the order of body.nodes), not {told(over)}. Remedy: such as lambda x: 1.0 + "
            "x[:, 2]; of values at other points, kanefe.MappedField(points, values)"
        )
    return values, values.reshape(len(nodes), -1).shape[1]


def takes_time(function: Callable[..., Any], label: str) -> bool:
    """Return whether a field takes places and time, and not places alone; refuse what takes neither."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # some functions in C have no signature
        return False
    required = [
        p.name for p in parameters if p.default is p.empty and p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)
    ]
    if len(required) not in (1, 2):
        raise ModelError(
            f"over= of {label} must be a function of places, f(x), or of places and time, f(x, t); it takes "
            f"({', '.join(required)})"
        )
    return len(required) == 2


@checked("name")
@dataclass(frozen=True)
class LoadShape:
    """A load that varies by place on a surface, named when a body is made, so that its statics can be in the reduction.

    Parameters
    ----------
    of : str, Place, function of nodes or ShellFace
        The surface, as ``surfaces=`` takes it.
    over : callable
        The shape: a function of places (n, 3) in m, in the frame of the mesh -> (n,).

    Raises
    ------
    ModelError
        If the shape is not such a function.

    Examples
    --------
    Water 3 m deep at a wall, in N/m2 per N/m3:

    >>> depth = LoadShape("wet", over=lambda x: np.maximum(3.0 - x[:, 2], 0.0))
    """

    of: Any
    over: Callable[..., Any]

    def __post_init__(self) -> None:
        if not callable(self.over) or takes_time(self.over, "a LoadShape"):
            raise ModelError(
                f"over= of a LoadShape is a function of places, f(x), not {told(self.over)}. Remedy: such as lambda "
                "x: 1.0 + x[:, 2]; of values at points, kanefe.MappedField(points, values); what varies by time too, "
                "over= of add_pressure and add_traction"
            )


def field_of(shape: LoadShape, name: str) -> PlaceField:
    """Return the field of the surface called `name`."""
    return PlaceField(shape.over, f"the surface {name!r}")
