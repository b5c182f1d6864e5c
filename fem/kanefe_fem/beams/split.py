"""Frames of beams with their elements split: the source of a beam model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.model import FiniteElementModel, NodeGroup
from kanefe.fe_model.places import PlaceLike
from kanefe.fe_model.skin import group_at
from kanefe.fe_model.source import Changeable, ModelSource
from kanefe_fem.machine.memory import check_size

ONE_ORDER = "elements of beams have one order, with cubic bending"


@dataclass(frozen=True, eq=False)
class SplitBeams:
    """What a beam model is made of, element by element.

    Attributes
    ----------
    points : ndarray, shape (n, 3)
    elements : ndarray of int, shape (m, 2)
    sections, materials : list of m
    orientation : array_like, shape (3,) or (m, 3), or None
    groups : dict of str to NodeGroup
    spans : dict of str to ndarray of int
        Elements of each line.
    has_lines : bool
        Whether the lines were given.
    """

    points: np.ndarray
    elements: np.ndarray
    sections: list[Any]
    materials: list[Any]
    orientation: Any
    groups: Mapping[str, NodeGroup]
    spans: Mapping[str, np.ndarray]
    has_lines: bool

    def source(self, make: Callable[[dict[str, Any]], FiniteElementModel]) -> ModelSource:
        """Return the source of the model that ``make(arrays)`` makes, with the keywords of `beam_model` as arrays."""

        def again(refined: int, order: int | None, places: Mapping[str, PlaceLike]) -> FiniteElementModel:
            return make(self.split(refined, places))

        return ModelSource(again, Changeable(len(self.elements)), Changeable(1, ONE_ORDER), keeps_nodes=True)

    def split(self, times: int, places: Mapping[str, PlaceLike]) -> dict[str, Any]:
        """Return the arrays with each element cut into 2^times equal ones; old nodes keep their numbers.

        Sections, materials and directions of an element are those of its parts.
        """
        count, parts, m = len(self.points), 2**times, len(self.elements)
        check_size(m * parts, f"refined={times} of a beam model")
        inner = count + np.arange(m * (parts - 1)).reshape(m, parts - 1)
        chain = np.hstack((self.elements[:, :1], inner, self.elements[:, 1:]))
        ends = self.points[self.elements]
        t = np.arange(1, parts)[:, None] / parts
        new = ends[:, :1] * (1.0 - t) + ends[:, 1:] * t
        towards = None if self.orientation is None else np.asarray(self.orientation, dtype=float)
        found = {name: group_at(self.points, (), place, f"interface {name!r}") for name, place in places.items()}
        if taken := set(found) & set(self.groups):
            raise ModelError(f"the beam model has a group {min(taken)!r} already. Remedy: another name")
        return {
            "nodes": np.vstack((self.points, new.reshape(-1, 3))),
            "elements": np.stack((chain[:, :-1], chain[:, 1:]), axis=2).reshape(-1, 2),
            "section": [section for section in self.sections for _ in range(parts)],
            "material": [material for material in self.materials for _ in range(parts)],
            "orientation": np.repeat(towards, parts, axis=0) if towards is not None and towards.ndim == 2 else towards,
            "groups": {name: group.nodes.tolist() for name, group in {**self.groups, **found}.items()},
            "lines": {
                name: (own[:, None] * parts + np.arange(parts)).ravel().tolist() for name, own in self.spans.items()
            }
            if self.has_lines
            else None,
        }
