"""Sampled controllers as tables for compiled code: see `kanefe.kernels.steppers.sampling`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.integrate.run_checks.drive_growth import EARLY
from kanefe.kernels.steppers.sampling import VALUES, Progress, Sampled, Samples, controllers_of, progress_of
from kanefe.loads.offered_function import CompiledByNumba
from kanefe.tree.reading_terms import terms_of

if TYPE_CHECKING:
    from kanefe.loads.controller import Controller

LOG_ROWS = 256
"""Number of samples after which compiled code has its log emptied."""


def sample_tables(
    model: Model, sampled: Sequence[Controller], start: float, stop: float, together: float
) -> tuple[Samples, list[np.ndarray | None]]:
    """Return the tables of controllers for a run, and the memory of each whose function is compiled."""
    terms = [terms_of(model, reading) or [] for one in sampled for reading in one.reads]
    flat, held = [term for own in terms for term in own], getattr(getattr(model.route, "inputs", None), "held", ())
    most_reads = max((len(one.reads) for one in sampled), default=0)
    most_drives = max((one.drive_count for one in sampled), default=0)
    rooms = [1 if one.delay == 0.0 else math.ceil(one.delay / one.every) + 2 for one in sampled]
    functions = [one.function if isinstance(one.function, CompiledByNumba) else None for one in sampled]
    sizes = [0 if function is None else function.memory for function in functions]
    first_state = model.coordinate_count + model.free_count
    samples = Samples(
        controllers=np.zeros((len(sampled), Sampled.integer_count), dtype=np.int64),
        times=np.zeros((len(sampled), Sampled.number_count)),
        progress=np.zeros(Progress.integer_count, dtype=np.int64),
        limits=np.zeros(Progress.number_count),
        read_at=np.cumsum([0, *map(len, terms)]),
        read_of=np.array([place for place, _ in flat], dtype=np.int64),
        read_by=np.array([factor for _, factor in flat], dtype=float),
        memory=np.zeros(sum(sizes)),
        late=np.zeros((sum(rooms), 1 + most_drives)),
        changes=np.zeros((sum(one.drive_count for one in sampled), 2)),
        log=np.zeros((LOG_ROWS + len(sampled), VALUES + most_reads + most_drives)),
        drives_at=VALUES + most_reads,
        acted=np.zeros((LOG_ROWS, 1 + model.state_count)),
        first_state=first_state,
        held=np.array([(place, first_state + state) for place, state, _ in held], dtype=np.int64).reshape(-1, 2),
        factors=np.array([factor for _, _, factor in held], dtype=float),
    )
    progress = progress_of(samples)
    progress.asked, progress.end, progress.together = -1, stop, together
    ends = np.cumsum([0, *sizes])
    _put_controllers(model, samples, sampled, start, rooms, ends)
    memories = [samples.memory[ends[i] : ends[i + 1]] if function else None for i, function in enumerate(functions)]
    return samples, memories


def _put_controllers(
    model: Model, samples: Samples, sampled: Sequence[Controller], start: float, rooms: list[int], ends: np.ndarray
) -> None:
    """Write what is given of each controller."""
    reads = changes = late = 0
    for own, one, room, end in zip(controllers_of(samples), sampled, rooms, ends.tolist(), strict=False):
        is_plain = all(terms_of(model, reading) is not None for reading in one.reads)
        if isinstance(one.function, CompiledByNumba) and is_plain:
            own.address = one.function.address(len(one.reads), one.drive_count, one.label)
        own.first_read, own.reads = reads, len(one.reads) if is_plain else 0
        own.first_drive, own.drives = samples.first_state + model.held[one.name].start, one.drive_count
        own.first_memory, own.first_late, own.late_room, own.first_change, own.row = end, late, room, changes, -1
        own.start, own.every, own.delay, own.level = start, one.every, one.delay, EARLY
        reads, changes, late = reads + len(one.reads), changes + one.drive_count, late + room
