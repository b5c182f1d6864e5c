"""Scenes in other units, m, mm and um, kg and t, and of other sizes: what is the same in all of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

import kanefe as kf

SAME = 1e-9
"""Difference of places over a metre, and of axes: round-off of the forces over the stiffness."""


class Units(NamedTuple):
    """How many units of length and of mass a metre and a kilogram have; the second stays."""

    m: float
    kg: float

    @property
    def newton(self) -> float:
        return self.kg * self.m

    @property
    def inertia(self) -> float:
        return self.kg * self.m**2

    @property
    def pascal(self) -> float:
        return self.kg / self.m

    def system(self, *gravity: float) -> kf.System:
        return kf.System(gravity=tuple(self.m * g for g in gravity))

    def at(self, *place: float) -> tuple[float, ...]:
        return tuple(self.m * x for x in place)

    def body(self, scene: kf.System, name: str, mass: float, inertia: float, com: tuple[float, ...], **options: object):
        return scene.add_rigid_body(name, self.kg * mass, self.inertia * inertia, com=self.at(*com), **options)


SI, OTHERS = Units(1.0, 1.0), (Units(1e3, 1e-3), Units(1e6, 1.0), Units(1e-6, 1e-18))
DOWN = (0.0, 0.0, -9.81)


def places(found: kf.Equilibrium, of: Units) -> np.ndarray:
    """Return where the centre, or the tip, of each body is in m, and its rotation."""
    rows = []
    for body in found.model.bodies:
        for interface in (None,) if body.flexible is None else (None, "tip"):
            place, rotation = found.position(body.name, interface), found.rotation(body.name, interface)
            rows.append(np.append(place / of.m, rotation))
    return np.array(rows)


@cache
def in_si(scene: Callable[[Units], kf.Equilibrium]) -> np.ndarray:
    return places(scene(SI), SI)


def assert_same_as_in_si(scene: Callable[[Units], kf.Equilibrium], of: Units) -> None:
    np.testing.assert_allclose(places(scene(of), of), in_si(scene), rtol=0, atol=SAME)
