"""The order-n route of scenes in which everything moves in one plane: three speeds a body."""

from __future__ import annotations

from functools import cached_property
from typing import Any, Self

from kanefe.kernels.compiler.entries import LATER
from kanefe.kernels.planar.evaluation import evaluate_planar, planar_memory_size
from kanefe.kernels.planar.layout import PlanarTables
from kanefe.order_n.rates_kernel import RatesKernel
from kanefe.order_n.route import OrderN
from kanefe.order_n.tables.planar_tables import floats_in_plane
from kanefe.tree.model_data import ModelData


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
        self.spatial, self.planar = in_space, planar
        # the kernels of the plane take the coordinates of a planar joint at once, without stiffness along them
        self._is_planar_if_implicit = not any(
            body.has_coordinate_forces and floats_in_plane(body.joint) for body in self.model.bodies
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return PlanarRoute, (self.spatial, self.planar)

    def started_otherwise(self, model: ModelData) -> Self:
        """Return the route of a model that differs in its start alone, with the same tables and kernels."""
        other = super().started_otherwise(model)
        other.spatial = self.spatial.started_otherwise(model)
        return other

    def _rates_kernel(self, is_implicit: bool, is_balanced: bool = False) -> RatesKernel:
        """Return the kernel of the plane, or that of space for what the plane has not."""
        if is_balanced or (is_implicit and not self._is_planar_if_implicit):
            return super()._rates_kernel(is_implicit, is_balanced)
        return self._in_plane

    @cached_property
    def _in_plane(self) -> RatesKernel:
        evaluation = evaluate_planar.bound(LATER, self.planar, *(LATER,) * 4)
        return self._kernel_of(evaluation, planar_memory_size(self.planar))
