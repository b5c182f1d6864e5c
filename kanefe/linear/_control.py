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
    """Return a `control.StateSpace` in steps of a period (s), without inputs: change of its states, and its outputs."""
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
    """Return names without '.', which python-control keeps for its own use."""
    return [name.replace(".", "_") for name in names]


def state_space(linearisation: StateSpace) -> Any:
    """Return a `control.StateSpace` with names."""
    lin = linearisation
    return control.ss(
        lin.A,
        lin.B,
        lin.C,
        lin.D,
        states=_plain(lin.state_names),
        inputs=_plain(lin.input_names),
        outputs=_plain(lin.output_names),
        remove_useless_states=False,
    )
