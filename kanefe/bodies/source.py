"""What a body was made from, so that it can be made again: with another reduction, stiffening, mesh or order.

A source holds what its maker was given, by reference; matrices of the full-order model it does not hold. It is no field
of the body: copies, pickles and files have none.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple, TypeVar

from kanefe.arguments import told
from kanefe.errors import ModelError
from kanefe.fe_model.interface import Interface, as_interface
from kanefe.fe_model.places import PlaceLike
from kanefe.fe_model.source import Changeable

UNKNOWN = (
    "what it was made from is not known: a body from a file or another process, or changed after it was made, has its "
    "reduced matrices alone"
)
"""Reason why a body without a source cannot be made again."""

LEVELS = ("none", "inertial", "full")

Body = TypeVar("Body")


class Changes(NamedTuple):
    """What is to be otherwise in a body.

    Attributes
    ----------
    reduction : object
        None: as it was; "none": every degree of freedom is kept.
    stiffening : str or None
    refined : int
        Number of times that cells are split.
    order : int or None
    segments : int or None
        Of a segmented body.
    """

    reduction: Any = None
    stiffening: str | None = None
    refined: int = 0
    order: int | None = None
    segments: int | None = None

    def of_body(self, reduction: Any, stiffening: Any) -> dict[str, Any]:
        """Return reduction and stiffening after the changes, as keywords of the maker."""
        if self.reduction is not None:
            reduction = None if isinstance(self.reduction, str) and self.reduction == "none" else self.reduction
        return {"reduction": reduction, "stiffening": self.stiffening or stiffening}


@dataclass(frozen=True)
class Rebuildable:
    """What of a body can be changed by `FlexibleBody.rebuilt`, and where not, why.

    Attributes
    ----------
    reduction, stiffening, mesh, order : Changeable
        `now` is the reduction, the level of stiffening, the number of cells, the order of the displacement.

    Examples
    --------
    >>> from kanefe_fem import Material, Rectangle, beam_body, straight_beam
    >>> import kanefe as kf
    >>> rod = straight_beam(1.0, Rectangle(0.02, 0.02), Material(E=210e9, nu=0.3, rho=7850.0))
    >>> body = beam_body(rod, {"root": "clamped"}, kf.CraigBampton(modes=4))
    >>> print(body.rebuildable)
    reduction   CraigBampton(modes=4)  yes
    stiffening  none                   yes
    mesh        20 cells               yes
    order       1                      no: elements of beams have one order, with cubic bending
    """

    reduction: Changeable
    stiffening: Changeable
    mesh: Changeable
    order: Changeable

    def __str__(self) -> str:
        rows = [(f.name, _words(f.name, getattr(self, f.name).now), str(getattr(self, f.name))) for f in fields(self)]
        width = max(len(now) for _, now, _ in rows)
        return "\n".join(f"{name:10}  {now:{width}}  {answer}".rstrip() for name, now, answer in rows)

    def but(self, why_not: str) -> Rebuildable:
        """Return the same with a reason why nothing can be changed."""
        return Rebuildable(*(getattr(self, f.name).but(why_not) for f in fields(self)))


def _words(name: str, now: Any) -> str:
    return f"{now} cells" if name == "mesh" else str(now)


@dataclass(frozen=True, eq=False)
class Source:
    """How to make a body again.

    Attributes
    ----------
    make : callable
        ``make(body, changes) -> body``, of the body that has this source.
    about : callable
        ``about(body) -> Rebuildable``.
    """

    make: Callable[[Any, Any], Any]
    about: Callable[[Any], Rebuildable]


def sourced(body: Body, source: Source) -> Body:
    """Return a new body after it was told what it was made from."""
    object.__setattr__(body, "source", source)
    return body


def about_body(body: Any) -> Rebuildable:
    """Return what of a body can be changed."""
    if body.source is not None:
        about: Rebuildable = body.source.about(body)
        return about
    return now_of(getattr(body, "segments", (body,))[0]).but(UNKNOWN)


def now_of(body: Any, order: Any = None) -> Rebuildable:
    """Return what a body has, as if all of it could be changed."""
    record = body.provenance.get("reduction", {})
    method = record.get("method") if isinstance(record, Mapping) else None
    return Rebuildable(
        Changeable(method),
        Changeable(body.provenance.get("stiffening", "none")),
        Changeable(sum(len(block.nodes) for block in body.cells)),
        Changeable(order),
    )


def rebuilt_body(body: Any, changes: Any, label: str = "this body") -> Any:
    """Return the body made again with changes; itself if there are none.

    Raises
    ------
    ModelError
        If a change is not valid, or not possible; the message says why.
    """
    _check(changes)
    asked = [name for name in Rebuildable.__dataclass_fields__ if _is_asked(changes, name)]
    about = body.rebuildable
    for name in asked:
        if not getattr(about, name):
            raise ModelError(
                f"the {name} of {label} cannot be changed: {getattr(about, name).why_not}. Remedy: make it from its "
                "source with other arguments; print(body.rebuildable) shows what can be changed"
            )
    return body.source.make(body, changes) if body.source is not None and any(changes) else body


def _is_asked(changes: Changes, name: str) -> bool:
    return bool(changes.refined) if name == "mesh" else getattr(changes, name) is not None


def _check(changes: Changes) -> None:
    if (
        changes.reduction is not None
        and isinstance(changes.reduction, str)
        and changes.reduction not in ("auto", "none")
    ):
        raise ModelError(
            f"reduction={changes.reduction!r} of a rebuilt body. Remedy: CraigBampton(modes=...) or another reduction; "
            "'auto' is CraigBampton(), 'none' keeps every degree of freedom; None leaves the reduction as it was"
        )
    if changes.stiffening is not None and (not isinstance(changes.stiffening, str) or changes.stiffening not in LEVELS):
        raise ModelError(f"stiffening={told(changes.stiffening)} of a rebuilt body. Remedy: {', '.join(LEVELS)}")
    if isinstance(changes.refined, bool) or not isinstance(changes.refined, int) or changes.refined < 0:
        raise ModelError(
            f"refined={told(changes.refined)} of a rebuilt body. Remedy: the number of times that its cells are split, "
            "a whole number from 0"
        )
    if changes.order is not None and (isinstance(changes.order, bool) or changes.order not in (1, 2)):
        raise ModelError(f"order={told(changes.order)} of a rebuilt body. Remedy: 1 or 2")


def kept_places(
    interfaces: Mapping[str, str | Interface],
) -> tuple[dict[str, str | Interface], dict[str, PlaceLike]]:
    """Return interfaces that are the same parts when cells are split, and the places that become groups before.

    A place would catch other facets of a finer mesh.
    """
    kept, places = dict(interfaces), dict[str, PlaceLike]()
    for name, given in interfaces.items():
        spec = as_interface(name, given)
        if spec.at is not None:
            group = f"{name} (by its place)"
            places[group], kept[name] = spec.at, replace(spec, at=None, groups=(group,))
    return kept, places


def belongs_to_nodes(interfaces: Mapping[str, str | Interface], damping: Any) -> str:
    """Return what of the options belongs to the nodes of one mesh, as a reason not to change it; empty if nothing."""
    for name, given in interfaces.items():
        spec = as_interface(name, given)
        if spec.weights is not None and not isinstance(spec.weights, str):
            return f"interface {name!r} has a weight for each of its nodes"
    if damping is not None and hasattr(damping, "shape"):
        return "its damping is a matrix of the degrees of freedom of this mesh"
    return ""
