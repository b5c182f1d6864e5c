"""Forces along one coordinate of a joint: spring, damper, dry friction, limits, and the inertia of a geared rotor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from kanefe.arguments import plain_numbers
from kanefe.errors import ModelError
from kanefe.frames import Vector, numbers, shaped_numbers
from kanefe.kernels.loads.coordinate_law import CoordinateLaw, coordinate_force, coordinate_potential, coordinate_slopes
from kanefe.kernels.values.filled import filled_from


@dataclass(frozen=True)
class CoordinateForce:
    """Force along a joint coordinate q, on the child and reversed on the parent.

    ``-k (q - rest) - c dq``, and beyond a limit by d the one-sided stop ``-(k_limit d + c_limit dd)``, which never
    pulls. For an angle N m, rad and rad/s take the place of N, m and m/s below.

    Dry friction is that of a spring and damper to an anchor, which moves only when it slips: the force against the
    motion is ``p = k_f w + c_f dq``, limited to `friction`, with w the stretch of the spring and ``dw/dt = (force -
    k_f w) / c_f``. So it sticks without creep. In a scene it is a separate load, "friction of <body>": ``result.load``
    has force, stretch, whether it sticks and the slip speed, and ``result.events["<body> slip"]`` and ``["<body>
    stick"]`` have the times of changes. If the joint has several coordinates, the name of the coordinate follows that
    of the body.

    Parameters
    ----------
    stiffness, damping : float
        N/m and N s/m.
    rest : float
        Coordinate at which the spring is slack, m.
    friction : float
        Dry friction while it slips, N, independent of the load of the joint.
    static_friction : float, optional
        Force at which it begins to slip, N; default: `friction`.
    friction_stiffness : float, optional
        k_f, N/m; default: the static friction over 1e-7 of the scene's length (or 1e-7 rad), a tenth of what a run at
        the default tolerance resolves.
    friction_damping : float, optional
        c_f, N s/m; default: critical damping for the inertia along the coordinate at the start, or 0.1 ms times k_f in
        a scene with unreduced bodies.
    limits : (float or None, float or None)
        Lower and upper limit of the coordinate, m; None: no limit.
    limit_stiffness, limit_damping : float
        Stiffness and damping of the stops at the limits, N/m and N s/m.
    limit_restitution : float, optional
        Instead of the damping: coefficient of restitution of the stops, above 0, at most 1. The force of a stop is then
        ``k_limit d max(0, 1 + lambda dd)`` (Hunt & Crossley), with lambda from the speed of each impact, 1 mm/s (1
        mrad/s) at least. It is a separate load, "stop of <body>", with ``result.events["<body> touch"]`` and
        ``["<body> lift"]``.
    armature : float
        Inertia of a rotor behind a gear, times the square of the ratio N, kg along a distance, kg m2 about an axis: it
        takes ``armature ddq`` of the force and has the energy ``armature dq^2 / 2``. It counts for this coordinate
        alone: the weight of the rotor belongs to the body that carries it, and its angular momentum, which is N times
        smaller than this inertia gives, is left out.

    Raises
    ------
    ModelError
        If a number is negative or not finite, the limits are reversed, a stop has no stiffness, or both damping and
        restitution; or the static friction is below `friction`.

    Examples
    --------
    >>> door = CoordinateForce(friction=0.2, limits=(0.0, 1.5), limit_stiffness=500.0, limit_damping=2.0)
    >>> door.force(1.75, 0.0)
    -125.0
    """

    stiffness: float = 0.0
    damping: float = 0.0
    rest: float = 0.0
    friction: float = 0.0
    static_friction: float | None = None
    friction_stiffness: float | None = None
    friction_damping: float | None = None
    limits: Sequence[float | None] = (None, None)
    limit_stiffness: float = 0.0
    limit_damping: float = 0.0
    limit_restitution: float | None = None
    armature: float = 0.0
    lower: float = field(init=False, repr=False)
    upper: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping", "friction", "limit_stiffness", "limit_damping", "armature"):
            if not (self._finite(name) and getattr(self, name) >= 0):
                raise ModelError(f"{name} of a joint coordinate must be finite and >= 0, not {getattr(self, name)!r}")
        if not self._finite("rest"):
            raise ModelError(f"rest of a joint coordinate must be finite, not {self.rest!r}")
        self._check_friction()
        lower, upper = _bounds(self.limits)
        if lower >= upper:
            raise ModelError(
                f"the limits ({lower:.6g}, {upper:.6g}) of a joint coordinate are reversed. Remedy: the lower one first"
            )
        is_limited = math.isfinite(lower) or math.isfinite(upper)
        if is_limited and self.limit_stiffness == 0.0:
            raise ModelError("limits of a joint coordinate need a stop to push back. Remedy: give limit_stiffness")
        if not is_limited and (self.limit_stiffness or self.limit_damping):
            raise ModelError("limit_stiffness or limit_damping without limits does nothing. Remedy: give limits")
        if self.limit_restitution is not None:
            self._check_restitution(is_limited)
            lower, upper = -math.inf, math.inf  # the stops are a separate load
        plain_numbers(self)
        object.__setattr__(self, "lower", lower)
        object.__setattr__(self, "upper", upper)

    @classmethod
    def backlash(
        cls,
        play: float,
        *,
        stiffness: float,
        damping: float = 0.0,
        restitution: float | None = None,
        rest: float = 0.0,
        friction: float = 0.0,
    ) -> CoordinateForce:
        """Return a spring with play: no force acts within ``rest +- play/2``, and one-sided stops beyond.

        Their force, as of teeth or a key, is ``-(k d + c dd)`` at a distance d beyond, or has a `restitution` instead
        of the damping.

        Parameters
        ----------
        play : float
            Whole free travel, m or rad.
        stiffness, damping : float
            k and c of the stops, N/m and N s/m.
        restitution : float, optional
            See `limit_restitution`.
        rest : float
            Middle of the play, m.
        friction : float
            Dry friction at any coordinate, N.

        Examples
        --------
        >>> key = CoordinateForce.backlash(0.02, stiffness=1000.0)
        >>> round(key.force(0.015, 0.0), 9), key.force(-0.009, 3.0)
        (-5.0, 0.0)
        """
        width = numbers(play)
        if width.shape != () or not np.isfinite(width) or width <= 0.0:
            raise ModelError(f"play of backlash must be one number, finite and > 0, not {play!r}")
        middle = float(shaped_numbers(rest, (), "rest of backlash"))
        ends = middle - 0.5 * float(width), middle + 0.5 * float(width)
        return cls(
            rest=rest,
            friction=friction,
            limits=ends,
            limit_stiffness=stiffness,
            limit_damping=damping,
            limit_restitution=restitution,
        )

    def _check_restitution(self, is_limited: bool) -> None:
        e = numbers(self.limit_restitution)
        if e.shape != () or not 0.0 < e <= 1.0:
            raise ModelError(f"limit_restitution must be a number above 0, at most 1, not {self.limit_restitution!r}")
        if not is_limited:
            raise ModelError("limit_restitution without limits does nothing. Remedy: give limits")
        if self.limit_damping:
            raise ModelError("a stop has either limit_damping or limit_restitution. Remedy: leave one out")

    def _check_friction(self) -> None:
        for name in ("static_friction", "friction_stiffness", "friction_damping"):
            value = getattr(self, name)
            if value is None:
                continue
            if not (self._finite(name) and value > 0):
                raise ModelError(f"{name} of a joint coordinate must be finite and > 0, not {value!r}")
            if self.friction == 0.0:
                raise ModelError(f"{name} without friction does nothing. Remedy: give friction")
        if self.static_friction is not None and self.static_friction < self.friction:
            raise ModelError(
                f"static_friction, {float(self.static_friction):g}, is below friction, {float(self.friction):g}. "
                "Remedy: the larger as static_friction"
            )

    def _finite(self, name: str) -> bool:
        value = numbers(getattr(self, name))
        return value.shape == () and bool(np.isfinite(value))

    @property
    def is_dissipative(self) -> bool:
        """Whether it dissipates energy other than by friction."""
        return bool(self.damping or self.limit_damping)

    @property
    def acts(self) -> bool:
        """Whether it has forces other than friction and stops with a restitution, which are separate loads."""
        return bool(self.stiffness or self.damping or self.is_varying)

    @property
    def is_varying(self) -> bool:
        """Whether its slopes change with the state: it has limits."""
        return math.isfinite(self.lower) or math.isfinite(self.upper)

    @cached_property
    def law(self) -> Vector:
        """Its numbers without friction, as in `kanefe.kernels.loads.coordinate_law`."""
        stop = {"stop_stiffness": self.limit_stiffness, "stop_damping": self.limit_damping}
        return filled_from(self, CoordinateLaw, **stop)

    def force(self, q: float, rate: float) -> float:
        """Return the generalised force without friction at coordinate q (m) and its rate (m/s), N."""
        return float(sum(coordinate_force(CoordinateLaw(self.law), q, rate)))

    def potential(self, q: float) -> float:
        """Return the energy in the spring and in the stops at coordinate q, J."""
        return float(coordinate_potential(CoordinateLaw(self.law), q))

    def dissipation(self, q: float, rate: float) -> float:
        """Return the power dissipated by damping and stops, W."""
        return float(-coordinate_force(CoordinateLaw(self.law), q, rate)[1] * rate)

    def slopes(self, q: float, rate: float) -> tuple[float, float]:
        """Return stiffness and damping at coordinate q and its rate, N/m and N s/m: minus the slopes of the force."""
        k, c = coordinate_slopes(CoordinateLaw(self.law), q, rate)
        return float(k), float(c)


def limits_of(law: CoordinateForce) -> tuple[float, float]:
    """Return lower and upper limit, infinite where there is none, also of stops that are a separate load."""
    return _bounds(law.limits)


def _bounds(limits: Sequence[float | None]) -> tuple[float, float]:
    """Return lower and upper limit, infinite where there is none."""
    given = list(limits) if isinstance(limits, (tuple, list)) or numbers(limits).shape == (2,) else []
    bounds = [numbers(sign * math.inf if x is None else x) for x, sign in zip(given, (-1, 1), strict=False)]
    if len(given) != 2 or any(x.shape != () or np.isnan(x) for x in bounds):
        raise ModelError(f"limits of a joint coordinate must be two numbers, lower and upper, not {limits!r}")
    return float(bounds[0]), float(bounds[1])
