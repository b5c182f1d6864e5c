"""The method that suits a scene, and why: what method="auto" takes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from kanefe.equations.model import Model
from kanefe.integrate.auto.abrupt_forces import (
    explicit_serves_contacts,
    explicit_serves_friction,
    explicit_serves_stops,
    rate_at_stops,
)
from kanefe.integrate.auto.cost import (
    LEAST_OF_RADAU,
    evaluation,
    explicit_work,
    radau_work,
    sampled_work,
    steps_of_radau,
)
from kanefe.integrate.auto.explicit_rates import look_at_state, rate_of_functions
from kanefe.integrate.auto.many_impacts import many_impacts
from kanefe.integrate.auto.rivals import EXPLICIT, FEWER_STAGES, rivals_of, why_left_out
from kanefe.integrate.auto.stiffest_rate import stiffest_rate
from kanefe.integrate.auto.vibrations import (
    CALM,
    LEAST_DAMPING,
    UNSEEN,
    UNSEEN_UNDAMPED,
    Vibrations,
    all_damped,
    begun_by,
    least_damping,
    vibrations,
)
from kanefe.integrate.breakpoints import SAMPLES, changes_of
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.jumps import NO_CHANGES, Changes
from kanefe.integrate.methods.table import own_methods, serving
from kanefe.integrate.stepper import LEAST_STEPS, MOST_SPEEDS
from kanefe.loads.base import Load
from kanefe.tree.scales import modal_frequencies, scene_length

MOST_EXPLICIT_STEPS = 2000.0
"""Steps of the explicit method for the elastic modes above which an implicit method is taken."""

LOOSE_RTOL = 1e-4
"""Relative tolerance from which the extrapolation has less work than Radau's method if all vibrations are damped."""

LEAST_RTOL_OF_SWEEPS = 1e-7
"""Relative tolerance below which vibrations that any motion excites have to be resolved."""

FEW_PERIODS, FEW_IF_LOOSE = 30.0, 20.0
"""Periods of the slowest mode in a run up to which every method resolves its vibrations; and their number from
`LOOSE_RTOL` on, where the extrapolation has no first step that is long enough."""

MOST_OUTSIDE = 150.0
"""Product of the highest rate outside the sweep and the span below which steps that sample functions often enough
suffice."""

SHARE_OF_DEPTH, CONTACT_ATOL = 0.01, 1e-7
"""Largest absolute tolerance with contacts and friction: a hundredth of their deflection, and that relative to the size
of the scene where the deflection is not known and may be 1e-5. With a larger tolerance a loose run shakes sticking
points loose and takes more steps."""

MANY_SAMPLES = 50.0
"""Number of controller samples from which Radau's method needs too many Jacobians, and steps of the explicit method end
at samples more often than for their error."""

EVALUATIONS_INSTEAD = 26.0
"""Evaluations of the extrapolation in the time of a step of Radau's method, at tolerances below `LOOSE_RTOL`: two to
six of its steps, of 13 to 18 evaluations each, in drawn linkages of flexible bodies."""

STIFF_FORCES = "its steps tell forces of stiff modes less exactly"

STOPS = "stops"


class SuitedMethod(NamedTuple):
    """A method for a scene.

    Attributes
    ----------
    name, reason : str
    then : str
        Method that takes over where the error asks for steps below `least` (s); empty: none does.
    least : float
    share : float
        Of the usual absolute tolerance.
    step : float or None
        Of a method with fixed steps, s.
    changes : Changes or None
        Those of functions of the time, where they were asked for.
    rivals : tuple of str
        Methods that the run tries in its place.
    left_out : dict of str to str, or None
        Why others are not tried, by their names.
    unfit : str
        Why the extrapolation is not tried, although it serves the scene.
    """

    name: str
    reason: str
    then: str = ""
    least: float = 0.0
    share: float = 1.0
    step: float | None = None
    changes: Changes | None = None
    rivals: tuple[str, ...] = ()
    left_out: dict[str, str] | None = None
    unfit: str = ""


class Candidates(NamedTuple):
    """Methods of which one is taken for a scene.

    Attributes
    ----------
    names : tuple of str
        All that `choose` may return: known before anything is evaluated, so that they are compiled together.
    choose : function () -> SuitedMethod
        Evaluates the scene where it has to.
    others : str
        Why it returns no other.
    """

    names: tuple[str, ...]
    choose: Callable[[], SuitedMethod]
    others: str = ""


def candidates(model: Model, start: float, stop: float, rtol: float | None, atol: float) -> Candidates:
    """Return the methods of which one is taken for a scene, and what chooses among them; for fixed steps without rtol.

    `atol` is that of `StepControl`.

    Not stiff: the explicit method of order 8. Stiff: the extrapolation, which treats modes and joint springs within the
    order-n sweep, and steps over vibrations. It lets what is hardly damped grow where its steps are some radians of it,
    so that it hands over where they would be; Radau's method, or the explicit one where that is less work, follows
    vibrations from the start where they are larger than the tolerance or the run lasts few of their periods. Radau's
    method also where something stiff is outside the sweep (springs between frames, functions of the state) or begins at
    once (stops, contacts, friction in joints unless the explicit one has far less work), and where that is too much
    work generalised-alpha; not under sampled controllers, at whose samples it would begin anew.
    """
    span, granular = stop - start, model.granular
    if granular is not None:
        why, step = many_impacts(model, granular, span)
        return Candidates(("moreau-jean",), lambda: SuitedMethod("moreau-jean", why, step=step))
    if model.has_unreduced:
        return Candidates(own_methods(), lambda: _of_route(model, serving(model, *own_methods())))
    found = _of_many(model, start, stop, rtol, atol)

    def choose() -> SuitedMethod:
        own = serving(model, *own_methods())  # its route is asked, for which kernels are compiled
        if len(own) == 1:
            return _of_route(model, own)
        taken = found.choose()
        rivals = rivals_of(model, found.names, taken.name)
        if taken.unfit:
            rivals = tuple(name for name in rivals if name != "extrapolation")
        left_out = why_left_out(model, found.others, taken.name, (taken.then, *rivals))
        if taken.unfit:
            left_out["extrapolation"] = taken.unfit
        return taken._replace(rivals=rivals, left_out=left_out)

    return Candidates(found.names, choose)


def _of_route(model: Model, own: Sequence[str]) -> SuitedMethod:
    return SuitedMethod(own[0], f"the only one for {model.route.reason}")


def _of_many(model: Model, start: float, stop: float, rtol: float | None, atol: float) -> Candidates:
    """Return the methods that may suit a scene which several serve."""
    span = stop - start
    abrupt = [load for load in model.loads if load.acts_at_once]
    if abrupt and model.free_count + model.state_count <= MOST_SPEEDS:
        others = f"{abrupt[0].kind} {abrupt[0].name!r} may become stiff suddenly"
        suited = partial(_for_abrupt_forces, model, abrupt, (start, stop), rtol, atol)
        return Candidates(("radau5", *EXPLICIT), suited, others)
    rate = _fastest(model, start, span)
    if not look_at_state(model) and not _is_stiff(rate, span):
        return Candidates(EXPLICIT, lambda: _explicit(model, span), "nothing is stiff")
    is_plain = not (model.loads or model.has_stops or look_at_state(model)) and all_damped(model)
    names = ("extrapolation",) if is_plain and _is_loose(rtol) else ("extrapolation", "radau5", *EXPLICIT)
    suited = partial(_by_rates, model, (start, stop), rtol, atol, rate)
    return Candidates(
        (*names, "generalised-alpha"), suited, "nothing but damped vibrations is stiff" if is_plain else ""
    )


def _explicit(model: Model, span: float) -> SuitedMethod:
    """Return the explicit method for what is not stiff: that with fewer stages where samples make steps short."""
    every = min((controller.every for controller in model.controllers if controller.is_sampled), default=math.inf)
    if span > MANY_SAMPLES * every:
        return SuitedMethod(FEWER_STAGES, f"no stiff elastic modes, and controllers end a step each {every:g} s")
    return SuitedMethod("dop853", "no stiff elastic modes")


def _is_loose(rtol: float | None) -> bool:
    return rtol is None or rtol >= LOOSE_RTOL


def _for_abrupt_forces(
    model: Model, abrupt: Sequence[Load], times: tuple[float, float], rtol: float | None, atol: float
) -> SuitedMethod:
    """Return the method for a scene with forces that act at once: contacts, friction, stops."""
    from kanefe.contact.contact import compliant_contacts
    from kanefe.integrate.auto.loaded_contacts import loaded_depth

    start, span = times[0], times[1] - times[0]
    depth = loaded_depth(model, start) if any(load.straight for _, load in compliant_contacts(abrupt)) else 0.0
    share = min(max(CONTACT_ATOL, SHARE_OF_DEPTH * depth / scene_length(model)) / atol, 1.0)
    if explicit_serves_friction(model, abrupt, start, span):
        return SuitedMethod("dop853", "friction in joints, which is not stiff if all of it sticks", share=share)
    reason = f"{abrupt[0].kind} {abrupt[0].name!r} may become stiff suddenly"
    if explicit_serves_contacts(model, abrupt, start, span, rtol, atol, depth > 0.0):
        reason += ", but seldom acts"
        return SuitedMethod("dop853", reason, share=share)
    return SuitedMethod("radau5", reason, share=share)


def _by_rates(model: Model, times: tuple[float, float], rtol: float | None, atol: float, rate: float) -> SuitedMethod:
    """Return the method for a scene by the rates (rad/s) of its elastic modes and of functions of the state."""
    (start, stop), span = times, times[1] - times[0]
    dynamics = Dynamics(model)
    outside = rate_of_functions(dynamics, start)
    if not _is_stiff(max(rate, outside), span):
        return _explicit(model, span)
    reason = f"functions of the state with rates up to {outside:.2g} rad/s are stiff over {span:g} s"
    if _is_stiff(rate, span):
        what = "springs and joints" if all(body.flexible is None for body in model.bodies) else "elastic modes"
        reason = f"{what} up to {rate / (2 * math.pi):.3g} Hz are stiff over {span:g} s"
    if model.states_move:
        by_sweeps = serving(model, "extrapolation", "dop853")[0] if all_damped(model) else "dop853"
        few = model.free_count + model.state_count <= MOST_SPEEDS and serving(model, "radau5")
        return SuitedMethod("radau5" if few else by_sweeps, f"{reason}, and internal states of loads are followed")
    names = [STOPS] if model.has_stops else []
    names += ["springs between frames"] if model.loads else []
    names += [obstacle.kind for obstacle in model.route.obstacles]
    if outside * span > MOST_OUTSIDE:
        names.append(f"functions of the state with rates up to {outside:.2g} rad/s")
    if names:
        if _is_stiff(rate, span):
            reason += f", with {' and '.join(names)}"
        if names == [STOPS] and explicit_serves_stops(model, start, span):
            return SuitedMethod("dop853", f"{reason}, which act for short times")
        if model.free_count <= MOST_SPEEDS or outside * span > MOST_OUTSIDE:
            return SuitedMethod("radau5", reason)
        return SuitedMethod("generalised-alpha", f"{reason}, and {model.free_count} speeds are too many for radau5")
    changes = changes_of(dynamics, start, stop) if dynamics.calls_functions else NO_CHANGES
    return _by_vibrations(dynamics, times, rtol, atol, reason, changes)._replace(changes=changes)


def _by_vibrations(
    dynamics: Dynamics, span: tuple[float, float], rtol: float | None, atol: float, reason: str, changes: Changes
) -> SuitedMethod:
    """Return the method for a scene whose sweep knows all that is stiff: by whether its vibrations are followed.

    They are those of the start, and those that begin where functions of the time change at once.
    """
    model, (start, stop) = dynamics.model, span
    is_loose, by_radau = _is_loose(rtol), _tells_forces_by_radau(model)
    if is_loose and all_damped(model):
        return SuitedMethod("extrapolation", reason)
    found = vibrations(dynamics, start, stop - start)
    every = min((controller.every for controller in model.controllers), default=math.inf)
    if stop - start > MANY_SAMPLES * every and np.all(found.ratios >= least_damping(found.frequencies * every)):
        reason += f", and controllers restart every method each {every:g} s"
        explicit = explicit_work(model, (stop - start) * float(found.frequencies.max(initial=0.0)))
        lasts = not is_loose and np.any(found.ratios < LEAST_DAMPING)  # and is seen anew from each sample on
        is_more = lasts and explicit < sampled_work(model, (stop - start) / every)
        return SuitedMethod("dop853" if is_more else "extrapolation", reason)
    undamped = float(found.frequencies[found.ratios < LEAST_DAMPING].min(initial=math.inf))
    # of loops also at loose tolerances: what pins do to modes is in their accelerations
    unfit = STIFF_FORCES if by_radau and (not is_loose or (rtol is not None and model.constraints)) else ""
    if is_loose and undamped == math.inf and not unfit:
        return SuitedMethod("extrapolation", reason)
    largest, seen = float(found.sizes.max(initial=0.0)), "at the start"
    if len(changes.ends):
        found, when = begun_by(changes.sides, (stop - start) / SAMPLES, dynamics, found)
        if found.sizes.max(initial=0.0) > largest:
            largest, seen = float(found.sizes.max()), f"once a function of the time changes, at {when:.4g} s"
    if largest * (1.0 - (rtol or 0.0)) <= (UNSEEN if undamped == math.inf else UNSEEN_UNDAMPED) * atol:
        seen = ""
    followed = _followed(dynamics, (start, stop), rtol, undamped, seen, changes)
    if not followed and undamped == math.inf:
        if unfit:
            return SuitedMethod("radau5", f"{reason}, and forces are more exact by its steps", unfit=unfit)
        return SuitedMethod("extrapolation", reason)
    # where it is handed over, something vibrates whose radians are steps
    least = LEAST_OF_RADAU if followed else (stop - start) * undamped
    name = _follower(model, stop - start, max(least, steps_of_radau(stop - start, rtol, atol, found)), found)
    if not followed:
        return SuitedMethod("extrapolation", reason, then=name, least=CALM / undamped)
    reason += f", and {followed}{_without_damping(model)}"
    if undamped == math.inf and model.free_count > MOST_SPEEDS:
        return SuitedMethod("extrapolation", f"{reason}, and {model.free_count} speeds are too many for radau5")
    return SuitedMethod(name, reason, unfit=unfit if name == "radau5" else "")


def _tells_forces_by_radau(model: Model) -> bool:
    """Return whether Radau's method tells forces of flexible bodies better for no more work, at tight tolerances."""
    is_flexible = any(body.flexible is not None for body in model.bodies)
    is_served = is_flexible and bool(serving(model, "radau5"))
    return is_served and radau_work(model, 1.0) <= EVALUATIONS_INSTEAD * evaluation(model)


def _followed(
    dynamics: Dynamics,
    times: tuple[float, float],
    rtol: float | None,
    undamped: float,
    seen: str,
    changes: Changes,
) -> str:
    """Return in words why vibrations are to be followed; nothing where they are not.

    `seen` tells when they are larger than the tolerance, if they are.
    """
    model, (start, stop) = dynamics.model, times
    span, is_undamped = stop - start, undamped < math.inf
    if rtol is not None and rtol < LEAST_RTOL_OF_SWEEPS:
        return f"rtol={rtol:g} resolves their vibrations"
    frequencies = modal_frequencies(model)
    if not np.any(frequencies > 0.0) or (is_undamped and _has_springs(model)):
        return "vibrations on springs of joints are resolved"
    slowest = undamped if is_undamped else float(frequencies[frequencies > 0.0].min())
    is_loose = _is_loose(rtol)
    if span * slowest < 2.0 * math.pi * (FEW_IF_LOOSE if is_loose else FEW_PERIODS):
        return f"the slowest, of {slowest / (2 * math.pi):.3g} Hz, is followed"
    longest = min((controller.every for controller in model.controllers), default=span)
    if dynamics.calls_functions:
        longest = min(longest, span / LEAST_STEPS, float(np.diff(changes.ends).min(initial=math.inf)))
    if is_undamped and longest < CALM / undamped:
        return "steps that functions and controllers require resolve undamped vibrations"
    if rtol is not None and seen:
        return f"vibrate by more than rtol={rtol:g} {seen}"
    return ""


def _without_damping(model: Model) -> str:
    """Return what to do where the steps are short since flexible bodies vibrate for ever; nothing where none does."""
    flexible = [(body.name, body.flexible.body) for body in model.bodies if body.flexible is not None]
    names = [repr(name) for name, body in flexible if not (np.any(body.damping) or body.relaxation is not None)]
    if not names:
        return ""
    shown = names if len(names) < 4 else [*names[:2], f"{len(names) - 2} more"]
    return f"; no damping of {', '.join(shown)}: with kf.ModalDamping(0.01) steps are longer"


def _has_springs(model: Model) -> bool:
    """Return whether joints have springs."""
    forces = [force for body in model.bodies for force in body.joint.coordinate_forces]
    return any(force is not None and force.stiffness > 0.0 for force in forces)


def _follower(model: Model, span: float, steps: float, found: Vibrations) -> str:
    """Return the method that follows vibrations with less work.

    Radau's, for which so many steps are enough, or the explicit one with those for which the fastest is stable.
    """
    explicit = explicit_work(model, span * float(found.frequencies.max(initial=0.0)))
    return "dop853" if explicit < radau_work(model, steps) else "radau5"


def _is_stiff(rate: float, span: float) -> bool:
    # DOP853 is stable up to |h w| = 6, but where modes are excited its error control asks for |h w| of about 2
    return span * rate / 2.0 > MOST_EXPLICIT_STEPS


def _fastest(model: Model, start: float, span: float) -> float:
    """Return a lower bound of the fastest rate of the scene in rad/s, accurate enough to decide whether it is stiff."""
    is_elastic = any(body.flexible is not None or body.has_coordinate_forces for body in model.bodies)
    if not (is_elastic or model.loads):
        return 0.0
    # of the bodies alone: motions of the whole scene are faster still, and need the mass of all of it
    alone = float(modal_frequencies(model).max(initial=0.0))
    if _is_stiff(alone, span):
        return alone
    return rate_at_stops(model, start) if model.has_stops and not model.loads else stiffest_rate(model, start)
