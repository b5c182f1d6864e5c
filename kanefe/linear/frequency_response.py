"""Frequency response of a linearised scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.linear.state_space import StateSpace

if TYPE_CHECKING:
    from kanefe.views.plots import Figure


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Complex amplitudes ``H(f) = C (2 pi i f - A)^-1 B + D`` of the outputs for inputs of unit amplitude.

    Bodies with structural damping have the stiffness ``K + i H``, which is in A then.

    Attributes
    ----------
    frequencies : ndarray, shape (F,)
        Hz.
    response : ndarray of complex, shape (F, outputs, inputs)
        Unit of the output per unit of the input.
    output_names, input_names : tuple of str
    """

    frequencies: np.ndarray
    response: np.ndarray
    output_names: tuple[str, ...]
    input_names: tuple[str, ...]

    @property
    def magnitude(self) -> np.ndarray:
        """Amplitudes, shape (F, outputs, inputs)."""
        return np.asarray(np.abs(self.response))

    @property
    def phase(self) -> np.ndarray:
        """Phases in rad, without jumps over the frequencies, shape (F, outputs, inputs)."""
        return np.asarray(np.unwrap(np.angle(self.response), axis=0))

    @checked
    def receptance(self, output: str, input: str) -> np.ndarray:
        """Return the response of one output to one input, complex, shape (F,), such as of a position per unit of force.

        Parameters
        ----------
        output, input : str
            One of `output_names` and of `input_names`, with or without the unit.

        Raises
        ------
        ModelError
            If there is no such name, or more than one; the message lists the names.
        """
        return self._column(output, input, "output")

    @checked
    def transmissibility(self, output: str, over: str, input: str | None = None) -> np.ndarray:
        """Return the ratio of two outputs when one input oscillates, complex, shape (F,).

        Parameters
        ----------
        output, over : str
            Two of `output_names`, with or without the unit.
        input : str, optional
            One of `input_names`; not needed if there is only one.

        Raises
        ------
        ModelError
            If there is no such name (the message lists them), or there are several inputs and none is named.
        """
        if input is None and len(self.input_names) > 1:
            raise ModelError(
                f"a transmissibility needs the input that oscillates. Remedy: input=, one of {self.input_names}"
            )
        given = self.input_names[0] if input is None else input
        return self._column(output, given, "output") / self._column(over, given, "over")

    def _column(self, output: str, input: str, what: str) -> np.ndarray:
        row, column = place_of(self.output_names, output, what), place_of(self.input_names, input, "input")
        return np.asarray(self.response[:, row, column])

    @checked
    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw magnitudes and phases over the frequency, and write the picture to `path` if given.

        Raises
        ------
        ModelError, MissingDependency
            If the kind of file is unknown, or matplotlib is not installed.
        """
        from kanefe.views.linear_plots import ResponseCurves, frequency_response_picture

        names = self.output_names, self.input_names
        return frequency_response_picture(ResponseCurves(self.frequencies, self.magnitude, self.phase, *names), path)


def checked_frequencies(linearisation: StateSpace, frequencies: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return frequencies (Hz) for the response of a linearised scene with inputs and outputs, checked.

    Raises
    ------
    ModelError
        If they are not valid, or there are no inputs or outputs.
    """
    at = np.atleast_1d(numbers(frequencies))
    if at.ndim != 1 or not len(at) or not np.all(np.isfinite(at)) or np.any(at < 0.0):
        raise ModelError(f"frequencies must be finite and not negative, in Hz, not {frequencies!r}")
    for what, count in (("inputs", linearisation.B.shape[1]), ("outputs", len(linearisation.C))):
        if not count:
            raise ModelError(
                f"the linearisation has no {what}, and so no frequency response. Remedy: linearise(..., "
                f"{what}=[{'force body x' if what == 'inputs' else 'position body x'!r}])"
            )
    return at


def frequency_response(linearisation: StateSpace, frequencies: Sequence[float] | np.ndarray) -> FrequencyResponse:
    """Return the frequency response of a linearised scene: see `Linearisation.frequency_response`."""
    at = checked_frequencies(linearisation, frequencies)
    A, B, C, D = linearisation.A, linearisation.B, linearisation.C, linearisation.D
    A = A if linearisation.structural is None else A + 1j * linearisation.structural
    response = np.empty((len(at), len(C), B.shape[1]), dtype=complex)
    for i, f in enumerate(at):
        try:
            response[i] = C @ np.linalg.solve(2j * np.pi * f * np.eye(len(A)) - A, B) + D
        except np.linalg.LinAlgError:
            raise ModelError(
                f"the response at {f:.6g} Hz is infinite: an undamped or rigid motion has that frequency. Remedy: "
                "leave it out, or damp the scene"
            ) from None
    return FrequencyResponse(at, response, linearisation.output_names, linearisation.input_names)


def place_of(names: tuple[str, ...], name: str, what: str) -> int:
    """Return the number of a channel by its name, with or without the unit."""
    found = [i for i, one in enumerate(names) if name in (one, one.partition(" [")[0])]
    if len(found) != 1:
        raise ModelError(f"{what}: there is no channel {name!r} in this response. There are: {', '.join(names)}")
    return found[0]
