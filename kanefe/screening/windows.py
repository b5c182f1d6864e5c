"""Screened runs: superpose as long as no event is near, integrate around events, and continue."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Unpack

import numpy as np

from kanefe.arguments import checked
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers, shaped_numbers
from kanefe.integrate.events.load_events import events_of_loads
from kanefe.integrate.options import RunOptions, WindowKeywords
from kanefe.integrate.run import integrate
from kanefe.integrate.run_checks.energy_check import account
from kanefe.integrate.run_checks.structural_damping import warn_of_structural_damping
from kanefe.integrate.set_up import check_motions
from kanefe.integrate.status import RunStatus
from kanefe.integrate.trajectory import Trajectory, wanted_times
from kanefe.loads.screened import screening_of
from kanefe.result import Result
from kanefe.screening.riders import Motions
from kanefe.screening.screened_run import ScreenedRun
from kanefe.screening.small import NotSuperposed
from kanefe.screening.sticking import Sticking
from kanefe.screening.superposition import Superposed, superposed
from kanefe.storage.files import LARGEST_SHARE, usable_memory
from kanefe.tree.bending import Bent

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start
    from kanefe.linear.state import Freezable

SPACING = 0.25
"""Default step of the superposition, s: waves that excite a deck have frequencies below 2 Hz."""

OF_PERIOD = 8
"""Smallest number of steps of the superposition per period of loads other than the frame's motion."""

FINER = 5
"""Number of interpolated values of event functions per step."""

LEAD = 2
"""Number of steps by which a window begins before the near event."""

BEHIND = 1.0
"""Time by which a window continues after the near event, s."""

APART = 2.0
"""Time between two events below which one window covers both, s."""

LOOK_AHEAD, MOST_WINDOW = 30.0, 30.0
"""Duration of the first superposition after an interval without one, and largest length of growing windows, s."""

SLIP_STEP = 0.02
"""Interval of the states in a window at which slid distances are evaluated, s."""

GRAZING = 1e-6
"""Excess relative to the event function at rest below which an event is grazing."""


@checked("spacing")
def screen(
    scene: Freezable,
    duration: float | tuple[float, float],
    *,
    start: Start = None,
    output_step: float | None = None,
    spacing: float = SPACING,
    **options: Unpack[WindowKeywords],
) -> ScreenedRun:
    """Run a scene on a driven frame, integrating only near events.

    As long as all contacts that stick at the start continue to stick, and no other event of a load occurs, such as a
    breaking rope, the scene vibrates about a known motion. These vibrations are superposed by transfer functions over
    all frequencies of the frame's motion and corrected with the residual of the full equations; the remaining error is
    bounded. Where an event function is closer to its limit than this bound, a window is integrated, with the events of
    a full run. After it, bodies may stick at other positions.

    Parameters
    ----------
    scene : System
        On one frame that is driven from the ground, such as a deck; all other bodies are free or connected to it.
    duration : float or (float, float)
        Duration from t = 0, or first and last time, s.
    start : state, optional
        As `kanefe.System.simulate` takes it: a rest on the frame.
    output_step : float, optional
        Time between stored states, s; default: a 500th of the duration.
    spacing : float
        Step of the superposition, s, short compared with the motion of the frame and with other excitations; at most an
        eighth of the shortest period of a rotor's harmonics.
    **options
        For the windows, as for `kanefe.System.simulate`: method, rtol, atol, step, most_steps, most_seconds, progress.

    Returns
    -------
    ScreenedRun

    Raises
    ------
    ModelError
        If the scene has parts that cannot be screened: loops, controllers, rigid contacts, winches and other loads
        whose internal states change by themselves, friction with creep, unreduced bodies; if not exactly one frame is
        driven; or an option is not valid.
    SimulationError
        If a window fails.

    Examples
    --------
    ``print(kf.screen(scene, 1200.0, start=rest))``
    """
    if not hasattr(scene, "freeze"):
        raise ModelError(f"a screened run needs a scene, not {scene!r}. Remedy: a kf.System with a driven frame")
    given = numbers(duration)
    span = (0.0, given) if given.ndim == 0 else given
    first, last = (float(t) for t in shaped_numbers(span, (2,), "the duration of a screened run"))
    if not last > first:
        raise ModelError(f"the duration of a screened run must be above zero s, not {duration!r}")
    if not (numbers(spacing).shape == () and 0.0 < numbers(spacing) < np.inf):
        raise ModelError(f"spacing of a screened run must be above zero s, not {spacing!r}")
    RunOptions(t_span=(first, last), output_step=output_step, **options)
    model = scene.freeze(first, start)
    warn_of_structural_damping(model)
    check_motions(model, first, last)
    _refuse_fast_loads(model, spacing)
    needed, usable = (last - first) / spacing * model.initial_state.nbytes, LARGEST_SHARE * usable_memory()
    if needed > usable:
        raise ModelError(
            f"spacing={spacing:g} s over {last - first:g} s needs {needed / 2**30:.3g} GiB for the states alone, and "
            f"{usable / 2**30:.3g} can be used. Remedy: a spacing that resolves the motion of the frame, such as "
            f"{SPACING:g} s"
        )
    return _Run(Sticking(model), wanted_times(first, last, output_step), (first, last), spacing, options).done()


def _refuse_fast_loads(model: Model, spacing: float) -> None:
    """Raise a ModelError if a load of a rotor is too fast for the steps of the superposition."""
    for load in model.loads:
        most = screening_of(load).forcing
        if most * spacing * OF_PERIOD > 2.0 * np.pi:
            enough = 0.95 * 2.0 * np.pi / (OF_PERIOD * most)  # still below the limit when rounded
            raise ModelError(
                f"{load.kind} {load.name!r} has harmonics of up to {most / (2.0 * np.pi):.3g} Hz, which steps of "
                f"{spacing:g} s do not resolve. Remedy: spacing={enough:.2g}, or kf.System.simulate"
            )


@dataclass(eq=False)
class _Run:
    """A screened run in progress."""

    sticking: Sticking
    wanted: Vector
    span: tuple[float, float]
    spacing: float
    options: WindowKeywords
    windows: list[tuple[float, float]] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    expected: list[float] = field(default_factory=list)
    rows: list[tuple[Vector, Matrix]] = field(default_factory=list)
    happened: dict[str, list[float]] = field(default_factory=dict)
    grazing: Counter[str] = field(default_factory=Counter)
    steps: int = 0
    bent: list[Bent] = field(default_factory=list)

    def done(self) -> ScreenedRun:
        model = self.sticking.model
        self.happened = {event.name: [] for event in events_of_loads(model, keeps_steps=False)}
        self.bound = np.zeros(len(self.sticking.names))
        self.scales = self.sticking.watched(model, np.array([self.span[0]]), model.initial_state[None])[0]
        t, y = self.span[0], model.initial_state
        until, window = self.span[1], 0.0
        while t < self.span[1]:
            near, reason, found = self._looked(t, y, until)
            if near is None:
                if found is None:
                    raise TypeError("without an event near, there is a superposition")
                self._keep(found, until)
                y = self._state_at(found, len(found.times) - 1)
                t, window = until, 0.0
                until = self._far_enough(t)
                continue
            begin, end = near
            if found is not None and begin > t:
                row = int(np.searchsorted(found.times, begin + 1e-9)) - 1
                if found.times[row] > t:
                    self._keep(found, float(found.times[row]))
                    t, y, window = float(found.times[row]), self._state_at(found, row), 0.0
            # successive windows become longer
            window = min(2.0 * window, MOST_WINDOW) if window else 0.0
            end = min(max(end + BEHIND, t + window), self.span[1])
            window = max(window, end - t)
            y = self._integrated(t, end, y, reason)
            t, until = end, min(end + LOOK_AHEAD, self.span[1]) if found is None else self._far_enough(end)
        return self._run()

    def _far_enough(self, t: float) -> float:
        """Return the end of the next interval near an event, as expected from an earlier superposition."""
        return next((end for end in self.expected if end > t + APART), self.span[1])

    def _looked(self, t: float, y: Vector, until: float) -> tuple[tuple[float, float] | None, str, Superposed | None]:
        """Return the first interval near an event (None: none), the reason, and the superposition."""
        steps = max(int(np.ceil((until - t) / self.spacing - 1e-9)), 12)
        times = np.linspace(t, until, steps + 1)
        try:
            found = superposed(self.sticking, times, y, self.span)
        except NotSuperposed as error:
            return (t, min(until, t + APART)), str(error), None
        fine, is_near = self._near(found, y)
        if not is_near.any():
            return None, "", found
        rows = np.flatnonzero(is_near.any(axis=1))
        gap = round(APART / (fine[1] - fine[0]))
        stops = np.flatnonzero(np.diff(rows) > gap)
        ends = fine[rows[np.append(stops, -1)]] + APART
        self.expected = [float(end) for end in ends if end < until] + [end for end in self.expected if end > until]
        last = rows[stops[0]] if len(stops) else rows[-1]
        event = int(np.flatnonzero(is_near[rows[0]])[0])
        begin = fine[rows[0]] - LEAD * (times[1] - times[0])
        return (max(t, float(begin)), float(fine[last])), self.sticking.names[event], found

    def _near(self, found: Superposed, y: Vector) -> tuple[Vector, np.ndarray]:
        """Return fine times, and for each event whether its function is closer to its limit than the error bound."""
        from scipy.interpolate import CubicSpline

        t = found.times
        fine = np.linspace(t[0], t[-1], FINER * (len(t) - 1) + 1)
        values = CubicSpline(t, found.watched)(fine)
        sides = np.sign(self.sticking.watched(self.sticking.model, t[:1], y[None])[0])
        count, bound = len(sides), np.repeat(found.bound, FINER, axis=0)[FINER // 2 :][: len(fine)]
        # the transient decays: its bound at the start of a step holds for the whole step
        bound = bound + np.repeat(found.left_of_start(t), FINER, axis=0)[: len(fine)]
        is_near = values <= bound  # for ropes, which only pull
        is_near[:, :count] = sides * values[:, :count] <= bound[:, :count]
        is_near[:, count:] |= values[:, count:] + bound[:, count:] >= self.sticking.strongest
        return fine, is_near

    def _state_at(self, found: Superposed, row: int) -> Vector:
        """Return the state at one of the times, including the transient."""
        return self._states(
            found,
            found.times[row : row + 1],
            Motions(*(p[row : row + 1] for p in found.motions)),
            found.internal[row : row + 1],
        )[0]

    def _states(self, found: Superposed, times: Vector, motions: Motions, internal: Matrix) -> Matrix:
        count = self.sticking.riders.count
        left = found.small.transient(found.begun, times - found.times[0])
        more = Motions(motions.xi + left[:, :count], motions.rate + left[:, count:], motions.acceleration)
        moved = self.sticking.carrier.over(times)
        q, u, _ = self.sticking.riders.absolute(moved, found.place, more)
        return np.hstack((q, u, internal + left[:, :count] @ found.small.W.T))

    def _keep(self, found: Superposed, until: float) -> None:
        """Store the superposition at the output times from its start to a time, and its error bound."""
        from scipy.interpolate import CubicSpline

        bound = (found.bound + found.left_of_start(found.times))[found.times <= until]
        self.bound = np.maximum(self.bound, bound.max(axis=0))
        times = self._wanted(found.times[0], until)
        if not len(times):
            return
        motions = Motions(*(CubicSpline(found.times, part)(times) for part in found.motions))
        self.rows.append((times, self._states(found, times, motions, CubicSpline(found.times, found.internal)(times))))

    def _integrated(self, t: float, end: float, y: Vector, reason: str) -> Vector:
        """Integrate a window, and return the state at its end."""
        model = self.sticking.model
        q, u, z = model.parts(y)
        begun: Model = replace(model, initial_coordinates=q, initial_speeds=u, initial_states=z)
        inside = self._wanted(t, end)
        finely = np.linspace(t, end, max(int((end - t) / SLIP_STEP), 1) + 1)
        found = integrate(
            begun, (t, end), output_times=np.union1d(inside, finely), **(self.options | {"progress": False})
        )
        found.raise_for_status()
        states = np.hstack((found.coordinates, found.speeds, found.internal))
        if len(inside):
            self.rows.append((inside, states[np.searchsorted(found.times, inside)]))
        for name, times in found.events.items():
            self.happened[name] += times.tolist()
        self._count_grazing((t, end), found)
        self.steps += int(found.statistics["steps"])
        self.bent += found.bent
        if self.windows and self.windows[-1][1] == t:
            self.windows[-1] = (self.windows[-1][0], end)
        else:
            self.windows.append((t, end))
            self.reasons.append(reason)
        return np.asarray(states[-1])

    def _count_grazing(self, span: tuple[float, float], found: Trajectory) -> None:
        """Count slips with negligible excess force, which is the rate of the path times the damping."""
        model = self.sticking.model
        for event in self.sticking.events:
            load = model.loads[event.number]
            damping = screening_of(load).slip_damping
            if not (damping and event.of.name == "slip"):
                continue
            sticks = np.append(found.events[f"{load.subject} stick"], span[1])
            path = found.internal[:, model.load_states[event.number].start]
            limit = GRAZING * abs(self.scales[self.sticking.events.index(event)])
            for slip in found.events[event.name]:
                stick = sticks[sticks >= slip][0]
                before, after = np.searchsorted(found.times, slip, "right") - 1, np.searchsorted(found.times, stick)
                # for one point the excess force itself, for several their sum
                pull = damping * (path[min(after, len(path) - 1)] - path[before])
                self.grazing[event.name] += bool(pull <= limit * (stick - slip))

    def _wanted(self, begin: float, end: float) -> Vector:
        """Return the output times from one time to before another; the last one is included."""
        is_last = end >= self.span[1]
        return self.wanted[(self.wanted >= begin) & ((self.wanted < end) | is_last)]

    def _run(self) -> ScreenedRun:
        done = self._trajectory()
        account(self.sticking.model, done)
        return ScreenedRun(
            Result(self.sticking.model, done),
            tuple(self.windows),
            tuple(self.reasons),
            dict(zip(self.sticking.names, self.bound.tolist(), strict=True)),
            {name: n for name, n in self.grazing.items() if n},
        )

    def _trajectory(self) -> Trajectory:
        model = self.sticking.model
        times = np.concatenate([times for times, _ in self.rows])
        states = np.vstack([states for _, states in self.rows])
        n, m = model.coordinate_count, model.free_count
        unknown = np.full(len(times), np.nan)
        return Trajectory(
            times=times,
            coordinates=states[:, :n],
            speeds=states[:, n : n + m],
            dissipated=unknown,
            work=unknown,
            statistics={"method": "screened", "steps": self.steps, "windows": len(self.windows)},
            status=RunStatus("finished", self.span[1]),
            events={name: np.array(found) for name, found in self.happened.items()},
            internal=states[:, n + m :],
            bent=self.bent,
        )
