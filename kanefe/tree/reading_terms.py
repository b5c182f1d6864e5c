"""What is read of a state as a sum of its entries, as compiled code can do."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kanefe.errors import ModelError
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.loads.controller import Reading


def terms_of(model: ModelData, reading: Reading) -> list[tuple[int, float]] | None:
    """Return places in the state (q, u, z) and their factors, whose sum a reading is; None: it is no such sum."""
    i, number, n = reading.component, model.index(reading.body), model.coordinate_count
    body = model.bodies[number]
    if reading.what == "joint_coordinates":
        return [(int(body.coordinates[i]), 1.0)] if body.coordinates[i] >= 0 else None
    if reading.what == "joint_speeds":
        return [(n + int(body.speeds[i]), 1.0)] if body.speeds[i] < model.free_count else None
    if body.flexible is None or not body.flexible.body.components:
        return None
    eta = body.flexible.eta
    if reading.what == "modal_coordinates":
        return [(eta.start + i, 1.0)]
    if reading.what == "modal_speeds":
        return [(n + body.flexible.speeds.start + i, 1.0)]
    if reading.what == "deflection":
        frame = body.flexible.body.interface(reading.interface)
        if frame.is_linear:
            return [(eta.start + k, float(frame.motion[i, k])) for k in range(eta.stop - eta.start)]
    return None


def checked_terms(model: ModelData, reading: Reading, label: str) -> list[tuple[int, float]]:
    """Return the same of a compiled load; a ModelError names it where what it reads is no such sum."""
    terms = terms_of(model, reading)
    if terms is None:
        raise ModelError(
            f"the compiled function of {label} reads {reading.label!r}, which is not in the state: a driven "
            "coordinate, or a deflection that is not linear in the modal coordinates (of second order, or of an exact "
            "beam). Remedy: a function of time, modal_coordinates, or a function in Python, f(t, state)"
        )
    return terms
