"""What a load does at given ends, by its action in Python and by its compiled function."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.kernels.compiler.addresses import addresses, call_in_python
from kanefe.kernels.force_elements.places import SIGNATURE, WRENCHES
from kanefe.loads.action import Action, End
from kanefe.loads.base import Load

WAYS = "python", "compiled"


def acted(load: Load, ends: Sequence[End], states: np.ndarray, way: str) -> Action:
    """Return the action of a load, one of two `WAYS`."""
    return load.action(0.0, ends, states) if way == "python" else action_of(load, written(load, ends, states))


def written(load: Load, ends: Sequence[End], states: np.ndarray) -> np.ndarray:
    """Return what the compiled function of a load writes; of complex ends or states that of complex numbers."""
    kernel = load.kernel
    numbers = np.concatenate([np.concatenate((end.p, end.A.ravel(), end.v, end.w)) for end in ends])
    is_complex = np.iscomplexobj(numbers) or np.iscomplexobj(states)
    kind = np.complex128 if is_complex else np.float64
    out = np.zeros(WRENCHES + 6 * len(ends) + len(states), dtype=kind)
    address = addresses(kernel.real, kernel.complex_, SIGNATURE)[is_complex]
    call_in_python(
        address,
        (0.0, kernel.numbers, np.zeros(0), numbers.astype(kind), np.asarray(states).astype(kind), out),
    )
    return out


def action_of(load: Load, out: np.ndarray) -> Action:
    """Return the action that is written in an array."""
    last = WRENCHES + 6 * len(load.ends)
    return Action(out[WRENCHES:last].reshape(-1, 6), out[0], out[1], out[2], out[last:])


def assert_complex_steps_are_differences(
    load: Load, ends: Sequence[End], states: np.ndarray, rtol: float = 1e-6
) -> None:
    """Compare derivatives of forces and rates, along random motions of the ends and rates of the states.

    Central differences of a step of 1e-6 leave 1e-9 of what is smooth, and a thousand times that of small numbers.
    """
    rng = np.random.default_rng(5)
    along = [End(*(rng.standard_normal(np.shape(part)) for part in end)) for end in ends]
    of_states = rng.standard_normal(len(states))

    def at(step: complex) -> tuple[list[End], np.ndarray]:
        moved = [
            End(*(x + step * dx for x, dx in zip(end, change, strict=True)))
            for end, change in zip(ends, along, strict=True)
        ]
        return moved, states + step * of_states

    found = written(load, *at(1e-30j)).imag[WRENCHES:] / 1e-30
    h = 1e-6
    wanted = (written(load, *at(h)) - written(load, *at(-h)))[WRENCHES:] / (2.0 * h)
    np.testing.assert_allclose(found, wanted, rtol=rtol, atol=rtol * np.abs(wanted).max())
