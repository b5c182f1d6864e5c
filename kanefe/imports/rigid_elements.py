"""Rigid elements of Nastran's bulk data, of which matrices of all grid points (KGG, MGG) know nothing."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Mapping
from typing import Any

import numpy as np

from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.imports.card import Card

REFERENCE = {"RBE2": (3,), "RBE3": (4,), "RBAR": (3, 4), "RROD": (3, 4), "RBE1": (3, 5, 7)}
"""Fields with the grid points of rigid elements that may have nothing else."""

TIES = (*REFERENCE, "RBAR1", "RSPLINE", "RTRPLT", "RTRPLT1", "RSSCON", "MPC")
"""Cards that tie grid points to each other."""


def check_rigid_elements(
    cards: Iterable[Card], stiff: Collection[int], heavy: Collection[int], groups: Mapping[str, Any], name: str
) -> None:
    """Refuse grid points that are in a rigid element only, and tell which elements a matrix does not hold.

    Parameters
    ----------
    cards : iterable of Card
    stiff, heavy : labels
        Grid points with rows in the stiffness and in the mass matrix.
    groups : dict of str to labels
        Groups that were asked for.
    name : str
        Name of the stiffness matrix in its file.

    Raises
    ------
    ModelError
        If a group names such a grid point, or one has mass.

    Warns
    -----
    AccuracyWarning
        If the matrix is that of all grid points (``K*GG``), and there are such elements.
    """
    ties = [card for card in cards if card.name in TIES]
    if not ties:
        return
    only: dict[int, Card] = {}
    for card in ties:
        for field in REFERENCE.get(card.name, ()):
            if card.field(field).isdigit() and card.whole(field) not in stiff:
                only.setdefault(card.whole(field), card)
    for group, labels in groups.items():
        for label in np.atleast_1d(np.asarray(labels)).tolist():
            if label in only:
                raise _in_element_only(f"group {group!r} has grid point {label}", only[label], name)
    for label in sorted(set(heavy) & set(only)):
        raise _in_element_only(f"grid point {label} has mass", only[label], name)
    if name.endswith("GG"):
        listed = ", ".join(f"{card.name} {card.field(2)}" for card in ties[:5]) + (", ..." if len(ties) > 5 else "")
        warnings.warn(
            f"{name} knows nothing of rigid elements and MPC: the body is without {listed}. Remedy: tie these grid "
            "points as interfaces of kind 'rigid' or 'average', or export KAA and MAA with their rows as freedoms=",
            AccuracyWarning,
            stacklevel=outside(),
        )


def _in_element_only(what: str, card: Card, name: str) -> ModelError:
    return ModelError(
        f"{what}, which is in {card.name} {card.field(2)} ({card.file}, line {card.at}) only: {name} has no stiffness "
        "there, since it knows nothing of rigid elements. Remedy: a group of the grid points that the element ties, "
        "as an interface of kind 'rigid' (RBE2) or 'average' (RBE3) with position= of this point; or export KAA "
        "and MAA with their rows as freedoms="
    )
