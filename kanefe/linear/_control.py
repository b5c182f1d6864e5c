"""The door to python-control: a linearised scene as its StateSpace."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.errors import MissingDependency
from kanefe.frames import Matrix
from kanefe.linear.state_space import StateSpace

try:
    import control
except ImportError as _error:
    raise MissingDependency("control", "Linearisation.to_control", "pip install 'kanefe[control]'") from _error

Names = tuple[str, ...]


def sampled_space(change: Matrix, measured: Matrix, period: float, states: Names, outputs: Names) -> Any:
    """Return a discrete `control.StateSpace` with a period (s), without inputs, from its state and output matrices."""
    return control.ss(
        change,
        np.zeros((len(change), 1)),
        measured,
        np.zeros((len(measured), 1)),
        period,
        states=_plain(states),
        inputs=["none"],
        outputs=_plain(outputs),
        remove_useless_states=False,
    )


def _plain(names: Names) -> list[str]:
    """Return names without '.', which python-control reserves."""
    return [name.replace(".", "_") for name in names]


def state_space(linearisation: StateSpace) -> Any:
    """Return a `control.StateSpace` with names."""
    return control.ss(
        linearisation.A,
        linearisation.B,
        linearisation.C,
        linearisation.D,
        states=_plain(linearisation.state_names),
        inputs=_plain(linearisation.input_names),
        outputs=_plain(linearisation.output_names),
        remove_useless_states=False,
    )
