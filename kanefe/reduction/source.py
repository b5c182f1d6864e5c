"""The source of a body that `flexible_body` makes: its model while somebody has it, or what that was made from."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from kanefe.bodies.source import Changes, Rebuildable, Source, belongs_to_nodes, kept_places, now_of
from kanefe.fe_model.interface import Interface
from kanefe.fe_model.model import FiniteElementModel
from kanefe.fe_model.source import Changeable

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody

GIVEN = "its matrices were given, and not what they were made from"

GONE = "the model with its matrices is gone, a body does not keep it; a variable that holds the model would"


def source_of_model(
    make: Callable[..., FlexibleBody],
    model: FiniteElementModel,
    interfaces: Mapping[str, str | Interface],
    options: Mapping[str, Any],
) -> Source:
    """Return the source of a body that ``make(model, interfaces, **options)`` makes, which is `flexible_body`."""
    held, of_model, interfaces, options = weakref.ref(model), model.source, dict(interfaces), dict(options)

    def again(body: FlexibleBody, changes: Changes) -> FlexibleBody:
        own = dict(interfaces)
        whole: Any = held()
        if of_model is not None and (whole is None or changes.refined or changes.order is not None):
            own, places = kept_places(interfaces) if changes.refined else (own, {})
            whole = of_model.make(changes.refined, changes.order, places)
        asked = {**options, **changes.of_body(options["reduction"], options["stiffening"])}
        return make(whole, own, **asked)

    def about(body: FlexibleBody) -> Rebuildable:
        now = replace(
            now_of(body), reduction=Changeable(options["reduction"]), stiffening=Changeable(options["stiffening"])
        )
        whole = held()
        if of_model is None:
            return _of_matrices(now, whole)
        by_number = belongs_to_nodes(interfaces, options["damping"])
        mesh = replace(of_model.mesh, now=now.mesh.now).but(by_number)
        return replace(now, mesh=mesh, order=of_model.order.but(by_number))

    return Source(again, about)


def _of_matrices(now: Rebuildable, model: FiniteElementModel | None) -> Rebuildable:
    if model is None:
        return now.but(GONE)
    told = replace(now.but(GIVEN), reduction=now.reduction, stiffening=now.stiffening)
    if model.stress_stiffness is None and model.geometric_stiffness is None:
        without = Changeable(now.stiffening.now, "its matrices come without a geometric stiffness")
        return replace(told, stiffening=without)
    return told
