"""The self-check of imported matrices: conditions that hold for every free body.

``K R = 0`` for the six rigid motions R of the nodes and for no others; ``R^T M R`` contains mass, centre of mass and
inertia of a body, with the same mass along every axis, equal to those that the user gives. Wrong order of the nodes,
wrong units, supports, mechanisms and loose parts all violate one of these conditions.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, TypedDict

import numpy as np
import scipy.sparse as sp
import scipy.sparse.csgraph
import scipy.sparse.linalg as spla

from kanefe.errors import AccuracyWarning, ModelError, UnitWarning, outside
from kanefe.fe_model.factorise import Factorise, splu_factorise
from kanefe.fe_model.given_pattern import ROUND_OFF
from kanefe.fe_model.grounded import GroundSprings, ResistedTurns, ground_springs, resisted_turns
from kanefe.fe_model.model import COMPONENTS, TRANSLATIONS, FiniteElementModel
from kanefe.imports.alike_masses import check_alike
from kanefe.imports.lowest_modes import lowest_modes, slope_of
from kanefe.imports.mass_properties import check_moments, mass_properties

STATED = 1e-3
"""Permitted relative difference between mass properties of M and given ones: listings have four digits."""

COUNTED_SIZE = 20_000
"""Number of degrees of freedom up to which the zero modes of K are counted with scipy's own factorisation."""

WAVE_SPEEDS = (1.0, 1e5)
"""Range of wave speeds, m/s, outside which units look wrong: soft rubber has about 30, diamond 18,000."""

DENSEST = 5e4
"""Mass per volume of the bounding box above which units look wrong, kg/m3: osmium has 22,600, and no body fills its
box."""

MOTIONS = ("translation x", "translation y", "translation z", "rotation x", "rotation y", "rotation z")


class Expected(TypedDict, total=False):
    """Expected properties of the body: the keywords of `self_check`, which readers pass on."""

    expected_mass: float | None
    expected_center: Sequence[float] | None
    expected_inertia: np.ndarray | Sequence[Sequence[float]] | None
    factorise: Factorise | None


@dataclass(frozen=True)
class SelfCheck:
    """Findings of the self-check.

    Attributes
    ----------
    rigid_motions : int
        Number of rigid motions the nodes can make (six in space).
    rigid_residual : float
        Largest force of K for a unit rigid motion, relative to its largest row sum.
    zero_modes : int or None
        Number of motions that K leaves free. None: not counted, because the model is large and `factorise` not given.
    mass : float
        kg, from M and the rigid translations.
    center_of_mass : tuple of float
        In G, m.
    inertia : tuple of tuple of float
        About the origin of G, kg m2, from M and the rigid rotations.
    wave_speed : float or None
        Order of magnitude of the speed of waves through the elements, m/s.
    slope : float or None
        Root of the mean squared rotation over the mean squared displacement of the nodes, weighed by their mass, in
        the lowest elastic mode, 1/m: of bending waves their wave number. None: not counted, or no rotations.
    """

    rigid_motions: int
    rigid_residual: float
    zero_modes: int | None
    mass: float
    center_of_mass: tuple[float, ...]
    inertia: tuple[tuple[float, ...], ...]
    wave_speed: float | None
    slope: float | None

    def as_dict(self) -> dict[str, Any]:
        """Return the findings for a file."""
        return asdict(self)


def self_check(
    model: FiniteElementModel,
    *,
    expected_mass: float | None = None,
    expected_center: Sequence[float] | None = None,
    expected_inertia: np.ndarray | Sequence[Sequence[float]] | None = None,
    factorise: Factorise | None = None,
) -> SelfCheck:
    """Check a full-order model of a free body and return the findings.

    Parameters
    ----------
    model : FiniteElementModel
    expected_mass : float, optional
        kg.
    expected_center : array_like, shape (3,), optional
        Centre of mass in G, m.
    expected_inertia : array_like, shape (3, 3), optional
        About the centre of mass, in components of G, kg m2.
    factorise : callable, optional
        Factorises a symmetric positive definite sparse matrix. Default: that of scipy up to 20,000 degrees of freedom;
        larger models are checked for zero modes only if it is given.

    Raises
    ------
    ModelError
        If K resists a rigid motion or leaves another one free, if the body has loose parts, if M is not that of a
        body, or if mass, centre or inertia differ from the expected ones by more than 1e-3.

    Warns
    -----
    UnitWarning
        If waves would run slower than 1 m/s or faster than 100 km/s through the elements.
    AccuracyWarning
        If weak springs to ground hold rotations of nodes, elements resist a rigid turn a little, few entries of M
        differ between directions, or one is missing between two nodes that others in their direction have.

    Examples
    --------
    >>> import kanefe as kf
    >>> K = 100.0 * np.array([[1, 0, -1, 0], [0, 0, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 0]])
    >>> dumbbell = kf.model_from_matrices(np.eye(4), K, [[-0.5, 0, 0], [0.5, 0, 0]], components=("x", "y"))
    >>> self_check(dumbbell).rigid_motions
    3
    """
    _check_mass(model)
    _check_stated(model, expected_mass, expected_center, expected_inertia)
    springs: GroundSprings | ResistedTurns | None = ground_springs(model)
    residual, count = _check_rigid_motions(model, springs, factorise)
    if springs is None and residual > ROUND_OFF:
        springs = resisted_turns(model)
    check_moments(model)
    check_alike(model)
    _check_one_piece(model)
    zeros, lowest = _check_zero_modes(model, count, factorise, springs)
    speed = wave_speed(model)
    if speed is not None and not WAVE_SPEEDS[0] <= speed <= WAVE_SPEEDS[1]:
        warnings.warn(
            f"units look wrong: waves would run through the elements of this body at some {speed:.2g} m/s, in steel "
            "it is 5000. Remedy: nodes in m, K in N/m, M in kg; imports of a model in mm and tonnes say "
            "units='mm, t, s'",
            UnitWarning,
            stacklevel=outside(),
        )
    mass, center, inertia = mass_properties(model)
    _warn_of_density(model, mass)
    return SelfCheck(
        rigid_motions=count,
        rigid_residual=residual,
        zero_modes=zeros,
        mass=mass,
        center_of_mass=tuple(center.tolist()),
        inertia=tuple(tuple(row) for row in inertia.tolist()),
        wave_speed=speed,
        slope=None if lowest is None else slope_of(model, lowest),
    )


def wave_speed(model: FiniteElementModel) -> float | None:
    """Return the median over the nodes of ``h sqrt(K_cc / M_cc)`` with the distance h to the nearest neighbour, m/s."""
    width = len(model.components)
    rows, columns = _node_pairs(model)
    lengths = np.linalg.norm(model.nodes[rows] - model.nodes[columns], axis=1)
    apart = lengths > 0
    nearest = np.full(len(model.nodes), np.inf)
    np.minimum.at(nearest, rows[apart], lengths[apart])
    kept = [i for i, c in enumerate(model.components) if c in TRANSLATIONS]
    K = model.stiffness.diagonal()[: model.nodal_size].reshape(-1, width)[:, kept]
    M = model.mass.diagonal()[: model.nodal_size].reshape(-1, width)[:, kept]
    known = np.isfinite(nearest) & (M > 0).all(axis=1)
    if not np.any(known):
        return None
    return float(np.median(nearest[known] * np.sqrt(np.maximum(K[known] / M[known], 0.0).max(axis=1))))


def _node_pairs(model: FiniteElementModel) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs of different nodes that K couples, with repetitions."""
    width, size = len(model.components), model.nodal_size
    entries = model.stiffness[:size, :size].tocoo()
    rows, columns = entries.row // width, entries.col // width
    kept = (rows != columns) & (entries.data != 0)
    return rows[kept], columns[kept]


def _warn_of_density(model: FiniteElementModel, mass: float) -> None:
    """Warn of an impossible density in the box around the nodes; a body on a line or plane has no box."""
    size = np.ptp(model.nodes, axis=0)
    if size.min() > 1e-3 * size.max() and mass > DENSEST * size.prod():
        warnings.warn(
            f"units look wrong: {mass:.3g} kg in a box of {size[0]:.3g} x {size[1]:.3g} x {size[2]:.3g} m. Remedy: "
            "nodes in m, K in N/m, M in kg; units= of the reader is what the *file* has, such as 'mm, t, s'",
            UnitWarning,
            stacklevel=outside(),
        )


def _check_mass(model: FiniteElementModel) -> None:
    diagonal = model.mass.diagonal()
    if diagonal.min() < 0:
        raise ModelError(
            f"the mass matrix has a negative diagonal entry ({diagonal.min():.3g}, row {diagonal.argmin()}). Remedy: "
            "export it again, without fluid or stress"
        )
    R = model.rigid_modes()
    generalised = R.T @ (model.mass @ R)
    present = [COMPONENTS.index(c) for c in model.components if c in TRANSLATIONS]
    masses = np.diag(generalised)[present]
    if not present or masses.min() <= 0:
        raise ModelError(
            f"the body's mass by its matrix is {masses} kg along its translations: it must be above zero. "
            "Remedy: check that the mass matrix is complete"
        )
    if np.ptp(masses) > ROUND_OFF * masses.max():
        raise ModelError(
            f"the body's mass by its matrix differs between directions: {masses} kg. "
            "Remedy: check the order of components, and that no row or column is missing" + _order_hint(model)
        )
    if len(present) == 3:
        _, com, inertia = mass_properties(model)
        about_com = inertia - masses.mean() * (com @ com * np.eye(3) - np.outer(com, com))
        if not np.isfinite(about_com).all():
            raise ModelError(
                "the body's moments of inertia by its nodes and matrix overflow. Remedy: check the nodes, in m"
            )
        moments = np.linalg.eigvalsh(0.5 * (about_com + about_com.T))
        if moments[0] < -ROUND_OFF * abs(moments[2]) or moments[2] > (1 + ROUND_OFF) * (moments[0] + moments[1]):
            raise ModelError(
                f"the body's principal moments of inertia by its matrix, {moments} kg m2, are not those of a body. "
                "Remedy: check that nodes and matrix are in the same order and units" + _order_hint(model)
            )


def _check_stated(
    model: FiniteElementModel,
    expected_mass: float | None,
    expected_center: Sequence[float] | None,
    expected_inertia: np.ndarray | Sequence[Sequence[float]] | None,
) -> None:
    """Compare the mass properties from M and the rigid motions with the expected ones."""
    mass, center, about_origin = mass_properties(model)
    if expected_mass is not None and abs(mass - expected_mass) > STATED * abs(expected_mass):
        raise ModelError(
            f"the body's mass by its matrix is {mass:.6g} kg, {expected_mass:.6g} kg was expected. "
            "Remedy: check units (a model in mm and tonnes has M in tonnes)"
        )
    size = float(np.ptp(model.nodes, axis=0).max()) or 1.0
    if expected_center is not None:
        stated = np.asarray(expected_center, dtype=float)
        if stated.shape != (3,) or not np.all(np.isfinite(stated)):
            raise ModelError(f"expected_center must be three finite numbers in m, not {expected_center!r}")
        if abs(center - stated).max() > STATED * size:
            raise ModelError(
                f"the body's centre of mass by its matrix is {np.round(center, 6)} m, {stated} m was expected. "
                "Remedy: check that nodes and matrices are in the same order and units"
            )
    if expected_inertia is not None:
        stated = np.asarray(expected_inertia, dtype=float)
        if stated.shape != (3, 3) or not np.all(np.isfinite(stated)):
            raise ModelError("expected_inertia must be a finite matrix (3, 3) in kg m2 about the centre of mass")
        about_center = about_origin - mass * (center @ center * np.eye(3) - np.outer(center, center))
        if abs(about_center - stated).max() > STATED * abs(stated).max():
            raise ModelError(
                f"the body's inertia about its centre of mass by its matrix is {about_center.tolist()} kg m2, "
                f"{stated.tolist()} was expected. Remedy: check units and the order of the nodes, and the sign of "
                "products of inertia (the entries off the diagonal are -int rho x y)"
            )


def _check_rigid_motions(
    model: FiniteElementModel, springs: GroundSprings | ResistedTurns | None, factorise: Factorise | None
) -> tuple[float, int]:
    """Check that K leaves the rigid motions of the nodes free, or nearly; return the residual and their number."""
    R, kept = model.unit_rigid_modes()
    forces = np.linalg.norm(model.stiffness @ R, axis=0)
    scale = spla.norm(model.stiffness, np.inf)
    worst = int(np.argmax(forces))
    if forces[worst] > ROUND_OFF * scale:
        if springs is not None:
            raise ModelError(f"the stiffness matrix is not that of a free body: {springs}")
        only_rotations = forces[kept < 3].max(initial=0.0) <= ROUND_OFF * scale
        hint = ""
        if only_rotations and not model.generalised and (model.size <= COUNTED_SIZE or factorise is not None):
            share = _share_of_turns(model, len(kept), factorise or splu_factorise)
            if share <= STATED:
                return float(forces[worst] / scale), int(np.linalg.matrix_rank(R, tol=1e-9))
            hint = (
                f" (translations are free, so it is not a support: the nodes are in another order, or {share:.2g} of "
                "the first squared frequency is of warped quadrangles of shells)"
            )
        elif only_rotations and model.generalised:
            hint = " (translations are free: another order, or springs to ground inside, such as PARAM,K6ROT)"
        elif only_rotations:
            hint = " (translations are free, so it is not a support: the nodes are in another order)"
        raise ModelError(
            f"the stiffness matrix resists the rigid {MOTIONS[kept[worst]]} of the nodes (force "
            f"{forces[worst] / scale:.2g} of its largest). Remedy: check that nodes and matrix are in the same order"
            f"{hint}, and that the body was exported unsupported{_order_hint(model)}"
        )
    return float(forces[worst] / scale) if scale else 0.0, int(np.linalg.matrix_rank(R, tol=1e-9))


def _share_of_turns(model: FiniteElementModel, count: int, factorise: Factorise) -> float:
    """Return what resists rigid turns, relative to the first squared elastic frequency, by the diagonal of M."""
    squares, _ = lowest_modes(model, min(count + 1, model.size), factorise)
    return resisted_turns(model).square / squares[count] if len(squares) > count and squares[count] else np.inf


def _order_hint(model: FiniteElementModel) -> str:
    """Return a hint if the rows seem to be ordered component by component: all x, then all y, ..."""
    if model.generalised:
        return ""
    width, count = len(model.components), len(model.nodes)
    by_node = np.arange(model.size).reshape(width, count).T.ravel()
    R, _ = model.unit_rigid_modes()
    K = model.stiffness[by_node][:, by_node]
    free = np.linalg.norm(K @ R, axis=0).max() <= ROUND_OFF * spla.norm(model.stiffness, np.inf)
    return ". The rows seem to be all x, then all y, ...: say order='components'" if free and width > 1 else ""


def _check_one_piece(model: FiniteElementModel) -> None:
    """Check that K holds the nodes together."""
    count = len(model.nodes)
    rows, columns = _node_pairs(model)
    graph = sp.csr_matrix((np.ones(len(rows)), (rows, columns)), (count, count))
    parts, part_of = scipy.sparse.csgraph.connected_components(graph, directed=False)
    if parts > 1:
        sizes = np.bincount(part_of)
        loose = np.flatnonzero(part_of == np.argmin(sizes))
        named = ", ".join(str(n) for n in loose[:5]) + (", ..." if len(loose) > 5 else "")
        raise ModelError(
            f"the stiffness matrix leaves more than the rigid motions free: the body falls into {parts} loose parts, "
            f"the smallest has {len(loose)} node(s) ({named}). Remedy: check hinges, contacts, ties and unconnected "
            "nodes in the exporting program, or leave these nodes out"
        )


def _check_zero_modes(
    model: FiniteElementModel,
    expected: int,
    factorise: Factorise | None,
    springs: GroundSprings | ResistedTurns | None,
) -> tuple[int | None, np.ndarray | None]:
    """Check that K leaves only the rigid motions free; return their number and the lowest other one, if counted."""
    if model.size > COUNTED_SIZE and factorise is None:
        return None, None
    squares, shapes = lowest_modes(model, min(expected + 1, model.size), factorise or splu_factorise)
    lowest = shapes[:, expected] if len(squares) > expected else None
    if springs is not None and len(squares) > expected:
        share = springs.square / squares[expected] if squares[expected] else np.inf
        if share > STATED:
            raise ModelError(f"the stiffness matrix is not that of a free body: {springs}")
        if share > ROUND_OFF:
            warnings.warn(
                f"the stiffness matrix is not quite that of a free body: {springs}, before the body floats. They make "
                f"up {share:.2g} of its first squared frequency",
                AccuracyWarning,
                stacklevel=outside(),
            )
            return expected, lowest
    if len(squares) > expected and squares[expected] <= 1e3 * max(abs(squares[:expected]).max(), np.finfo(float).tiny):
        raise ModelError(
            f"the stiffness matrix leaves more than the {expected} rigid motions free: it has a mechanism, "
            "loose parts or a weak support. "
            "Remedy: check hinges, grounding springs and unconnected nodes in the exporting program"
            + (", and leave rigid motions out of the generalised coordinates" if model.generalised else "")
        )
    return expected, lowest
