"""A simulation as C source, with the image of its memory and tables of its addresses."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from kanefe.fmu import c_text as c
from kanefe.fmu.image import Image, NeedsPython, with_nested
from kanefe.fmu.output_tables import OutputTables
from kanefe.integrate.methods.kernel_memory import SMALLEST_STEP
from kanefe.integrate.methods.kernel_stepper import KernelStepper
from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.compiler.entries import Call
from kanefe.kernels.evaluation.evaluation import AT_TIME
from kanefe.kernels.events.watched_run import Does
from kanefe.kernels.scene import memory_size
from kanefe.kernels.steppers.step_commands import NO_INERTIA, VECTOR, Command, Step
from kanefe.kernels.sweeps.drives import Drives, Piece
from kanefe.kernels.sweeps.outward import motions_of_rows
from kanefe.kernels.values.records import column
from kanefe.loads.controller import INPUTS
from kanefe.order_n.route import OrderN
from kanefe.order_n.sweeps import Sweeps
from kanefe.stepping.simulation import LITTLE, Simulation
from kanefe.tree.model_data import QUADRATURES

ROW, ACCELERATED_ROW = 18, 24
"""Number of values of the motion of a link, without and with accelerations."""

COMMANDS = "START ACCEPTED DONE JACOBIAN FAILED"
FLAGS = {
    "HAS_EVENTS": "PASS_STEPS",
    "HAS_FRAMES": "MOVE",
    "HAS_ACCELERATIONS": "EVALUATE",
    "CAN_TELL_FORCES": "TELL_FORCES",
    "CAN_TELL_LOADS": "TELL_LOADS",
}
"""Names of the flags of calls that only some scenes have."""

PLACES = "TIME TIME_OLD STOP SMALLEST NEXT_OUTPUT TIME_EXCESS TO_EVENT COMMAND STAGE CONTINUES STEPS STORED"
PLACES += " IS_LEFT_OPEN WANTS_DENSE"


class SceneSource(NamedTuple):
    """The parts from which the model of a scene is compiled.

    Attributes
    ----------
    header : str
        C header.
    image : bytes
    files : tuple of Path
        Libraries of the functions that it calls.
    """

    header: str
    image: bytes
    files: tuple[Path, ...]


MOST_NAMED = 4
"""Largest number of events that a message names."""


def obstacle(sim: Simulation) -> str:
    """Return the reason why a simulation cannot run without Python, with a remedy; empty if it can."""
    model, stepper = sim.model, sim.stepper
    sampled = [controller.name for controller in model.controllers if controller.is_sampled]
    if not IS_COMPILED:
        return "its kernels are run as Python. Remedy: unset KANEFE_JIT"
    if sampled:
        return f"the controller {sampled[0]!r} is a Python function. Remedy: what it drives as inputs"
    if not isinstance(model.route, OrderN):
        return f"the scene is not in compiled code: {model.route.reason}"
    if not model.route.is_autonomous:
        return "a load or a motion is a Python function of time or state. Remedy: an input, or a table of time, instead"
    if not isinstance(stepper, KernelStepper):
        return f"the method {stepper.name!r} is in Python. Remedy: method='radau5', 'dop853' or 'extrapolation'"
    if stepper.name == "energy-momentum":
        return f"the method {stepper.name!r} asks for energies. Remedy: method='radau5'"
    watch = sim.event_watch
    if watch is None:
        return ""
    if watch.watched is None:
        named = ", ".join(map(repr, list(sim.events)[:MOST_NAMED])) or "the end of a joint's range"
        return f"these events are looked for in Python: {named}. Remedy: leave them out"
    events = zip(watch.events, watch.watched.kinds, strict=True)
    acting = [event.name for event, kind in events if kind in (Does.ACTS, Does.BOUND)]
    if acting:
        return (
            f"these events act in Python: {', '.join(map(repr, acting[:MOST_NAMED]))}. Remedy: leave out what "
            "ends the run, a bearing without a table"
        )
    return ""


def scene_source(sim: Simulation) -> SceneSource:
    """Return a simulation at its start as source.

    Raises
    ------
    NeedsPython
        If it needs Python; the message gives the reason.
    """
    if found := obstacle(sim):
        raise NeedsPython(found)
    return _Tables(sim).made()


class _Tables:
    """Builder of the source of a simulation."""

    def __init__(self, sim: Simulation) -> None:
        model, stepper, route = sim.model, sim.stepper, sim.model.route
        if not (isinstance(route, OrderN) and isinstance(stepper, KernelStepper)):
            raise TypeError("the scene needs Python")
        self.sim, self.model, self.stepper, self.route = sim, model, stepper, route
        self.size = stepper.vectors.shape[1]
        self.motions: Drives = route.motion_tables  # type: ignore[assignment]  # of an autonomous scene
        self.driven = len(model.drives)
        self.outputs = OutputTables(sim, Sweeps(route, np.zeros(1), model_state(sim)[None]))
        self.times, self.states = np.zeros(1), np.zeros((1, self.size))
        self.watched = None if sim.event_watch is None else sim.event_watch.watched
        run, passing, self.inputs = stepper.prepared(self.times, self.states, self.watched)
        self.calls = [run] if passing is None else [run, passing]
        self.run, self.passing = run, passing
        self.lines: list[str] = []

    def made(self) -> SceneSource:
        self._check_jacobian()
        self._add_motions()
        self._add_forces()
        for call in with_nested(self.calls):
            _clear(call)
        scene = self.run.arguments[0]
        scene.closing.closed[:] = scene.asked[:] = scene.derivatives.state[:] = 0.0
        if self.passing is not None and self.watched is not None:
            for part in (self.watched, *self.passing.arguments[1][:3]):
                for name in part._fields:
                    if name in CLEARED_OF_EVENTS:
                        getattr(part, name)[...] = 0.0
        image = Image(self.calls)
        self._add_scene(image)
        libraries = tuple(dict.fromkeys(file for file, _ in image.functions))
        return SceneSource("\n".join(self.lines) + "\n", image.content(), libraries)

    def _check_jacobian(self) -> None:
        """Refuse a scene whose method needs derivatives of the rates that would not be exact."""
        stepper, route = self.stepper, self.route
        if "jacobians" in stepper.statistics and (route.inputs.needs_state or not route.is_complex):
            raise NeedsPython(
                "a load or joint has no function of complex numbers, with which "
                f"{stepper.name!r} differentiates. Remedy: method='dop853'"
            )

    def _add_motions(self) -> None:
        """Include the motions of frames in the image if outputs need any."""
        self.moved = self.evaluated = None
        if not self.outputs.frames:
            return
        model, scene = self.model, self.outputs.sweeps.placed[1]
        count = self.size - QUADRATURES
        drives, state = np.zeros((1, self.driven, 3)), np.zeros((1, count))
        rates = np.zeros((int(self.outputs.has_accelerations), model.free_count))
        found = np.zeros((1, len(scene.tables.rows), ACCELERATED_ROW if len(rates) else ROW))
        memory = np.zeros(memory_size(scene))
        call = motions_of_rows.bound(scene, drives, state, rates, found, memory).prepared()
        self.moved = call, drives, state, rates, found
        self.calls.append(call)
        if len(rates):
            self.evaluated = self.route.rates_call()
            self.evaluated.vectors[:] = 0.0
            self.evaluated(0.0)
            self.calls.append(self.evaluated.call)

    def _add_forces(self) -> None:
        """Include forces, and outputs of loads, if they are outputs."""
        route, outputs, kernels = self.route, self.outputs, list[tuple[str, Call]]()
        shared = np.zeros(1), np.zeros((1, self.driven, 3)), route.inputs.constants[None].copy(), self._state()
        self.forces: dict[str, np.ndarray] = {}
        if outputs.has_forces:
            forces, found, is_told = route.force_kernel.prepared(*shared, np.zeros((0, 0)))
            shared[0][0], shared[1][0] = self.sim.time, route.drives(self.sim.time)
            forces()
            if not is_told[0]:
                raise NeedsPython(
                    "rows of loop joints depend on each other, or the start is a singular position: their forces are "
                    "computed in Python. Remedy: loop joints that hold less, or motions as outputs"
                )
            is_told[:] = 0
            self.forces |= {"AT_FORCES": found, "AT_IS_TOLD": is_told}
            kernels.append(("TELL_FORCES", forces))
        if outputs.told is not None:
            loads, found = outputs.told.prepared(*shared)
            self.forces["AT_LOADS"] = found
            kernels.append(("TELL_LOADS", loads))
        for array in shared[:2]:
            array[...] = 0.0
        shared[3][...] = 0.0
        self.force_calls = dict(kernels)
        self.calls += self.force_calls.values()
        names = "AT_TOLD_TIME", "AT_TOLD_DRIVES", "AT_TOLD_INPUTS", "AT_TOLD_STATE"
        if kernels:
            self.forces |= dict(zip(names, shared, strict=True))

    def _state(self) -> np.ndarray:
        """Return the state without quadratures, in a row."""
        return model_state(self.sim)[None, : self.size - QUADRATURES].copy()

    def _add_scene(self, image: Image) -> None:
        self._add_counts(image)
        self._add_calls(image)
        self.lines += [c.define(name, image.place(array)) for name, array in self._places().items()]
        kept = self._kept()
        self.lines += [
            c.define("KEPT_COUNT", len(kept)),
            c.integers("KEPT", [(image.place(array), array.nbytes) for array in kept], 2),
            c.integers("POINTERS", image.pointers, 2),
            c.integers("CALLED", image.called, 2),
        ]
        files, symbols = [path.name for path, _ in image.functions], [symbol for _, symbol in image.functions]
        for name, of in (("FILES", files), ("NAMES", symbols)):
            self.lines.append(f"static const char *const FUNCTION_{name}[] = {{{', '.join(map(c.text, of))}}};")
        self._add_inputs()
        self.lines += self.outputs.lines()

    def _add_counts(self, image: Image) -> None:
        """Add the sizes of the scene, and the names of what its method commands."""
        model, sim = self.model, self.sim
        held, first = model.held.get(INPUTS, slice(0, 0)), model.coordinate_count + model.free_count
        counts = {
            "IMAGE_BYTES": image.size,
            "SIZE": self.size,
            "WORKS": QUADRATURES,
            "COORDINATE_COUNT": model.coordinate_count,
            "SPEED_COUNT": model.free_count,
            "LOAD_COUNT": held.stop - held.start,
            "FIRST_HELD": first + held.start,
            "DRIVEN": self.driven,
            "PIECE_NUMBERS": Piece.number_count,
            "AT_TIME": AT_TIME,
            "KNOWS_TIME": int(self.driven > len(sim.courses)),
            "POINTER_COUNT": len(image.pointers),
            "CALLED_COUNT": len(image.called),
            "FUNCTION_COUNT": len(image.functions),
        }
        counts |= {name: Command[name].value for name in COMMANDS.split()}
        counts |= {"NO_INERTIA": NO_INERTIA, "STATE": VECTOR.state}
        counts |= {name: column(Step, name.lower()) for name in PLACES.split()}
        self.lines += [c.define(name, value) for name, value in counts.items()]
        self.lines += [
            f"#define SMALLEST_STEP {c.number(float(SMALLEST_STEP))}",
            f"#define LITTLE {c.number(LITTLE * sim.asked.every)}",
            "enum { CALL_FUNCTION, CALL_PLACES, CALL_NUMBERS, CALL_RESULT };",
        ]

    def _add_calls(self, image: Image) -> None:
        """Add the calls of kernels that the scene has, and which they are."""
        calls = {
            "INTEGRATE": self.run,
            "PASS_STEPS": self.passing,
            "MOVE": None if self.moved is None else self.moved[0],
            "EVALUATE": None if self.evaluated is None else self.evaluated.call,
            **self.force_calls,
        }
        for call, name in ((self.run, "MOST_STEPS"), (self.passing, "MOST_STEPS_OVER_EVENTS")):
            if call is not None:
                self.lines.append(c.define(name, call.signature.place_of("run", "most_steps")))
        self.lines += [c.integers(name, list(image.call(call))) for name, call in calls.items() if call is not None]
        if self.moved is not None:
            self.lines.append(c.define("ROW_NUMBERS", self.moved[-1].shape[2]))
        self.lines += [c.define(flag, int(calls.get(name) is not None)) for flag, name in FLAGS.items()]

    def _places(self) -> dict[str, np.ndarray]:
        """Return the arrays whose places are told, by the names of these."""
        stepper, scene = self.stepper, self.run.arguments[0]
        places = {
            "AT_INTEGERS": stepper.integers,
            "AT_REALS": stepper.reals,
            "AT_VECTORS": stepper.vectors,
            "AT_TIMES": self.times,
            "AT_STATES": self.states,
            "AT_INPUTS": self.inputs,
            "AT_MOTIONS": scene.motions.motions,
            "AT_PIECES": scene.motions.pieces,
            "AT_SPANS": scene.motions.spans,
            "AT_OUTPUT_DRIVES": scene.drives,
        }
        if self.watched is not None:
            places["AT_EVENT_COUNTS"] = self.watched.counts
        if self.moved is not None:
            _, drives, state, rates, found = self.moved
            places |= {"AT_MOTION_DRIVES": drives, "AT_MOTION_STATE": state, "AT_MOTION_FOUND": found}
            if self.evaluated is not None:
                places |= {"AT_MOTION_RATES": rates, "AT_EVALUATED": self.evaluated.vectors}
                places |= {"AT_EVALUATED_DRIVES": self.evaluated.drives, "AT_EVALUATED_INPUTS": self.evaluated.inputs}
        return places | self.forces

    def _kept(self) -> list[np.ndarray]:
        """Return the arrays that make up the state of the simulation."""
        stepper, watched = self.stepper, self.watched
        kept = [stepper.integers, stepper.reals, stepper.vectors, self.states]
        if self.sim.courses:
            kept.append(self.run.arguments[0].motions.pieces)
        if watched is not None:
            kept += [watched.values, watched.noise, watched.last, watched.actions, watched.regime, watched.usual]
        return kept

    def _add_inputs(self) -> None:
        sim, model = self.sim, self.model
        first = model.coordinate_count + model.free_count
        held = self.route.inputs.held
        self.lines += [
            c.define("HELD_COUNT", len(held)),
            c.integers("HELD_PLACES", [(place, first + state) for place, state, _ in held], 2),
            c.numbers("HELD_FACTORS", [factor for _, _, factor in held]),
            c.define("COURSE_COUNT", len(sim.courses)),
            c.integers("COURSES", [int(self.motions.motions[sim.drive_of(course), 0]) for course in sim.courses]),
            c.define("INPUT_COUNT", len(sim.input_names)),
            c.numbers("INPUT_STARTS", list(sim.inputs.values())),
        ]


def model_state(sim: Simulation) -> np.ndarray:
    """Return the state of a simulation, including internal states of loads."""
    return np.asarray(sim.state.state)


CLEARED = ("drives", "memory", "given", "found")
CLEARED_OF_EVENTS = ("records", "times", "samples", "brackets", "found", "drives", "inputs", "states")
"""Arguments of calls, and arrays of the events, that kernels write before they read them."""


def _clear(call: object) -> None:
    """Set to zero what a kernel writes before it reads it, so that the image is reproducible."""
    for name, value in zip(call.signature.names, call.arguments, strict=True):  # type: ignore[attr-defined]
        if name in CLEARED and isinstance(value, np.ndarray):
            value[...] = 0.0
