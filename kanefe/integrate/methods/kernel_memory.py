"""The memory of a compiled method at the start of a run: see `kanefe.kernels.steppers.step_commands`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.breakpoints import breakpoints_of, changes_of
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.locked_speeds import locked_speeds
from kanefe.integrate.methods.elastic_speeds import elastic_speeds, is_damped
from kanefe.integrate.methods.kernel_set import Kernels
from kanefe.integrate.methods.method import LEAST_RTOL
from kanefe.integrate.run_checks.bending_check import WatchedBodies, bends_in_kernels
from kanefe.integrate.run_checks.functions_of_user import asks_for_state
from kanefe.integrate.stepper import LEAST_STEPS
from kanefe.kernels.steppers.breakpoints import LIMITS
from kanefe.kernels.steppers.force_scales import put_force_scales
from kanefe.kernels.steppers.settled_outputs import Settling
from kanefe.kernels.steppers.step_commands import Step
from kanefe.kernels.values.filled import allocate, place
from kanefe.tree.model_data import QUADRATURES
from kanefe.tree.scales import coordinate_moves, displacement_scales

if TYPE_CHECKING:
    from kanefe.integrate.stepper import StepControl

SMALLEST_STEP = 16.0 * float(np.finfo(float).eps)
"""Smallest step relative to the largest time: below it, times lose their digits. A jump of a force or a power leaves an
error proportional to the step, so that a step across a jump may have to be this small; the loop ends runs that do not
advance."""

LEAST_MODE = 1e-13
"""Least error that is allowed along a mode, relative to what moves its body by its size: hundreds of round-offs."""

NO_CLUSTER = 1e-3
"""Length of a step after rejections, relative to the longest so far, below which they have clustered: across a jump a
step of any order has an error in proportion to its length, which is smaller than tolerances in use only then."""

ITERATED = 1e-10, 1e-12
"""Relative and absolute tolerance of the iterations with fixed steps."""


class StepMemory(NamedTuple):
    """The arrays of a step."""

    integers: np.ndarray
    reals: np.ndarray
    vectors: np.ndarray

    def step(self, kernels: Kernels) -> Any:
        """Return them by name."""
        return kernels.record(*self)


def new_memory(
    dynamics: Dynamics, start: float, stop: float, control: StepControl, kernels: Kernels, bodies: WatchedBodies
) -> StepMemory:
    """Return the memory of a method at the start of a run; times in s. `bodies` are those whose bending is watched."""
    y = dynamics.initial_state(start)
    memory = _allocated(dynamics, start, stop, y, control, kernels, bodies)
    step = memory.step(kernels)
    _put_run(step, dynamics, start, stop, control, kernels)
    step.state[:] = y
    rtol, atol = ITERATED
    if control.step is None:
        rtol = max(kernels.of_tolerance(control.rtol), LEAST_RTOL)
        atol = max(rtol * (control.atol / control.rtol), 1e-300)
    step.relative, step.scale[:] = rtol, atol * dynamics.scales(start, y, control.looseness)
    step.large[:] = step.scale
    if not (step.is_fixed or dynamics.model.controllers) and kernels.scales_with_forces:
        _scale_modes(step, dynamics, control.rtol)
    return memory


def _allocated(
    dynamics: Dynamics, start: float, stop: float, y: Vector, control: StepControl, kernels: Kernels,
    bodies: WatchedBodies,
) -> StepMemory:  # fmt: skip
    """Return the memory with its lengths, and with what is given of the scene."""
    model, moves = dynamics.model, coordinate_moves(dynamics.model)
    locked, (knots, sides) = None, (np.zeros(0), np.zeros(0))
    if control.step is None:
        if kernels.is_implicit or kernels.has_jacobian:
            # the extrapolation lets grow what nothing damps, beside methods that solve with Jacobians
            locked = locked_speeds(dynamics, start, y[:-QUADRATURES], kernels.has_jacobian)
        changes = changes_of(dynamics, start, stop) if control.changes is None else control.changes
        dynamics.seconds_looking = changes.seconds
        knots, sides = breakpoints_of(dynamics, changes)
    whole = {
        "size": len(y), "coordinates": model.coordinate_count, "speeds": model.free_count, "move_count": len(moves),
        "bend_count": len(bends_in_kernels(bodies, 0)[0]), "breakpoint_count": len(knots), "side_count": len(sides),
        "sampled_speeds": 0 if locked is None else model.free_count,
        "joint_speeds": 0 if locked is None else len(locked.rows),
    }  # fmt: skip
    integers, reals, flat = allocate(kernels.record, **whole, **kernels.whole(model))
    bent, bends = bends_in_kernels(bodies, len(reals))
    vectors = np.zeros((-(-len(flat) // len(y)), len(y)))
    memory = StepMemory(integers, np.concatenate((reals, bends)), vectors)
    step = memory.step(kernels)
    step.moves[:], step.bends[:] = np.reshape(np.array(moves, dtype=np.int64), (-1, 3)), bent
    if len(knots):
        step.breakpoints[:], step.left_sides[:], step.next_breakpoint = knots, sides, 1
        step.last_kept = len(sides) or -LIMITS.most_kept
    if locked is not None:
        step.every, step.joint_of_speed[:], step.shaken[:] = locked
    if kernels.has_jacobian:
        step.jacobian_row = place(step, "jacobian") // len(y)
    return memory


def _put_run(step: Step, dynamics: Dynamics, start: float, stop: float, control: StepControl, kernels: Kernels) -> None:
    """Write what a run asks for."""
    model = dynamics.model
    if kernels.settles_outputs:
        elastic = elastic_speeds(model)
        step.elastic[model.coordinate_count + elastic] = 1.0
        step.settles = Settling.SOME if len(elastic) else Settling.NOT
    step.has_loops = model.is_constrained
    step.looks_for_jumps = control.step is None and asks_for_state(model)
    step.time = step.time_old = start
    step.stop, step.smallest = stop, SMALLEST_STEP * max(abs(start), abs(stop))
    # what happens between the substeps of a step is not seen: functions of the user are looked at often enough
    step.largest = (stop - start) / LEAST_STEPS if dynamics.calls_functions else math.inf
    step.shortest_share, step.reach = NO_CLUSTER, kernels.reach
    step.largest_of_drives = step.to_event = step.longest_restart = math.inf
    if control.step is not None:
        step.is_fixed, step.next_step = True, control.step


def _scale_modes(step: Step, dynamics: Dynamics, rtol: float) -> None:
    """Let modes be followed relative to the forces of their bodies.

    Not of bodies whose vibrations hardly fade, which all would be followed to the end of the run. (Where controllers
    sample, no modes are: each of their jumps would have them followed anew.)
    """
    model, scale, large, unit = dynamics.model, step.scale, step.large, step.unit
    n, displacements = model.coordinate_count, displacement_scales(model)
    bodies = [body.flexible.speeds for body in model.bodies if body.flexible and is_damped(body.flexible.body)]
    of_speeds = {speed: k + 1 for k, speeds in enumerate(bodies) for speed in range(speeds.start, speeds.stop)}
    for turns, at, speed in coordinate_moves(model):
        if not turns and speed in of_speeds:
            unit[at], unit[n + speed] = 1.0 / displacements[speed], of_speeds[speed]
            least = min(LEAST_MODE * displacements[speed] / large[at], 1.0)
            scale[[at, n + speed]] = least * large[[at, n + speed]]
    step.of_forces, step.least_allowed = rtol, LEAST_MODE
    put_force_scales(step)
