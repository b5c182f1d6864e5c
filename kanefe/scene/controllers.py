"""Methods of `System` that add sampled controllers."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.loads.offered_function import CompiledByNumba
from kanefe.scene.readings import readings_of, texts_of
from kanefe.scene.scene import Scene
from kanefe.scene.targets import Named, Target, axes_of, joint_entry, target_of

DRIVES = {"motor": "", "force": "N", "torque": "N m"}
ELSEWHERE = {
    "drive": "a motor on a free coordinate, or a Motion for what is known beforehand",
    "gravity": "force on each body",
    "load": "motor, force or torque, which add to the loads that there are",
}


class ControllerMethods(Scene):
    """The part of `System` that adds controllers."""

    @checked("every", "reads", "drives", "delay")
    def add_controller(
        self,
        name: str,
        function: Callable[[float, np.ndarray, dict[str, Any]], Any],
        *,
        every: float,
        reads: Named,
        drives: Named,
        delay: float = 0.0,
    ) -> None:
        """Add a sampled controller: a Python function of measured quantities, whose drives are held between samples.

        Between samples a run stays in compiled code. Steps end at samples, so that drives do not jump within a step.
        The result has all samples in ``result.controllers[name]``. Linear analyses treat the scene without it, with its
        drives as inputs.

        Parameters
        ----------
        name : str
            Unique among controllers.
        function : callable
            ``f(t, reads, memory)`` -> one number for each drive. t in s; reads (k,) in the given order; memory is a
            dict for integrals and filters, empty at the start of each run; of `kanefe.compiled` an array of zeros.
            Where that reads joints, modes and deflections, the run does not return to Python for it.
        every : float
            Sampling time, s; the first sample is at the start of a run.
        reads : str, sequence or mapping of str
            As the outputs of `kanefe.linearise`: ``"joint_coordinates hub"``, ``"velocity arm/tip z"``, ``"acceleration
            arm/tip x'"``; x is along N, x' along the frame's own axes, and without an axis all three are read.
            "rotation" is the rotation vector from N to the frame, rad.
        drives : str, sequence or mapping of str
            As the inputs of `kanefe.linearise`: ``"motor hub"`` (N m along an angle, N along a distance), ``"force body
            x"``, ``"torque body/interface z'"``. They act in addition to other loads.
        delay : float
            Time from a sample until its drives act, s.

        Raises
        ------
        ModelError
            If an argument is not valid; the message names it and lists possible values.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z"))
        >>> def hold(t, reads, memory):
        ...     angle, rate = reads
        ...     return 4.0 * (1.0 - angle) - 1.0 * rate
        >>> reads = ("joint_coordinates hub", "joint_speeds hub")
        >>> scene.add_controller("hold", hold, every=1e-3, reads=reads, drives="motor hub")
        >>> result = scene.simulate((0.0, 2.0))
        >>> result.controllers["hold"].drives.shape
        (2000, 1)
        """
        from kanefe.loads.controller import Controller

        label = f"controller {name!r}"
        self._check_open(label)
        if not isinstance(name, str) or not name:
            raise ModelError(f"the name of a controller must be a text, not {name!r}")
        if any(other.name == name for other in self._controllers):
            raise ModelError(f"the scene already has a {label}. Remedy: another name")
        _check_function(function, label)
        for what, value, least in (("every", every, math.ulp(0.0)), ("delay", delay, 0.0)):
            given = numbers(value)
            if not (given.shape == () and math.isfinite(given) and given >= least):
                above = "above zero" if least else "zero or more"
                raise ModelError(f"{what} of {label} must be {above}, in s, not {value!r}")
        readings = readings_of(self._entries, reads, label)
        wanted = [self._drives(label, *named) for named in texts_of(drives, "drives", label)]
        names = [drive for found in wanted for drive, _, _ in found]
        number = 0
        for found in wanted:
            for drive, target, made in found:
                self._hold(name, number, f"{drive.partition(' [')[0]} by {label}", target, made)
                number += 1
        if isinstance(function, CompiledByNumba):
            function.address(len(readings), number, label)  # whether it gives these drives
        self._controllers.append(Controller(name, function, float(every), float(delay), readings, tuple(names)))

    def _drives(self, label: str, name: str, text: object) -> list[tuple[str, Target, tuple[int, bool]]]:
        """Return name, target, and component and axes of each drive of one text."""
        role = f"{label} drives"
        what = text.strip().partition(" ")[0] if isinstance(text, str) else ""
        if what in ELSEWHERE:
            raise ModelError(f"{role} {text!r}: a controller does not drive a {what}. Remedy: {ELSEWHERE[what]}")
        target = target_of(self._entries, name, text, DRIVES, role)
        entry = self._entries[target.body]
        if target.what == "motor":
            return [
                (f"{title} [{'N m' if unit == 'rad' else 'N'}]", target, (i, False))
                for title, i, unit in joint_entry(self._entries, target, role)
            ]
        if entry.flexible is not None and target.interface is None:
            listed = ", ".join(frame.name for frame in entry.interfaces) or "none"
            raise ModelError(
                f"{role} {text!r}: a flexible body is loaded at its interfaces. Remedy: '{target.what} "
                f"{entry.name}/interface'; it has: {listed}"
            )
        return [(f"{title} [{DRIVES[target.what]}]", target, (i, own)) for title, i, own in axes_of(target, role)]

    def _hold(self, name: str, number: int, label: str, target: Target, made: tuple[int, bool]) -> None:
        """Add the load of one drive of a controller."""
        from kanefe.loads.controller import Held
        from kanefe.loads.joint_load import JointLoad
        from kanefe.loads.point_load import PointLoad

        entry, (component, is_own) = self._entries[target.body], made
        if target.what == "motor":
            entry.joint_loads.append(JointLoad(label, Held(name, number), component, takes_state=True))
            return
        axis = np.eye(3)[component]
        if is_own and target.interface is not None:  # loads that follow an interface are in axes of G rotated with it
            axis = target.interface.axes @ axis
        held = Held(name, number, (float(axis[0]), float(axis[1]), float(axis[2])))
        load = PointLoad(label, held, target.what == "torque", np.zeros(3), is_own, takes_state=True)
        entry.loads.append((load, target.interface))


def _check_function(function: object, label: str) -> None:
    """Raise a ModelError if a function does not take three arguments."""
    wanted = "f(t, reads, memory) -> drives"
    if not callable(function):
        raise ModelError(f"{label} needs a function {wanted}, not {function!r}")
    if isinstance(function, CompiledByNumba):
        if not function.is_controller:
            raise ModelError(f"{label} needs a function {wanted}, not f(t, reads) of a load. Remedy: one with a memory")
        return
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # some functions in C have no signature
        return
    try:
        signature.bind(0.0, None, {})
    except TypeError as error:
        raise ModelError(f"{label} needs a function {wanted}; its parameters are {signature}") from error
