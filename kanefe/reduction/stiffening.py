"""Motion-induced stiffening: the second-order displacement of a body, from unit loads and their geometric stiffness.

Linear elasticity in G lacks the foreshortening ``u2`` of parts that bend or rotate. Let the strain be of second order,
``e(u) + 1/2 g(u, u)``; given the coordinates eta, the displacement ``u2 = 1/2 eta^T H eta`` that costs least energy
solves ``K u2 = -1/2 int C g(u, u) : e(v)``. It takes the cubic terms out of the elastic energy altogether, and by
reciprocity with the static state (u_l, stress s_l) of a unit load f_l its work is a geometric stiffness:

    f_l . u2 = 1/2 eta^T H_l eta,  H_l = -Psi^T K_g(s_l) Psi + sum_n Theta_n^T D_n Theta_n + sum_p Theta_p^T E_p Theta_p

Parts that turn rigidly by theta (the patch of an interface, the section of a beam) move their points by
``theta x r + 1/2 theta x (theta x r)``. Their second terms do work too: against the forces ``F = K u_l - f_l`` with
which a tie holds the nodes of its patch, and with the load itself at the points of a section. With ``A = sum r F^T``

    D = tr(A) I - sym(A),        E = sym(A) - tr(A) I   (there r is the arm in the section and F the load)

so that rigid rotations are not stiffened: for a body that rotates by theta, ``f . u2 = 1/2 f . (theta x (theta x X))``.
The deviation of the nodes of a patch from the motion of its frame rotates with the frame.

Uniform fields (rho e_b) and linear ones (rho X_a e_b) span all inertia loads: 3 accelerations (and gravity), 6 products
of angular speeds, 3 angular accelerations. Loads on interfaces and load patterns have unit loads of their own.
(Wallrapp & Schwertassek, "Representation of geometric stiffening in multibody system simulation", Int. J. Numer. Meth.
Engng 32 (1991) 1833-1850, without the second terms.)
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np
import scipy.sparse as sp

from kanefe.bodies.flexible import FlexibleBody
from kanefe.errors import ModelError
from kanefe.fe_model.load_pattern import LoadPattern
from kanefe.fe_model.model import COMPONENTS, TRANSLATIONS, FiniteElementModel, rigid_motion
from kanefe.fe_model.statics import StaticProblem
from kanefe.fe_model.ties import Tie

StiffeningLevel = Literal["none", "inertial", "full"]

INERTIAL_LOADS = (*TRANSLATIONS, *(a + b for a in TRANSLATIONS for b in TRANSLATIONS))
"""Names of the unit inertia loads: "b" is rho e_b, "ab" is rho X_a e_b."""


@dataclass(frozen=True, eq=False)
class Stiffening:
    """Second-order displacement of a body with K coordinates, weighted by unit loads; symmetric in the last two axes.

    Attributes
    ----------
    first : ndarray, shape (3, K, K)
        int rho H_b, kg per coordinate squared times m.
    second : ndarray, shape (3, 3, K, K)
        int rho X_a H_b.
    interfaces : dict of str to ndarray, shape (6, K, K)
        H of the translation and rotation vector of each interface frame. Empty with "inertial".
    patterns : dict of str to ndarray, shape (3, K, K)
        int H_b dA of each load pattern. Empty with "inertial".
    pressures : dict of str to ndarray, shape (K, K)
        -int H . n dA of each surface whose change with the displacements is known. Empty with "inertial".
    """

    first: np.ndarray
    second: np.ndarray
    interfaces: dict[str, np.ndarray] = field(default_factory=dict)
    patterns: dict[str, np.ndarray] = field(default_factory=dict)
    pressures: dict[str, np.ndarray] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class _UnitLoads:
    """Unit loads, one for each column.

    Attributes
    ----------
    names : list of str
    nodal : ndarray, shape (N, m)
        Forces on the degrees of freedom of the model.
    tied : ndarray, shape (tied, m)
        Forces on the tied coordinates, in addition to the nodal ones: loads on interface frames.
    points : ndarray, shape (3 P, m)
        Distribution of the nodal forces over the points of the mass field.
    """

    names: list[str]
    nodal: np.ndarray
    tied: np.ndarray
    points: np.ndarray


def check_stiffening(level: str, model: FiniteElementModel) -> None:
    """Refuse a stiffening that is unknown, or not possible for the model.

    Raises
    ------
    ModelError
        The level is none of "none", "inertial", "full", or the model has no geometric stiffness (or not all of it).
    """
    if not isinstance(level, str) or level not in get_args(StiffeningLevel):
        raise ModelError(f"stiffening={level!r} is not possible. Remedy: one of 'none', 'inertial', 'full'")
    if level == "none" or model.stress_stiffness is not None:
        return
    source = model.provenance.get("source", "this model")
    if model.geometric_stiffness is None:
        raise ModelError(
            f"stiffening={level!r} was asked, but {source} has no geometric stiffness. Remedy: stiffening='none', a "
            "body made of a mesh or of beams, or model_from_matrices(..., geometric_stiffness={...})"
        )
    if level == "full":
        raise ModelError(
            f"stiffening='full' was asked, but {source} has the geometric stiffness of inertia loads only. "
            "Remedy: stiffening='inertial', or model_from_matrices(..., stress_stiffness=...)"
        )


def second_order_motion(problem: StaticProblem, basis: np.ndarray, level: StiffeningLevel) -> Stiffening:
    """Return the second-order displacement of a body.

    Parameters
    ----------
    problem : StaticProblem
        Statics of the body as it is held in G.
    basis : ndarray, shape (tied, K)
        All coordinates of the body, in tied coordinates.
    level : "inertial" or "full"
        Unit loads: those of inertia, or also those on interfaces and load patterns.
    """
    model, K = problem.model, basis.shape[1]
    inertial = _second_order(problem, _inertia_loads(model, problem.size), basis)
    found = Stiffening(inertial[:3], inertial[3:].reshape(3, 3, K, K))
    if level == "full":
        for tie in problem.ties.ties:
            found.interfaces[tie.name] = _second_order(problem, _frame_loads(problem, tie), basis)
        for name, pattern in model.load_patterns.items():
            found.patterns[name] = _second_order(problem, _pattern_loads(name, pattern.traction, problem), basis)
            if pattern.pressure_change is not None and pattern.pressure is not None:
                unit = _pattern_loads(name, pattern.pressure[:, None], problem)
                found.pressures[name] = _second_order(problem, unit, basis)[0]
    return found


def stiffened(body: FlexibleBody, found: Stiffening) -> FlexibleBody:
    """Return the body with its second-order motion."""
    return replace(
        body,
        moments=replace(body.moments, quadratic_first=found.first, quadratic_second=found.second),
        interfaces=tuple(replace(f, quadratic=found.interfaces.get(f.name)) for f in body.interfaces),
        load_patterns=tuple(_stiffened_pattern(p, found) for p in body.load_patterns),
    )


def _stiffened_pattern(pattern: LoadPattern, found: Stiffening) -> LoadPattern:
    change, by_stress = pattern.pressure_change, found.pressures.get(pattern.name)
    if change is not None and by_stress is not None:
        change = np.vstack((change[:6], change[6:] + by_stress))
    return replace(pattern, quadratic_first=found.patterns.get(pattern.name), pressure_change=change)


def _second_order(problem: StaticProblem, loads: _UnitLoads, coordinates: np.ndarray) -> np.ndarray:
    """Return H_l of each load, shape (m, K, K)."""
    model, T = problem.model, problem.ties.transformation
    basis = np.asarray(T @ coordinates)
    tied = T.T @ loads.nodal + loads.tied
    nodal, points = loads.nodal, loads.points
    if problem.rigid_count:
        motion = T @ (problem.rigid_modes @ (problem.rigid_modes.T @ tied))
        nodal = nodal - model.mass @ motion
        if model.mass_field is not None:
            points = points - _weighted(model.mass_field.mass, model.mass_field.interpolation @ motion)
    u = T @ problem.solve(tied)
    held = model.stiffness @ u - nodal
    # displacements whose forces are below this are round-off
    scale = 1e-12 * np.abs(loads.nodal).sum(axis=0) + 1e-12 * np.abs(loads.tied).sum(axis=0)
    stiffness = float(np.median(model.stiffness.diagonal()))
    H = np.zeros((len(loads.names), basis.shape[1], basis.shape[1]))
    for number, name in enumerate(loads.names):
        if np.abs(u[:, number]).max(initial=0.0) * stiffness > scale[number]:
            H[number] -= basis.T @ (_geometric_stiffness(model, name, u[:, number], points[:, number]) @ basis)
        H[number] += _turned_patches(problem, held[:, number], coordinates, basis)
        H[number] += _turned_sections(model, points[:, number], basis)
    return 0.5 * (H + H.transpose(0, 2, 1))


def _geometric_stiffness(model: FiniteElementModel, name: str, u: np.ndarray, load: np.ndarray) -> sp.csr_matrix:
    if model.stress_stiffness is not None:
        return model.stress_stiffness(u, load)
    given = model.geometric_stiffness or {}
    if name not in given:
        raise ModelError(
            f"the geometric stiffness of the unit inertia load {name!r} is not given (there are: "
            f"{', '.join(given) or 'none'}). Remedy: add it to geometric_stiffness; an empty sparse matrix if the body "
            "never feels this load"
        )
    return given[name]


def _inertia_loads(model: FiniteElementModel, size: int) -> _UnitLoads:
    """Return rho e_b and rho X_a e_b, as forces consistent with the mass matrix."""
    mass_field = model.mass_field
    if mass_field is not None:
        fields = np.column_stack([np.ones(len(mass_field.points)), mass_field.points])
        fields = np.einsum("pa,bc->pcab", fields, np.eye(3)).reshape(-1, 12)
        points = _weighted(mass_field.mass, fields)
        nodal = np.asarray(mass_field.interpolation.T @ points)
    else:
        nodal = np.asarray(model.mass @ _nodal_fields(model))
        points = np.zeros((0, 12))
    return _UnitLoads(list(INERTIAL_LOADS), nodal, np.zeros((size, 12)), points)


def _nodal_fields(model: FiniteElementModel) -> np.ndarray:
    """Return the motions e_b and X_a e_b of the nodes, which rotate by half the curl, shape (N, 12)."""
    fields = np.zeros((len(model.nodes), 6, 4, 3))
    fields[:, range(3), 0, range(3)] = 1.0
    for a in range(3):
        fields[:, range(3), 1 + a, range(3)] = model.nodes[:, [a]]
        b, c = (a + 1) % 3, (a + 2) % 3
        fields[:, 3 + c, 1 + a, b], fields[:, 3 + b, 1 + a, c] = 0.5, -0.5
    kept = [COMPONENTS.index(c) for c in model.components]
    return fields[:, kept].reshape(model.size, 12)


def _frame_loads(problem: StaticProblem, tie: Tie) -> _UnitLoads:
    """Return three unit forces and three unit moments on a frame, along the axes of G."""
    tied = np.zeros((problem.size, 6))
    tied[tie.rows] = tie.directions.T
    model = problem.model
    return _UnitLoads([tie.name] * 6, np.zeros((model.size, 6)), tied, np.zeros((_point_rows(model), 6)))


def _pattern_loads(name: str, forces: np.ndarray, problem: StaticProblem) -> _UnitLoads:
    """Return unit tractions along the axes of G, or a unit pressure, as forces (N, m)."""
    count = forces.shape[1]
    points = np.zeros((_point_rows(problem.model), count))
    return _UnitLoads([name] * count, np.asarray(forces, dtype=float), np.zeros((problem.size, count)), points)


def _point_rows(model: FiniteElementModel) -> int:
    return 0 if model.mass_field is None else 3 * len(model.mass_field.points)


def _weighted(mass: sp.csr_matrix, fields: np.ndarray) -> np.ndarray:
    """Return the scalar mass times vector fields of the points, shape (3 P, m)."""
    return np.asarray(mass @ fields.reshape(mass.shape[0], -1)).reshape(fields.shape)


def _turned_patches(problem: StaticProblem, held: np.ndarray, coordinates: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Return the work of the tie forces on the second-order motion of turned patches.

    sum Theta^T D Theta; and where nodes leave the rigid motion by delta (average patches, released components), this
    deviation turns with the frame: ``-lambda . (theta x delta)`` for each of them.
    """
    model = problem.model
    width, count = len(model.components), coordinates.shape[1]
    work = np.zeros((count, count))
    for tie in problem.ties.ties:
        r = model.nodes[tie.nodes] - tie.position
        force, moved = np.zeros((len(r), 3)), np.zeros((len(r), 3, count))
        for column, component in enumerate(model.components):
            if component in TRANSLATIONS:
                axis = TRANSLATIONS.index(component)
                force[:, axis], moved[:, axis] = held[tie.nodes * width + column], basis[tie.nodes * width + column]
        rigid = rigid_motion(r, np.zeros(3)) @ np.kron(np.eye(2), tie.axes)
        frame = np.zeros((6, count))
        frame[list(tie.components)] = coordinates[tie.rows]
        rest = [c for c in range(6) if c not in tie.components]
        deviation = moved.reshape(-1, count) - rigid @ frame
        if rest:  # where nodes are released, the patch may rotate also about components that are not in the frame
            frame[rest] = np.linalg.lstsq(rigid[:, rest], deviation, rcond=1e-9)[0]
            deviation -= rigid[:, rest] @ frame[rest]
        turn = tie.axes @ frame[3:]
        A = r.T @ force
        work += turn.T @ (np.trace(A) * np.eye(3) - 0.5 * (A + A.T)) @ turn
        work -= 2.0 * turn.T @ np.cross(deviation.reshape(-1, 3, count), force[:, :, None], axis=1).sum(axis=0)
    return work


def _turned_sections(model: FiniteElementModel, points: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Return the work of a load on the second-order motion of parts that turn rigidly, sum Theta^T E Theta."""
    mass_field = model.mass_field
    if mass_field is None or mass_field.turns is None or mass_field.arms is None:
        return np.zeros(())
    at = np.flatnonzero(mass_field.arms.any(axis=1))
    A = mass_field.arms[at, :, None] * points.reshape(-1, 1, 3)[at]
    E = 0.5 * (A + A.transpose(0, 2, 1)) - np.trace(A, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    rows = (3 * at[:, None] + np.arange(3)).ravel()
    turns = (mass_field.turns[rows] @ basis).reshape(-1, 3, basis.shape[1])
    return np.asarray(np.einsum("pai,pab,pbj->ij", turns, E, turns, optimize=True))
