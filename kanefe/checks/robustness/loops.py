"""Closed loops through singular positions: the N-four-bar mechanism, whose bars all become collinear."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.checks.robustness.runs import controlled_methods, follow, is_accurate, tolerance
from kanefe.checks.verification.loops import parallelograms
from kanefe.checks.verification.references import load_references
from kanefe.equations.model import Model
from kanefe.integrate.trajectory import Trajectory
from kanefe.kernels.constraints.tolerances import CLOSING
from kanefe.result import Result
from kanefe.states.constraints import constraint_residuals
from kanefe.states.state import State

SPAN = 10.0

COARSE = "rtol 1e-6 over some thousand steps, errors all of one sign"


def loop_opening(model: Model, t: float, q: np.ndarray) -> float:
    """Return the largest residual of the holonomic constraints in a configuration, m or rad."""
    return float(np.abs(constraint_residuals(State(model, t, q))).max(initial=0.0))


def singular_positions(effort: Effort) -> Iterator[Finding]:
    """Run parallelograms through the position in which they could change to antiparallelograms."""
    cases = [(2, 1e-9, SPAN), (10, 1e-8, SPAN), (40, 1e-8, SPAN)]
    if effort.is_quick:
        cases = [(2, 1e-9, SPAN), (40, 1e-8, 1.0)]
    for count, rtol, span in cases:
        model = parallelograms(count)
        run = follow(model, span, rtol=rtol, method="dop853", output_step=0.1)
        yield from _findings(model, run, count, span, "dop853")
    for method in controlled_methods():
        model = parallelograms(2)
        if method == "dop853" or method not in controlled_methods(model):
            continue
        span = SPAN if not effort.is_quick else 1.0
        run = follow(model, span, rtol=tolerance(method, 1e-8, 1e-6), method=method, output_step=0.1)
        yield from _findings(model, run, 2, span, method)
    for method in controlled_methods(parallelograms(2)):
        yield _thrown(method, effort)


def _thrown(method: str, effort: Effort) -> Finding:
    """Start the cranks fast or slowly, so that they pass a singular position or turn back near it."""
    rng = np.random.default_rng(0)
    fast, slow = rng.uniform(-8.0, 8.0, effort.count(20, 2)), 10.0 ** rng.uniform(-4.0, 0.0, effort.count(10, 1))
    upright = parallelograms(2)
    spreads, tried = [], "1e-8, 1e-6, 1e-4" if is_accurate(method) else "1e-4"
    # tight tolerances take thousands of steps with a method of order 2 and show nothing more
    for rtol in (1e-8, 1e-6, 1e-4) if is_accurate(method) else (1e-4,):
        for speed in (*fast.tolist(), *slow.tolist()):
            model = replace(upright, initial_speeds=upright.initial_speeds * speed)
            run = follow(model, SPAN if not effort.is_quick else 1.0, rtol=rtol, method=method, output_step=0.1)
            cranks = [Result(model, run).joint_coordinates(f"crank {i}")[:, 0] for i in range(3)]
            spreads.append(float(np.ptp(cranks, axis=0).max()))
    return Finding.of(
        f"N-four-bar, N = 2, thrown at 1e-4 ... 8 rad/s, rtol {tried}",
        spreads,
        "cranks out of parallel [rad]",
        1e-6,
        "another branch would be a turn away",
        method,
    )


def _findings(model: Model, run: Trajectory, count: int, span: float, method: str) -> Iterator[Finding]:
    result = Result(model, run)
    cranks = np.array([result.joint_coordinates(f"crank {i}")[:, 0] for i in range(count + 1)])
    # the bars are collinear where the cranks are horizontal
    passes = int(np.count_nonzero(np.diff(np.sign(np.cos(cranks[0])))))
    what = f"N-four-bar (A02), N = {count}, {span:g} s"
    spread = float(np.ptp(cranks, axis=0).max())
    yield Finding(
        what,
        passes,
        "cranks out of parallel [rad]",
        spread,
        1e-6,
        "another branch would be a turn away",
        f"{method}; counted: singular positions passed",
    )
    energy = result.energy
    yield Finding(
        what,
        passes,
        "energy over its range, relative",
        float(np.abs(energy.balance_error).max() / np.ptp(energy.kinetic)),
        1e-4 if is_accurate(method) else 1e-2,
        "rtol 1e-6 beside a singular position, ten passes" if is_accurate(method) else COARSE,
        method,
    )
    openings = [loop_opening(model, t, q) for t, q in zip(run.times.tolist(), run.coordinates, strict=True)]
    reason = "projected to round-off, of which the square root remains at a singular position"
    yield Finding.of(
        f"{what}: stored states", openings, "opening of a loop [m]", 1e3 * CLOSING.tolerance * count, reason, method
    )
    expected = load_references()["A02"].values.get(str(count), {}).get("B0", {})
    rows = [(i, value) for t, value in expected.items() if (i := round(float(t) / 0.1)) < len(result.times)]
    if rows:
        angle = cranks[0]
        errors = [max(abs(-np.sin(angle[i]) - x), abs(np.cos(angle[i]) - y)) for i, (x, y) in rows]
        limit = 1e-5 if is_accurate(method) else 1e-2
        reason = "the tolerance of A02" if is_accurate(method) else COARSE
        yield Finding.of(f"{what}: place of B0 at full seconds", errors, "error [m]", limit, reason, method)


CASES = (StressCase("singular-loops", "loops through singular positions", singular_positions),)
