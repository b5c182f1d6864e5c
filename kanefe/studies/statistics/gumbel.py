"""Gumbel distribution fitted to maxima, with confidence intervals that are also valid for few maxima.

``F(x) = exp(-exp(-(x - mu) / sigma))`` is the distribution of block maxima. The parameters are those of maximum
likelihood, as ``scipy.stats.gumbel_r.fit`` finds them. It is a location-scale family, so that the distribution of the
pivot ``(x_p - mu^) / sigma^`` depends on the number of maxima only: it is sampled once, with a fixed seed, and gives
intervals with the nominal coverage for ten maxima as for a thousand. (Lawless, Statistical Models and Methods for
Lifetime Data, on pivotal quantities of extreme-value distributions.)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import numbers

LEAST = 3
"""Number of maxima below which nothing is fitted."""

SAMPLES = 4000
"""Number of samples for the confidence intervals: their ends are within 1 % of the nominal probability."""

ITERATIONS = 60
"""Largest number of iterations of Newton's method for the scale; it takes 5 to 10."""


@dataclass(frozen=True)
class GumbelFit:
    """Gumbel distribution of some maxima.

    Attributes
    ----------
    location : float
        mu, the most probable maximum.
    scale : float
        sigma.
    count : int
        Number of maxima.

    Examples
    --------
    >>> fit = GumbelFit.of([3.1, 2.7, 3.4, 2.9, 3.0, 3.8, 2.8, 3.2, 3.3, 2.6])
    >>> round(fit.quantile(0.9), 3)
    3.549
    >>> low, high = fit.quantile_band(0.9)
    >>> low < 3.549 < high
    True
    """

    location: float
    scale: float
    count: int

    @classmethod
    def of(cls, maxima: np.ndarray) -> GumbelFit:
        """Return the fit to some maxima, shape (n,), by maximum likelihood.

        Raises
        ------
        ModelError
            If they are fewer than three, not finite, or all equal.
        """
        x = numbers(maxima).ravel()
        if len(x) < LEAST or not np.isfinite(x).all() or np.ptp(x) <= 1e-12 * np.abs(x).max():
            raise ModelError(f"Gumbel's law needs {LEAST} finite maxima or more that are not all equal")
        location, scale = _fitted(x[None, :])
        return cls(float(location[0]), float(scale[0]), len(x))

    @property
    def mean(self) -> float:
        """The expected maximum."""
        return self.location + float(np.euler_gamma) * self.scale

    @checked
    def quantile(self, probability: float) -> float:
        """Return the value that a maximum does not exceed with some probability."""
        return self.location + self.scale * _reduced(probability)

    @checked
    def quantile_band(self, probability: float, band: float = 0.9) -> tuple[float, float]:
        """Return the confidence interval of a quantile."""
        mu, sigma = _fits_of_standard(self.count)
        pivot = (_reduced(probability) - mu) / sigma
        low, high = np.quantile(pivot, _ends(band))
        return self.location + self.scale * float(low), self.location + self.scale * float(high)

    @checked
    def exceedance(self, limit: float) -> float:
        """Return the probability that a maximum is above a limit."""
        return float(-np.expm1(-np.exp(-(limit - self.location) / self.scale)))

    @checked
    def exceedance_band(self, limit: float, band: float = 0.9) -> tuple[float, float]:
        """Return the confidence interval of that probability."""
        mu, sigma = _fits_of_standard(self.count)
        reduced = mu + sigma * (limit - self.location) / self.scale
        low, high = np.quantile(reduced, _ends(band))
        return float(-np.expm1(-np.exp(-high))), float(-np.expm1(-np.exp(-low)))


def _reduced(probability: float) -> float:
    return float(-np.log(-np.log(_share(probability, "probability"))))


def _ends(band: float) -> tuple[float, float]:
    return 0.5 * (1.0 - _share(band, "band")), 0.5 * (1.0 + band)


def _share(value: float, what: str) -> float:
    if not 0.0 < value < 1.0:
        raise ModelError(f"{what} must lie between 0 and 1, not {value!r}")
    return float(value)


def _fitted(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return locations and scales, (m,), of m samples in rows (m, n).

    The scale solves ``sigma = mean(x) - sum(x w) / sum(w)`` with ``w = exp(-x / sigma)``; samples are shifted
    and scaled before, so that no exponential overflows.
    """
    low, spread = x.min(axis=1, keepdims=True), x.std(axis=1, keepdims=True)
    z = (x - low) / spread
    mean = z.mean(axis=1)
    s = np.full(len(z), np.sqrt(6.0) / np.pi)  # from the moments of the distribution
    for _ in range(ITERATIONS):
        w = np.exp(-z / s[:, None])
        total, first, second = w.sum(axis=1), (z * w).sum(axis=1), (z * z * w).sum(axis=1)
        miss = s - mean + first / total
        slope = 1.0 + (second / total - (first / total) ** 2) / s**2
        step = miss / slope
        s = np.maximum(s - step, 0.1 * s)
        if np.abs(step).max() < 1e-14:
            break
    at = -s * np.log(np.exp(-z / s[:, None]).mean(axis=1))
    return low[:, 0] + spread[:, 0] * at, spread[:, 0] * s


@lru_cache(maxsize=64)
def _fits_of_standard(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the fits to many samples of the standard distribution, each of `count` maxima."""
    generator = np.random.default_rng(20260101)
    parts = [_fitted(generator.gumbel(size=(SAMPLES // 10, count))) for _ in range(10)]  # in ten parts to save memory
    return np.concatenate([mu for mu, _ in parts]), np.concatenate([sigma for _, sigma in parts])
