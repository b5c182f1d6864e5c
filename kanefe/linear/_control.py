"""The door to python-control: a linearised scene as its StateSpace."""

from __future__ import annotations

from typing import Any

from kanefe.errors import MissingDependency
from kanefe.linear.state_space import StateSpace

try:
    import control
except ImportError as _error:
    raise MissingDependency("control", "Linearisation.to_control", "pip install 'kanefe[control]'") from _error


def state_space(linearisation: StateSpace) -> Any:
    """Return a `control.StateSpace` with names; python-control keeps '.' for its own use, so that names have none."""

    def plain(names: tuple[str, ...]) -> list[str]:
        return [name.replace(".", "_") for name in names]

    lin = linearisation
    return control.ss(
        lin.A,
        lin.B,
        lin.C,
        lin.D,
        states=plain(lin.state_names),
        inputs=plain(lin.input_names),
        outputs=plain(lin.output_names),
        remove_useless_states=False,
    )
