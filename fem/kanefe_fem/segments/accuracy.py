"""How many segments an accuracy needs: results of k are compared with those of 2 k."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import kanefe as kf
from kanefe.bodies.segmented import SegmentedBody
from kanefe.errors import AccuracyWarning, ModelError, SimulationError
from kanefe.frames import numbers, rotation_matrices, shaped_numbers
from kanefe_fem.segments.centre_line import arc_lengths

FREQUENCIES = 3
"""Number of frequencies that are compared."""

ORDER = 2
"""Power of the length of a segment with which errors fall."""

NAME = "body"
"""Name of the body in the scenes of comparisons."""

GRAVITY = 9.81
"""Weight per mass under which bodies without loads are compared, m/s2."""

Measure = dict[str, np.ndarray]


def converged(
    chain: Callable[[int], SegmentedBody],
    segments: int | None,
    accuracy: float,
    loads: Mapping[str, Sequence[float]] | None,
    along: Callable[[SegmentedBody], Any] | None,
) -> SegmentedBody:
    """Return the chain of the fewest segments, of a number and its doubles, whose estimated error is small enough."""
    limit = numbers(accuracy)
    if limit.shape != () or not 0.0 < limit < 1.0:
        raise ModelError(f"accuracy = {accuracy!r} must be a relative error between 0 and 1")
    if loads is not None and along is not None:
        raise ModelError("give loads= or along=, not both")
    count = 4 if segments is None else int(segments)
    coarse = chain(count)
    before = _measured(coarse, loads, along)
    while True:
        try:
            fine = chain(2 * count)
        except ModelError as error:
            told = "" if before else " (they have no balance, or no modes about it)"
            raise ModelError(
                f"the accuracy {accuracy:g} is not reached by {count} segments{told}, and {error}"
            ) from error
        after = _measured(fine, loads, along)
        if before and after:
            factor = 2**ORDER / (2**ORDER - 1.0)
            found = {name: factor * float(abs(after[name] - before[name]).max(initial=0.0)) for name in before}
            if max(found.values()) <= limit:
                return replace(coarse, found=found)
        coarse, before, count = fine, after, 2 * count


def _measured(
    chain: SegmentedBody,
    loads: Mapping[str, Sequence[float]] | None,
    along: Callable[[SegmentedBody], Any] | None,
) -> Measure:
    """Return positions over the length, rotations and frequencies; nothing if there is no balance with so few."""
    length = arc_lengths(chain.line)[-1]
    faces = {name: chain.segments[chain.segment_of(name)].body.interface(name) for name in chain.interfaces}
    names = [name for name, face in faces.items() if not face.fixed_components]
    if not names:
        raise ModelError("accuracy= compares interfaces that move, and there is none. Remedy: {'tip': 'rigid'}")
    if along is not None:
        result = along(chain)
        if not hasattr(result, "deflection") or not any(name.startswith(f"{NAME} ") for name in result.bodies):
            raise ModelError(f"along must return a Result in which the chain is called {NAME!r}, not {result!r}")
        result.raise_for_status()
        moved = np.concatenate([result.position(NAME, name) for name in names])
        turned = np.concatenate([rotation_matrices(result.rotation(NAME, name)).reshape(-1, 9) for name in names])
        return {
            "displacement": moved / length,
            "rotation": turned,
            "frequency": _frequencies(kf.equilibrium(_scene(chain))),
        }
    try:
        with warnings.catch_warnings():  # few segments bend too far each, which is what is found out
            warnings.simplefilter("ignore", AccuracyWarning)
            rests = [kf.equilibrium(_scene(chain, *case)) for case in _cases(chain, loads)]
            frequency = _frequencies(rests[0] if loads else kf.equilibrium(_scene(chain)))
    except SimulationError:
        return {}
    found = np.array([rest.deflection(NAME, name) for rest in rests for name in names])
    return {"displacement": found[:, :3] / length, "rotation": found[:, 3:], "frequency": frequency}


def _cases(
    chain: SegmentedBody, loads: Mapping[str, Sequence[float]] | None
) -> list[tuple[dict[str, np.ndarray], np.ndarray]]:
    """Return the static cases: loads at interfaces, and gravity."""
    if loads is None:
        return [({}, axis * GRAVITY) for axis in np.eye(3)]
    given = {}
    for name, load in loads.items():
        chain.segment_of(name)
        given[name] = shaped_numbers(load, (6,), f"the load on {name!r}, force and moment,")
    return [(given, np.zeros(3))]


def _scene(
    chain: SegmentedBody, loads: Mapping[str, np.ndarray] | None = None, gravity: np.ndarray | None = None
) -> kf.System:
    """Return a scene in which G of the chain is at rest."""
    scene = kf.System(gravity=(0.0, 0.0, 0.0) if gravity is None else gravity.tolist())
    body = scene.add_segmented_body(NAME, chain)
    for name, load in (loads or {}).items():
        scene.add_force(body.interface(name), load[:3].tolist())
        if load[3:].any():
            scene.add_torque(body.interface(name), load[3:].tolist())
    return scene


def _frequencies(rest: kf.Equilibrium) -> np.ndarray:
    """Return the logarithms of the first frequencies about a balance, so that differences are relative."""
    frequencies = rest.linearise().modes().frequencies
    return np.log(np.sort(frequencies[frequencies > 0.0])[:FREQUENCIES])
