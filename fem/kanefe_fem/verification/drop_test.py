"""K23: a drop test of the gear from a mesh, with lift, according to 14 CFR 27.725."""

from __future__ import annotations

import math
from collections.abc import Iterator
from importlib.resources import as_file, files
from typing import NamedTuple

import numpy as np
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.result import Result
from kanefe_fem.sramss import parameters as given
from kanefe_fem.sramss import spatial_gear, spatial_scene
from kanefe_fem.sramss.spatial import SHOES

SPAN, STEP = 0.1, 1e-4
"""Duration of the run and interval of its outputs, s: the lowest position is at 0.04 to 0.05 s."""


class Drop(NamedTuple):
    """A run, the total force of all shoes (N), the lowest output, and the vertical travel of the airframe (m)."""

    result: Result
    pushed: np.ndarray
    lowest: int
    way: float

    @classmethod
    def of(cls, result: Result) -> Drop:
        """Return the values of a run."""
        height = result.position("airframe")[:, 2]
        lowest = int(np.argmin(height))
        pushed = np.sum([result.contact(shoe).normal for shoe in SHOES], axis=0)
        return cls(result, pushed, lowest, float(height[0] - height[lowest]))


def drop(reference: Reference) -> Iterator[Check]:
    """K23: two methods; the energy absorbed by the gear; the impulse of its shoes; load factors."""
    height, lift = (reference.values[name] for name in ("height", "lift"))
    with as_file(files("kanefe_fem") / "data" / "skid_gear.msh") as path:
        gear = spatial_gear(path)
    mass = given.AIRFRAME_MASS + gear.mass
    weight, sink = mass * given.GRAVITY, math.sqrt(2.0 * given.GRAVITY * height)
    for mu in reference.values["mu"]:
        scene, what = spatial_scene(gear, mu=mu, lift=lift * weight, sink=sink), f"mu {mu:g}"
        one, other = (
            Drop.of(scene.simulate((0.0, SPAN), method=method, rtol=1e-9, output_step=STEP))
            for method in ("radau5", "dop853")
        )
        quantity = f"peak load of the shoes and way, {what}, radau5 against dop853 [N, m]"
        yield Check.relative(quantity, [one.pushed.max(), one.way], [other.pushed.max(), other.way], 1e-7)

        centre, energy, momentum = other.result.center_of_mass()[:, 2], other.result.energy, other.result.momentum
        # the travel of the gear is less than that of the airframe, on which the lift acts
        fallen = weight * (height + centre[0] - centre[other.lowest]) - lift * weight * other.way
        taken = (energy.kinetic + energy.elastic + energy.dissipated)[other.lowest]
        yield Check.relative(f"energy of the drop, {what} [J]", taken, fallen, 1e-6)
        impulse = simpson(other.pushed, x=other.result.times)
        change = momentum.linear[-1, 2] - momentum.linear[0, 2] + (1.0 - lift) * weight * SPAN
        yield Check.relative(f"impulse of the shoes, {what} [N s]", impulse, change, 1e-5)

        effective = weight * (height + (1.0 - lift) * other.way) / (height + other.way)
        factor = other.pushed.max() / effective  # nj, of the gear alone, dropped without lift
        slowed = CubicSpline(other.result.times, momentum.linear[:, 2])(other.result.times, 1).max() / mass
        quantity = f"load factor nj We / W + L, {what}, to how the aircraft is slowed down"
        yield Check.relative(quantity, factor * effective / weight + lift, 1.0 + slowed / given.GRAVITY, 1e-5)


CASES = (Case("K23", drop),)
