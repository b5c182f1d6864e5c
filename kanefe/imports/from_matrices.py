"""Full-order models from matrices of other programs, checked before use."""

from __future__ import annotations

import warnings
import zipfile
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, TypeAlias, Unpack, cast

import numpy as np
import scipy.sparse as sp

from kanefe.arguments import checked
from kanefe.errors import FileError, ModelError, outside
from kanefe.fe_model.damping import real_matrix
from kanefe.fe_model.given_pattern import ROUND_OFF, check_pattern
from kanefe.fe_model.load_pattern import NodalPattern
from kanefe.fe_model.model import (
    COMPONENTS,
    ROTATIONS,
    TRANSLATIONS,
    Cells,
    FiniteElementModel,
    MassField,
    NodeGroup,
    Stresses,
    StressStiffness,
)
from kanefe.frames import numbers
from kanefe.imports.given_field import check_added_mass, check_field_mass, checked_field
from kanefe.imports.mass_completion import completed_mass_field, estimated_part
from kanefe.imports.nodal_inertia import NodalFormWarning, NodalInertia, inertia_of_nodes, tell_share
from kanefe.imports.rigid_parts import NOISE
from kanefe.imports.self_check import Expected, self_check
from kanefe.imports.text import read_market
from kanefe.storage.files import regular_file

Matrix: TypeAlias = sp.spmatrix | np.ndarray | str | Path

Order: TypeAlias = Literal["nodes", "components"]


class BesideMatrices(Expected, total=False):
    """Optional data of a model besides its matrices, and expected properties: keywords of `model_from_matrices`."""

    cells: Sequence[Cells]
    load_patterns: Mapping[str, NodalPattern] | None
    geometric_stiffness: Mapping[str, Matrix] | None
    stress_stiffness: StressStiffness | None
    mass_field: MassField | NodalInertia | None
    added_mass: Matrix | None
    stresses: Stresses | None


@checked(
    "components",
    "cells",
    "geometric_stiffness",
    "stress_stiffness",
    "order",
    "expected_mass",
    "expected_center",
    "expected_inertia",
    "source",
)
def model_from_matrices(
    mass: Matrix | None,
    stiffness: Matrix,
    nodes: np.ndarray | Sequence[Sequence[float]],
    *,
    components: Sequence[str] = TRANSLATIONS,
    damping: Matrix | None = None,
    groups: Mapping[str, int | Sequence[int]] | None = None,
    order: Order = "nodes",
    generalised: int = 0,
    source: str = "given matrices",
    **more: Unpack[BesideMatrices],
) -> FiniteElementModel:
    """Return a full-order model of a free body from its matrices and nodes.

    Parameters
    ----------
    mass, stiffness : sparse matrix, ndarray or path, shape (N, N)
        M and K of the unsupported body in kg and N/m; a path names a scipy .npz or a Matrix Market .mtx file. M may be
        None with a `mass_field`.
    nodes : ndarray, shape (n, 3)
        Reference coordinates in m, in the order of the degrees of freedom.
    components : sequence of str
        Degrees of freedom of every node, in order: among "x", "y", "z", "rx", "ry", "rz".
    damping : as mass, optional
        C in N s/m.
    groups : dict of str to node numbers, optional
        Candidates for interfaces.
    order : "nodes" or "components"
        Rows of the matrices: all components of the first node, then of the second, ...; or x of all nodes, then y, ...
    generalised : int
        Number of coordinates of a superelement in addition to those of its nodes, such as fixed-boundary modes
        (Craig-Bampton): the last rows of the matrices. They must be zero in rigid motions.
    source : str
        Recorded in the provenance.
    **more
        The other parameters below.

    Other Parameters
    ----------------
    cells : sequence of Cells, optional
        For views.
    load_patterns : dict of str to NodalPattern, optional
        Surfaces and lines that can carry distributed loads: for Lagrange elements from `NodalPattern.of_nodes`.
    geometric_stiffness : dict of str to matrices as mass, optional
        For ``stiffening="inertial"``: stress stiffness matrix (tension positive) of the static stress of each unit
        load "x", "y", "z" (rho e_b) and "xx", "xy", ... (rho X_a e_b), with the interfaces fixed as in the body; for
        a floating body, under the load minus the inertia of its rigid motion.
    stress_stiffness : callable, optional
        For any stiffening: see `FiniteElementModel`. In the order "nodes".
    mass_field : MassField, optional
        Shape functions at mass points, in the order "nodes", for exact inertia where nodes rotate; its mass may be a
        vector.
    added_mass : as mass, optional
        Of a fluid around the body: see `FiniteElementModel`.
    stresses : callable, optional
        Stress recovery: see `FiniteElementModel`. In the order "nodes".
    expected_mass : float, optional
        Required mass, kg.
    expected_center : array_like, shape (3,), optional
        Required centre of mass in G, m.
    expected_inertia : array_like, shape (3, 3), optional
        Required inertia about the centre of mass, kg m2.
    factorise : callable, optional
        Factorises large matrices for the count of the zero modes: see `kanefe.imports.self_check.self_check`.

    Returns
    -------
    FiniteElementModel
        With exact inertia if M tells how points move (`kanefe.imports.nodal_inertia`): elements that interpolate
        displacements and rotations alike, beams of the static shape functions, lumped masses. Of another M, and of a
        superelement with generalised coordinates (`kanefe.imports.mass_completion`), mass, momenta and energy are exact
        and the change of the inertia with deformation is estimated, with a `NodalFormWarning` that tells how much.

    Raises
    ------
    ModelError
        If shapes disagree, a matrix is not finite or not symmetric, K does not leave exactly the rigid motions of these
        nodes free (wrong order of nodes, a support, a mechanism), mass and inertia cannot be those of a body or are
        not the expected ones, or the resultant of the forces of a load pattern differs from that of its area and
        first moment.
    FileError
        If a file does not exist or cannot be read.

    Examples
    --------
    >>> K = 100.0 * np.array([[1, 0, -1, 0], [0, 0, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 0]])
    >>> dumbbell = model_from_matrices(np.eye(4), K, [[-0.5, 0, 0], [0.5, 0, 0]], components=("x", "y"))
    >>> dumbbell.size
    4
    """
    points = _points(nodes)
    stress_stiffness, load_patterns = more.pop("stress_stiffness", None), more.pop("load_patterns", None)
    geometric_stiffness = more.pop("geometric_stiffness", None) or {}
    _check_optional(stress_stiffness, groups, load_patterns)
    names = _names(components)
    size = len(points) * len(names) + _generalised(generalised, names)
    by_node = _rows_by_node(order, len(points), len(names), size)

    def ordered(given: Matrix, what: str) -> sp.csr_matrix:
        matrix = _matrix(given, what, size)
        return matrix if by_node is None else matrix[by_node][:, by_node]

    field, read = _given_inertia(mass, more.pop("mass_field", None), points, names, generalised)
    M, K = ordered(read, "mass matrix"), ordered(stiffness, "stiffness matrix")
    C = None if damping is None else ordered(damping, "damping matrix")
    of_loads = {name: ordered(K_g, f"geometric stiffness {name!r}") for name, K_g in geometric_stiffness.items()}
    own, share = _mass_field(field, M, K, points, names, generalised)
    model = FiniteElementModel(
        nodes=points,
        components=names,
        stiffness=K,
        mass=M,
        mass_field=own,
        damping=C,
        cells=tuple(more.pop("cells", ())),
        groups={name: _group(name, numbers, points) for name, numbers in (groups or {}).items()},
        load_patterns=dict(load_patterns or {}),
        geometric_stiffness=of_loads or None,
        stress_stiffness=stress_stiffness,
        provenance={"source": source},
        generalised=generalised,
        added_mass=_fluid(more.pop("added_mass", None), ordered),
        stresses=more.pop("stresses", None),
    )
    for name, pattern in model.load_patterns.items():
        check_pattern(model, name, pattern)
    found = self_check(model, **cast(Expected, more))
    _check_entries(sp.csr_matrix(read), sp.csr_matrix(0.5 * (read + read.T)))
    return _told(replace(model, provenance={**model.provenance, "self_check": found.as_dict()}), share, source)


def _check_optional(stress_stiffness: Any, groups: Any, load_patterns: Any) -> None:
    if stress_stiffness is not None and not callable(stress_stiffness):
        raise ModelError(f"stress_stiffness must be a function of a displacement, not {stress_stiffness!r}")
    for what, named in (("groups", groups), ("load_patterns", load_patterns)):
        if named is not None and not isinstance(named, Mapping):
            raise ModelError(f"{what} must be a dict by names, not {named!r}")


def _points(nodes: np.ndarray | Sequence[Sequence[float]]) -> np.ndarray:
    points = numbers(nodes)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points) or not np.all(np.isfinite(points)):
        raise ModelError(f"nodes must be finite numbers of shape (n, 3) in m, not of shape {points.shape}")
    return points


def _given_inertia(
    mass: Matrix | None,
    field: MassField | NodalInertia | None,
    points: np.ndarray,
    names: tuple[str, ...],
    generalised: int,
) -> tuple[MassField | NodalInertia | None, sp.csr_matrix]:
    """Return the mass field, checked, and the mass matrix as given or of the field; readers check superelements'."""
    if field is not None and not isinstance(field, NodalInertia) and not generalised:
        field = checked_field(field, points, names, len(points) * len(names))
    if mass is None:
        if field is None:
            raise ModelError("there is neither a mass matrix nor a mass field. Remedy: one of them, in kg")
        return field, (field.field if isinstance(field, NodalInertia) else field).mass_matrix()
    return field, real_matrix(_read(mass, "mass matrix") if isinstance(mass, (str, Path)) else mass)


def _mass_field(
    field: MassField | NodalInertia | None,
    M: sp.csr_matrix,
    K: sp.csr_matrix,
    points: np.ndarray,
    names: tuple[str, ...],
    generalised: int,
) -> tuple[MassField | None, float]:
    """Return the given mass field, or that which M tells, and the part of M that is estimated."""
    if field is None and not generalised:
        return inertia_of_nodes(K, M, points, names)
    if isinstance(field, NodalInertia):
        return field
    if field is not None and not generalised:
        check_field_mass(field, M)
    return field, 0.0


def _fluid(given: Matrix | None, ordered: Callable[[Matrix, str], sp.csr_matrix]) -> sp.csr_matrix | None:
    if given is None:
        return None
    A = ordered(given, "added mass")
    check_added_mass(A)
    return A


def without_rotary_inertia(slope: float | None) -> str:
    """Return what a body of sheets or beams is told whose nodes turn without mass, by the slope of its lowest mode.

    A wave of the number k in a section of thickness t is ``(k t)^2 / 24`` too fast: rho t^3/12 over rho t.
    """
    text = "no rotary inertia: bending waves of length L in sections of thickness t are 1.6 (t/L)^2 too fast"
    return text + (f", the lowest mode 1 % if t is {np.sqrt(0.24) / slope:.2g} m" if slope else "")


def _told(model: FiniteElementModel, share: float, source: str) -> FiniteElementModel:
    """Return a model, told what of its inertia is estimated or not there; that of a superelement is completed."""
    told: dict[str, Any] = {"estimated_inertia": share} if share else {}
    turning = np.isin(model.components, ROTATIONS)
    if not model.generalised:
        tell_share(share, source)
        if turning.any() and not model.mass.diagonal().reshape(-1, len(turning))[:, turning].any():
            told["told"] = [without_rotary_inertia(model.provenance["self_check"]["slope"])]
    if not model.generalised or model.mass_field is not None:
        return replace(model, provenance={**model.provenance, **told})
    share = estimated_part(model)
    warnings.warn(
        f"{source} is a superelement with {model.generalised} generalised coordinates: its mass, frequencies and "
        f"momenta are exact, their change with deformation in a rotation is estimated from M ({share:.2g} of the "
        "energy of these coordinates), which is accurate if the rotation is slow compared with its lowest frequency. "
        "Remedy for fast rotation: export the full matrices, or (MYSTRAN) PHIXG and MGG too",
        NodalFormWarning,
        stacklevel=outside(),
    )
    told = {**model.provenance, "estimated_inertia": share}
    return replace(model, mass_field=completed_mass_field(model), provenance=told)


def _rows_by_node(order: Order, count: int, width: int, size: int) -> np.ndarray | None:
    """Return the rows of matrices node by node, those of generalised coordinates last; None if they are so."""
    if order == "nodes":
        return None
    if order != "components":
        raise ModelError(f"order of the rows must be 'nodes' or 'components', not {order!r}")
    by_node = np.arange(count * width).reshape(width, count).T.ravel()
    return np.append(by_node, np.arange(count * width, size))


def _names(components: Sequence[str]) -> tuple[str, ...]:
    names = tuple(components)
    if not names or len(set(names)) != len(names) or any(c not in COMPONENTS for c in names):
        raise ModelError(f"components must be different names among {', '.join(COMPONENTS)}, not {names}")
    return names


def _generalised(count: int, names: tuple[str, ...]) -> int:
    if not isinstance(count, (int, np.integer)) or count < 0:
        raise ModelError(f"generalised must be a number of coordinates, not {count!r}")
    if count and not set(TRANSLATIONS) <= set(names):
        raise ModelError(
            f"a superelement needs x, y and z of its nodes beside its generalised coordinates, not {', '.join(names)}. "
            "Remedy: export all translations of the boundary nodes"
        )
    return int(count)


def _matrix(given: Matrix, what: str, size: int) -> sp.csr_matrix:
    """Return the symmetric part of a matrix in CSR form, after checks."""
    matrix = real_matrix(_read(given, what) if isinstance(given, (str, Path)) else given)
    if matrix.shape != (size, size):
        raise ModelError(
            f"the {what} has shape {matrix.shape}, nodes and components give {size} degrees of freedom. "
            "Remedy: check the components of a node, that no degree of freedom was condensed, and generalised= of a "
            "superelement"
        )
    if not np.all(np.isfinite(matrix.data)):
        raise ModelError(f"the {what} has {np.sum(~np.isfinite(matrix.data))} entries that are not finite")
    largest = abs(matrix).max()
    asymmetry = abs(matrix - matrix.T).max()
    if asymmetry > ROUND_OFF * largest:
        raise ModelError(
            f"the {what} is not symmetric: entries differ from their mirror by up to {asymmetry:.3g} of {largest:.3g}. "
            "Remedy: export the full matrix, or mirror its triangle"
        )
    return (0.5 * (matrix + matrix.T)).tocsr()


def _check_entries(given: sp.spmatrix, M: sp.csr_matrix) -> None:
    """Check every entry of the mass matrix by those of its own rows, since those of rotations are small."""
    scale = np.sqrt(np.maximum(M.diagonal(), 0.0))
    noise = NOISE * scale.max(initial=0.0) ** 2
    for entries, least, wrong in (
        (abs(given - given.T).tocoo(), ROUND_OFF, "has another value than its mirror"),
        (abs(M).tocoo(), 1.0 + ROUND_OFF, "is larger than the root of the product of their own"),
    ):
        at = np.flatnonzero(entries.data > least * scale[entries.row] * scale[entries.col] + noise)
        if len(at):
            raise ModelError(
                f"the mass between rows {entries.row[at[0]]} and {entries.col[at[0]]} (from 0) {wrong}. Remedy: check "
                "that no entry of the mass matrix is missing or wrong"
            )


def _read(path: str | Path, what: str) -> Any:
    path = Path(path)
    if path.suffix == ".mtx":
        return read_market(path, what)
    regular_file(path, f"for the {what}")
    try:
        if path.suffix == ".npz":
            return sp.load_npz(path)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise FileError(f"cannot read the {what} from {path}: {error}. Remedy: export it again") from error
    raise FileError(f"the {what} cannot be read from a {path.suffix or 'nameless'} file. Remedy: .npz (scipy) or .mtx")


def _group(name: str, numbers: int | Sequence[int], points: np.ndarray) -> NodeGroup:
    chosen = np.atleast_1d(np.asarray(numbers))
    if chosen.dtype.kind not in "iu" or not len(chosen) or chosen.min() < 0 or chosen.max() >= len(points):
        raise ModelError(f"group {name!r} must be node numbers from 0 to {len(points) - 1}, not {numbers!r}")
    return NodeGroup(np.unique(chosen), points[np.unique(chosen)].mean(axis=0))
