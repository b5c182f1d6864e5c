"""Paths of equilibria of a scene over the factor of its loads, through limit points, and branches from them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.linear.equilibrium.equilibria import balanced
from kanefe.linear.equilibrium.overflow import check_loads
from kanefe.linear.paths.arc_length import Stop
from kanefe.linear.paths.loaded_scene import LoadedScene
from kanefe.linear.paths.path_of_equilibria import EquilibriumPath
from kanefe.linear.paths.path_settings import WHAT, settings_of
from kanefe.linear.paths.traced import first_stop, traced
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.stability.buckling_modes import Buckling
from kanefe.linear.stability.load_path import check_resisted, matrices_at_rest
from kanefe.linear.stability.raised_loads import chosen_loads
from kanefe.linear.state import check_no_rigid_contacts, model_in_state, rubbing

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start
    from kanefe.linear.state import Freezable

ALIKE = 0.5
"""Cosine between a buckling shape and that of a branch point above which they are the same."""

BEYOND = 2.0
"""Largest factor of a path that looks for the branch of a buckling mode, relative to the factor of this mode."""


@checked("loads", "to", "down_to", "longest", "points", "t", "start")
def equilibrium_path(
    scene: Freezable | Model,
    *,
    loads: str | Sequence[str] | None = None,
    to: float | None = None,
    down_to: float | None = None,
    longest: float = 0.05,
    points: int = 1000,
    t: float | None = None,
    start: Start = None,
    branch: Buckling | tuple[Buckling, int] | None = None,
) -> EquilibriumPath:
    """Follow the equilibria of a scene as its loads are raised in proportion, stable or not, also where they fall.

    From the rest without the raised loads, by the arc length of displacements and load factor (Riks 1979, Keller 1977),
    with steps that the corrections of the last one determine. Limit points (snap-through), branch points (buckling)
    and, for loads without potential, the onset of flutter are solved for, to some 1e-9; ``path.branch()`` follows a
    branch. Small imperfections of the scene turn branch points into limit points or bends, as they do in reality.

    Follower loads contribute their full, unsymmetric stiffness. Scenes at rest only: friction, rigid contacts and
    drives that move are refused.

    Parameters
    ----------
    scene : System or Model
    loads : str or sequence of str, optional
        Loads that are raised in proportion, as for `buckling`; all others are constant.
    to : float, optional
        Factor of the loads at which the path ends; negative to reverse them. Default: 1; with `branch`, twice its
        factor.
    down_to : float, optional
        Factor on the other side at which it ends too, zero or of the other sign; default: ``-to``.
    longest : float
        Largest change in one step of a coordinate, rad or scene lengths, and of the factor relative to `to`: for
        denser points. Accuracy does not depend on it.
    points : int
        Largest number of points.
    t : float, optional
        Time at which functions of time are evaluated, s; default: that of the start, or zero.
    start : state, optional
        Where the search for the first equilibrium begins, as `kanefe.System.simulate` takes it.
    branch : Buckling or (Buckling, int), optional
        Follow the post-buckling branch of this mode (default: the first) instead, from the branch point that has its
        shape. `loads` are those of the buckling analysis.

    Returns
    -------
    EquilibriumPath

    Raises
    ------
    ModelError
        If an argument is not valid, nothing is raised, a motion has no restoring force at the start, or no branch
        point has the shape of the mode.
    SimulationError
        If there is no equilibrium to start from.

    Warns
    -----
    SimulationWarning
        If the path ends before the factor leaves the range: `EquilibriumPath.ended` has the reason.
    AccuracyWarning
        If raised loads that turn with the surface of a flexible body leave out how this deforms, or where a body is
        bent farther than its kinematics or its functions show, as `equilibrium` warns: told once, at the worst point.

    Examples
    --------
    Half a von Mises truss, a bar of stiffness k, length l and span a, snaps through at k (l^(2/3) - a^(2/3))^(3/2):

    >>> import kanefe as kf
    >>> scene = kf.System()
    >>> node = scene.add_rigid_body("node", 1.0, at=(0.995, 0.1, 0), joint=kf.Prismatic("y"))
    >>> scene.add_spring("bar", scene.ground, node, stiffness=1e6)
    >>> scene.add_force(node, (0, -1, 0))
    >>> path = kf.equilibrium_path(scene, to=400.0)
    >>> [round(point.factor, 2) for point in path.limit_points]
    [193.41, -193.41]
    """
    if branch is not None:
        return _branch_of_mode(scene, loads, to, down_to, longest, points, t, start, branch)
    path = _followed(scene, loads, 1.0 if to is None else to, down_to, longest, points, t, start)
    path._warn()
    return path


def _followed(
    scene: Freezable | Model,
    loads: str | Sequence[str] | None,
    to: float,
    down_to: float | None,
    longest: float,
    points: int,
    t: float | None,
    start: Start,
) -> EquilibriumPath:
    settings = settings_of(to, down_to, longest, points)
    model, time, q, _ = model_in_state(scene, t, start, WHAT)
    check_no_rigid_contacts(model, WHAT)
    _check_no_friction(model)
    raised, kept = chosen_loads(model, time, loads, WHAT)
    check_loads(model, model.literal.at(time, q))
    loaded = LoadedScene(model, time, raised, abs(settings.to))
    y = np.concatenate((q, np.zeros(model.free_count), model.initial_states))
    rest = balanced(loaded.model_at(0.0), t=time, start=None if start is None else y)
    small = SmallMotions(loaded.model_at(0.0), time, rest.q, np.zeros(model.free_count))
    if small.is_moving:
        raise ModelError(f"{WHAT}: a driven joint moves. Remedy: a time t at which all drives are at rest")
    M, _, K = matrices_at_rest(small)
    check_resisted(small, M, K, WHAT, may_tip=True)
    first: Stop = first_stop(loaded, rest.q, 0.0, np.sign(settings.to))
    found = traced(loaded, first, settings.bounds, settings.longest, settings.points, on_branch=False)
    return EquilibriumPath(loaded, kept, settings, found)


def _branch_of_mode(
    scene: Freezable | Model,
    loads: str | Sequence[str] | None,
    to: float | None,
    down_to: float | None,
    longest: float,
    points: int,
    t: float | None,
    start: Start,
    branch: Buckling | tuple[Buckling, int],
) -> EquilibriumPath:
    buckled, mode = branch if isinstance(branch, tuple) and len(branch) == 2 else (branch, 0)
    if not isinstance(buckled, Buckling):
        raise ModelError(f"{WHAT}: branch must be the result of kanefe.buckling, or this and a mode, not {branch!r}")
    if loads is not None:
        raise ModelError(f"{WHAT}: with branch=, the loads are those of buckling. Remedy: leave out loads=")
    buckled.describe(mode)  # refuses a mode that is not there
    shape = buckled.tangents[:, mode]
    factor = float(buckled.factors[mode])
    to = BEYOND * factor if to is None else to
    path = _followed(scene, buckled.path.raised, to, down_to, longest, points, t, start)
    likeness = [_alike(path.loaded, shape, point.tangents) for point in path.branch_points]
    if not likeness or max(likeness) < ALIKE:
        there = ", ".join(f"{point.factor:.6g}" for point in path.branch_points) or "none"
        raise ModelError(
            f"{WHAT}: no branch point up to {path.factors[-1]:.6g} times the loads has the shape of mode {mode} "
            f"(branch points: {there}; the path ended {path.ended}). Remedy: to=..., farther than its factor "
            f"{factor:.6g}; or, if the scene is imperfect, the path itself, which bends instead of branching"
        )
    return path.branch(int(np.argmax(likeness)))


def _alike(loaded: LoadedScene, shape: Vector, shapes: np.ndarray) -> float:
    """Return the cosine between a shape and the space of some others, in displacements."""
    weights = loaded.weights
    a, B = weights * shape, weights[:, None] * shapes
    return float(np.linalg.norm(np.linalg.qr(B)[0].T @ a) / np.linalg.norm(a))


def _check_no_friction(model: Model) -> None:
    """Raise a ModelError for friction, whose rests depend on how they were reached."""
    if (load := rubbing(model)) is not None:
        raise ModelError(
            f"{WHAT}: friction of {load.name!r} is not supported: its rests depend on the way there. Remedy: leave "
            "it out, or a slow run with loads that rise over time"
        )
