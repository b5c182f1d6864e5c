"""Small motions of a scene with its sampled controllers: poles, stability and responses of the sampled loop.

Between samples the scene moves by its continuous equations with constant drives, which the matrix exponential solves
exactly; at samples the controllers read, update their memory and drives. Over one common period the states of the loop
are multiplied by one matrix, whose eigenvalues are the poles. (Astrom & Wittenmark, Computer-Controlled
Systems, 3rd ed. 1997, chapters 2 and 4; for several rates the monodromy of a periodic system.)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.linalg

from kanefe.arguments import checked
from kanefe.equations.model import Model
from kanefe.errors import KanefeError, ModelError
from kanefe.frames import Matrix, Vector
from kanefe.integrate.readings import reader
from kanefe.integrate.run_checks.structural_damping import warn_of_structural_damping
from kanefe.linear.frequency_response import FrequencyResponse, checked_frequencies
from kanefe.linear.inputs import inputs_of
from kanefe.linear.linearisation import Linearisation, input_directions, linearised
from kanefe.linear.outputs import Output, output_rows, outputs_of
from kanefe.linear.sampled.drives_and_readings import pushed, read_inputs, read_rows
from kanefe.linear.sampled.sampled_laws import LinearLaw, linear_law
from kanefe.linear.sampled.sampling_events import (
    COMMON,
    change_at,
    common_period,
    flows,
    instants_of,
    late_samples,
    places_of,
    turned,
)
from kanefe.linear.small_motions import Directions
from kanefe.linear.state import started_model
from kanefe.linear.unsettled import warn_of_imbalance
from kanefe.loads.controller import Controller
from kanefe.scene.targets import Named

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start
    from kanefe.linear.state import Freezable

GROWTH = 1e-9
"""Distance of a pole outside the unit circle below which it counts as on the circle."""

NEUTRAL = 1e-6
"""Distance of a pole from 1, dimensionless, below which it is a motion without restoring force; double poles are
accurate to the square root of round-off."""

ROUNDS = 3
"""Number of iterations between drives and measured accelerations that depend on each other."""


@dataclass(frozen=True, eq=False)
class SampledLoop:
    """Small motions of a scene with its sampled controllers, from `sampled_loop`; ``print`` shows the poles.

    Attributes
    ----------
    plant : Linearisation
        Of the scene with constant drives of the controllers; it has the requested inputs and outputs.
    period : float
        Common to all controllers, s.
    change : ndarray, shape (states, states)
        Matrix of the states of the loop from one period to the next, before the samples of each.
    state_names : tuple of str
        States of the plant, then of each controller its memory, its drives, and its drives that do not act yet.
    laws : tuple of LinearLaw
        The linearised controllers.
    measured : ndarray, shape (outputs, states)
        Derivatives of the outputs of the plant by the states of the loop.
    """

    plant: Linearisation
    period: float
    change: Matrix
    state_names: tuple[str, ...]
    laws: tuple[LinearLaw, ...]
    measured: Matrix
    _through: Callable[[float], tuple[Matrix, Matrix]]

    @cached_property
    def poles(self) -> np.ndarray:
        """Eigenvalues z of `change`, the largest first, complex, shape (states,)."""
        found = np.linalg.eigvals(self.change)
        return np.asarray(found[np.lexsort((found.imag, -np.abs(found)))])

    @property
    def eigenvalues(self) -> np.ndarray:
        """``log(z) / period``, 1/s, of the nonzero poles; frequencies up to half of that of the period."""
        z = self.poles[np.abs(self.poles) > GROWTH]
        return np.asarray(np.log(z) / self.period)

    @property
    def grows(self) -> np.ndarray:
        """Whether each pole grows, shape (states,); motions without restoring force, at z = 1, do not."""
        return np.asarray((np.abs(self.poles) > 1.0 + GROWTH) & (np.abs(self.poles - 1.0) > NEUTRAL))

    @property
    def is_stable(self) -> bool:
        """Whether no pole grows."""
        return not bool(self.grows.any())

    @property
    def growth(self) -> float:
        """Factor by which the fastest motion grows in one period; below one all motions decay."""
        return float(np.abs(self.poles[0]))

    @checked
    def frequency_response(self, frequencies: Sequence[float] | np.ndarray) -> FrequencyResponse:
        """Return the response of the outputs in the loop to inputs that oscillate continuously.

        The loop also responds at frequencies shifted by multiples of that of the period; the result is the part of each
        output at the frequency of the input, the mean over a period of ``y exp(-2 pi i f t)``.

        Parameters
        ----------
        frequencies : array_like, shape (F,)
            Hz, not negative.

        Raises
        ------
        ModelError
            If there are no inputs or outputs, a frequency is not valid, or the loop is unstable.
        """
        at = checked_frequencies(self.plant, frequencies)
        if not self.is_stable:
            raise ModelError(
                f"the loop is not stable, it grows by {self.growth:.6g} in {self.period:g} s, and has no steady "
                "response. Remedy: smaller gains, or a shorter sampling interval"
            )
        response = np.empty((len(at), len(self.plant.C), self.plant.B.shape[1]), dtype=complex)
        for i, f in enumerate(at):
            pushed, measured = self._through(float(f))
            states = len(self.change)
            # amplitudes that one period leaves unchanged
            start = np.linalg.solve(np.eye(states) - pushed[:, :states], pushed[:, states:])
            response[i] = (measured[:, :states] @ start + measured[:, states:]) / self.period
        return FrequencyResponse(at, response, self.plant.output_names, self.plant.input_names)

    def to_control(self) -> Any:
        """Return the loop as a `control.StateSpace` in steps of the period: no inputs, outputs those of the plant.

        Raises
        ------
        MissingDependency
            If python-control is not installed: ``pip install 'kanefe[control]'``.
        """
        from kanefe.linear._control import sampled_space

        return sampled_space(self.change, self.measured, self.period, self.state_names, self.plant.output_names)

    def __str__(self) -> str:
        names = ", ".join(f"{law.controller.name!r} every {law.controller.every:g} s" for law in self.laws)
        lines = [
            f"sampled loop of {names}: poles over {self.period:g} s",
            f"{'|z|':>10}  {'[Hz]':>10}  {'damping [%]':>11}",
        ]
        for z, grows in zip(self.poles, self.grows, strict=True):
            if abs(z) <= GROWTH or z.imag < 0.0:
                continue
            s = np.log(z) / self.period
            ratio = -100.0 * s.real / abs(s) if abs(s) * self.period > NEUTRAL else 0.0
            note = "  (unstable)" if grows else ""
            lines.append(f"{abs(z):10.6f}  {s.imag / (2.0 * np.pi):10.6g}  {ratio:11.4g}{note}")
        return "\n".join(lines)


def sampled_loop(
    scene: Freezable | Model,
    *,
    t: float | None = None,
    start: Start = None,
    inputs: Named | None = (),
    outputs: Named | None = None,
) -> SampledLoop:
    """Linearise a scene together with its sampled controllers.

    Parameters
    ----------
    scene : System or Model
        With controllers, see `kanefe.System.add_controller`. They are called many times with copies of their memory, at
        this time and with readings near those at rest, for differences.
    t : float, optional
        s; default: the time of the state, or zero. Time is fixed: targets keep their values at t.
    start : state, optional
        As for `kanefe.linearise`; default: the start of the scene. The drives are those that the controllers return
        there.
    inputs, outputs : str, sequence or mapping of str, optional
        As for `kanefe.linearise`: disturbances and measurements, for frequency responses. Default: no inputs, and free
        joint coordinates and speeds.

    Returns
    -------
    SampledLoop

    Raises
    ------
    ModelError
        If the scene has no controllers, their memory contains anything but numbers, or their sampling intervals have no
        common multiple; else as `kanefe.linearise`.

    Warns
    -----
    UnsettledWarning
        If the state is not in balance with the drives of the controllers.

    Examples
    --------
    A sampled brake changes the speed by 1 - 5.0 every 0.1 / 0.01 kg m2/s:

    >>> import kanefe as kf
    >>> scene = kf.System()
    >>> arm = scene.add_rigid_body("arm", 1.0, 0.1, joint=kf.Revolute("z"))
    >>> scene.add_controller("brake", lambda t, reads, memory: -5.0 * reads[0] / 0.1, every=0.01,
    ...                      reads="joint_speeds arm", drives="motor arm")
    >>> kf.sampled_loop(scene).poles.real.round(6)
    array([-4.,  1.,  0.])
    """
    loop = _about(*started_model(scene, t, start, "sampled_loop"), inputs, outputs)
    warn_of_structural_damping(loop.plant.model, "sampled_loop")
    warn_of_imbalance(loop.plant.imbalance, "sampled_loop", "start= a rest with the drives, such as result.at(end)")
    return loop


def poles_in_words(model: Model, t: float, y: Vector) -> str | None:
    """Return a description of the fastest pole about a state in a run; None if none grows or poles are unknown."""
    try:
        loop = _about(model, t, y.copy(), (), ())
    except KanefeError:
        return None
    if loop.is_stable:
        return None
    z = loop.poles[0]
    turns = abs(np.angle(z)) / (2.0 * np.pi * loop.period)
    return (
        f"; about the state there its fastest pole is |z| = {abs(z):.4g} over {loop.period:g} s, at {turns:.4g} Hz "
        "(kanefe.sampled_loop has all)"
    )


def _about(model: Model, time: float, y: Vector, inputs: Named | None, outputs: Named | None) -> SampledLoop:
    controllers = [one for one in model.controllers if one.is_sampled]
    if not controllers:
        raise ModelError("sampled_loop: the scene has no controllers. Remedy: add_controller, or kanefe.linearise")
    first, reads = model.coordinate_count + model.free_count, _readers(model, time)
    laws: list[LinearLaw] = []
    for _ in range(ROUNDS):
        laws = [linear_law(one, time, read(y)) for one, read in zip(controllers, reads, strict=True)]
        before = y.copy()
        for law in laws:
            held = model.held[law.controller.name]
            y[first + held.start : first + held.stop] = law.drives
        if np.array_equal(before, y):
            break
    plant = linearised(model, time, y, inputs, outputs)
    driven = input_directions(plant.small, inputs_of(plant.model, plant.time, plant.small.q, plant.small.u, inputs))
    return _loop(plant, tuple(laws), outputs_of(plant.small, outputs), driven)


def _readers(model: Model, t: float) -> list[Callable[[Vector], Vector]]:
    """Return, for each controller, the function of the state that reads its inputs at a time (s)."""

    def reads(controller: Controller) -> Callable[[Vector], Vector]:
        numbers_of = [reader(model, one) for one in controller.reads]
        return lambda y: np.array([one(t, y, lambda: model.route.state(t, y)) for one in numbers_of])

    return [reads(controller) for controller in model.controllers if controller.is_sampled]


def _loop(
    plant: Linearisation, laws: tuple[LinearLaw, ...], outputs: Sequence[Output], driven: Directions
) -> SampledLoop:
    n, digits = len(plant.A), COMMON * min(law.controller.every for law in laws)
    places, size = places_of(laws, n)
    acting = np.concatenate([np.arange(at.acting.start, at.acting.stop) for at in places])
    drives = pushed(plant, laws)
    generator = np.zeros((size, size))
    generator[:n, :n] = plant.A
    generator[np.ix_(np.arange(n - len(plant.small.speeds.leading), n), acting)] = drives.ddu[
        plant.small.speeds.leading
    ]
    measured = np.zeros((len(plant.C), size))
    measured[:, :n] = plant.C
    measured[:, acting] = output_rows(plant.small, outputs, drives)
    rows = [
        np.hstack((read_rows(plant, read, acting, laws, size), read_inputs(plant, law, driven)))
        for law, read in zip(laws, _readers(plant.model, plant.time), strict=True)
    ]
    period, counts = common_period(laws)
    instants = instants_of(laws, period, counts)
    jumps = [change_at(instant, laws, places, rows, size) for instant in instants]
    spans = np.diff([*(instant.time for instant in instants), period])
    ends = turned(laws, places, counts, size)

    over_period = partial(_over_period, jumps, spans, ends)

    def through(f: float) -> tuple[Matrix, Matrix]:
        """Return the transition over a period of complex amplitudes, and the integrals of outputs from them.

        Amplitudes are ``x exp(-2 pi i f t)`` of the states of the loop, then unit ones of the inputs.
        """
        inputs, count = plant.B.shape[1], len(plant.C)
        kept = size + inputs
        whole = np.zeros((kept + count,) * 2, dtype=complex)
        whole[:size, :size] = generator - 2j * np.pi * f * np.eye(size)
        whole[:n, size:kept] = plant.B
        whole[kept:, :size] = measured
        whole[kept:, size:kept] = plant.D
        total = over_period(flows(whole, digits), inputs + count)
        return total[:size, :kept], total[kept:, :kept]

    return SampledLoop(
        plant, period, over_period(flows(generator, digits), 0), _names(plant, laws), laws, measured, through
    )


def _over_period(
    jumps: Sequence[Matrix], spans: Vector, ends: Matrix, flow: Callable[[float], Matrix], more: int
) -> Matrix:
    """Return the transition over a period of the states of the loop, and of `more` that samples do not change."""
    size = len(ends)
    total, at_once = np.eye(size + more), np.eye(size + more)
    for jump, span in zip(jumps, spans, strict=True):
        read = min(jump.shape[1], size + more)  # without inputs there are no columns to read
        at_once[:size, :read] = jump[:, :read]
        total = flow(float(span)) @ at_once @ total
    return np.asarray(scipy.linalg.block_diag(ends, np.eye(more)) @ total)


def _names(plant: Linearisation, laws: Sequence[LinearLaw]) -> tuple[str, ...]:
    names = list(plant.state_names)
    for law in laws:
        drives, late = law.controller.drives, range(late_samples(law))
        names += [*law.names, *drives, *(f"{drive}, late {k + 1}" for k in late for drive in drives)]
    return tuple(names)
