"""The order-n route of scenes in which everything moves in one plane: three speeds a body."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from kanefe.kernels.entries import LATER, Bound
from kanefe.kernels.planar.evaluation import evaluate_planar, planar_workspace_size
from kanefe.kernels.planar.layout import PlanarTables
from kanefe.kernels.stepping import PUSH_STIFFNESS, Run
from kanefe.order_n.planar_tables import floats_in_plane
from kanefe.order_n.route import OrderN


class PlanarRoute(OrderN):
    """The equations of motion of a planar scene in order n.

    Parameters
    ----------
    in_space : OrderN
        The route of the same scene in space: what is not asked often is left to it.
    planar : PlanarTables
    """

    name = "order n, in the plane"

    def __init__(self, in_space: OrderN, planar: PlanarTables) -> None:
        self.__dict__.update(in_space.__dict__)
        self.reason = "rigid bodies that all move in one plane"
        self.planar = planar
        self._planar_size = planar_workspace_size(planar)
        # the kernels of the plane take the coordinates of a planar joint at once, without stiffness along them
        self._is_planar_if_implicit = not any(
            body.has_coordinate_forces and floats_in_plane(body.joint) for body in self.model.bodies
        )

    def _evaluate(
        self, drives: np.ndarray, t: float, inputs: np.ndarray, vectors: np.ndarray, shares: tuple[float, float]
    ) -> tuple[int, float]:
        """Call the kernel of the plane, or that of space for what the plane has not."""
        if len(vectors) > PUSH_STIFFNESS and not self._is_planar_if_implicit:
            return super()._evaluate(drives, t, inputs, vectors, shares)
        memory, is_implicit = np.empty(self._planar_size), len(vectors) > PUSH_STIFFNESS
        return self._planar_evaluation(is_implicit, t, *shares, drives, inputs, vectors, memory)  # type: ignore[no-any-return]

    def _integrate(self, run: Run, vectors: np.ndarray, is_implicit: bool, is_balanced: bool) -> tuple[int, float]:
        """Call the kernel of the plane, or that of space for what the plane has not."""
        if is_balanced or (is_implicit and not self._is_planar_if_implicit):
            return super()._integrate(run, vectors, is_implicit, is_balanced)
        return self._go_on_by(self._planar_evaluation, self._planar_size, run, vectors, is_balanced)

    @cached_property
    def _planar_evaluation(self) -> Bound:
        return self._expected(
            evaluate_planar.bound(LATER, LATER, LATER, LATER, self.planar, LATER, LATER, LATER, LATER)
        )
