"""Motion-induced interruptions: the rate at which a person on a deck loses balance, after Graham."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers, rotation_matrices, shaped_numbers
from kanefe.result import Result

AXES = {"longitudinal": 0, "lateral": 1}


@dataclass(frozen=True)
class Interruptions:
    """See `interruptions`."""

    body: str
    at: tuple[float, float, float]
    limits: dict[str, float]
    sliding: float | None
    after: float
    name: str

    def __call__(self, result: Result) -> dict[str, float]:
        """Return rates of a run by name, 1/min."""
        apparent, times = self._apparent_gravity(result)
        if apparent[:, 2].min() <= 0.0:
            raise ModelError(f"the apparent gravity on {self.body!r} is not always downward. Remedy: its z axis upward")
        span = float(times[-1] - times[0]) / 60.0
        shares = {name: apparent[:, AXES[name]] / apparent[:, 2] for name in self.limits}
        most = np.max([np.abs(shares[name]) / limit for name, limit in self.limits.items()], axis=0)
        found = {
            f"{self.name} tipping": _rises(most - 1.0) / span,
            f"{self.name} tipping by Rice": sum(
                _rate_by_rice(shares[name], times, limit) for name, limit in self.limits.items()
            ),
        }
        if self.sliding is not None:
            along = np.hypot(apparent[:, 0], apparent[:, 1]) / apparent[:, 2]
            found[f"{self.name} sliding"] = _rises(along - self.sliding) / span
        return found

    def _apparent_gravity(self, result: Result) -> tuple[np.ndarray, Vector]:
        """Return the apparent gravity at the point, reversed, in axes of the body, m/s2, and the times, s."""
        if result.run is None:
            raise ModelError("interruptions need the gravity of a scene, which a result from a file does not have")
        shown = result.times >= self.after
        if np.count_nonzero(shown) < 3:
            raise ModelError(f"fewer than three output times are after {self.after:g} s")
        axes = rotation_matrices(result.rotation(self.body)[shown])
        w, dw = result.angular_velocity(self.body)[shown], result.angular_acceleration(self.body)[shown]
        at = np.broadcast_to(self.at, w.shape)
        origin = result.acceleration(self.body)[shown] - result.run.model.gravity
        apparent = np.einsum("tji,tj->ti", axes, origin) + np.cross(dw, at) + np.cross(w, np.cross(w, at))
        return apparent, result.times[shown]


@checked
def interruptions(
    body: str,
    at: Sequence[float] = (0.0, 0.0, 0.0),
    *,
    lateral: float = 0.25,
    longitudinal: float = 0.17,
    sliding: float | None = None,
    after: float = 0.0,
    name: str = "crew",
) -> Interruptions:
    """Return a reducer to the rates (1/min) at which a person who stands on a deck tips or slides.

    A person tips when the ratio of the apparent lateral to the apparent vertical gravity exceeds half the stance over
    the height of the centre of mass (Graham, "Motion-induced interruptions as ship operability criteria", Naval
    Engineers Journal 102, 1990), and slides when it exceeds the friction coefficient of shoes. The accelerations are
    exactly those of the point; the rotational inertia of the person is neglected. Events are counted at the output
    times, of which there should be at least five per second. By Rice, the rate is that of a Gaussian process with the
    mean, deviation and mean crossings of the run, also for events that are too rare for one run.

    Parameters
    ----------
    body : str
        The deck, with axes x forward, y to port, z up.
    at : array_like, shape (3,)
        Position of the person's centre of mass in axes of the body, m.
    lateral, longitudinal : float
        Limits of tipping.
    sliding : float, optional
        Friction coefficient of shoes; None: sliding is not counted.
    after : float
        Time from which events count, s, such as after the ramp of a sea.
    name : str
        Prefix of the outputs: "crew tipping", "crew tipping by Rice", "crew sliding".

    Raises
    ------
    ModelError
        If an argument is not valid; when called, if the run has no such body, or its z axis is not upward.

    Examples
    --------
    >>> from kanefe.studies import interruptions
    >>> study = kf.Study(build, interruptions("deck", (2.0, 0.0, 1.0), after=30.0), ...)     # doctest: +SKIP
    """
    place = shaped_numbers(at, (3,), "the place of interruptions")
    for label, value in (("lateral", lateral), ("longitudinal", longitudinal), ("sliding", sliding)):
        if value is not None and not (numbers(value).shape == () and 0.0 < numbers(value) < math.inf):
            raise ModelError(f"{label} of interruptions must be above zero, not {value!r}")
    x, y, z = place.tolist()
    limits = {"lateral": float(lateral), "longitudinal": float(longitudinal)}
    return Interruptions(body, (x, y, z), limits, sliding, float(after), name)


def _rises(values: Vector) -> int:
    """Return the number of upward zero crossings of a record."""
    return int(np.count_nonzero((values[1:] > 0.0) & (values[:-1] <= 0.0)))


def _rate_by_rice(values: Vector, times: Vector, limit: float) -> float:
    """Return the rate (1/min) at which a Gaussian process with the statistics of a record exceeds +-limit."""
    mean, deviation = float(values.mean()), float(values.std())
    if deviation == 0.0:
        return 0.0
    crossings = _rises(values - mean) / (float(times[-1] - times[0]) / 60.0)
    return sum(crossings * math.exp(-0.5 * ((limit - side * mean) / deviation) ** 2) for side in (1.0, -1.0))
