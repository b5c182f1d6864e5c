"""Tangent coordinates of a tree about a state, and the derivatives of its accelerations by them.

A small motion is a vector z in the directions of the free speeds, ``q = advance(q0, z)``: displacements, angles, modal
coordinates and, for rotations, the rotation vector in the moving frame. About a moving state

    dz/dt = G z + du,        d(du/dt) = f_z z + f_u du

where G is ``-w~`` for each rotation with its angular velocity w in the moving frame, and zero otherwise.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kanefe.equations.model import Model
from kanefe.fe_model.model import TRANSLATIONS
from kanefe.frames import Matrix, Vector, skew
from kanefe.linear.unit_forces import load_columns, load_values
from kanefe.tree.body_terms import BodyTerms
from kanefe.tree.model_data import QUADRATURES, ModelData
from kanefe.tree.scales import joint_scales, kept_of_scene, largest_extent, scene_length
from kanefe.tree.scene_state import SceneState

DIFFERENCE_STEP = 1e-3
"""Step of fourth-order central differences, rad or scene lengths: both of their errors are about 1e-12."""

NEAREST, LEAST_SHARE = 0.1, 1e-5
"""Largest step of differences along a compliant contact, relative to its depth or distance; and smallest step, relative
to the usual one."""


def rotations(model: Model) -> list[tuple[BodyTerms, np.ndarray]]:
    """Return the bodies whose joint has Euler parameters, with the three free speeds of the rotation."""
    found = [(body, body.joint.rotation_at) for body in model.bodies]
    return [(body, body.speeds[first : first + 3]) for body, first in found if first is not None]


def tangent_names(model: ModelData) -> tuple[str, ...]:
    """Return a name for every tangent coordinate, with its unit in brackets: in the order of the free speeds."""
    names = list(model.speed_names())
    for body in model.bodies:
        own, first = list(body.joint.coordinate_names), body.joint.rotation_at
        if first is not None:
            own[first : first + 4] = [f"rotation {c} [rad]" for c in "xyz"]
        for where, name in zip(body.speeds, own, strict=True):
            if where < model.free_count:
                names[where] = f"{body.name}: {name}"
        if body.flexible:
            for i in range(body.flexible.body.free_count):
                names[body.flexible.speeds.start + i] = f"{body.name}: eta {i}"
    return tuple(names)


def turning(model: Model, u: Vector) -> Matrix:
    """Return G of ``dz/dt = G z + du`` over the free speeds u, shape (free, free)."""
    G = np.zeros((model.free_count, model.free_count))
    for _, at in rotations(model):
        G[np.ix_(at, at)] = -skew(u[at])
    return G


def tangent_steps(model: Model, directions: Matrix) -> Vector:
    """Return the step of differences along each direction (free, k): `DIFFERENCE_STEP` of a large displacement."""
    sizes = np.abs(directions / large_tangents(model)[:, None]).max(axis=0, initial=0.0)
    return np.asarray(DIFFERENCE_STEP / np.where(sizes > 0.0, sizes, 1.0))


@kept_of_scene
def large_tangents(model: ModelData) -> Vector:
    """Return a large displacement along every free speed, rad, m, or modal units: of a body its size, or a radian."""
    length = scene_length(model)
    scales = joint_scales(model, length)
    for body in model.bodies:
        if body.flexible:
            # the largest displacement over the body's size, or rotation over a radian, per unit of the coordinate
            flexible = body.flexible.body
            extent = largest_extent(flexible) or length
            sizes = np.array([extent if component in TRANSLATIONS else 1.0 for component in flexible.components])
            basis = np.abs(np.asarray(flexible.basis[:, : flexible.free_count]))
            moved = basis.reshape(-1, len(sizes), basis.shape[1]) / sizes[:, None]
            moved = moved.reshape(-1, basis.shape[1]).max(axis=0, initial=0.0)
            scales[body.flexible.speeds] = 1.0 / np.where(moved > 0.0, moved, 1.0)
    return scales


def difference(function: Callable[[float], Vector], h: float) -> Vector:
    """Return the derivative of a function of one number at zero: central, of the fourth order in h."""
    return np.asarray((8.0 * (function(h) - function(-h)) - (function(2.0 * h) - function(-2.0 * h))) / (12.0 * h))


def contact_depths(state: SceneState) -> list[list[float]]:
    """Return the depths of the points of each compliant contact, m; negative: the distance."""
    if not state.model.loads:
        return []
    from kanefe.contact.contact import compliant_contacts

    return [
        [float(touch.depth) for touch in contact.touches(state.load_ends(i), state.load_states(i))]
        for i, contact in compliant_contacts(state.model.loads)
    ]


def parting_share(state: SceneState) -> float:
    """Return the factor on the steps of differences with which no compliant contact opens or closes."""
    nearest = min((abs(depth) for depths in contact_depths(state) for depth in depths), default=np.inf)
    least = NEAREST * nearest / (DIFFERENCE_STEP * scene_length(state.model))
    return min(1.0, max(least, LEAST_SHARE))


class Derivatives:
    """Derivatives of the accelerations of the free speeds at a state, along given directions.

    By complex steps through the order-n kernels, exact to round-off. Functions of the user that depend on the state are
    differentiated by central differences, and scenes of the literal route entirely.

    Parameters
    ----------
    model : Model
    t : float
        s.
    q, u : ndarray
        Coordinates and free speeds.
    """

    def __init__(self, model: Model, t: float, q: Vector, u: Vector) -> None:
        self.model, self.t, self.q, self.u = model, t, q, u
        self._state = np.concatenate((q, u, model.initial_states, np.zeros(QUADRATURES)))
        none = np.zeros((0, len(self._state)))
        is_own = model.route.evaluate(t, self._state).is_own
        self.is_exact = is_own and model.route.partial_derivatives(t, self._state, none) is not None
        self._loads: Matrix | None = None
        self._share = 1.0 if self.is_exact else parting_share(model.literal.at(t, q, u))
        if self.is_exact and model.route.derivatives(t, self._state, none) is None:
            state = model.literal.at(t, q, u)
            self._loads = model.literal.responses(state, load_columns(state))

    def along(self, z: Matrix, du: Matrix) -> Matrix:
        """Return the rates of change of the accelerations along tangents z and speeds du, each (free, k)."""
        model, t, q = self.model, self.t, self.q
        n, m = model.coordinate_count, model.free_count
        if not self.is_exact:
            steps = self._steps(z, du)
            changes = [difference(self._accelerations(*pair), h) for *pair, h in zip(z.T, du.T, steps, strict=True)]
            return np.reshape(changes, (-1, m)).T
        directions = np.zeros((z.shape[1], len(self._state)))
        directions[:, n : n + m] = du.T
        directions[:, :n] = (model.coordinate_map(q) @ z).T
        exact = model.route.partial_derivatives(t, self._state, directions)
        if exact is None:
            raise TypeError("the route is exact at this state")
        found = exact[:, n : n + m].T
        if self._loads is not None:
            steps = self._steps(z, du)
            changes = [difference(self._values(*pair), h) for *pair, h in zip(z.T, du.T, steps, strict=True)]
            found = found + self._loads @ np.reshape(changes, (len(changes), -1)).T
        return found

    def _steps(self, z: Matrix, du: Matrix) -> Vector:
        """Return the steps of differences, from the tangents and from the displacements of the speeds in one second."""
        return self._share * np.minimum(tangent_steps(self.model, z), tangent_steps(self.model, du))

    def _values(self, z: Vector, du: Vector) -> Callable[[float], Vector]:
        model = self.model
        return lambda h: load_values(model.literal.at(self.t, model.advance(self.q, h * z), self.u + h * du))

    def _accelerations(self, z: Vector, du: Vector) -> Callable[[float], Vector]:
        model, at = self.model, slice(self.model.coordinate_count, self.model.coordinate_count + self.model.free_count)
        z_now = model.initial_states
        return lambda h: model.rhs(self.t, np.concatenate((model.advance(self.q, h * z), self.u + h * du, z_now)))[at]
