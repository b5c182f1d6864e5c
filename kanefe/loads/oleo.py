"""Oleo struts: gas compression, and flow of oil through an orifice."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import Vector, shaped_numbers
from kanefe.kernels.force_elements.oleo import OleoNumbers, gas_in, oil_through, oleo, room_left
from kanefe.kernels.values.filled import filled_from
from kanefe.loads.action import End, LoadKernel
from kanefe.loads.along_line import AlongLine

ATMOSPHERE = 101325.0
"""Pressure around the strut, Pa."""


@checked("name")
@dataclass(frozen=True, eq=False)
class Oleo(AlongLine):
    """The forces in a telescopic strut with gas and oil, which separate its two ends along their line.

    With the stroke s, by which the ends are closer than at full extension, and its rate v,

        F = A (p0 (1 - s A / V0)^-n - pa) + c v |v|,

    with c in compression and `rebound` in extension. It has neither guide nor stops: use a prismatic joint for the
    strut, with a `kanefe.CoordinateForce` for the stop at full extension, against which the gas pushes, and the
    friction of its seals. Friction of the bearings under side load is that of `kanefe.Prismatic`.

    Parameters
    ----------
    name : str
        Unique among the loads between frames of a scene.
    ends : (Frame, Frame)
        Frames on the cylinder and on the piston, on the axis of the strut.
    area : float
        A, of the piston that compresses the gas, m2.
    pressure : float
        p0 of the gas at full extension, absolute, Pa.
    volume : float
        V0 of the gas at full extension, m3.
    orifice : float
        c, N s2/m2: see `orifice_coefficient`.
    rebound : float, optional
        c for extension, N s2/m2; default: `orifice`.
    exponent : float
        n of the gas: 1 for slow strokes, up to 1.4 for fast ones.
    ambient : float
        pa around the strut, Pa.
    extended : float, optional
        Distance of the ends at full extension, m; default: that at the start.

    Raises
    ------
    ModelError
        If an argument is not valid; the message names it.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> stop = kf.CoordinateForce(limits=(None, 0.0), limit_stiffness=1e7)
    >>> mass = scene.add_point("mass", 500.0, at=(0, 0, 1), joint=kf.Prismatic("z", forces=stop))
    >>> c = kf.Oleo.orifice_coefficient(density=860.0, area=3e-3, orifice=6e-5)
    >>> gas = {"area": 3e-3, "pressure": 8e5, "volume": 8e-4}
    >>> scene.add(kf.Oleo("oleo", (scene.ground, mass), orifice=c, **gas))
    >>> rest = kf.equilibrium(scene)
    >>> float(rest.load("oleo")[2].round(1))  # N: the weight
    4905.0
    """

    name: str
    ends: tuple[Any, ...]
    area: float = field(kw_only=True)
    pressure: float = field(kw_only=True)
    volume: float = field(kw_only=True)
    orifice: float = field(default=0.0, kw_only=True)
    rebound: float | None = field(default=None, kw_only=True)
    exponent: float = field(default=1.3, kw_only=True)
    ambient: float = field(default=ATMOSPHERE, kw_only=True)
    extended: float | None = field(default=None, kw_only=True)

    kind = "oleo"
    columns = ("stroke [m]", "rate [m/s]", "gas [N]", "oil [N]")
    needs_rotation = False

    def __post_init__(self) -> None:
        label = f"oleo {self.name!r}"
        if not isinstance(self.ends, (tuple, list)) or len(self.ends) != 2:
            raise ModelError(f"{label} needs two ends: on the cylinder and on the piston")
        object.__setattr__(self, "ends", tuple(self.ends))
        for what in ("area", "pressure", "volume", "extended", "orifice", "rebound", "ambient", "exponent"):
            value = getattr(self, what)
            if value is None and what in ("rebound", "extended"):
                continue
            given = float(shaped_numbers(value, (), f"{what} of {label}"))
            may_be_zero = what in ("orifice", "rebound", "ambient")
            if given < 0.0 or (given == 0.0 and not may_be_zero):
                raise ModelError(f"{what} of {label} must be {'>= 0' if may_be_zero else '> 0'}, not {value!r}")
        if self.exponent < 1.0:
            raise ModelError(f"exponent of {label} must be 1 (slow) or above, not {self.exponent!r}")

    @staticmethod
    @checked("density", "area", "orifice", "discharge")
    def orifice_coefficient(*, density: float, area: float, orifice: float, discharge: float = 0.7) -> float:
        """Return c of an orifice through which a piston presses oil, ``rho A^3 / (2 (Cd Ao)^2)``, N s2/m2.

        Parameters
        ----------
        density : float
            Density of the oil, kg/m3.
        area, orifice : float
            Areas of the piston and of the orifice, m2.
        discharge : float
            Discharge coefficient Cd.

        Examples
        --------
        >>> import kanefe as kf
        >>> round(kf.Oleo.orifice_coefficient(density=860.0, area=3e-3, orifice=6e-5))
        6582
        """
        for what, value in (("density", density), ("area", area), ("orifice", orifice), ("discharge", discharge)):
            if shaped_numbers(value, (), f"{what} of an orifice") <= 0.0:
                raise ModelError(f"{what} of an orifice must be > 0, not {value!r}")
        through = float(discharge) * float(orifice)
        ratio = float(area) / through if through > 0.0 else math.inf
        found = 0.5 * float(density) * float(area) * ratio * ratio
        if not 0.0 < found < math.inf:
            raise ModelError(f"area, orifice and discharge must be of oil, in m2: {area!r}, {orifice!r}, {discharge!r}")
        return found

    @property
    def exchanges_energy(self) -> bool:
        """Whether there is oil."""
        return bool(self.orifice or self.rebound)

    def forces(self, length: Any, rate: Any) -> tuple[Any, Any, Any]:
        """Return the stroke (m), and the forces of gas and oil, N, from the distance of the ends and its rate.

        NaN if the gas has no volume left.
        """
        given = OleoNumbers(self.kernel.numbers)
        stroke = (self.extended or 0.0) - length
        return stroke, gas_in(given, stroke)[0], oil_through(given, -rate)

    def pull(self, t: float, length: Any, rate: Any, states: Vector) -> Any:
        """Return the tension, N: negative, because it is compression."""
        _, gas, oil = self.forces(length, rate)
        return -(gas + oil)

    def started(self, t: float, ends: Sequence[End]) -> Oleo:
        """Return the strut with its length at full extension.

        Raises
        ------
        ModelError
            If the ends coincide, or are so close that the gas has no volume left.
        """
        length = float(np.linalg.norm(ends[1].p - ends[0].p))
        if length == 0.0:
            raise ModelError(f"the ends of oleo {self.name!r} coincide: it has no direction. Remedy: move one")
        begun = replace(self, extended=length) if self.extended is None else self
        stroke = float(begun.extended or 0.0) - length
        if room_left(OleoNumbers(begun.kernel.numbers), stroke) <= 0.0:
            raise ModelError(
                f"oleo {self.name!r} begins with a stroke of {stroke:.4g} m, and its gas has room for "
                f"{self.volume / self.area:.4g} m. Remedy: a larger volume, or ends farther apart"
            )
        return begun

    def tell(self, t: float, ends: Sequence[End], states: Vector) -> Vector:
        """Return stroke (m), its rate (m/s), and the forces of gas and oil (N), which separate the ends."""
        length, rate, _ = self.path(t, ends)
        with np.errstate(invalid="ignore"):
            stroke, gas, oil = self.forces(length, rate)
        return np.array((stroke, -rate, gas, oil))

    @cached_property
    def kernel(self) -> LoadKernel:
        """Its compiled function and numbers."""
        extended = math.nan if self.extended is None else self.extended
        rebound = self.orifice if self.rebound is None else self.rebound
        given = filled_from(self, OleoNumbers, extended=extended, rebound=rebound)
        return LoadKernel(oleo, given, oleo)
