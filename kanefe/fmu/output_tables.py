"""Outputs of a simulation as tables in C: the place of each in the state, or a component of the motion of a frame."""

from __future__ import annotations

import numpy as np

from kanefe.bodies.flexible import InterfaceFrame
from kanefe.fmu import c_text as c
from kanefe.fmu.image import NeedsPython
from kanefe.loads.controller import Reading
from kanefe.order_n.sweeps import Sweeps
from kanefe.order_n.tables.frame_offsets import FrameOffset
from kanefe.stepping.simulation import Simulation

VECTORS = ("position", "rotation", "velocity", "angular_velocity", "acceleration", "angular_acceleration")
KINDS = ("IN_STATE", "DRIVE", "DEFLECTION", *(what.upper() for what in VECTORS))

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
    has_accelerations : bool

    Raises
    ------
    NeedsPython
        If an output needs Python.
    """

    def __init__(self, sim: Simulation, sweeps: Sweeps) -> None:
        self.sweeps, self._model = sweeps, sim.model
        self.frames: list[FrameOffset] = []
        self._numbers: dict[tuple[int, str], int] = {}
        self.has_accelerations = False
        self._rows = [self._row(output.name, output.reading) for output in sim.output_list]

    def lines(self) -> list[str]:
        """Return the lines of the tables."""
        found = ["enum { " + ", ".join(KINDS) + " };", TYPES.strip(), c.define("OUTPUT_COUNT", len(self._rows))]
        frames = [_frame(frame_offset) for frame_offset in self.frames]
        if frames:
            found.append(f"static const frame FRAMES[] = {{{', '.join(frames)}}};")
        rows = [f"{{{', '.join((*map(str, row[:-1]), c.number(row[-1])))}}}" for row in self._rows]
        found.append(f"static const output OUTPUTS[] = {{{', '.join(rows) or '{0}'}}};")
        return found

    def _row(self, name: str, reading: Reading | None) -> tuple[int, int, int, int, int, float]:
        if reading is None:
            raise NeedsPython(
                f"the output {name!r} is a force, which is computed in Python. "
                "Remedy: motions, joint or modal coordinates as outputs"
            )
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
