"""What a full-order model was made from, so that it can be made again on a finer mesh or of another order."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from kanefe.fe_model.model import FiniteElementModel
from kanefe.fe_model.places import PlaceLike


@dataclass(frozen=True)
class Changeable:
    """Whether something of a body can be made otherwise; as a condition, whether it can.

    Attributes
    ----------
    now : object
        What the body has.
    why_not : str
        Why it cannot be changed; empty if it can.
    told : str
        What a change does not reach.
    """

    now: Any = None
    why_not: str = ""
    told: str = ""

    def but(self, why_not: str) -> Changeable:
        """Return the same with a reason why it cannot be changed, unless that is empty or there is one already."""
        return replace(self, why_not=self.why_not or why_not)

    def __bool__(self) -> bool:
        return not self.why_not

    def __str__(self) -> str:
        answer = f"no: {self.why_not}" if self.why_not else "yes"
        return f"{answer}; {self.told}" if self.told and not self.why_not else answer


@dataclass(frozen=True, eq=False)
class ModelSource:
    """How to make a model again.

    Attributes
    ----------
    make : callable
        ``make(refined, order, places) -> FiniteElementModel``: with its cells split so many times, of this order (None:
        as it was), and with groups of what lies in places before cells are split.
    mesh, order : Changeable
        Whether the mesh and the order can be changed.
    keeps_nodes : bool
        Whether nodes keep their numbers on a finer mesh.
    """

    make: Callable[[int, int | None, Mapping[str, PlaceLike]], FiniteElementModel]
    mesh: Changeable
    order: Changeable
    keeps_nodes: bool = False

    def then(self, change: Callable[[FiniteElementModel], FiniteElementModel]) -> ModelSource:
        """Return the source of a model that is changed after it was made."""
        make = self.make
        return replace(self, make=lambda refined, order, places: change(make(refined, order, places)))


def with_source(model: FiniteElementModel, source: ModelSource | None) -> FiniteElementModel:
    """Return a new model after it was told what it was made from; a changed copy of it has no source."""
    object.__setattr__(model, "source", source)
    return model


def changed_model(
    model: FiniteElementModel,
    change: Callable[[FiniteElementModel], FiniteElementModel],
    *,
    by_number: str = "",
) -> FiniteElementModel:
    """Return ``change(model)``, which is made again from the source of the model.

    Parameters
    ----------
    model : FiniteElementModel
    change : callable
    by_number : str
        What of the change belongs to the numbers of this mesh's nodes, so that it has no meaning on another mesh.
    """
    source = None if model.source is None else model.source.then(change)
    if source is not None and by_number and not source.keeps_nodes:
        source = replace(source, mesh=source.mesh.but(by_number), order=source.order.but(by_number))
    return with_source(change(model), source)
