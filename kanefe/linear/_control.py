"""The door to python-control: a linearised scene as its StateSpace."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg

from kanefe.errors import MissingDependency, ModelError
from kanefe.frames import Matrix
from kanefe.linear.input_to_output import channels_of, residues, tell_of_losses
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
    tell_of_losses(linearisation, "a state space")
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


def modal_space(linearisation: StateSpace) -> Any:
    """Return a `control.StateSpace` whose states are those of the modes, each moved as much as it is seen.

    Raises
    ------
    ModelError
        If modes coincide.
    """
    found = residues(channels_of(linearisation))
    if found is None:
        raise ModelError("modes coincide, as those of rigid motions do. Remedy: to_control() without modal")
    blocks: list[Matrix] = []
    B: list[Matrix] = []
    C: list[Matrix] = []
    names: list[str] = []
    for value, b, c in zip(found.values, found.b, found.c.T, strict=True):
        scale = np.sqrt(np.linalg.norm(b) / np.linalg.norm(c))
        b, c, number = b / scale, c * scale, len(blocks) + 1
        if value.imag == 0.0:  # its eigenvector is real but for a sign
            blocks.append(np.array([[value.real]]))
            B, C, names = [*B, b.real], [*C, c.real], [*names, f"{number}: decay"]
        elif value.imag > 0.0:  # the conjugate is the same motion
            blocks.append(np.array([[value.real, value.imag], [-value.imag, value.real]]))
            B += [np.sqrt(2.0) * b.real, -np.sqrt(2.0) * b.imag]
            C += [np.sqrt(2.0) * c.real, np.sqrt(2.0) * c.imag]
            names += [f"{number}: {value.imag / (2.0 * np.pi):.6g} Hz {part}" for part in ("cos", "sin")]
    return control.ss(
        scipy.linalg.block_diag(*blocks),
        np.array(B),
        np.array(C).T,
        linearisation.D,
        states=_plain(tuple(names)),
        inputs=_plain(linearisation.input_names),
        outputs=_plain(linearisation.output_names),
        remove_useless_states=False,
    )
