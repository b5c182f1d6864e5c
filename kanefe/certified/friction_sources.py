"""Sources of error of contacts: the springs of friction anchors, against rigid ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from kanefe.certified.choice import Choice, Kept, Source
from kanefe.errors import ModelError, did_you_mean
from kanefe.loads.base import has_contacts

FACTORS = 1.0, 4.0, 16.0, 64.0
"""Factors on the stiffness of anchors; what they leave falls with its inverse."""

GIVEN = "its laws are data. Remedy to measure friction against rigid anchors: stiffer="


def anchor_sources(scene: Any, stiffer: str | Sequence[str]) -> tuple[list[Source], list[Kept]]:
    """Return the friction anchors of the contacts that are named, and the contacts that are as given.

    Raises
    ------
    ModelError
        If there is no contact of a name, or it has no anchors.
    """
    wanted = (stiffer,) if isinstance(stiffer, str) else tuple(stiffer)
    contacts = {load.name: load for load in scene._loads if has_contacts((load,))}
    for name in wanted:
        if name not in contacts:
            did = did_you_mean(name, contacts)
            raise ModelError(
                f"stiffer={name!r}: there is no such contact. {did}There are: {', '.join(contacts) or 'none'}"
            )
        if not getattr(getattr(contacts[name], "friction", None), "spring", 0.0):
            raise ModelError(f"stiffer={name!r}: this contact has no friction anchors")
    sources = [
        Source(
            f"friction anchors of {name}",
            tuple(
                Choice(
                    f"{factor:g} times as stiff",
                    f"{name}: {factor:g} times the stiffness of anchors",
                    anchors={name: factor},
                )
                if factor > 1.0
                else Choice("as given")
                for factor in FACTORS
            ),
        )
        for name in wanted
    ]
    return sources, [Kept(f"contact {name}", GIVEN) for name in contacts if name not in wanted]


def put_anchors(scene: Any, anchors: Mapping[str, float]) -> None:
    """Make friction anchors of an open scene so many times as stiff; their damping follows as the root."""
    for number, load in enumerate(scene._loads):
        factor = anchors.get(load.name, 1.0)
        if factor == 1.0:
            continue
        law = load.friction
        damping = None if law.damping is None else law.damping * factor**0.5
        stiffer = law.with_numbers(stiffness=factor * law.stiffness, damping=damping)
        scene._loads[number] = replace(load, friction=stiffer)
