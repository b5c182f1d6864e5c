"""What records channels while a run goes on."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import reduce
from pathlib import Path

import numpy as np

from kanefe._version import __version__
from kanefe.equations.model import Model
from kanefe.errors import FileError, ModelError, SimulationWarning, did_you_mean, outside
from kanefe.frames import Vector
from kanefe.integrate.options import RunOptions
from kanefe.integrate.state_rows import merged, rows_at
from kanefe.integrate.status import RunStatus
from kanefe.integrate.trajectory import Trajectory, wanted_times
from kanefe.records.record import Record, records_of
from kanefe.records.record_file import FORMAT, VERSION
from kanefe.records.table import Columns, Table
from kanefe.results.channels import RunChannels
from kanefe.results.reader import Reader
from kanefe.results.recorded import Recorded
from kanefe.results.tables import Channel, channels_of
from kanefe.storage.growing_file import GrowingFile, Layout
from kanefe.tree.model_data import QUADRATURES

EVENTS_AT_ONCE = 256
"""Number of states at events that are evaluated together."""


def recorder_of(model: Model, options: RunOptions, asked: object, path: str | Path | None) -> Recorder:
    """Return the recorder of the arguments ``record=`` and ``record_file=`` of a run.

    Raises
    ------
    ModelError
        If they are not valid, there is no such channel, two columns have the same name, or checkpoints are wanted too.
    """
    records = records_of(asked)
    if not records:
        raise ModelError("record_file was given, and nothing to record. Remedy: record=['position arm x', ...]")
    if options.checkpoint is not None or options.resume is not None:
        raise ModelError(
            "record and checkpoint (or resume) were both given: what was recorded is not in a checkpoint. Remedy: "
            "one of the two, or a run in parts, each with start= the end of the one before"
        )
    return Recorder(model, options.span, options.times, records, path)


class Recorder:
    """Records channels of a run.

    Parameters
    ----------
    model : Model
    span : (float, float)
        s.
    outputs : ndarray
        Output times of the run, s.
    records : sequence of Record
    path : path, optional
        File that is written as the run goes on.

    Raises
    ------
    ModelError
        If there is no such channel, or two columns have the same name.
    """

    def __init__(
        self,
        model: Model,
        span: tuple[float, float],
        outputs: np.ndarray,
        records: Sequence[Record],
        path: str | Path | None,
    ) -> None:
        self._model, self._records, self._path = model, tuple(records), path
        start = np.concatenate((model.initial_state, np.zeros(QUADRATURES)))[None]
        first = self._reader(np.array([span[0]]), start, None)
        self._columns = [_columns_of(channels_of(first, record.channels), record) for record in records]
        counts = Counter(name for columns in self._columns for name in columns.names)
        twice = [name for name, count in counts.items() if count > 1]
        if twice:
            raise ModelError(
                f"{twice[0]!r} is recorded twice. Remedy: once, or a name of its own: "
                f"Record({{'another name': {twice[0]!r}}})"
            )
        self._own = [
            np.zeros(0) if record.events else outputs if record.step is None else wanted_times(*span, record.step)
            for record in records
        ]
        self.times = reduce(merged, sorted(self._own, key=len, reverse=True))
        self.events = tuple(dict.fromkeys(name for record in records for name in record.events))
        self._at_events: list[list[tuple[float, Vector]]] = [[] for _ in records]
        self._turned: dict[tuple[int, str], Vector] = {}
        self._is_full = False
        self._tables: list[Table] = []
        self._file: GrowingFile | None = None

    def begin(self, events: Sequence[str]) -> None:
        """Begin, with the names of all events of the run.

        Raises
        ------
        ModelError
            If there is no event of a name.
        FileError
            If the file cannot be written.
        """
        for name in self.events:
            if name not in events:
                did = did_you_mean(name, events)
                raise ModelError(
                    f"record at {name!r}: there is no such event. {did}Remedy: one of {', '.join(events) or 'none'}"
                )
        if self._path is not None:
            header = {
                "format": FORMAT,
                "version": str(VERSION),
                "kanefe": __version__,
                "tables": [columns._asdict() for columns in self._columns],
            }
            layouts = [Layout(len(columns.names), not columns.is_extremes) for columns in self._columns]
            self._file = GrowingFile(self._path, header, layouts)
        self._tables = [Table(columns, self._file, i) for i, columns in enumerate(self._columns)]

    def take(self, times: np.ndarray, states: np.ndarray, accelerations: np.ndarray | None) -> None:
        """Take states (T, state) at some times, each time once, and accelerations (T, free) where they are kept."""
        for i, own in enumerate(self._own):
            wanted = rows_at(times, own)
            if len(times[wanted]):
                rates = None if accelerations is None else accelerations[wanted]
                self._add(i, times[wanted], states[wanted], rates)

    def happened(self, name: str, t: float, y: Vector) -> None:
        """Take the state before an event at time t, s."""
        for i, record in enumerate(self._records):
            if name in record.events:
                self._at_events[i].append((t, y))
                if len(self._at_events[i]) >= EVENTS_AT_ONCE:
                    self._add_events(i)

    def leave(self) -> None:
        """Close the file without a status: the run was not begun, or an error ended it."""
        if self._file is not None:
            self._file.leave()

    def end(self, status: RunStatus) -> Mapping[str, Recorded]:
        """End, and return what was recorded, by column."""
        for i in range(len(self._records)):
            self._add_events(i)
        if self._file is not None:
            try:
                self._file.close({"status": asdict(status)})
            except FileError as error:
                if not self._is_full:
                    warnings.warn(str(error), SimulationWarning, stacklevel=outside())
        return {name: column for table in self._tables for name, column in table.recorded().items()}

    def _add_events(self, number: int) -> None:
        taken, self._at_events[number] = self._at_events[number], []
        if taken:
            self._add(number, np.array([t for t, _ in taken]), np.array([y for _, y in taken]), None)

    def _add(self, number: int, times: np.ndarray, states: np.ndarray, accelerations: np.ndarray | None) -> None:
        """Add the channels of a record at some states."""
        if self._is_full:
            return
        reader = self._reader(times, states, accelerations)
        channels = channels_of(reader, self._records[number].channels)
        values = np.hstack([self._as_before(number, reader, channel) for channel in channels])
        try:
            self._tables[number].add(times, values)
        except FileError as error:
            self._give_up(error)

    def _as_before(self, number: int, reader: Reader, channel: Channel) -> np.ndarray:
        """Return the values of a channel; Euler parameters without a jump of sign from the block before."""
        quantity, body, interface = channel.place
        if quantity != "rotation":
            return channel.values
        e = reader.read(quantity, body, interface or None)
        key = number, channel.name
        sign = -1.0 if key in self._turned and float(self._turned[key] @ e[0]) < 0.0 else 1.0
        self._turned[key] = sign * e[-1]
        return sign * channel.values

    def _give_up(self, error: FileError) -> None:
        """Record nothing more, and say so: the run goes on."""
        self._is_full = True
        warnings.warn(f"{error}. The run goes on; what was recorded ends here", SimulationWarning, stacklevel=outside())

    def _reader(self, times: np.ndarray, states: np.ndarray, accelerations: np.ndarray | None) -> Reader:
        run = Trajectory.of_states(self._model, times, states, statistics={}, accelerations=accelerations)
        return Reader(RunChannels(self._model, run))


def _columns_of(channels: Sequence[Channel], record: Record) -> Columns:
    names = tuple(name for channel in channels for name in channel.columns)
    units = tuple(unit for channel in channels for unit in channel.units)
    return Columns(names, units, record.keep == "extremes")
