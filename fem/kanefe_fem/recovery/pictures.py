"""Pictures of a body with a scalar of its stress; shells with their thickness and both faces."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

import numpy as np

from kanefe.errors import ModelError
from kanefe.results.reader import Reader
from kanefe_fem.recovery.envelope import Envelope
from kanefe_fem.recovery.scalars import FAILURES, TITLES, Scalar
from kanefe_fem.recovery.shell_fields import ShellStrainFields
from kanefe_fem.recovery.strain_fields import StrainFields

DRAWN = 0.05
"""Largest displacement that is drawn, relative to the size of the body."""


class Recovered(Protocol):
    """What pictures need of a `kanefe_fem.recovery.recovery.Recovery`."""

    result: Reader
    name: str
    frames: np.ndarray
    eta: np.ndarray
    material: int | None

    def envelope(self, quantity: Scalar) -> Envelope:
        """Return the greatest value of a scalar over the times, at every node."""
        ...


def write_picture(
    recovery: Recovered,
    fields: StrainFields,
    path: str | Path,
    quantity: Scalar,
    frame: int | None,
    scale: float | None,
    options: dict[str, Any],
) -> Path:
    """Write the picture that `Recovery.picture` describes; return its path."""
    from kanefe.views.pictures import write_field

    if quantity not in fields.scalars:
        raise ModelError(f"there is no picture of {quantity!r}. There are: {', '.join(fields.scalars)}")
    eta = recovery.eta if frame is None else recovery.eta[frame][None]
    nodes, arms, cells = np.arange(len(fields.nodes)), None, fields.cells
    if isinstance(fields, ShellStrainFields) and fields.face is None and fields.ply is None:
        drawn = fields.drawn()
        values = fields.faces_scalar(quantity, eta, recovery.material)
        nodes, arms, cells = drawn.nodes, drawn.arms, drawn.all_cells
    elif frame is None:
        values = recovery.envelope(quantity).values
    else:
        values = fields.scalar(quantity, "nodes", eta, recovery.material)[0]
    points = fields.nodes[nodes] if arms is None else fields.nodes[nodes] + arms
    if frame is not None:
        shape = recovery.result.body(recovery.name)
        moved = recovery.result.nodal_displacements(recovery.name, int(recovery.frames[frame]), nodes)
        if arms is not None:
            moved = moved + np.cross(shape.rotations(eta, nodes)[0], arms)
        size, largest = float(np.ptp(points, axis=0).max()), float(abs(moved).max())
        factor = scale if scale is not None else (DRAWN * size / largest if largest > 0.0 else 1.0)
        points = points + factor * moved
    unit, per_unit = ("1", 1.0) if quantity in FAILURES else ("MPa", 1e6)
    limit = options.pop("limit")
    last = None if limit is None else limit / per_unit
    return write_field(path, points, cells, values / per_unit, f"{TITLES[quantity]} [{unit}]", limit=last, **options)
