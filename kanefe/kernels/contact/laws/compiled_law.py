"""A normal force by a function of the user in machine code."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple, NoReturn

import numpy as np

from kanefe.arguments import checked, positive
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.kernels.compiler.addresses import law_in_python
from kanefe.kernels.compiler.foreign import address_of
from kanefe.kernels.contact.laws.normal_law import NormalForce, NormalLaw, Pressing
from kanefe.kernels.language import Behind, Record, call_law, inlined

BY_FUNCTION = 3.0


class Limits(NamedTuple):
    """How a function of the user is checked."""

    looked_at: tuple[float, ...] = (1e-3, 0.1, 0.5, 1.0)
    """Depths relative to the given depth at which a function is checked; the rates are a tenth of it per second and
    more. """
    step: float = 1e-5
    """Step of central differences relative to a depth or a rate: truncation and round-off both leave 1e-10."""
    least_step: float = 1e-6
    """Smallest step of a rate, m/s."""
    share: float = 1e-3
    """Largest deviation of a given slope from differences, relative to the largest slope: far below a wrong factor, and
    above the error of differences."""
    at_nothing: float = 1e-6
    """Fraction of a depth, and of its energy, below which the energy counts as zero."""


LIMITS = Limits()


class FunctionNumbers(Record):
    """Numbers of `CompiledLaw`: where its function is, whether that writes derivatives, and its constants."""

    address: float
    has_slopes: float
    constants: Annotated[Any, Behind()]


CONSTANTS = FunctionNumbers.number_count


@inlined
def by_function(numbers: Any, at: int, point: Pressing) -> NormalForce:
    """Return what a function of the user gives: see `NormalLaw.law`.

    It takes real numbers; complex ones, which carry derivatives, are led through its slopes.
    """
    given, depth, rate, share = FunctionNumbers(numbers, at), point.depth, point.rate, point.share
    address, own = int(given.address), at + CONSTANTS
    d, v = depth.real, rate.real
    force, elastic, energy, by_depth, by_rate = call_law(address, d, v, numbers, own)
    d_beside, v_beside = depth - d, rate - v
    if given.has_slopes == 0.0 and (d_beside.imag != 0.0 or v_beside.imag != 0.0):
        h, h_rate = LIMITS.step * d, LIMITS.step * abs(v) + LIMITS.least_step
        over, under = call_law(address, d + h, v, numbers, own)[0], call_law(address, d - h, v, numbers, own)[0]
        by_depth = (over - under) / (2.0 * h)
        over = call_law(address, d, v + h_rate, numbers, own)[0]
        under = call_law(address, d, v - h_rate, numbers, own)[0]
        by_rate = (over - under) / (2.0 * h_rate)
    normal_force = share * (force + by_depth * d_beside + by_rate * v_beside)
    # what is taken is told, and nothing follows from it: the slope of the force serves for that of its elastic part
    elastic_part = share * (elastic + (by_depth if force >= 0.0 else 0.0) * d_beside)
    return NormalForce(normal_force, elastic_part, share * (energy + elastic * d_beside), 0.0 * rate)


@checked("slopes")
@dataclass(frozen=True, init=False, eq=False)
class CompiledLaw(NormalLaw):
    """``F = f(d, dd/dt)``, f a function of the user in machine code, which both routes call by its address.

    It is ``void f(double depth, double rate, const double *constants, double *out)``: depth in m, above 0, and its rate
    in m/s, positive on the way in. It writes, of all points of a contact together, which share it:

    * ``out[0]``: the normal force, N; where it is below 0, nothing acts.
    * ``out[1]``: the elastic part of it, N, that comes back: the derivative of the energy by the depth.
    * ``out[2]``: the energy in it, J, 0 at no depth.
    * ``out[3]``, ``out[4]``, with `slopes`: the derivatives of the force by depth, N/m, and by rate, N s/m.

    `out` comes as zeros: where 1 and 2 are left so, all work of the force counts as taken from the scene, and what it
    gives back as taken less. Without `slopes` derivatives, of stiff methods and in small motions, are by central
    differences of the force, good to some ten digits where it is smooth.

    Parameters
    ----------
    function : object
        A ``numba.cfunc``, a function of a library opened by ctypes or cffi, or an address.
    depth : float
        How deep a contact is typically pressed, m: there the function is looked at, and force over depth is what
        counts as its stiffness.
    constants : array_like, shape (n,)
        What the function is given besides.
    slopes : bool
        Whether the function writes derivatives.

    Raises
    ------
    ModelError
        If it is no compiled function, does not press, gives what is not finite, or if energy, elastic part and slopes
        contradict each other.

    Examples
    --------
    >>> import kanefe as kf
    >>> from numba import cfunc, types
    >>> numbers = types.CPointer(types.float64)
    >>> @cfunc(types.void(types.float64, types.float64, numbers, numbers))
    ... def rubber(d, rate, c, out):
    ...     out[1] = c[0] * d + c[1] * d**3
    ...     out[2] = c[0] * d**2 / 2 + c[1] * d**4 / 4
    ...     out[0] = out[1] * (1 + c[2] * rate)
    >>> law = kf.CompiledLaw(rubber, depth=1e-3, constants=(1e5, 1e11, 0.5))
    >>> round(law.pressed(1e-3).force, 6)
    200.0
    """

    kind = BY_FUNCTION
    numbers = FunctionNumbers
    law = staticmethod(by_function)
    stiffness: float = 0.0
    damping: float = field(default=0.0, init=False)
    function: Any = field(default=None, compare=False)
    constants: np.ndarray = field(default_factory=lambda: np.zeros(0))
    has_slopes: bool = False
    gives: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def __init__(self, function: Any, depth: float, constants: Any = (), slopes: bool = False) -> None:
        address = address_of(function, "the function of CompiledLaw")
        depth = positive(depth, "depth of CompiledLaw")
        own = np.ascontiguousarray(numbers(constants), dtype=float)
        if own.ndim != 1 or not np.all(np.isfinite(own)):
            raise ModelError(f"constants of CompiledLaw must be finite numbers in a row, not {constants!r}")

        def called(d: float, rate: float) -> np.ndarray:
            return np.array(law_in_python(address, d, rate, own, 0))

        # by what it gives one function is told from another
        self._set(function=function, constants=own, has_slopes=slopes, gives=_checked(called, depth, slopes))
        self._set(stiffness=float(called(depth, 0.0)[0] / depth), damping=0.0)

    def __reduce__(self) -> NoReturn:
        raise ModelError(
            "a CompiledLaw cannot be sent to another process: the address of its function is valid in this one only. "
            "Remedy: make the scene, and the law, in the process that runs it"
        )

    @property
    def address(self) -> int:
        """Where the function is in this process."""
        return address_of(self.function, "the function of CompiledLaw")


def _checked(f: Callable[[float, float], np.ndarray], depth: float, has_slopes: bool) -> np.ndarray:
    """Return the values of a function at the checked depths; a ModelError says what is wrong with them."""
    at = [(share * depth, rate) for share in LIMITS.looked_at for rate in (0.0, 10.0 * depth, -10.0 * depth)]
    given = np.array([f(d, rate) for d, rate in at])
    label = "the function of CompiledLaw"
    for (d, rate), values in zip(at, given, strict=True):
        if not np.all(np.isfinite(values)):
            raise ModelError(f"{label} gives {values} at a depth of {d:g} m and a rate of {rate:g} m/s")
    force = f(depth, 0.0)[0]
    if not force > 0.0:
        raise ModelError(
            f"{label} does not repel: {force:g} N at the depth of {depth:g} m. Remedy: out[0], positive away from the "
            "surface, or another depth"
        )
    if abs(f(LIMITS.at_nothing * depth, 0.0)[2]) > LIMITS.at_nothing * max(abs(f(depth, 0.0)[2]), force * depth):
        raise ModelError(f"the energy of {label} is not 0 at zero depth: out[2]")
    for (d, rate), values in zip(at, given, strict=True):
        h, h_rate = LIMITS.step * d, LIMITS.step * abs(rate) + LIMITS.least_step
        elastic = "elastic part, out[1], is not the derivative of its energy, out[2],"
        _check_slope(f, elastic, (1, 2), (d, rate), (h, 0.0), force)
        if has_slopes and values[0] > 0.0:
            _check_slope(
                f, "slope, out[3], is not that of its force by depth", (3, 0), (d, rate), (h, 0.0), force / depth
            )
            _check_slope(f, "slope, out[4], is not that of its force by rate", (4, 0), (d, rate), (0.0, h_rate), 0.0)
    return given


def _check_slope(
    f: Callable[[float, float], np.ndarray],
    what: str,
    places: tuple[int, int],
    at: tuple[float, float],
    step: tuple[float, float],
    large: float,
) -> None:
    """Raise a ModelError if a number is not the slope of another: not between both one-sided ones, as at a kink."""
    (slope, value), (d, rate), (h, h_rate), size = places, at, step, max(step)
    middle, given = f(d, rate)[value], f(d, rate)[slope]
    low, high = f(d - h, rate - h_rate)[value], f(d + h, rate + h_rate)[value]
    sides = sorted(((middle - low) / size, (high - middle) / size))
    room = LIMITS.share * max(abs(sides[0]), abs(sides[1]), large)
    if not sides[0] - room <= given <= sides[1] + room:
        raise ModelError(
            f"the function of CompiledLaw: its {what} at a depth of {d:g} m and a rate of {rate:g} m/s: {given:g}, by "
            f"differences {0.5 * (sides[0] + sides[1]):g}"
        )
