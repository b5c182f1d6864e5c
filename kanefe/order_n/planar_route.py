"""The order-n route of scenes in which everything moves in one plane: three speeds a body."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kanefe.kernels.drives import Drives
from kanefe.kernels.planar.layout import PlanarTables
from kanefe.kernels.planar.march import march_planar, room_size
from kanefe.kernels.stepping import Run
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
        self._planar_room = room_size(planar)
        # the kernels of the plane take the coordinates of a planar joint at once, without stiffness along them
        self._is_planar_if_implicit = not any(
            body.has_coordinate_forces and floats_in_plane(body.joint) for body in self.model.bodies
        )

    def _march(
        self,
        drives: np.ndarray,
        motions: Drives | None,
        fill: Callable[..., None] | None,
        t: float,
        inputs: np.ndarray,
        vectors: np.ndarray,
        shares: tuple[float, float],
        run: Run | None,
        *,
        is_implicit: bool,
        is_balanced: bool = False,
    ) -> tuple[int, float]:
        """Call the kernel of the plane, or that of space for what the plane has not."""
        rest = drives, motions, fill, t, inputs, vectors
        if is_balanced or (is_implicit and not self._is_planar_if_implicit):
            return super()._march(*rest, shares, run, is_implicit=is_implicit, is_balanced=is_balanced)
        return march_planar(self.planar, *rest, *shares, run, np.empty(self._planar_room))
