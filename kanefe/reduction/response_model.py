"""Accuracy of the response of a basis to harmonic loads, measured against a richer basis of the same body.

Responses are compared at complex frequencies ``s = sigma + i w`` with w from zero to the highest frequency of the loads
and sigma a fifth of it, and in statics. On the imaginary axis itself undamped resonances have no finite relative error;
at s the loads grow over a few periods, and a relative error d of a natural frequency gives an error of about 5 d.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg

from kanefe.fe_model.statics import StaticProblem
from kanefe.reduction.load_cases import LoadGroup

SWELL = 0.2
"""Value of sigma relative to the highest angular frequency."""

SAMPLES = 9
"""Number of frequencies from zero to the highest one at which responses are compared."""

FLOOR = 0.1
"""Fraction of the body's motion below which the motion of an interface is not used as the reference of an error."""

SAFETY = 2.0
"""Factor on the estimate: a sudden load moves truncated modes twice as far as a slow one, and the rich basis also has
an error."""


@dataclass(frozen=True, eq=False)
class Output:
    """A motion that is compared: the norm of q linear combinations of the coordinates.

    Attributes
    ----------
    name : str
    rows : ndarray, shape (q, p)
        Coefficients of the coordinates of the rich basis.
    extent : float
        For a rotation, one over the size of the body, 1/m; otherwise 1.
    """

    name: str
    rows: np.ndarray
    extent: float


@dataclass(frozen=True, eq=False)
class ResponseModel:
    """A body in p M-orthonormal coordinates that are rich enough to be the reference of others.

    Attributes
    ----------
    stiffness : ndarray, shape (p, p)
    groups : sequence of LoadGroup
    forces : ndarray, shape (p, m)
        Forces of all groups, side by side.
    outputs : tuple of Output
    mass : float
        kg; the M-norm of a motion over its root is the root mean square of the displacement.
    up_to_frequency : float
        Hz.
    """

    stiffness: np.ndarray
    groups: Sequence[LoadGroup]
    forces: np.ndarray
    outputs: tuple[Output, ...]
    mass: float
    up_to_frequency: float

    @classmethod
    def of_basis(
        cls, problem: StaticProblem, basis: np.ndarray, groups: Sequence[LoadGroup], up_to_frequency: float
    ) -> ResponseModel:
        """Return the model of M-orthonormal columns, shape (tied, p)."""
        K = basis.T @ (problem.stiffness @ basis)
        size = float(np.linalg.norm(np.ptp(problem.model.nodes, axis=0))) or 1.0
        outputs = []
        for tie in problem.ties.ties:
            turning = np.array([c >= 3 for c in tie.components], dtype=bool)
            moving = np.isin(tie.rows, problem.released)
            for name, chosen, extent in (("translation", moving & ~turning, 1.0), ("rotation", moving & turning, size)):
                if np.any(chosen):
                    outputs.append(Output(f"{tie.name} {name}", basis[tie.rows[chosen]], 1.0 / extent))
        R = problem.model.rigid_modes()[:, :3]
        return cls(
            stiffness=0.5 * (K + K.T),
            groups=groups,
            forces=basis.T @ np.hstack([group.forces for group in groups]),
            outputs=tuple(outputs),
            mass=float(np.einsum("ij,ij->j", R, problem.model.mass @ R).max()),
            up_to_frequency=up_to_frequency,
        )

    @cached_property
    def points(self) -> np.ndarray:
        """Complex frequencies s in rad/s, the static one first."""
        top = 2 * np.pi * self.up_to_frequency
        return np.concatenate(([0.0], SWELL * top + 1j * np.linspace(0.0, top, SAMPLES)))

    @cached_property
    def responses(self) -> np.ndarray:
        """Coordinates under every load at every s, shape (points, p, m)."""
        return _responses(self.stiffness, self.forces, self.points)

    def slices(self) -> list[slice]:
        """Return the columns of `forces` of each group."""
        ends = np.cumsum([group.forces.shape[1] for group in self.groups])
        return [slice(end - group.forces.shape[1], end) for end, group in zip(ends, self.groups, strict=True)]

    def errors(self, coordinates: np.ndarray) -> dict[str, Any]:
        """Return the errors of a basis within this one.

        Parameters
        ----------
        coordinates : ndarray, shape (p, k)
            Orthonormal columns: the basis in the coordinates of this model.

        Returns
        -------
        dict
            Json-able; see `kanefe.reduction.error_estimate`.
        """
        small = coordinates.T @ self.stiffness @ coordinates
        reduced = coordinates @ _responses(small, coordinates.T @ self.forces, self.points)
        loads: dict[str, Any] = {}
        worst: dict[str, Any] = {"value": -1.0}
        root = scipy.linalg.cholesky(self.stiffness)
        for group, columns in zip(self.groups, self.slices(), strict=True):
            exact = self.responses[:, :, columns]
            error = reduced[:, :, columns] - exact
            own = np.linalg.norm(exact, axis=1).max(axis=-1) / np.sqrt(self.mass)
            missed_by = np.linalg.norm(error, axis=1).max(axis=-1) / np.sqrt(self.mass)
            shares = {"displacement": missed_by / own}
            for output in self.outputs:
                moved = np.linalg.norm(output.rows @ exact, axis=1).max(axis=-1)
                missed = np.linalg.norm(output.rows @ error, axis=1).max(axis=-1)
                shares[output.name] = missed / np.maximum(moved, FLOOR * own * output.extent)
            energy = np.linalg.norm(root @ error, axis=1).max(axis=-1) / np.linalg.norm(root @ exact, axis=1).max(
                axis=-1
            )
            entry = {name: SAFETY * float(share.max()) for name, share in shares.items()}
            loads[group.name] = {
                "unit": group.unit,
                "components": list(group.kept),
                "static": SAFETY * max(float(share[0]) for share in shares.values()),
                **entry,
                "stress": SAFETY * float(energy.max()),
                "displacement_per_unit_load": SAFETY * float(missed_by.max()),
            }
            for name, share in shares.items():
                if SAFETY * share.max() > worst["value"]:
                    at = self.points[int(share.argmax())]
                    worst = {
                        "value": SAFETY * float(share.max()),
                        "load": group.name,
                        "output": name,
                        "frequency": float(at.imag / (2 * np.pi)),
                    }
        return {**worst, "up_to_frequency": float(self.up_to_frequency), "loads": loads}


def _responses(K: np.ndarray, forces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return ``(K + s^2)^-1 forces`` for every s, shape (points, p, m)."""
    if not len(K):
        return np.zeros((len(points), 0, forces.shape[1]))
    squares, vectors = scipy.linalg.eigh(0.5 * (K + K.T))
    modal = vectors.T @ forces
    return np.asarray(vectors @ (modal / (squares[:, None] + points[:, None, None] ** 2)))
