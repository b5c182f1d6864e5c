"""Damage by fatigue over the surface of a body, from its stress modes and the history of its coordinates.

The stress at a node is ``s(t) = S eta(t)``, in principal directions of the history ``sum_j c_j w_j(t)``. Every value of
a history is the end of at most one full cycle, whose corrected amplitude is at most the larger of its two ends. So with
the slope p of the S-N curve Miner's sum is at most ``sum_t |s(t)|^p``, and by Minkowski's inequality at most
``(sum_j |c_j| (sum_t |w_j|^p)^(1/p))^p``, which takes no pass over the times at any node. Nodes are counted in the
order of this bound, until what is left is below a share of the largest damage.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kanefe.errors import ModelError
from kanefe.fatigue.curve import SNCurve
from kanefe.fatigue.mean_stress import MeanStress
from kanefe.fatigue.miner import law_of
from kanefe.fe_model.model import Cells
from kanefe.kernels.fatigue.cycle_damage import SIGNED_VON_MISES, Correction, DamageLaw, damage_of_stresses
from kanefe_fem.recovery.scalars import COMPONENTS
from kanefe_fem.recovery.strain_fields import StrainFields

SIGNED = "signed_von_mises"

LEAST_SHOWN = 1e-6
"""Smallest damage that pictures tell apart, relative to the largest."""

PIECE = 2**19
"""Number of stresses in one piece of the work: 4 MiB, which stay in the cache of a processor."""

DEVIATOR = np.array(
    [
        [np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0, 0.0, 0.0],
        [0.0, np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0, 0.0],
        [-np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, np.sqrt(3.0), 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, np.sqrt(3.0), 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, np.sqrt(3.0)],
    ]
)
"""Rows whose products with a stress have the length of von Mises' stress."""


@dataclass(frozen=True, eq=False)
class DamageMap:
    """Damage at the nodes of the surface of a body: of a shell the worst of its faces and of the fibres of stiffeners.

    Attributes
    ----------
    quantity : str
        The scalar whose cycles were counted.
    values : ndarray, shape (n,)
        Share of the life that the run uses up; NaN inside of the body.
    is_bound : ndarray of bool, shape (n,)
        Where cycles were not counted, because the damage cannot be above `floor` times the largest; the value is an
        upper bound.
    floor : float
    positions : ndarray, shape (n, 3)
        Nodes in G, m.
    cells : tuple of Cells
    """

    quantity: str
    values: np.ndarray
    is_bound: np.ndarray
    floor: float
    positions: np.ndarray
    cells: tuple[Cells, ...]

    @property
    def where(self) -> int:
        """Number of the node with the largest damage."""
        return int(np.nanargmax(self.values))

    @property
    def peak(self) -> float:
        """Largest damage."""
        return float(self.values[self.where])

    @property
    def peak_position(self) -> np.ndarray:
        """Position of the largest damage in G, shape (3,), m."""
        return self.positions[self.where]

    @property
    def repeats(self) -> float:
        """How often the run can be repeated until a crack is expected."""
        return 1.0 / self.peak if self.peak > 0.0 else np.inf

    def picture(self, path: str | Path, *, view: Sequence[float] = (1.0, -1.3, 0.9), title: str | None = None) -> Path:
        """Draw the body with the decimal logarithm of its damage in colours, from the floor to the largest.

        Parameters
        ----------
        path : path
            Path of the picture (.png).
        view : array_like, shape (3,)
            Direction in G from the body towards the viewer.
        title : str, optional

        Raises
        ------
        ModelError, FileError, MissingDependency
            If nothing is damaged, the file cannot be written, or pyvista is not installed.
        """
        from kanefe.views.pictures import write_field

        if not self.peak > 0.0:
            raise ModelError("nothing of the body is damaged: all cycles are below the endurance limit")
        values = np.log10(np.maximum(self.values, max(self.floor, LEAST_SHOWN) * self.peak))
        label, last = "log10 of the damage", float(np.log10(self.peak))
        return write_field(path, self.positions, self.cells, values, label, view=view, title=title, limit=last)

    def __str__(self) -> str:
        counted = int(np.isfinite(self.values).sum() - self.is_bound.sum())
        place = ", ".join(f"{x:.4g}" for x in self.peak_position)
        return (
            f"damage {self.peak:.3g} of {self.quantity} at node {self.where} ({place}) m, {self.repeats:.3g} repeats; "
            f"{counted} nodes counted, {int(self.is_bound.sum())} below {self.floor:g} of it"
        )


def damage_map(
    fields: StrainFields,
    eta: np.ndarray,
    curve: SNCurve,
    mean_stress: MeanStress | None,
    quantity: str,
    floor: float,
    material: int | None,
) -> DamageMap:
    """Return the damage of coordinates (T, k) at the nodes of the surface.

    Raises
    ------
    ModelError
        If there is no such quantity, the history is too short, or a mean stress alone breaks the material.
    """
    if quantity not in (SIGNED, *COMPONENTS):
        raise ModelError(f"there is no damage of {quantity!r}. There are: {SIGNED}, {', '.join(COMPONENTS)}")
    if not 0.0 <= floor < 1.0:
        raise ModelError(f"floor of a damage map is a share of the largest damage, from 0 to below 1, not {floor:g}")
    if len(eta) < 2:
        raise ModelError("a damage needs at least two output times. Remedy: simulate(..., output_step=...)")
    law, scalar = law_of(curve, mean_stress), (*COMPONENTS, SIGNED).index(quantity)
    places, shapes = zip(*fields.surface_modes(material), strict=True)
    outside, modes = np.concatenate(places), np.concatenate(shapes)
    has_stress = np.isfinite(modes).all(axis=(1, 2))
    outside, modes = outside[has_stress], modes[has_stress]
    damages = _bounds(modes, eta, DamageLaw(law), scalar)
    order, counted, largest = np.argsort(-damages, kind="stable"), 0, 0.0
    piece = max(1, PIECE // (6 * len(eta)))
    coordinates, stresses = np.ascontiguousarray(eta.T), np.empty((piece, 6, len(eta)))
    memory = np.empty(2 * len(eta) + 1)
    while counted < len(order) and damages[order[counted]] > floor * largest:
        chosen = order[counted : counted + piece]
        found, own = np.empty(len(chosen)), stresses[: len(chosen)]
        np.matmul(modes[chosen].reshape(-1, eta.shape[1]), coordinates, out=own.reshape(-1, len(eta)))
        damage_of_stresses(own, scalar, law, memory, found)
        damages[chosen] = found
        counted, largest = counted + len(chosen), max(largest, float(found.max()))
    values, is_bound = np.full(len(fields.nodes), np.nan), np.zeros(len(fields.nodes), dtype=bool)
    ascending, not_counted = np.argsort(damages, kind="stable"), np.full(len(order), False)
    not_counted[order[counted:]] = damages[order[counted:]] > 0.0
    for of_nodes, of_points in ((values, damages), (is_bound, not_counted)):  # the last is the worst at its node
        of_nodes[outside[ascending]] = of_points[ascending]
    if not np.isfinite(largest):
        place = fields.nodes[int(np.nanargmax(values))].round(6).tolist()
        raise ModelError(
            f"the mean stress at {place} m breaks the material at once: it is above the ultimate strength. Remedy: "
            "check the strength, in Pa, and the stress there"
        )
    return DamageMap(quantity, values, is_bound, floor, fields.nodes, fields.cells)


def _bounds(modes: np.ndarray, eta: np.ndarray, law: DamageLaw, scalar: int) -> np.ndarray:
    """Return an upper bound of the damage at each node, from stress modes (n, 6, k) and coordinates (T, k)."""
    _, _, directions = np.linalg.svd(eta, full_matrices=False)  # rows
    histories = np.abs(eta @ directions.T)  # (T, j)
    rows = DEVIATOR if scalar == SIGNED_VON_MISES else np.eye(6)[[scalar]]
    sizes = np.linalg.norm(rows @ (modes @ directions.T), axis=1)  # (n, j)
    largest = histories.max(axis=0)
    scale = np.where(largest > 0.0, largest, 1.0)
    norms = scale * ((histories / scale) ** law.slope).sum(axis=0) ** (1.0 / law.slope)
    bounds = (sizes @ norms / law.amplitude) ** law.slope / law.cycles
    if np.isinf(law.slope_below):
        bounds[sizes @ largest < law.amplitude] = 0.0
    if law.correction in (Correction.GOODMAN, Correction.GERBER):
        bounds[sizes @ largest >= law.parameter] = np.inf  # near the strength, corrected amplitudes have no bound
    return bounds
