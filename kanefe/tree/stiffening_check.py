"""A warning if a body with stiffening="inertial" carries bodies or loads that would stiffen it too."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from kanefe.errors import outside
from kanefe.tree.body_terms import BodyTerms, is_unreduced
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame


class StiffeningWarning(UserWarning):
    """Forces on a body whose effect on its stiffness is neglected, although that of its own inertia is not."""


def warn_of_loads_that_do_not_stiffen(model: ModelData) -> None:
    """Warn of bodies with stiffening="inertial" that carry bodies, loads or loops, whose effect is neglected.

    A mass on the tip of a rotating beam stiffens it. Without this effect the beam softens with speed and diverges.
    """
    missing: dict[int, list[str]] = {}
    for number, words in unstiffened(model):
        missing.setdefault(number, []).append(words)
    for number, carried in missing.items():
        terms = model.bodies[number].flexible
        is_full = terms is not None and terms.body.provenance.get("stiffening") == "full"
        level, remedy = ("inertial", "make the body with stiffening='full'")
        if is_full:
            level, remedy = ("full", "surfaces={'own': LoadShape(...)} when the body is made, in place of over=")
        warnings.warn(
            f"flexible body {model.bodies[number].name!r} has stiffening={level!r}, which leaves out what the forces "
            f"of {', '.join(dict.fromkeys(carried))} do to its stiffness: in a spin its frequencies may be far off. "
            f"Remedy: {remedy}",
            StiffeningWarning,
            stacklevel=outside(),
        )


def unstiffened(model: ModelData) -> Iterator[tuple[int, str]]:
    """Yield the number of a body that stiffens, and a name for each thing it carries that does not stiffen it."""
    for body in model.bodies:
        if body.parent_interface is not None and _lacks(model, body.parent, body.parent_interface):
            yield body.parent, f"body {body.name!r} at interface {body.parent_interface.name!r}"
    for number, body in enumerate(model.bodies):
        for load, frame in body.loads:
            if frame is not None and _lacks(model, number, frame):
                yield number, load.label
        for field_load in body.field_loads:
            may_stiffen = field_load.follows or not field_load.is_pressure
            if may_stiffen and field_load.pattern.quadratic_first is None and _stiffens(body):
                yield number, field_load.label
    for load_between in model.loads:
        for marker in load_between.ends:
            if marker.interface is not None and _lacks(model, marker.body, marker.interface):
                yield marker.body, f"{load_between.kind} {load_between.name!r}"
    for constraint in model.constraints:
        for row in constraint.rows:
            for marker in row.markers:
                if marker.interface is not None and _lacks(model, marker.body, marker.interface):
                    yield marker.body, f"{constraint.kind} {constraint.name!r}"


def _stiffens(body: BodyTerms) -> bool:
    """Return whether the inertia of a body stiffens it."""
    return (
        body.flexible is not None
        and not is_unreduced(body.flexible.body)
        and body.flexible.body.moments.quadratic_first is not None
    )


def _lacks(model: ModelData, number: int, frame: InterfaceFrame) -> bool:
    """Return whether a body stiffens, but not by loads on a frame that moves with its coordinates."""
    body = model.bodies[number]
    if body.flexible is None or frame.quadratic is not None or not _stiffens(body):
        return False
    return bool(np.any(frame.motion[:, : body.flexible.body.free_count]))
