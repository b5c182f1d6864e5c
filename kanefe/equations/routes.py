"""The choice of a route for a frozen scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.literal.route import LiteralRoute
from kanefe.tree.model_data import ModelData
from kanefe.tree.route import Route

if TYPE_CHECKING:
    from kanefe.order_n.tree_matrix import TreeMatrix, TreePattern


def route_of(model: ModelData) -> Route:
    """Return the route by which a scene is evaluated: the fastest that supports the whole scene."""
    if model.has_unreduced:
        return starting_route(model)
    from kanefe.order_n.planar_route import PlanarRoute
    from kanefe.order_n.route import OrderN, obstacles_of
    from kanefe.order_n.tables.planar_tables import planar_tables

    obstacles = obstacles_of(model)
    if obstacles:
        return LiteralRoute(model, obstacles)
    in_space = OrderN(model)
    planar = planar_tables(model, in_space.tables)
    return in_space if planar is None else PlanarRoute(in_space, planar)


def directions_of_loads(model: ModelData) -> int:
    """Return in how many directions loads between frames stiffen sweeps, 0: not in few of them, or there are none."""
    from kanefe.order_n import stiff_directions
    from kanefe.order_n.route import obstacles_of

    return 0 if model.has_unreduced or obstacles_of(model) else stiff_directions.directions_of_loads(model)


def newton_pattern(route: Route) -> TreePattern | None:
    """Return where Newton matrices have entries that keep the structure of a tree; None where dense ones are taken."""
    return getattr(route, "newton_pattern", None)


def newton_work(route: Any) -> float:
    """Return how many products a factorisation that keeps the structure of a tree takes about; infinite: it does not.

    In units of products in a dense matrix.
    """
    if not hasattr(type(route), "newton_pattern"):
        return np.inf
    from kanefe.order_n.tree_matrix import expected_work

    return expected_work(route)


def tree_matrix(route: Any) -> TreeMatrix:
    """Return the linearised equations of a scene that has a `newton_pattern`."""
    from kanefe.order_n.tree_matrix import TreeMatrix

    return TreeMatrix(route)


def swept_arms(model: ModelData) -> dict[int, np.ndarray]:
    """Return the arms of viscoelastic bodies that sweeps eliminate: see `kanefe.order_n.tables.arm_tables`."""
    from kanefe.order_n.route import obstacles_of
    from kanefe.order_n.tables import arm_tables

    return {} if model.has_unreduced or obstacles_of(model) else arm_tables.swept_arms(model)


def starting_route(model: ModelData) -> Route:
    """Return a route for the start only, without tables of kernels."""
    if model.has_unreduced:
        from kanefe.unreduced.route import UnreducedRoute

        return UnreducedRoute(model)
    return LiteralRoute(model)
