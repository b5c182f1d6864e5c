"""Space-filling samples of distributions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.studies.cases import MOST_VALUES

SAMPLINGS = ("latin hypercube", "sobol", "halton", "random")


def sampled_rows(
    distributions: Mapping[str, Any], samples: int, sampling: str, seed: int
) -> tuple[list[dict[str, float]], dict[str, Any]]:
    """Return rows of a table, and a record of the sampling.

    Parameters
    ----------
    distributions : mapping of str to frozen distribution
        Of scipy.stats: objects with a ``ppf``.
    samples : int
    sampling : str
        One of `SAMPLINGS`.
    seed : int

    Raises
    ------
    ModelError
        If there is no distribution, or an argument is not valid.
    """
    if not distributions:
        raise ModelError("there is no distribution to sample. Remedy: name=scipy.stats.norm(10.0, 0.5), for instance")
    if isinstance(samples, bool) or not isinstance(samples, (int, np.integer)) or samples < 1:
        raise ModelError(f"samples must be a whole number above zero, not {samples!r}")
    if samples > MOST_VALUES:
        raise ModelError(f"samples must be {MOST_VALUES} at most, not {samples!r}")
    if not isinstance(sampling, str) or sampling not in SAMPLINGS:
        raise ModelError(f"there is no sampling {sampling!r}. Remedy: {', '.join(SAMPLINGS)}")
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise ModelError(f"sampling_seed must be a whole number, zero or above, not {seed!r}")
    shares = _unit_samples(len(distributions), int(samples), sampling, np.random.default_rng(int(seed)))
    columns = {name: np.asarray(d.ppf(shares[:, j])) for j, (name, d) in enumerate(distributions.items())}
    rows = [{name: column[i].item() for name, column in columns.items()} for i in range(int(samples))]
    described = {name: _described(d) for name, d in distributions.items()}
    return rows, {"sampling": sampling, "seed": int(seed), "distributions": described}


def _unit_samples(dimension: int, samples: int, sampling: str, generator: np.random.Generator) -> np.ndarray:
    """Return numbers in (0, 1), shape (samples, dimension)."""
    if sampling == "random":
        return generator.random((samples, dimension))
    from scipy.stats import qmc

    makers: dict[str, Callable[..., Any]] = {
        "latin hypercube": qmc.LatinHypercube,
        "sobol": qmc.Sobol,
        "halton": qmc.Halton,
    }
    shares = np.asarray(makers[sampling](dimension, seed=generator).random(samples))
    tiny = np.finfo(float).eps  # an unbounded distribution has no value at 0 and 1
    return shares.clip(tiny, 1.0 - tiny)


def _described(distribution: Any) -> str:
    name = getattr(getattr(distribution, "dist", None), "name", type(distribution).__name__)
    parts = [repr(value) for value in getattr(distribution, "args", ())]
    parts += [f"{key}={value!r}" for key, value in getattr(distribution, "kwds", {}).items()]
    return f"{name}({', '.join(parts)})"
