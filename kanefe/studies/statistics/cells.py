"""Cells of a map: the maxima of all runs that differ only by random seeds, relative to a limit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.studies.statistics.gumbel import GumbelFit

LEAST_SPREAD = 5
"""Smallest number of different maxima for a fit: if most runs give the same value, such as no slip, an extreme-value
distribution does not apply."""

SAME_DIGITS = 9
"""Number of digits, relative to the largest maximum, within which two are equal: values limited by friction differ
only by round-off."""


@dataclass(frozen=True)
class Cell:
    """One cell of the map: one combination of the parameters that are not seeds.

    Attributes
    ----------
    parameters : dict
    runs : int
        Number of runs with this output.
    failed : int
        Number of runs without it.
    exceeded : int
        Runs above the limit.
    probability : float
        Share of the runs above the limit.
    band : (float, float)
        Confidence interval of that share by Clopper and Pearson, exact for any number of runs.
    fit : GumbelFit or None
        None if there are too few different maxima.
    mean, highest : float
        Of the maxima.
    """

    parameters: dict[str, Any]
    runs: int
    failed: int
    exceeded: int
    probability: float
    band: tuple[float, float]
    fit: GumbelFit | None
    mean: float
    highest: float


def cell_of(parameters: dict[str, Any], values: list[Any], limit: float, band: float) -> Cell:
    """Return the cell of some maxima, None for failed runs."""
    numbers = [value for value in values if isinstance(value, (int, float)) and math.isfinite(value)]
    if any(isinstance(value, (str, list)) for value in values):
        raise ModelError("operability needs outputs that are numbers: the maximum of each run")
    maxima = np.array(numbers, dtype=float)
    count, exceeded = len(maxima), int(np.count_nonzero(maxima > limit))
    different = len(np.unique(np.round(maxima / max(np.abs(maxima).max(initial=0.0), 1e-300), SAME_DIGITS)))
    is_spread = different >= LEAST_SPREAD and different > 0.5 * count
    return Cell(
        parameters=parameters,
        runs=count,
        failed=len(values) - count,
        exceeded=exceeded,
        probability=exceeded / count if count else math.nan,
        band=share_band(exceeded, count, band),
        fit=GumbelFit.of(maxima) if is_spread else None,
        mean=float(maxima.mean()) if count else math.nan,
        highest=float(maxima.max()) if count else math.nan,
    )


def share_band(hits: int, count: int, band: float) -> tuple[float, float]:
    """Return the confidence interval of a share by Clopper and Pearson."""
    if count == 0:
        return 0.0, 1.0
    from scipy.stats import beta

    tail = 0.5 * (1.0 - band)
    low = float(beta.ppf(tail, hits, count - hits + 1)) if hits else 0.0
    high = float(beta.ppf(1.0 - tail, hits + 1, count - hits)) if hits < count else 1.0
    return low, high
