"""The figures that have goals, in groups that are measured together."""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.goals import Figure, Goal
from benchmarks.work_precision.contact_costs import (
    AWAY_GOAL,
    BALLS_GOAL,
    MESH_GOAL,
    TOUCHING_GOAL,
    balls,
    meshes,
    patches,
)
from benchmarks.work_precision.contacts import (
    BOUNCING_GOALS,
    DROPPED_GOALS,
    ENERGY_GOALS,
    ONSET_GOAL,
    RATE_GOAL,
    ROLLING_GOALS,
    STICKING_GOAL,
    bouncing,
    dropped,
    energy,
    onset,
    rolling,
    sticking,
)
from benchmarks.work_precision.deck import CALL_GOAL, EXACT_GOAL, deck_calls
from benchmarks.work_precision.equal_error import AUTO_GOALS, CHAIN_GOALS, HINGED_GOALS, automatic, chains, hinged_bars
from benchmarks.work_precision.long_runs import (
    FLIGHT_GOAL,
    SPIN_UP_GOAL,
    SUITE_GOAL,
    TUMBLING_GOAL,
    free_flight,
    spin_up,
    suite_time,
    tumbling,
)
from benchmarks.work_precision.machine import Machine
from benchmarks.work_precision.ship import PASSAGE_GOAL, passage

GROUPS: dict[Callable[[Machine], list[Figure]], list[Goal]] = {
    hinged_bars: list(HINGED_GOALS.values()),
    chains: list(CHAIN_GOALS.values()),
    spin_up: [SPIN_UP_GOAL],
    tumbling: [TUMBLING_GOAL],
    free_flight: [FLIGHT_GOAL],
    dropped: list(DROPPED_GOALS.values()),
    bouncing: list(BOUNCING_GOALS.values()),
    rolling: list(ROLLING_GOALS.values()),
    sticking: [STICKING_GOAL],
    onset: [ONSET_GOAL, RATE_GOAL],
    energy: list(ENERGY_GOALS.values()),
    deck_calls: [CALL_GOAL, EXACT_GOAL],
    passage: [PASSAGE_GOAL],
    patches: [TOUCHING_GOAL, AWAY_GOAL],
    balls: [BALLS_GOAL],
    meshes: [MESH_GOAL],
    automatic: list(AUTO_GOALS.values()),
    suite_time: [SUITE_GOAL],
}
"""Goals by the function that measures them; all are missed if it cannot be measured."""
