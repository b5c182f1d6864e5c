"""How a run gets on: limits that end it, a warning where it takes too long, and an end where it stands still."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import SimulationWarning, outside
from kanefe.frames import Vector
from kanefe.integrate.methods.table import serving
from kanefe.integrate.run_checks.drive_growth import EARLY, GROWN, LATE
from kanefe.integrate.run_checks.functions_of_user import with_jump
from kanefe.integrate.run_checks.stiff_contacts import stiffest_contact
from kanefe.integrate.status import RunStatus
from kanefe.integrate.stepper import MOST_SPEEDS, StepFailure, Stepper, reports_worst
from kanefe.kernels.compiler._numba import seconds_compiling
from kanefe.tree.body_terms import is_unreduced

if TYPE_CHECKING:
    from kanefe.integrate.sampling import Sampler

SMALLEST_STEP = 1e-12
"""Average step over a batch or over several steps, relative to the span, below which a run does not advance."""

SOME_STEPS = 20

FIRST_STEPS = 5
"""Number of steps after which a method has found its length: it grows up to eight times a step from a careful guess."""

PATIENCE, LONGEST = 20.0, 600.0
"""Elapsed time from which a warning is issued, and predicted remaining time for which it is issued, s."""

SOON, LONG = 2.0, 60.0
"""Elapsed time and predicted remaining time of that warning for a run that resolves each vibration of a contact, s."""

WAIT = 10.0
"""Predicted remaining time of a run with all degrees of freedom of a mesh for which a reduction is suggested, s."""

MANY = 1e5
"""Number of remaining vibrations on a contact from which they dominate the time of a run: each takes several steps."""

LARGER = "a larger limit, or continue from a checkpoint with resume="
"""Remedy for a run that is ended by a limit."""

OTHERS = ("radau5", "dop853", "generalised-alpha")
"""Methods that are suggested for a slow run."""


Poles = Callable[[Model, float, Vector], str | None]
"""Function that describes the poles of a sampled loop about a state, or returns None if none is unstable."""


class OutOfTime(Exception):
    """The limit of seconds is passed within a step or a search."""


@dataclass(frozen=True)
class Limits:
    """What ends a run early.

    Attributes
    ----------
    steps : int or None
    seconds : float or None
        Of the wall clock.
    """

    steps: int | None = None
    seconds: float | None = None


class Pace:
    """How a run gets on.

    Parameters
    ----------
    model : Model
    stepper : Stepper
        At the start.
    end : float
        s.
    limits : Limits
    sampler : Sampler or None
        Of the controllers of the run.
    poles : callable, optional
        Tells of those of the loop.
    """

    def __init__(
        self,
        model: Model,
        stepper: Stepper,
        end: float,
        limits: Limits,
        sampler: Sampler | None = None,
        poles: Poles | None = None,
    ) -> None:
        self._model, self._stepper, self._end, self._limits = model, stepper, end, limits
        self._sampler, self._poles, self._is_grown = sampler, poles, False
        self._span = end - stepper.t
        self._began, self._from, self._compiled = time.monotonic(), stepper.t, seconds_compiling()
        self._is_warned, self._first = False, stepper.step_count
        self._mark = (0, stepper.t)

    def resume(self) -> None:
        """Continue from where the stepper now is, after a checkpoint."""
        self._from, self._first = self._stepper.t, self._stepper.step_count
        self.mark(self._from)

    def aim(self, end: float) -> None:
        """Let the run end at another time, s."""
        self._end = end

    def mark(self, t: float) -> None:
        """Look from time t (s) on at whether the run moves."""
        self._mark = self._stepper.step_count, t

    def check_progress(self) -> None:
        """Raise a StepFailure if the state is not finite or time stands still."""
        state = self._stepper.state()
        if not math.isfinite(float(state @ state)) and not np.all(np.isfinite(state)):  # the square may be too large
            worst = int(np.argmin(np.isfinite(state)))
            raise StepFailure("the motion has grown without bound", "check the loads, or take smaller steps", worst)
        steps, t = self._stepper.step_count, self._stepper.t
        if steps - self._mark[0] >= SOME_STEPS:
            if t - self._mark[1] < SMALLEST_STEP * self._span * (steps - self._mark[0]) and t < self._end:
                jump = self._jump()
                raise StepFailure(
                    f"its steps have become smaller than {SMALLEST_STEP:g} of the span{jump[0]}",
                    jump[1] or "check loads for jumps or growth without bound there, or loosen rtol",
                    self._stepper.worst if reports_worst(self._stepper) else None,
                )
            self._mark = steps, t

    def _elapsed(self) -> float:
        """Return how many seconds the run has taken; those of compiling are taken once, and do not count."""
        return time.monotonic() - self._began - (seconds_compiling() - self._compiled)

    def check_pace(self) -> None:
        """Warn once of a run that gets on too slowly to be waited for."""
        elapsed = self._elapsed()
        if not self._is_warned and (unknowns := large_systems(self._stepper)):
            self._check_systems(unknowns, elapsed)
        if self._is_warned or elapsed < min(SOON, PATIENCE):
            return
        t, step = self._stepper.t, self._stepper.t - self._stepper.t_old
        left = elapsed * (self._end - t) / max(t - self._from, 1e-300)
        if left > LONG:
            self._check_contacts(t, elapsed, left)
        if left > WAIT and self._model.has_unreduced:
            self._tell_of_unreduced(t, elapsed, left)
        if self._is_warned or elapsed < PATIENCE:
            return
        self._is_warned = True
        if left > LONGEST:
            moved = ", motions" if self._model.drives else ""
            sampled = " and controllers" if self._model.controllers else ""
            jump = self._jump()
            status = self.with_growth(
                RunStatus(
                    "stopped",
                    t,
                    f"at t = {t:.6g} s, after {elapsed:.0f} s, the steps of {self._stepper.name} are {step:.2g} s "
                    f"long: at this pace the run takes {_duration(left)} more{jump[0]}",
                    jump[1]
                    or f"check loads{moved}{sampled} for noise and jumps, loosen rtol, or another method, such as "
                    f"{self._others()}",
                )
            )
            warnings.warn(f"{status.reason}. Remedy: {status.remedy}", SimulationWarning, stacklevel=outside())

    def _check_systems(self, unknowns: int, elapsed: float) -> None:
        """Warn of full systems, once the first steps have told what each costs and how long they become."""
        t, steps = self._stepper.t, self._stepper.step_count - self._first
        step = t - self._stepper.t_old
        if steps < FIRST_STEPS or step <= 0.0:
            return
        of_one = elapsed / steps
        left = of_one * (self._end - t) / step
        if left < LONG:
            return
        self._is_warned = True
        warnings.warn(
            f"{self._stepper.name} solves full systems of {unknowns} unknowns, whose work grows with the cube of their "
            f"number: a step takes {of_one:.2g} s, and at t = {t:.6g} s the run takes {_duration(left)} more with "
            f"steps of {step:.2g} s. Remedy: method='auto', or {self._others()}, if that needs none",
            SimulationWarning,
            stacklevel=outside(),
        )

    def _tell_of_unreduced(self, t: float, elapsed: float, left: float) -> None:
        """Warn of bodies without reduction, which are a choice only if it is known what they cost."""
        self._is_warned = True
        bodies = [body for body in self._model.bodies if body.flexible and is_unreduced(body.flexible.body)]
        count = sum(body.flexible.body.free_count for body in bodies if body.flexible)
        steps = max(self._stepper.step_count, 1)
        warnings.warn(
            f"at t = {t:.6g} s, after {elapsed:.0f} s, {', '.join(repr(body.name) for body in bodies)} "
            f"{'moves' if len(bodies) == 1 else 'move'} with all {count} degrees of freedom of the mesh, at "
            f"{1e3 * elapsed / steps:.2g} ms a step: the run takes {left:.0f} s more. Remedy: "
            "reduction=kf.CraigBampton() where the body is made, which takes some microseconds a step, and "
            "tells what it leaves out",
            SimulationWarning,
            stacklevel=outside(),
        )

    def _check_contacts(self, t: float, elapsed: float, left: float) -> None:
        """Warn of a contact whose vibrations the run follows one by one."""
        contact = stiffest_contact(self._model)
        step = (t - self._from) / max(self._stepper.step_count, 1)
        if contact is None or step >= contact.period or self._end - t < MANY * contact.period:
            return
        self._is_warned = True
        warnings.warn(
            f"at t = {t:.6g} s, after {elapsed:.0f} s, the steps of {self._stepper.name} are {step:.2g} s long on "
            f"average: they resolve {contact}, on which {contact.mass:.3g} kg vibrates with a period of "
            f"{contact.period:.2g} s. At this pace the run takes {_duration(left)} more. Remedy: a lower "
            "stiffness (weight over permitted depth), more damping, or kanefe.Rigid()",
            SimulationWarning,
            stacklevel=outside(),
        )

    def check_drives(self) -> None:
        """Warn once of drives that grow from sample to sample; raise a StepFailure of a millionfold growth."""
        if self._sampler is None:
            return
        self._sampler.end_alarm()
        if self._is_grown and self._sampler.growth(LATE) is not None:
            raise StepFailure("drives have grown a millionfold", "")
        if not self._is_grown and self._sampler.growth(EARLY) is not None:
            self._is_grown = True
            status = self.with_growth(
                RunStatus("stopped", self._stepper.t, f"at t = {self._stepper.t:.6g} s", ""), EARLY
            )
            warnings.warn(f"{status.reason}. Remedy: {status.remedy}", SimulationWarning, stacklevel=outside())

    def with_growth(self, status: RunStatus, times: float = GROWN) -> RunStatus:
        """Return a status that names the controller, if one drives the scene harder and harder, and poles that grow."""
        grown = None if self._sampler is None else self._sampler.growth(times)
        if grown is None:
            return status
        reason, remedy = grown
        state = self._stepper.state()[: len(self._model.initial_state)]
        if self._poles is not None and np.all(np.isfinite(state)):
            reason += self._poles(self._model, self._stepper.t, state) or ""
        remedies = "; ".join(one for one in (remedy, status.remedy) if one)
        return replace(status, reason=f"{status.reason}; {reason}", remedy=remedies)

    def limit(self, steps: int) -> RunStatus | None:
        """Return the status of a run that a limit ends after so many steps; None if it continues."""
        limits, t = self._limits, self._stepper.t
        if limits.steps is not None and steps >= limits.steps:
            return RunStatus("stopped", t, f"by the limit of {limits.steps} steps", LARGER)
        return self.out_of_time(t) if self._is_out_of_time else None

    @property
    def _is_out_of_time(self) -> bool:
        return self._limits.seconds is not None and self._elapsed() >= self._limits.seconds

    def check_time(self) -> None:
        """Raise OutOfTime where the limit of seconds is passed."""
        if self._is_out_of_time:
            raise OutOfTime

    def out_of_time(self, t: float) -> RunStatus:
        """Return the status of a run that the limit of seconds ends at time t (s)."""
        jump = self._jump()
        remedy = jump[1] or f"{LARGER}, or another method, such as {self._others()}"
        return RunStatus("stopped", t, f"by the limit of {self._limits.seconds:g} seconds{jump[0]}", remedy)

    def _jump(self) -> tuple[str, str]:
        """Return what a function of the user does that jumps where the run is, and the remedy; or nothing."""
        if self._model.route.is_autonomous:
            return "", ""
        told = ""
        with suppress(Exception):  # of the user: the run tells of it, if it comes there
            told = with_jump(self._model, self._stepper.t, self._stepper.state())
        reason, _, remedy = told.partition(". Remedy: ")
        return (f"; {reason}", remedy) if reason else ("", "")

    def _others(self) -> str:
        """Return methods that could be tried in place of this one."""
        here = self._stepper.name.rpartition(", then ")[2]
        return " or ".join(repr(name) for name in serving(self._model, *OTHERS) if name != here) or "'auto'"


def large_systems(stepper: Stepper) -> int:
    """Return the number of unknowns of full systems that a stepper factorises, if it is above `MOST_SPEEDS`; else 0."""
    unknowns: int = getattr(stepper, "full_unknowns", 0)
    return unknowns if unknowns > MOST_SPEEDS else 0


def _duration(seconds: float) -> str:
    return f"{seconds / 3600.0:.2g} h" if seconds > 2 * 3600.0 else f"{seconds / 60.0:.2g} min"
