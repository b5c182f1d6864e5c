"""Outputs of a simulation as tables in C: the place of each in the state, in the motion of a frame, among forces."""

from __future__ import annotations

import numpy as np

from kanefe.bodies.flexible import InterfaceFrame
from kanefe.fmu import c_text as c
from kanefe.fmu.image import NeedsPython
from kanefe.kernels.contact.output_places import POINT_OUTPUTS
from kanefe.loads.controller import Reading
from kanefe.order_n.load_outputs import LoadOutputs
from kanefe.order_n.route import OrderN
from kanefe.order_n.sweeps import Sweeps
from kanefe.order_n.tables.frame_offsets import FrameOffset
from kanefe.results.channels import output_function
from kanefe.results.contact_points import in_columns
from kanefe.stepping.outputs import Output
from kanefe.stepping.simulation import Simulation
from kanefe.tree.run_sweeps import OutputFunction

VECTORS = ("position", "rotation", "velocity", "angular_velocity", "acceleration", "angular_acceleration")
KINDS = ("IN_STATE", "DRIVE", "DEFLECTION", "IN_FORCES", "IN_LOADS", *(what.upper() for what in VECTORS))

TYPES = """
typedef struct { int row; double axes[9], place[3]; } frame;
typedef struct { int what, place, component, is_own, other; double offset; } output;
"""


class OutputTables:
    """The outputs of a simulation.

    Parameters
    ----------
    sim : Simulation
    sweeps : Sweeps
        Of the route of the simulation.

    Attributes
    ----------
    frames : list of FrameOffset
        Frames whose motion is needed.
    has_accelerations, has_forces : bool
    told : LoadOutputs or None
        What tells the outputs of loads that are asked for.

    Raises
    ------
    NeedsPython
        If an output needs Python.
    """

    def __init__(self, sim: Simulation, sweeps: Sweeps) -> None:
        self.sweeps, self._model = sweeps, sim.model
        self.frames: list[FrameOffset] = []
        self._numbers: dict[tuple[int, str], int] = {}
        self.has_accelerations = self.has_forces = False
        self._route: OrderN = sim.model.route  # type: ignore[assignment]  # of a scene without Python
        self.told = self._load_outputs(sim)
        self._rows = [
            self._force(output) if output.reading is None else self._row(output.reading) for output in sim.output_list
        ]

    def lines(self) -> list[str]:
        """Return the lines of the tables."""
        found = ["enum { " + ", ".join(KINDS) + " };", TYPES.strip(), c.define("OUTPUT_COUNT", len(self._rows))]
        frames = [_frame(frame_offset) for frame_offset in self.frames]
        if frames:
            found.append(f"static const frame FRAMES[] = {{{', '.join(frames)}}};")
        rows = [f"{{{', '.join((*map(str, row[:-1]), c.number(row[-1])))}}}" for row in self._rows]
        found.append(f"static const output OUTPUTS[] = {{{', '.join(rows) or '{0}'}}};")
        return found

    def _load_outputs(self, sim: Simulation) -> LoadOutputs | None:
        """Return what tells all outputs of loads that are asked for."""
        functions: dict[int, tuple[OutputFunction, int]] = {}
        for output in sim.output_list:
            what, of, _, _ = output.channel or ("", "", "", 0)
            if what in ("load", "contact_points"):
                number = next(i for i, load in enumerate(self._model.loads) if load.name == of)
                if number in self._model.rigid_contacts:  # told with all forces
                    continue
                found = output_function(self._model.loads[number], what)
                if found is None:
                    raise NeedsPython(
                        f"the output {output.name!r} of a {self._model.loads[number].kind} is computed in Python. "
                        "Remedy: motions, reactions, or outputs of contacts"
                    )
                if functions.setdefault(number, found) != found:
                    raise NeedsPython(f"both 'load' and 'contact_points' of {of!r} are outputs. Remedy: one of them")
        return LoadOutputs(self._route, functions) if functions else None

    def _force(self, output: Output) -> tuple[int, int, int, int, int, float]:
        """Return where a force is: the first place, and how many wrenches one after the other are added up."""
        model, (what, of, interface, i) = self._model, output.channel or ("", "", "", 0)
        if what in ("load", "contact_points"):
            number = next(n for n, load in enumerate(model.loads) if load.name == of)
            if what == "contact_points":
                points = len(model.loads[number].probes)  # type: ignore[attr-defined]
                i = int(in_columns(np.arange(points * POINT_OUTPUTS).reshape(1, points, POINT_OUTPUTS))[0, i])
            if self.told is not None and number in self.told.columns:
                return KINDS.index("IN_LOADS"), self.told.columns[number].start + i, 0, 0, 0, 0.0
        self.has_forces = True
        told = self._route.force_kernel.told
        first, count = told.place(what, of, interface, i)
        numbers = told.numbers_of_parts(of, interface)
        if any(number in told.by_reaction for number in numbers):
            raise NeedsPython(
                f"the output {output.name!r} is at the root of an exact beam, which is computed in Python. Remedy: "
                f"'joint_reaction {of}'"
            )
        if any(number in told.undetermined for number in numbers):
            raise NeedsPython(
                f"the output {output.name!r} is of interfaces that share forces in several ways, which is computed in "
                "Python. Remedy: reactions, or interfaces with fewer fixed components"
            )
        return KINDS.index("IN_FORCES"), first, 0, 0, count, 0.0

    def _row(self, reading: Reading) -> tuple[int, int, int, int, int, float]:
        model, i = self._model, reading.component
        number = model.index(reading.body)
        body, n = model.bodies[number], model.coordinate_count
        if reading.what == "joint_coordinates":
            at = int(body.coordinates[i])
            return self._in_state(at) if at >= 0 else self._of_drive(int(body.speeds[i]), 0)
        if reading.what == "joint_speeds":
            speed = int(body.speeds[i])
            return self._in_state(n + speed) if speed < model.free_count else self._of_drive(speed, 1)
        if reading.what == "modal_coordinates":
            return self._in_state(model.flexible_terms(reading.body).eta.start + i)
        if reading.what == "modal_speeds":
            return self._in_state(n + model.flexible_terms(reading.body).speeds.start + i)
        frame = model.flexible_terms(reading.body).body.interface(reading.interface) if reading.interface else None
        place = self._frame(number, frame)
        if reading.what == "deflection" and frame is not None:
            return KINDS.index("DEFLECTION"), place, i, 0, self._frame(number, None), float(frame.position[i])
        self.has_accelerations |= "acceleration" in reading.what
        return KINDS.index(reading.what.upper()), place, i, int(reading.is_own), 0, 0.0

    def _in_state(self, at: int) -> tuple[int, int, int, int, int, float]:
        return KINDS.index("IN_STATE"), at, 0, 0, 0, 0.0

    def _of_drive(self, speed: int, rate: int) -> tuple[int, int, int, int, int, float]:
        return KINDS.index("DRIVE"), 3 * (speed - self._model.free_count) + rate, 0, 0, 0, 0.0

    def _frame(self, number: int, frame: InterfaceFrame | None) -> int:
        key = number, "" if frame is None else frame.name
        if key not in self._numbers:
            self._numbers[key] = len(self.frames)
            self.frames.append(self.sweeps.frame_offset(number, frame))
        return self._numbers[key]


def _frame(frame_offset: FrameOffset) -> str:
    axes, place = (", ".join(map(c.number, np.ravel(x).tolist())) for x in (frame_offset.axes, frame_offset.place))
    return f"{{{frame_offset.row}, {{{axes}}}, {{{place}}}}}"
