"""Spinning beams below, at and above their first frequency, with and without stiffening (D01, D05)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import follow
from kanefe.checks.verification.rotors import spin_eigenvalues
from kanefe.equations.model import Model
from kanefe.joints import Motion, Revolute
from kanefe.reduction import CraigBampton
from kanefe.reduction.stiffening import StiffeningLevel
from kanefe.system import System
from kanefe_fem.beams.body import beam_body
from kanefe_fem.verification.stiffened_beams import thin_beam

SHARES = (0.0, 0.5, 0.9, 0.99, 1.0, 1.01, 1.1, 2.0, 5.0)
"""Spin speeds relative to the first frequency at rest."""

START = 1e-4
"""Initial amplitude of the first mode, as deflection of the tip, m."""


def blade(stiffening: StiffeningLevel) -> FlexibleBody:
    """Return a clamped bar of 1 m with EI = rho A = 1 in the plane of the spin."""
    model = thin_beam(10)
    return beam_body(model, {"root": "clamped"}, reduction=CraigBampton(modes=4), stiffening=stiffening)


def spun(body: FlexibleBody, spin: float) -> Model:
    """Return the blade on a hub that spins about z, bent by its first mode."""
    scene = System()
    scene.add_flexible_body("blade", body, joint=Revolute("z", motion=Motion.steady(spin)))
    model = scene.freeze()
    terms = model.flexible_terms("blade")
    q = model.initial_coordinates.copy()
    tip = terms.body.basis[-2, : terms.body.free_count]  # y of the last node
    q[terms.eta[0] if not isinstance(terms.eta, slice) else terms.eta.start] = START / tip[0]
    return replace(model, initial_coordinates=q)


def softening(effort: Effort) -> Iterator[Finding]:
    """Compare growth in time with what is predicted.

    Without stiffening the bar bends in the plane with ``f^2 = f0^2 - spin^2`` (D05): above the first frequency it
    leaves its place with that rate; with stiffening it never does.
    """
    plain, stiff = blade("none"), blade("inertial")
    first = 2.0 * np.pi * plain.frequencies[0]
    growths, rates, bounded, signs = [], [], [], []
    for share in SHARES:
        spin = share * first
        square = spin**2 - first**2
        found = spin_eigenvalues(spun(plain, spin))
        predicted = np.sqrt(max(0.0, square))
        rates.append(abs(found.real.max() - predicted) / first)
        span = min(1.5, 12.0 / max(predicted, 1e-9))
        growths.append(_log_growth_error(spun(plain, spin), span, square))
        signs.append(float(spin_eigenvalues(spun(stiff, spin)).real.max() / first))
        bounded.append(_largest(spun(stiff, spin), 1.5) / START)
    what = f"rotating bar, {len(SHARES)} spins of 0 ... 5 times the first frequency,"
    yield Finding.of(
        f"{what} without stiffening",
        rates,
        "growth rate against sqrt(spin2 - f2), over f",
        1e-3,
        "at the critical speed itself the rate is the root of round-off",
    )
    yield Finding.of(
        f"{what} without stiffening, run",
        growths,
        "growth in time against prediction, log",
        0.01,
        "second and higher modes, and the stretch, take part by some 1e-3",
    )
    yield Finding.of(f"{what} with stiffening", signs, "growth rate over f", 1e-6, "stable at every spin")
    yield Finding.of(
        f"{what} with stiffening, run", bounded, "deflection over its start", 1.05, "swings and never grows"
    )


def _trace(model: Model, span: float) -> tuple[np.ndarray, np.ndarray]:
    run = follow(model, span, rtol=1e-9, method="dop853", output_step=span / 100)
    terms = model.flexible_terms("blade")
    tip = terms.body.basis[-2, : terms.body.free_count]
    return run.times, run.coordinates[:, terms.eta] @ tip


def _largest(model: Model, span: float) -> float:
    return float(np.abs(_trace(model, span)[1]).max())


def _log_growth_error(model: Model, span: float, square: float) -> float:
    times, tip = _trace(model, span)
    exact = START * np.cosh(np.emath.sqrt(square) * times).real
    return float(abs(np.log(np.abs(tip).max() / np.abs(exact).max())))


CASES = (StressCase("spin-stiffening", "spin of beams with and without stiffening", softening),)
