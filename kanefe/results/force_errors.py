"""The error of the forces of a run, estimated from the run itself: parts of it are run again, with a smaller tolerance.

Errors of positions are what the tolerance allows; those of forces are these times stiffnesses, and how large they are
depends on what the method does with modes that its steps pass over. A second run from a stored state tells: within a
few of its smaller steps stiff modes have their forces, while positions have hardly had time to differ. Parts are looked
at where the run starts, at even distances, and where forces are rougher than in all of these.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import AccuracyWarning, KanefeError, ModelError, outside
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.kernel_stepper import KernelStepper
from kanefe.integrate.methods.table import row_for, serving
from kanefe.integrate.stepper import ATOL_SHARE, StepControl
from kanefe.integrate.trajectory import Trajectory
from kanefe.results.channels import RunChannels
from kanefe.results.quantities import resolved_parts
from kanefe.tree.scales import scene_length

TIGHTER = 0.01
"""Tolerance of the parts that are run again, relative to that of the run."""

RTOL_OF_FIXED = 1e-6
"""Relative tolerance of parts of a run with fixed steps, which has none itself."""

PARTS = 5
"""Number of parts of a run that are run again."""

LEAST_STEPS = 6.0
"""Least length of a part, in mean steps of the run, where it has many: stiff modes need some to settle."""

ROUGH_PARTS = 2
"""Largest number of parts beside these, where forces are rougher than in all of them."""

MOST_LOOKS = 20
"""Number of outputs that are tried for them: an event may be near."""

SETTLED = 0.4
"""Time from the start of a part after which its forces are compared, relative to its length."""

LEAST_SHARE, LARGEST_SHARE = 0.02, 0.1
"""Least and largest length of a part, relative to the run: with outputs farther apart it would cost as much as one."""

ENOUGH_STEPS = 60.0
"""Length of a part, in mean steps of the run, that is enough where it is less than the least share."""

MOST_STEPS = 0.5
"""Largest number of steps of all parts, relative to that of the run."""

FEWEST_STEPS = 40
"""Number of steps that a part has at least."""

PROMISED = 100.0
"""Error of a force, relative to rtol and the largest force of its channel, above which a warning is issued."""

MOST_SPEEDS = 60
"""Number of speeds up to which parts are run by Radau's method, whose matrices have as many rows."""

WITHOUT, BY_HAND = "the errors of forces are not estimated", "result.force_errors() does so"

NOTHING = 1e-9
"""Size of a force or moment, relative to the largest of the scene, below which it is round-off."""


class ForceError(NamedTuple):
    """What is known of the error of a channel of forces.

    Attributes
    ----------
    quantity, name, part : str
        Such as "loop_force", "pin", "force"; of a load the part is a column.
    unit : str
    error : float
        Estimated: largest difference to parts of the run that were run again with a hundredth of its tolerance.
    largest : float
        Largest size in the run.
    is_least : bool
        Whether it may be larger: parts were left since they took too many steps, or loads have states, such as what
        sticks, which keep errors from before a part.
    """

    quantity: str
    name: str
    part: str
    unit: str
    error: float
    largest: float
    is_least: bool = False

    @property
    def share(self) -> float:
        """Error relative to the largest size."""
        return self.error / self.largest

    def __str__(self) -> str:
        size = f"{self.error:.2g} {self.unit}, {self.share:.1g} of the largest"
        about = "at least" if self.is_least else "about"
        return f"{self.part} in {self.quantity} {self.name!r} has an error of {about} {size}"


class PartOfRun(NamedTuple):
    """Numbers of the output times at which a part of a run begins and ends, and of the first that is compared."""

    first: int
    compared: int
    last: int


def force_errors(channels: RunChannels) -> tuple[ForceError, ...]:
    """Return the estimated errors of all channels of forces, the largest relative to its channel first.

    Raises
    ------
    ModelError
        If there is no estimate; the message says why.
    """
    if why := obstacle(channels):
        raise ModelError(f"{WITHOUT}: {why}")
    sizes = _forces_that_count(channels)
    largest = {key: float(np.linalg.norm(force, axis=1).max()) for key, force in sizes.items()}
    parts = _parts(channels)
    parts += _rough_parts(channels, parts, _roughness(channels.times, sizes.values()))
    rows, again, is_whole = _again(channels, parts)
    errors = dict(_forces(again))
    off = {key: float(np.linalg.norm(errors[key] - force[rows], axis=1).max()) for key, force in sizes.items()}
    # where something sticks, its force keeps the errors of all that has been
    is_least = not is_whole or channels.model.state_count > 0
    found = [ForceError(*key, off[key], largest[key], is_least) for key in sizes]
    return tuple(sorted(found, key=lambda one: -one.share))


def estimated_unasked(channels: RunChannels) -> tuple[ForceError, ...]:
    """Return the same for a run with elastic modes, whose statistics get the first of them, or why there is none.

    None of runs that call functions of the user from Python, which would be called again; and of runs without elastic
    modes nothing is said.
    """
    model, told = channels.model, channels.statistics
    if "steps" not in told or not any(body.flexible is not None for body in model.bodies):
        return ()
    try:
        if not model.route.is_autonomous:
            raise ModelError(f"{WITHOUT} unasked: functions in Python would be called again. Remedy: {BY_HAND}")
        found = force_errors(channels)
    except KanefeError as error:
        told["force_error_unknown"] = str(error)
        return ()
    if found:
        told["force_error"] = [*found[0][:3], found[0].error, found[0].largest, found[0].is_least]
    return found


def warn_of_error(channels: RunChannels, errors: Sequence[ForceError], quantity: str, name: str) -> None:
    """Warn if the error of a channel, or of one of which the force at an interface is a sum, is more than promised."""
    told = channels.statistics
    of_channel = [one for one in errors if quantity == "coupling_force" or one[:2] == (quantity, name)]
    if not of_channel or "rtol" not in told or of_channel[0].share <= PROMISED * told["rtol"]:
        return
    other = "" if told["method"] == "radau5" else "method='radau5', or "
    warnings.warn(
        f"the {of_channel[0]}, and rtol={told['rtol']:g} promises {PROMISED * told['rtol']:.1g}. "
        f"Remedy: {other}a smaller rtol; result.force_errors() has the errors of all forces",
        AccuracyWarning,
        stacklevel=outside(),
    )


def obstacle(channels: RunChannels) -> str:
    """Return why there is no estimate for a run, with a remedy; empty if there is one."""
    model, told = channels.model, channels.statistics
    if channels.status.kind == "failed":
        return "the run has failed. Remedy: that of its status"
    if "steps" not in told:
        return "these are states of no run. Remedy: simulate"
    if model.controllers or model.rigid_contacts or model.has_unreduced:
        what = "controllers" if model.controllers else "rigid contacts" if model.rigid_contacts else "unreduced bodies"
        return f"parts of runs with {what} cannot be run again. Remedy: compare with a run with a smaller rtol"
    if not _parts(channels):
        return "its outputs are too far apart, or too much happens between them. Remedy: a smaller output_step"
    return ""


def _parts(channels: RunChannels) -> list[PartOfRun]:
    """Return the parts that are run again: from the start, and at even distances up to the end."""
    ends = (round((len(channels.times) - 1) * (number + 1) / PARTS) for number in range(PARTS))
    found = [part for last in ends if (part := _part_to(channels, last)) is not None]
    if found:
        last = found[0].last - found[0].first
        if (first := _part_to(channels, last)) is not None and first.first == 0:
            found.append(first._replace(compared=1))  # what it begins with is exact
    return found


def _part_to(channels: RunChannels, last: int) -> PartOfRun | None:
    """Return the part that ends at the output of a number; None if there is none, or an event in it."""
    times, told = channels.times, channels.statistics
    span = float(times[-1] - times[0])
    of_step = 1.0 / max(told["steps"], 1)
    least = max(min(LEAST_STEPS * of_step, 0.5 * LARGEST_SHARE), min(ENOUGH_STEPS * of_step, LEAST_SHARE)) * span
    first = int(np.searchsorted(times, times[last] - least * (1.0 - 1e-9), side="right")) - 1
    if first < 0 or first == last or times[last] - times[first] > LARGEST_SHARE * span:
        return None
    happened = np.sort(np.concatenate((np.zeros(0), *channels.events.values())))
    if np.searchsorted(happened, times[first]) != np.searchsorted(happened, times[last], side="right"):
        return None
    settled = times[first] + SETTLED * (times[last] - times[first])
    return PartOfRun(first, min(int(np.searchsorted(times, settled)), last), last)


def _roughness(times: np.ndarray, forces: Iterable[np.ndarray]) -> np.ndarray:
    """Return for each output by how much a force is off the cubic through its neighbours, relative to its largest.

    What a method leaves in stiff modes changes from step to step, and shows so where forces change less: of the largest
    of all channels, shape (T,).
    """
    found = np.zeros(len(times))
    if len(times) < 5:
        return found
    beside = [times[:-4], times[1:-3], times[3:-1], times[4:]]
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = [
            np.prod([(times[2:-2] - other) / (one - other) for other in beside if other is not one], axis=0)
            for one in beside
        ]
        for force in forces:
            largest = np.linalg.norm(force, axis=1).max(initial=0.0)
            cubic = sum(
                w[:, None] * x for w, x in zip(weights, (force[:-4], force[1:-3], force[3:-1], force[4:]), strict=True)
            )
            off = np.linalg.norm(force[2:-2] - cubic, axis=1) / largest
            found[2:-2] = np.maximum(found[2:-2], np.where(off < np.inf, off, 0.0))
    return found


def _rough_parts(channels: RunChannels, parts: Sequence[PartOfRun], rough: np.ndarray) -> list[PartOfRun]:
    """Return parts about the outputs with the roughest forces, where they are rougher than in the parts given."""
    found: list[PartOfRun] = []
    seen = max((float(rough[part.compared : part.last + 1].max()) for part in parts), default=0.0)
    left = rough.copy()
    for _ in range(MOST_LOOKS):
        at = int(left.argmax())
        if left[at] <= seen or len(found) == ROUGH_PARTS:
            break
        behind = _part_to(channels, at)
        length = 0 if behind is None else at - behind.first
        # about in the middle of what is compared
        part = _part_to(channels, min(at + round(0.5 * (1.0 - SETTLED) * length), len(rough) - 1))
        if part is not None and part.compared <= at:
            found.append(part)
            left[part.compared : part.last + 1] = 0.0
        left[at] = 0.0
    return found


def _again(channels: RunChannels, parts: Sequence[PartOfRun]) -> tuple[np.ndarray, RunChannels, bool]:
    """Return the numbers of output times that were reached again, the channels of these, and whether all were."""
    model, times, told = channels.model, channels.times, channels.statistics
    rows: list[int] = []
    states = [np.zeros((0, channels.states.shape[1] + 2))]
    left = max(int(MOST_STEPS * told["steps"]), FEWEST_STEPS * len(parts))
    stepper, is_whole = _stepper(channels), True
    # the start last, with what the others have left: something may settle there
    for number, part in enumerate(sorted(parts, key=lambda part: part.first == 0)):
        y = np.concatenate((channels.states[part.first], [0.0, 0.0]))
        wanted = times[part.first + 1 : part.last + 1]
        reached = np.empty((len(wanted), len(y)))
        stepper.restart(float(times[part.first]), y)
        # as long as those of the run, with which stiff modes are damped
        stepper.step.next_step = (times[-1] - times[0]) / max(told["steps"], 1)
        stepper.aim(float(wanted[-1]))
        before = stepper.step_count
        try:
            passed = stepper.integrate_through(wanted, reached, left // (len(parts) - number))
        except KanefeError:
            passed = 0
        finally:
            left -= stepper.step_count - before
        is_whole = is_whole and passed == len(wanted)
        skipped = part.compared - part.first - 1
        rows += range(part.compared, part.first + 1 + passed)
        states.append(reached[skipped:passed] if passed > skipped else reached[:0])
    if not rows:
        raise ModelError(
            f"{WITHOUT}: no part of the run could be run again within "
            f"{MOST_STEPS:.0%} of its steps. Remedy: compare with a run with a smaller rtol"
        )
    at, found = np.array(rows, dtype=int), np.concatenate(states)
    return at, RunChannels(model, Trajectory.of_states(model, times[at], found, statistics={})), is_whole


def _stepper(channels: RunChannels) -> KernelStepper:
    """Return the stepper of the parts."""
    model, told = channels.model, channels.statistics
    own = [told["method"]] if told["method"] != "radau5" else []
    names = ["radau5", "extrapolation"] if model.free_count <= MOST_SPEEDS or not own else [*own, "radau5"]
    for name in serving(model, *names):
        row = row_for(model, name)
        rtol = max(TIGHTER * told["rtol"] if "rtol" in told else RTOL_OF_FIXED, row.least_rtol)
        control = StepControl(rtol, ATOL_SHARE * rtol, None)
        made = row.make(Dynamics(model), float(channels.times[0]), float(channels.times[-1]), control)
        if isinstance(made, KernelStepper):
            # what stiff modes do beside the rest is to be damped, not followed
            made.step.of_forces, made.step.scale[:] = 0.0, made.step.large
            return made
    raise ModelError(f"{WITHOUT}: no method serves the scene for it")


def _forces_that_count(channels: RunChannels) -> dict[tuple[str, str, str, str], np.ndarray]:
    """Return the vectors of force of `_forces` that are more than round-off, and than errors promised beside them."""
    sizes, length = dict(_forces(channels)), scene_length(channels.model)
    largest = {key: float(np.linalg.norm(force, axis=1).max()) for key, force in sizes.items()}
    arms = {"N": 1.0, "N m": length}  # and the power of a drive of poses is compared with itself alone
    sizes_of = {key: largest[key] / arms[key[3]] for key in largest if key[3] in arms}
    top = max(sizes_of.values(), default=0.0)
    least = dict.fromkeys(sizes, NOTHING * top)
    for key in sizes_of:  # a moment of nothing beside a force, as in a plane, or the other way round
        of_one = max(size for other, size in sizes_of.items() if other[:2] == key[:2])
        least[key] = max(least[key], min(PROMISED * channels.statistics.get("rtol", RTOL_OF_FIXED), 0.01) * of_one)
    return {key: force for key, force in sizes.items() if largest[key] > least[key] * arms.get(key[3], 0.0)}


def _forces(channels: RunChannels) -> Iterator[tuple[tuple[str, str, str, str], np.ndarray]]:
    """Yield quantity, name, part and unit of each vector of force, and its values, (T, components)."""
    model: Model = channels.model
    wrenches = [("joint_reaction", body.name) for body in model.bodies]
    for quantity, name in (*wrenches, *(("loop_force", name) for name in channels.loops)):
        found = channels.read(quantity, name)
        yield (quantity, name, "force", "N"), found[:, :3]
        yield (quantity, name, "moment", "N m"), found[:, 3:]
    along = [("driving_force", shape.name, shape.driven_names) for shape in channels.bodies if shape.is_driven]
    along += [("gear_force", name, columns) for name, columns in channels.gears.items()]
    for quantity, name, coordinates in along:
        found = channels.read(quantity, name).reshape(len(channels.times), -1)
        first = 0
        for label, unit, names in resolved_parts(quantity, coordinates):
            end = first + max(len(names), 1)
            yield (quantity, name, label, unit), found[:, first:end]
            first = end
    for name, columns in channels.loads.items():
        found = channels.read("load", name)
        for unit in ("N", "N m"):
            of = [i for i, column in enumerate(columns) if column.endswith(f"[{unit}]")]
            if of:
                yield ("load", name, "columns", unit), found[:, of]
