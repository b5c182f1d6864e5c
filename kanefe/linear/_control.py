"""The door to python-control: a linearised scene as its StateSpace."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.errors import MissingDependency
from kanefe.linear.sampled_loop import SampledLoop
from kanefe.linear.state_space import StateSpace

try:
    import control
except ImportError as _error:
    raise MissingDependency("control", "Linearisation.to_control", "pip install 'kanefe[control]'") from _error


def sampled_space(loop: SampledLoop) -> Any:
    """Return a `control.StateSpace` of a sampled loop in steps of its period, without inputs."""
    n, m = len(loop.change), len(loop.plant.output_names)
    return control.ss(
        loop.change,
        np.zeros((n, 1)),
        loop.measured,
        np.zeros((m, 1)),
        loop.period,
        states=_plain(loop.state_names),
        inputs=["none"],
        outputs=_plain(loop.plant.output_names),
        remove_useless_states=False,
    )


def _plain(names: tuple[str, ...]) -> list[str]:
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
