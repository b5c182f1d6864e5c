"""How much work a method has with a scene, in products: estimates, by which methods are weighed."""

from __future__ import annotations

import numpy as np

from kanefe.equations.model import Model
from kanefe.equations.routes import newton_work
from kanefe.integrate.auto.vibrations import Vibrations
from kanefe.integrate.methods.radau5 import of_order_three

PRODUCTS_A_BODY, PRODUCTS_A_FLEXIBLE_BODY, PRODUCTS_A_PAIR = 500.0, 4000.0, 6.0
"""Products in an evaluation for each rigid body, for each flexible body, and for each pair of its modes, in units of a
product of the factors below."""

PRODUCTS_A_CALL = 20_000.0
"""Products in a call of a Python function of the user, whatever it does."""

STABLE, STAGES = 5.5, 12.0
"""Radians of the fastest vibration in a step of the explicit method, and number of evaluations in a step."""

EVALUATIONS_A_STEP, PRODUCTS_OF_FACTORS = 6.5, 10.0 / 3.0
"""Evaluations in a step of Radau's method, and products relative to the cube of the number of speeds for one real and
one complex factorisation (2/3 and four times as many)."""

EVALUATIONS_A_SAMPLE = 400.0
"""Evaluations of the extrapolation between samples of a controller where nearly undamped modes vibrate by more than
1e-5."""

ERROR_OF_RADAU = 0.0084
"""Measured error of Radau's third-order formula relative to the fourth power of the radians of a vibration in a step.
"""

SEEN_BY_RADAU = 10.0
"""Vibration, in multiples of the permitted error, above which Radau's method resolves it: its first step damps smaller
ones."""

LEAST_DECAY = 1e-6
"""Decay of a vibration in a run below which it counts as undamped."""

LEAST_OF_RADAU, LEAST_BESIDE_KINKS = 100.0, 400.0
"""Least number of steps, without and with kinks in the forces."""


def compiled_evaluation(model: Model) -> float:
    """Return how many products the compiled part of an evaluation takes about."""
    modes = [body.flexible.body.free_count for body in model.bodies if body.flexible is not None]
    own = PRODUCTS_A_FLEXIBLE_BODY * len(modes) + PRODUCTS_A_PAIR * sum(k * k for k in modes)
    return PRODUCTS_A_BODY * (len(model.bodies) - len(modes)) + own


def evaluation(model: Model) -> float:
    """Return how many products an evaluation takes about."""
    return compiled_evaluation(model) + (0.0 if model.route.is_autonomous else PRODUCTS_A_CALL)


def explicit_work(model: Model, radians: float) -> float:
    """Return that of the explicit method, stable over so many radians of the fastest that there is."""
    return max(radians / STABLE, LEAST_OF_RADAU) * STAGES * evaluation(model)


def radau_work(model: Model, steps: float) -> float:
    """Return that of so many steps of Radau's method."""
    return steps * (EVALUATIONS_A_STEP * evaluation(model) + factors_of_radau(model))


def factors_of_radau(model: Model) -> float:
    """Return that of one real and one complex factorisation: of dense matrices, or of those of a tree."""
    size = float(model.free_count + moving_states(model))
    return PRODUCTS_OF_FACTORS * min(size**3, 3.0 * newton_work(model.route))


def moving_states(model: Model) -> int:
    """Return how many internal states of loads are solved for with the speeds."""
    return model.state_count if model.states_move else 0


def sampled_work(model: Model, samples: float) -> float:
    """Return the work of the extrapolation at tight tolerances, which restarts at samples of controllers."""
    return samples * EVALUATIONS_A_SAMPLE * evaluation(model)


def steps_of_radau(span: float, rtol: float | None, atol: float, found: Vibrations) -> float:
    """Return how many steps Radau's method takes about: those that its formula of order 3 asks for.

    They grow with the fourth root of what is left of a vibration, until it is stepped over or begins anew. What nothing
    else damps the method itself does: by y^6 / 7200 in a step of y radians, and the less is left, the more radians its
    error allows (Pade's approximation (2, 3) on the imaginary axis; Hairer & Wanner 1996, IV.5).
    """
    if rtol is None:
        return LEAST_OF_RADAU
    sizes = found.sizes * found.haste
    errors = sizes / (of_order_three(rtol) * (sizes + atol / rtol))
    seen = errors > SEEN_BY_RADAU
    errors, frequencies, begins = errors[seen], found.frequencies[seen], found.begins[seen]
    decay = np.maximum(found.ratios[seen] * frequencies, LEAST_DECAY / span)
    lasts = np.minimum(np.log(errors / SEEN_BY_RADAU) / decay, span / begins)
    paces = frequencies * (ERROR_OF_RADAU * errors) ** 0.25
    steps = paces * -np.expm1(-0.25 * decay * lasts) / (0.25 * decay)
    until_lost = 7200.0 / 1.5 * (ERROR_OF_RADAU * errors) ** 1.5
    return float((begins * np.minimum(steps, until_lost)).max(initial=LEAST_OF_RADAU))
