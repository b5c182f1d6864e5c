"""Sampled controllers as tables for compiled code: see `kanefe.kernels.steppers.sampling`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.integrate.run_checks.drive_growth import EARLY
from kanefe.kernels.steppers.sampling import VALUES, Samples
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
    rows, times, terms, sizes = list[tuple[int, ...]](), list[tuple[float, ...]](), list[list[tuple[int, float]]](), []
    first_state = model.coordinate_count + model.free_count
    late = memory = changes = 0
    for one in sampled:
        own = [terms_of(model, reading) for reading in one.reads]
        function = one.function if isinstance(one.function, CompiledByNumba) else None
        is_plain = all(found is not None for found in own)
        address = 0
        if function is not None and is_plain:
            address = function.address(len(own), one.drive_count, one.label)
        room = 1 if one.delay == 0.0 else math.ceil(one.delay / one.every) + 2
        first_drive = first_state + model.held[one.name].start
        row = len(terms), len(own) if is_plain else 0, first_drive, one.drive_count, memory, address
        rows.append((*row, 0, late, room, 0, -1, changes))
        times.append((start, one.every, one.delay, EARLY))
        terms += [found or [] for found in own]
        sizes.append(0 if function is None else function.memory)
        late, memory, changes = late + room, memory + sizes[-1], changes + one.drive_count
    most_reads = max((len(one.reads) for one in sampled), default=0)
    most_drives = max((one.drive_count for one in sampled), default=0)
    flat, held = [term for own in terms for term in own], getattr(getattr(model.route, "inputs", None), "held", ())
    samples = Samples(
        controllers=np.array(rows, dtype=np.int64).reshape(-1, 12),
        times=np.array(times).reshape(-1, 4),
        progress=np.array((-1, 0, 0, 0, 0), dtype=np.int64),
        limits=np.array((stop, together)),
        read_at=np.cumsum([0, *map(len, terms)]),
        read_of=np.array([place for place, _ in flat], dtype=np.int64),
        read_by=np.array([factor for _, factor in flat], dtype=float),
        memory=np.zeros(memory),
        late=np.zeros((late, 1 + most_drives)),
        changes=np.zeros((changes, 2)),
        log=np.zeros((LOG_ROWS + len(sampled), VALUES + most_reads + most_drives)),
        drives_at=VALUES + most_reads,
        acted=np.zeros((LOG_ROWS, 1 + model.state_count)),
        first_state=first_state,
        held=np.array([(place, first_state + state) for place, state, _ in held], dtype=np.int64).reshape(-1, 2),
        factors=np.array([factor for _, _, factor in held], dtype=float),
    )
    ends = np.cumsum([0, *sizes])
    memories = [
        samples.memory[ends[i] : ends[i + 1]] if isinstance(one.function, CompiledByNumba) else None
        for i, one in enumerate(sampled)
    ]
    return samples, memories
