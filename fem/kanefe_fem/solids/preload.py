"""Bodies under a static preload: the tangent stiffness of a stressed state.

    K u = f + K u_T,    K_t = K + K_g(u - u_T)

u is the static displacement under the loads f with some groups held, u_T the free expansion, and K_g the geometric
stiffness of the stress of ``u - u_T``, linear in it: linearised buckling (Zienkiewicz & Taylor, The Finite Element
Method, vol. 2). Tension stiffens (a string), compression softens, up to buckling, where K_t is no longer positive
definite.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.factorise import Factorisation, Factorise, splu_factorise
from kanefe.fe_model.model import COMPONENTS, TRANSLATIONS, FiniteElementModel
from kanefe.fe_model.source import changed_model
from kanefe.frames import numbers
from kanefe_fem.lumped.mean_motion import mean_motion

DENSE = 60
"""Number of degrees of freedom up to which eigenvalues are computed with dense matrices."""

Held = Sequence[str] | Mapping[str, float]
Loads = Mapping[str, Sequence[float]]

SLACK = 1e-6
"""Relative distance to the buckling load below which a load counts as buckling: its frequency is meaningless."""


@dataclass(frozen=True)
class Preload:
    """A static load case of a body.

    Parameters
    ----------
    held : dict of str to sequence of str, or to dict of str to float
        For each held group, the components ("x", "y", "z", "rx", ...) of its nodes that are fixed, or their
        displacements in m (rad): {"root": "xyz", "tip": {"x": 1e-3}} clamps the root of a solid and pulls its tip. For
        the static problem only: the interfaces of the body are chosen independently.
    forces : dict of str to array_like, shape (3,) or (6,)
        Force (N) and moment (N m, about the group's position) on the mean motion of each group, in axes of G.
    tractions : dict of str to array_like, shape (3,)
        In Pa, on surfaces of the model (its argument `surfaces`), or N/m on lines of beams.
    pressures : dict of str to float
        In Pa on the outer side of such surfaces.
    acceleration : array_like, shape (3,)
        Gravity, or minus the acceleration of G, in m/s2.
    angular_velocity : array_like, shape (3,)
        Angular velocity of G in rad/s, for centrifugal forces on the undeformed body.
    center : array_like, shape (3,)
        A point of the axis of rotation in m.
    thermal_strain : float
        Free expansion of the whole body, coefficient times change of temperature.

    Raises
    ------
    ModelError
        If a value is not a number or has another shape, or nothing is held or loaded.

    Examples
    --------
    A wire, pulled by 1 mm between its ends:

    >>> tight = Preload(held={"root": "xyz", "tip": {"x": 1e-3, "y": 0.0, "z": 0.0}})
    """

    held: Mapping[str, Held]
    forces: Loads = field(default_factory=dict)
    tractions: Loads = field(default_factory=dict)
    pressures: Mapping[str, float] = field(default_factory=dict)
    acceleration: Any = (0.0, 0.0, 0.0)
    angular_velocity: Any = (0.0, 0.0, 0.0)
    center: Any = (0.0, 0.0, 0.0)
    thermal_strain: float = 0.0

    def __post_init__(self) -> None:
        for name in ("forces", "tractions", "pressures"):
            if not isinstance(getattr(self, name), Mapping):
                raise ModelError(f"preload: {name} must be a dict by groups, not {getattr(self, name)!r}")
        freeze = object.__setattr__
        if not isinstance(self.held, Mapping) or not self.held:
            raise ModelError(
                "preload: nothing is held. Remedy: held={'root': 'xyz'} with a group that carries the loads"
            )
        freeze(self, "held", MappingProxyType(self.supports))
        for name, shapes in (("forces", ((3,), (6,))), ("tractions", ((3,),))):
            of = {key: _vector(f"{name} on {key!r}", value, shapes) for key, value in getattr(self, name).items()}
            freeze(self, name, MappingProxyType(of))
        pressures = {key: _vector(f"pressure on {key!r}", [p], ((1,),))[0] for key, p in self.pressures.items()}
        freeze(self, "pressures", MappingProxyType(pressures))
        for name in ("acceleration", "angular_velocity", "center"):
            freeze(self, name, _vector(name, getattr(self, name), ((3,),)))
        freeze(self, "thermal_strain", _vector("thermal_strain", [self.thermal_strain], ((1,),))[0])
        pulled = any(value != 0.0 for held in self.supports.values() for value in held.values())
        spread = (self.forces, self.tractions, self.pressures)
        if not (pulled or any(spread) or any(self.acceleration) or any(self.angular_velocity) or self.thermal_strain):
            raise ModelError(
                "preload: there is no load. Remedy: forces, pressures, thermal_strain, held={'tip': {'x': 1e-3}}"
            )

    @property
    def supports(self) -> dict[str, dict[str, float]]:
        """Displacements of the held components of each group, m or rad."""
        return {name: _held(name, given) for name, given in self.held.items()}

    @property
    def groups(self) -> list[str]:
        """Names of the groups that are held or carry a force."""
        return list(dict.fromkeys([*self.held, *self.forces]))

    @property
    def surfaces(self) -> list[str]:
        """Names of the surfaces that carry a traction or a pressure."""
        return list(dict.fromkeys([*self.tractions, *self.pressures]))

    def describe(self) -> dict[str, Any]:
        """Return the load case (json-able)."""
        of = {f.name: getattr(self, f.name) for f in fields(self)}
        return {name: dict(value) if isinstance(value, Mapping) else value for name, value in of.items()}


@checked
def preloaded(model: FiniteElementModel, preload: Preload, factorise: Factorise = splu_factorise) -> FiniteElementModel:
    """Return the model with the tangent stiffness of a preloaded state.

    Parameters
    ----------
    model : FiniteElementModel
        With a geometric stiffness: of a solid or of beams.
    preload : Preload
    factorise : callable, optional
        Factors a symmetric positive definite sparse matrix. Default: SuperLU; `kanefe_fem.solid_model` takes MUMPS.

    Returns
    -------
    FiniteElementModel
        With ``K + K_g`` for K. Its nodes do not move: the static displacement is assumed to be small; its largest value
        is ``provenance["preload"]["largest_displacement_m"]``.

    Raises
    ------
    ModelError
        If the model has no geometric stiffness, a group or surface is unknown, the supports leave the body free to
        move, or the body buckles under the load; the message has the buckling load.

    Notes
    -----
    The loads keep their directions in G. With external loads K_t resists (or supports) small rotations relative to G;
    a body without a fixed interface in the scene should have self-equilibrated loads, such as thermal stress.

    Examples
    --------
    >>> from kanefe_fem.beams.body import straight_beam
    >>> from kanefe_fem.materials.isotropic import Material
    >>> from kanefe_fem.beams.sections import SolidCircle
    >>> wire = straight_beam(1.0, SolidCircle(0.001), Material(E=210e9, nu=0.3, rho=7850.0))
    >>> tight = preloaded(wire, Preload(held={"root": "xyz"}, forces={"tip": (500.0, 0, 0)}))   # doctest: +SKIP
    """
    if model.stress_stiffness is None:
        raise ModelError(
            "preload: this model has no geometric stiffness (stress_stiffness is None), so a load cannot stiffen it. "
            "Remedy: a model of kanefe_fem.solid_model or beam_model, or give stress_stiffness with the matrices"
        )
    return changed_model(model, lambda whole: _with_preload(whole, preload, factorise))


def _with_preload(model: FiniteElementModel, preload: Preload, factorise: Factorise) -> FiniteElementModel:
    fixed, values = _supports(model, preload)
    free = np.setdiff1d(np.arange(model.size), fixed)
    K = sp.csr_matrix(model.stiffness)
    expansion = _expansion(model, preload.thermal_strain)
    force = _forces(model, preload) + K @ expansion
    inner = sp.csc_matrix(K[free][:, free])
    factors = _factored(inner, factorise)
    u = np.zeros(model.size)
    u[fixed] = values
    u[free] = factors.solve(force[free] - K[free][:, fixed] @ values)
    stress_stiffness: Any = model.stress_stiffness
    geometric = sp.csr_matrix(stress_stiffness(u - expansion))
    geometric = 0.5 * (geometric + geometric.T)
    share = _buckling_share(inner, sp.csc_matrix(geometric[free][:, free]), factors)
    if share >= 1.0 - SLACK:
        raise ModelError(
            f"preload: the body buckles at {1.0 / share:.3g} times this load. Remedy: reduce the load, check its sign, "
            "or hold the body better"
        )
    where = [model.components.index(c) for c in TRANSLATIONS if c in model.components]
    moved = np.linalg.norm(u.reshape(len(model.nodes), -1)[:, where], axis=1).max()
    record = {
        **preload.describe(),
        "largest_displacement_m": float(moved),
        "share_of_buckling_load": float(max(share, 0.0)),
    }
    return replace(model, stiffness=sp.csr_matrix(K + geometric), provenance={**model.provenance, "preload": record})


def _supports(model: FiniteElementModel, preload: Preload) -> tuple[np.ndarray, np.ndarray]:
    """Return the held degrees of freedom, in order, and their displacements."""
    width = len(model.components)
    given: dict[int, float] = {}
    for name, held in preload.supports.items():
        for component, value in held.items():
            if component not in model.components:
                raise ModelError(
                    f"preload: {name!r} is held in {component!r}, which the nodes of this model do not have. Remedy: "
                    f"components among {', '.join(model.components)}"
                )
            for node in model.group(name).nodes:
                dof = int(node) * width + model.components.index(component)
                if given.setdefault(dof, value) != value:
                    raise ModelError(
                        f"preload: node {node} of {name!r} is held at two different places in {component!r}. Remedy: "
                        "hold groups that share no nodes"
                    )
    fixed = np.array(sorted(given), dtype=int)
    if len(fixed) == model.size:
        raise ModelError("preload: every node is held, nothing is left to deform. Remedy: hold fewer groups")
    return fixed, np.array([given[int(dof)] for dof in fixed], dtype=float)


def _forces(model: FiniteElementModel, preload: Preload) -> np.ndarray:
    """Return the forces on all degrees of freedom, shape (N,)."""
    f = np.zeros(model.size)
    for name, given in preload.forces.items():
        T, blind = mean_motion(model, name, np.asarray(model.group(name).position, dtype=float))
        wrench = np.zeros(6)
        wrench[: len(given)] = given
        if blind.size and np.abs(wrench @ blind).max() > 1e-9 * np.abs(wrench).max() * np.abs(blind).max():
            raise ModelError(
                f"preload: the nodes of {name!r} cannot take this moment. Remedy: leave it out, or load a group of "
                "facets"
            )
        f += T.T @ wrench
    for name, traction in preload.tractions.items():
        f += _pattern(model, name).traction @ np.array(traction)
    for name, pressure in preload.pressures.items():
        pattern = _pattern(model, name)
        if pattern.pressure is None:
            raise ModelError(f"preload: {name!r} is a line, which has no outside. Remedy: give it a traction")
        f += pressure * pattern.pressure
    return f + _inertial_forces(model, preload)


def _inertial_forces(model: FiniteElementModel, preload: Preload) -> np.ndarray:
    """Return ``int rho N^T (g - w x (w x r))``, exact if there is a mass field."""
    g, w = np.array(preload.acceleration), np.array(preload.angular_velocity)
    if not (g.any() or w.any()):
        return np.zeros(model.size)
    mass_field = model.mass_field
    places = model.nodes if mass_field is None else mass_field.points
    acceleration = g - np.cross(w, np.cross(w, places - np.array(preload.center)))
    if mass_field is not None:
        return np.asarray(mass_field.interpolation.T @ (mass_field.mass @ acceleration).ravel())
    motion = np.zeros((len(model.nodes), len(model.components)))
    for column, component in enumerate(model.components):
        if component in TRANSLATIONS:
            motion[:, column] = acceleration[:, COMPONENTS.index(component)]
    return np.asarray(model.mass @ motion.ravel())


def _expansion(model: FiniteElementModel, strain: float) -> np.ndarray:
    """Return the free expansion of all nodes, ``strain X``, which causes no stress."""
    rows = [COMPONENTS.index(c) for c in model.components]
    full = np.zeros((len(model.nodes), 6))
    full[:, :3] = strain * model.nodes
    return full[:, rows].ravel()


def _pattern(model: FiniteElementModel, name: str) -> Any:
    if name not in model.load_patterns:
        known = ", ".join(model.load_patterns) or "none"
        raise ModelError(
            f"preload: this model has no surface or line for loads called {name!r}. It has: {known}. Remedy: "
            f"surfaces=[{name!r}] in solid_model"
        )
    return model.load_patterns[name]


def _factored(matrix: sp.csc_matrix, factorise: Factorise) -> Factorisation:
    remedy = "Remedy: hold more groups or components, so that no part can move freely"
    try:
        factors = factorise(matrix)
    except (RuntimeError, ModelError) as problem:
        raise ModelError(f"preload: what is held leaves the body free to move ({problem}). {remedy}") from problem
    u = np.cos(np.arange(matrix.shape[0]))  # a fixed vector with a component along every mode
    error = np.linalg.norm(factors.solve(matrix @ u) - u) / np.linalg.norm(u)
    if not error < 1e-3:
        raise ModelError(
            f"preload: what is held leaves the body free to move (a solve is wrong by {error:.1e}). {remedy}"
        )
    return factors


def _buckling_share(K: sp.csc_matrix, geometric: sp.csc_matrix, factors: Factorisation) -> float:
    """Return the greatest s of ``-K_g x = s K x``: the body buckles at 1/s times the load.

    s <= 0: it cannot buckle.
    """
    n = K.shape[0]
    if n <= DENSE:
        return float(np.linalg.eigvals(factors.solve(-geometric.toarray())).real.max())
    inverse = spla.LinearOperator((n, n), matvec=factors.solve, dtype=float)
    # with K added the values are 1 + s, so that the tolerance is relative to one even if all s are just below zero
    shifted = spla.eigsh(
        K - geometric, k=1, M=K, Minv=inverse, which="LA", v0=np.cos(np.arange(n)), tol=1e-5, return_eigenvectors=False
    )
    return float(shifted[0]) - 1.0


def _held(name: str, given: Held) -> dict[str, float]:
    pairs = dict(given) if isinstance(given, Mapping) else dict.fromkeys(given, 0.0)
    if not pairs or any(component not in COMPONENTS for component in pairs):
        raise ModelError(
            f"preload: {name!r} is held in {given!r}. Remedy: components among {', '.join(COMPONENTS)}, or a dict of "
            "them to displacements"
        )
    return {c: _vector(f"displacement of {name!r} in {c}", [value], ((1,),))[0] for c, value in pairs.items()}


def _vector(label: str, value: Any, shapes: Sequence[tuple[int, ...]]) -> tuple[float, ...]:
    vector = numbers(value)
    if vector.shape not in shapes or not np.isfinite(vector).all():
        wanted = " or ".join(str(shape[0]) for shape in shapes)
        raise ModelError(f"preload: {label} is {value!r}. Remedy: {wanted} finite number(s), in SI units")
    return tuple(vector.tolist())
