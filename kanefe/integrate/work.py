"""How much work a method has with a scene, in products: estimates, by which methods are weighed."""

from __future__ import annotations

from kanefe.equations.model import Model
from kanefe.integrate.methods.radau5 import of_order_three
from kanefe.integrate.vibrations import Vibrations

PRODUCTS_A_BODY, PRODUCTS_A_PAIR = 500.0, 6.0
"""Of an evaluation, for each body and each pair of its modes, in units of a product of the factors below."""

STABLE, STAGES = 5.5, 12.0
"""Radians of the fastest vibration in a step of the explicit method, and evaluations of a step."""

EVALUATIONS_A_STEP, PRODUCTS_OF_FACTORS = 6.5, 10.0 / 3.0
"""Of a step of Radau's method: evaluations, and products over the cube of the speeds, of one real and one complex
factorisation (2/3 and four times as many)."""

EVALUATIONS_A_SAMPLE = 400.0
"""Of the extrapolation between samples of a controller, where what is hardly damped vibrates by more than 1e-5."""

ERROR_OF_RADAU = 0.0084
"""Of its formula of order 3, over the fourth power of the radians of a vibration in a step: as measured."""

SEEN_BY_RADAU = 10.0
"""Times what is allowed: its first step damps smaller vibrations."""

LEAST_OF_RADAU, LEAST_BESIDE_KINKS = 100.0, 400.0
"""Steps at least; where forces have kinks."""


def _evaluation(model: Model) -> float:
    """Return how many products an evaluation takes about."""
    modes = [body.flexible.body.free_count for body in model.bodies if body.flexible is not None]
    return PRODUCTS_A_BODY * len(model.bodies) + PRODUCTS_A_PAIR * sum(k * k for k in modes)


def explicit_work(model: Model, radians: float) -> float:
    """Return that of the explicit method, stable over so many radians of the fastest that there is."""
    return max(radians / STABLE, LEAST_OF_RADAU) * STAGES * _evaluation(model)


def radau_work(model: Model, steps: float) -> float:
    """Return that of so many steps of Radau's method."""
    size = model.free_count + (model.state_count if model.states_move else 0)
    return steps * (EVALUATIONS_A_STEP * _evaluation(model) + PRODUCTS_OF_FACTORS * size**3)


def sampled_work(model: Model, samples: float) -> float:
    """Return that of the extrapolation at tight tolerances, which begins anew at samples of controllers."""
    return samples * EVALUATIONS_A_SAMPLE * _evaluation(model)


def steps_of_radau(span: float, rtol: float | None, atol: float, found: Vibrations) -> float:
    """Return how many steps Radau's method takes about: those that its formula of order 3 asks for."""
    if rtol is None:
        return LEAST_OF_RADAU
    errors = found.sizes / (of_order_three(rtol) * (found.sizes + atol / rtol))
    steps = span * found.frequencies * (ERROR_OF_RADAU * errors) ** 0.25
    return float(steps[errors > SEEN_BY_RADAU].max(initial=LEAST_OF_RADAU))
