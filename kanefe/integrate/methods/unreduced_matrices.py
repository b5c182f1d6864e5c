"""The iteration matrices of scenes with unreduced bodies: S factored once per step size, and the border around it."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.methods.generalised_alpha_formula import GeneralisedAlpha
from kanefe.states.constraints import constraint_rates
from kanefe.states.tangents import current_tangents
from kanefe.tree.scales import joint_scales, scene_length
from kanefe.tree.tangents import constant_tangents

if TYPE_CHECKING:
    from kanefe.unreduced.bordered import BodyBorder, Bordered
    from kanefe.unreduced.route import Residual, UnreducedRoute

LARGE = 20_000
"""Number of coordinates above which the factors of only two step sizes are kept instead of four, to save memory."""


class Reached(NamedTuple):
    """A state with its accelerations."""

    t: float
    q: Vector
    u: Vector
    du: Vector
    z: Vector


class TriedEnd(NamedTuple):
    """A trial of a step: its error, and the state at its end; z of the loads there."""

    error: float
    q: Vector
    u: Vector
    du: Vector
    a: Vector
    z: Vector


class MeasuredStep(NamedTuple):
    """Error of a step of some size, and the size of its first Newton step, both against what is allowed."""

    halvings: int
    error: float
    first: float


class NewtonStep(NamedTuple):
    """A Newton step, and what it was found with."""

    correction: Vector
    residual: Residual
    bordered: Bordered


class IterationMatrices:
    """Factors and borders of ``M + gamma' h C + beta' h^2 K``, by how often the span is halved to give h.

    Parameters
    ----------
    scene : UnreducedRoute
    formula : GeneralisedAlpha
    span : float
        s.

    Attributes
    ----------
    bordered : (int, Bordered) or None
        The equations made last, and their halvings.
    """

    def __init__(self, scene: UnreducedRoute, formula: GeneralisedAlpha, span: float) -> None:
        self._scene, self._formula, self._span = scene, formula, span
        self._changes = scene.model.has_varying_tangents
        self._stiffness, self._damping = constant_tangents(scene.small)
        self._edges: OrderedDict[int, tuple[list[BodyBorder], Vector]] = OrderedDict()
        is_large = any(substructure.body.free_count > LARGE for substructure in scene.condensed.substructures)
        self._kept = 2 if is_large else 4
        self.bordered: tuple[int, Bordered] | None = None
        self._made_at: Reached | None = None

    def clear(self, span: float) -> None:
        """Forget all matrices; the span is another one."""
        self._edges.clear()
        self.bordered, self._span = None, span

    def renew(self, q: Vector) -> None:
        """Have the border computed again at the present shape of the bodies; the factors of S remain valid."""
        self.bordered = None
        for key, (borders, _) in self._edges.items():
            self._edges[key] = self._scene.borders(q, [own.factors for own in borders]), q

    def equations(self, halvings: int, found: Residual, at: Reached, shape: Vector) -> tuple[Bordered, Vector | None]:
        """Return the equations of an iteration, and what is known of the constraints; kept where nothing changes.

        Parameters
        ----------
        halvings : int
        found : Residual
        at : Reached
            Where it was found.
        shape : ndarray, shape (coordinates,)
            The coordinates at which a new border is made.
        """
        from kanefe.unreduced.bordered import Bordered

        scene, small = self._scene, self._scene.small
        n = small.free_count
        if not small.constraints and not self._changes and self.bordered and self.bordered[0] == halvings:
            return self.bordered[1], None
        h = math.ldexp(self._span, -halvings)
        K, C = current_tangents(found.state, self._stiffness, self._damping)
        A = found.mass[:n, :n] + self._formula.damping_share(h) * C + self._formula.stiffness_share(h) * K
        rows, known = None, None
        if small.constraints:
            rows = constraint_rates(found.state)
            known = -(rows.J @ found.rates + rows.remainder)
        if halvings not in self._edges:
            self._factor(halvings, shape)
        self._edges.move_to_end(halvings)
        self.bordered = halvings, Bordered(scene.condensed, self._edges[halvings][0], A, found.state.motions, rows)
        self._made_at = at._replace(du=at.du.copy())  # the iteration corrects it in place
        return self.bordered[1], known

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return of each matrix the state at which it was made."""
        arrays = {"edges": np.array(list(self._edges), dtype=np.int64)}
        arrays |= {f"edge {key}": q.copy() for key, (_, q) in self._edges.items()}
        if self.bordered and self._made_at:
            arrays["border"] = np.array(self.bordered[0])
            arrays |= {f"border {name}": np.array(x) for name, x in self._made_at._asdict().items()}
        return arrays

    def resume(self, snapshot: Mapping[str, np.ndarray], span: float) -> None:
        """Compute the matrices again as they were."""
        self.clear(span)
        for key in snapshot["edges"].tolist():
            self._factor(key, np.array(snapshot[f"edge {key}"]))
        if "border" in snapshot:
            q, u, du, z = (np.array(snapshot[f"border {name}"]) for name in ("q", "u", "du", "z"))
            at = Reached(float(snapshot["border t"]), q, u, du, z)
            self.equations(int(snapshot["border"]), self._scene.residual(*at), at, q)

    def _factor(self, halvings: int, shape: Vector) -> None:
        """Make the factors of S and the borders of a step size: once, and kept while there is room."""
        while len(self._edges) >= self._kept:
            self._edges.popitem(last=False)
        h = math.ldexp(self._span, -halvings)
        factors = self._scene.factored(self._formula.damping_share(h), self._formula.stiffness_share(h))
        self._edges[halvings] = self._scene.borders(shape, factors), shape


def large_displacements(scene: UnreducedRoute) -> Vector:
    """Return the size of a large displacement along every free speed: 1 rad, or a length in m."""
    length = scene_length(scene.model)
    whole = joint_scales(scene.model, length)
    for body in scene.model.bodies:
        if body.flexible is None:
            continue
        extent = float(np.ptp(body.flexible.body.nodes, axis=0).max()) or length
        substructure = next((m for m in scene.condensed.substructures if m.speeds == body.flexible.speeds), None)
        if substructure is None:
            modal = np.diag(body.flexible.free_moments.elastic_mass)
            whole[body.flexible.speeds] = extent * np.sqrt(body.flexible.body.mass / np.maximum(modal, 1e-300))
            continue
        whole[substructure.speeds] = substructure.body.coordinate_scales(extent)
    return whole
