"""Small motions about a state as matrices with names, for modes, responses and other packages."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.linear.imbalance import Imbalance
from kanefe.linear.losses import condensed
from kanefe.linear.modes.unresisted import Unresisted, unresisted
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.tangents import turning
from kanefe.linear.unsettled import imbalance_in_words, unsettled


@dataclass(frozen=True, eq=False)
class StateSpace:
    """Small motions x of a scene about a state, ``dx/dt = A x + B w``, ``y = C x + D w``.

    x are independent tangent coordinates p (displacements, angles, modal coordinates, rotation vectors in the moving
    frame), followed by independent speeds r, and states of the arms of viscoelastic bodies. Without rolling, and with
    arms that follow at once, this is equivalent to

        M d2p/dt2 + (damping + gyroscopic) dp/dt + stiffness p = B_2 w

    Attributes
    ----------
    model : Model
    time : float
        s.
    state : ndarray
        y = (q, u) of the model.
    A : ndarray, shape (x, x)
    B : ndarray, shape (x, inputs)
    C : ndarray, shape (outputs, x)
    D : ndarray, shape (outputs, inputs)
    state_names, input_names, output_names : tuple of str
        With units in brackets.
    output_values : ndarray
        The outputs at the state itself.
    small : SmallMotions
        The motions of the tree for x.
    structural : ndarray, shape (x, x), or None
        H of ``A + i H`` in harmonic motions; None: no body has structural damping.
    """

    model: Model
    time: float
    state: Vector
    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    output_values: Vector
    small: SmallMotions
    structural: Matrix | None = None

    def __str__(self) -> str:
        """Return time, number of states, inputs and outputs."""

        def listed(names: tuple[str, ...]) -> str:
            return ", ".join(names) if names else "none named"

        lines = [
            f"small motions about t = {self.time:g} s: {len(self.A)} states; A, B, C, D are arrays",
            f"  inputs   {listed(self.input_names)}",
            f"  outputs  {listed(self.output_names)}",
        ]
        return "\n".join(lines + imbalance_in_words(self.imbalance))

    @property
    def position_count(self) -> int:
        """Number of tangent coordinates p; behind them x has speeds, and states of viscoelastic arms."""
        return self.small.positions.N.shape[1]

    @property
    def moving_count(self) -> int:
        """Number of tangent coordinates and speeds; behind them x has states of viscoelastic arms."""
        return self.position_count + self.small.speeds.N.shape[1]

    @cached_property
    def _undriven(self) -> Matrix:
        """A without the states of driven coordinates."""
        return self._without_drives(self.A)

    def _without_drives(self, matrix: Matrix) -> Matrix:
        """Return a matrix over the states without those of driven coordinates."""
        p, moving, drives = self.position_count, self.moving_count, len(self.small.drives)
        kept = np.r_[: p - drives, p : moving - drives, moving : len(matrix)]
        return matrix[np.ix_(kept, kept)]

    @cached_property
    def _unresisted(self) -> Unresisted:
        """Motions of the undriven states without restoring force."""
        return unresisted(self.small, condensed(self._undriven, self.moving_count - 2 * len(self.small.drives)))

    @cached_property
    def imbalance(self) -> Imbalance:
        """The largest imbalance of the state; accelerations of free motions do not count.

        `Imbalance.ratio` is relative to the forces that act there; below 1e-9 it is round-off.
        """
        return unsettled(self.small, self._unresisted)

    @property
    def is_exact(self) -> bool:
        """Whether derivatives of the scene's own forces are exact to round-off, not by differences."""
        return self.small.derivatives.is_exact

    @property
    def position_names(self) -> tuple[str, ...]:
        """Names of the tangent coordinates p."""
        return self.state_names[: self.position_count]

    @cached_property
    def _second_order(self) -> tuple[Matrix, Matrix, Matrix]:
        """Return M, the factor of the rates, and that of the coordinates: see `kanefe.linear.small_motions`."""
        small = self.small
        if not small.is_holonomic:
            raise ModelError(
                "a scene that rolls has more coordinates than speeds and no mass, damping and stiffness matrices of "
                "its coordinates alone. Remedy: A, or modes()"
            )
        n, N, A = self.position_count, small.positions.N, condensed(self.A, self.moving_count)
        M = N.T @ small.mass @ N
        a11, a21, a22 = A[:n, :n], A[n:, :n], A[n:, n:]
        return M, -M @ (a11 + a22), -M @ (a21 - a22 @ a11 + self._turning_rate())

    def undamped(self) -> Self:
        """Return the same without dissipation and circulatory forces: inertia, gyroscopic terms, symmetric stiffness.

        Arms of viscoelastic bodies follow at once, which leaves the long-term stiffness. Left out are the symmetric
        part of the factor of the rates and the skew part of that of the coordinates, such as
        the cross-coupled stiffness of bearings and of rotating damping in a fixed frame.

        Raises
        ------
        ModelError
            If the scene rolls, for which these matrices do not exist.
        """
        n, moving = self.position_count, self.moving_count
        A = condensed(self.A, moving).copy()
        M, K = self.mass, self.stiffness
        a11 = A[:n, :n]
        A[n:, n:] = -a11 - np.linalg.solve(M, self.gyroscopic)
        A[n:, :n] = A[n:, n:] @ a11 - self._turning_rate() - np.linalg.solve(M, 0.5 * (K + K.T))
        names = self.state_names[:moving]
        return replace(self, A=A, B=self.B[:moving], C=self.C[:, :moving], state_names=names, structural=None)

    def _turning_rate(self) -> Matrix:
        """Return the rate of change of A's upper left block along the motion."""
        small = self.small
        if not small.is_moving:
            return np.zeros((self.position_count, self.position_count))
        lead, N = small.positions.leading, small.positions.N
        G_rate = np.zeros_like(small.G)
        G_rate[: len(small.du), : len(small.du)] = turning(self.model, small.du)
        # J dN/dt = -dJ/dt N with dJ/dt = D - J G: the following entries change by B and by G
        N_rate = small.along_positions.du + small.G @ N
        N_rate = N_rate - N @ N_rate[lead]
        return np.asarray((G_rate @ N + small.G @ N_rate)[lead])

    @property
    def mass(self) -> Matrix:
        """M over the independent coordinates, symmetric."""
        return self._second_order[0]

    @property
    def damping(self) -> Matrix:
        """Symmetric part of the factor of the rates."""
        factor = self._second_order[1]
        return np.asarray(0.5 * (factor + factor.T))

    @property
    def gyroscopic(self) -> Matrix:
        """Skew part of the factor of the rates: Coriolis and gyroscopic terms."""
        factor = self._second_order[1]
        return np.asarray(0.5 * (factor - factor.T))

    @property
    def stiffness(self) -> Matrix:
        """Factor of the coordinates: elastic, geometric, gravity, centrifugal; symmetric without circulatory forces."""
        return self._second_order[2]
