"""What must not matter: where a scene is, how it is turned, its units, the order of its bodies, cuts through them."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import follow
from kanefe.checks.robustness.units import MILLIMETRES, Units
from kanefe.frames import rotation_matrix
from kanefe.result import Result
from robustness.random_scenes import Description, random_description

SPAN, OUTPUTS = 1.0, 5
"""Duration of each run, s, and number of its outputs."""

RTOL, ATOL = 1e-12, 1e-15

LIMIT = 1e-9
REASON = "a hundred steps of 1e-12 each, which the motion spreads by some tens"

Poses = dict[str, tuple[np.ndarray, np.ndarray]]
"""Positions (T, 3) in m and matrices A_NF (T, 3, 3) of frames, by name."""

Comparison = Callable[[Poses], Poses]

ODD = Units(length=1.0 / 0.3048, mass=1.0 / 14.5939, time=37.0)
"""Feet, slugs, and an arbitrary unit of time."""


def poses(scene: Description) -> Poses:
    """Return where the frames of a scene go, in SI units whatever it is written in."""
    units = scene.units
    model = scene.build().freeze()
    span = SPAN * units.time
    run = follow(model, span, rtol=RTOL, atol=ATOL, method="dop853", output_step=span / OUTPUTS)
    result, found = Result(model, run), {}
    for part in scene.parts:
        for label, interface in ((part.name, None), *(((f"{part.name} tip", "tip"),) if part.lattice >= 0 else ())):
            matrices = np.array([rotation_matrix(e) for e in result.rotation(part.name, interface)])
            found[label] = result.position(part.name, interface) / units.length, matrices
    return found


def difference(expected: Poses, found: Poses) -> float:
    """Return the largest difference of positions (m) and of direction cosines of the frames that are expected."""
    worst = 0.0
    for name, (place, matrix) in expected.items():
        worst = max(worst, float(np.abs(found[name][0] - place).max()), float(np.abs(found[name][1] - matrix).max()))
    return worst


def _shifted(scene: Description, rng: np.random.Generator) -> tuple[Description, Comparison]:
    shift = rng.uniform(-100.0, 100.0, 3)
    return scene.moved(shift), lambda found: {name: (p + shift, A) for name, (p, A) in found.items()}


def _turned(scene: Description, rng: np.random.Generator) -> tuple[Description, Comparison]:
    e = rng.standard_normal(4)
    e /= np.linalg.norm(e)
    Q = rotation_matrix(e)
    return scene.turned(e), lambda found: {name: (p @ Q.T, Q @ A) for name, (p, A) in found.items()}


def _in_units(scene: Description, rng: np.random.Generator) -> tuple[Description, Comparison]:
    units = (MILLIMETRES, ODD, Units(1e-3, 1e3, 1e-3))[int(rng.integers(3))]
    return scene.written_in(units), _same


def _same(found: Poses) -> Poses:
    return found


CHANGES: dict[str, Callable[[Description, np.random.Generator], tuple[Description, Comparison]]] = {
    "moved by up to 100 m": _shifted,
    "turned as a whole": _turned,
    "written in other units": _in_units,
    "bodies, loads and springs added in another order": lambda scene, rng: (scene.reordered(rng), _same),
    "every rigid body cut in two and fixed together": lambda scene, rng: (scene.split(rng), _same),
}


def invariances(effort: Effort) -> Iterator[Finding]:
    """Compare random scenes with themselves, changed in a way that must not matter."""
    seeds = range(effort.count(200, 3))
    scenes = [random_description(seed) for seed in seeds]
    originals = [poses(scene) for scene in scenes]
    for name, change in CHANGES.items():
        errors = []
        for seed, scene, original in zip(seeds, scenes, originals, strict=True):
            changed, comparison = change(scene, np.random.default_rng((seed, 3)))
            errors.append(difference(comparison(original), poses(changed)))
        # far from N's origin positions have the round-off of the distance: 100 m 2e-16, grown by some tens
        yield Finding.of(
            f"random scenes of up to 6 bodies, {name}, {SPAN:g} s",
            errors,
            "largest difference [m, 1]",
            LIMIT,
            REASON,
            f"scene {int(np.argmax(errors))} is the worst",
        )


CASES = (StressCase("invariance", "translation, rotation, units, order of bodies, cuts", invariances),)
