"""Full-order models from matrices that another program made, checked before anything is built on them."""

from __future__ import annotations

import warnings
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import scipy.io
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from kanefe.errors import FileError, ModelError
from kanefe.finite_element_model import COMPONENTS, TRANSLATIONS, Cells, FiniteElementModel, MassField, NodeGroup
from kanefe.frames import skew
from kanefe.load_pattern import NodalPattern

Matrix: TypeAlias = sp.spmatrix | np.ndarray | str | Path

ROUND_OFF = 1e-6
"""Relative error below which a property of exported matrices counts as round-off: files often carry 7 digits."""


class NodalFormWarning(UserWarning):
    """The inertia of nodes that rotate is only approximate without the shape functions."""


def model_from_matrices(
    mass: Matrix,
    stiffness: Matrix,
    nodes: np.ndarray | Sequence[Sequence[float]],
    *,
    components: Sequence[str] = TRANSLATIONS,
    damping: Matrix | None = None,
    groups: Mapping[str, int | Sequence[int]] | None = None,
    cells: Sequence[Cells] = (),
    load_patterns: Mapping[str, NodalPattern] | None = None,
    expected_mass: float | None = None,
) -> FiniteElementModel:
    """Return a full-order model of a free body from its matrices and nodes.

    Parameters
    ----------
    mass, stiffness : sparse matrix, ndarray or path, shape (N, N)
        M and K of the unsupported body in kg and N/m; a path names a scipy .npz or a Matrix Market .mtx file.
    nodes : ndarray, shape (n, 3)
        Reference coordinates in m, in the order of the degrees of freedom.
    components : sequence of str
        Degrees of freedom of every node, in their order: among "x", "y", "z", "rx", "ry", "rz".
    damping : as mass, optional
        C in N s/m.
    groups : dict of str to node numbers, optional
        Candidates for interfaces.
    cells : sequence of Cells, optional
        For views.
    load_patterns : dict of str to NodalPattern, optional
        Surfaces and lines that can carry distributed loads: for Lagrange elements from `NodalPattern.of_nodes`.
    expected_mass : float, optional
        Mass in kg that the matrix must have.

    Returns
    -------
    FiniteElementModel
        With exact inertia if M is the same scalar matrix for every translation (Lagrange elements); else the nodal form
        of Eq. 38 is used, which a `NodalFormWarning` says where nodes rotate.

    Raises
    ------
    ModelError
        If shapes disagree, a matrix is not finite or not symmetric, K does not leave exactly the rigid motions of these
        nodes free (wrong order of nodes, a support, a mechanism), mass and inertia cannot be those of a body, or the
        forces of a load pattern have another resultant than its area and first moment say.
    FileError
        If a file is not there or cannot be read.

    Examples
    --------
    Two masses of 1 kg and a bar of 100 N/m between them, in the plane:

    >>> K = 100.0 * np.array([[1, 0, -1, 0], [0, 0, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 0]])
    >>> dumbbell = model_from_matrices(np.eye(4), K, [[-0.5, 0, 0], [0.5, 0, 0]], components=("x", "y"))
    >>> dumbbell.size
    4
    """
    points = np.array(nodes, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points) or not np.all(np.isfinite(points)):
        raise ModelError(f"nodes must be finite numbers of shape (n, 3) in m, not of shape {points.shape}")
    names = tuple(components)
    if not names or len(set(names)) != len(names) or any(c not in COMPONENTS for c in names):
        raise ModelError(f"components must be different names among {', '.join(COMPONENTS)}, not {names}")
    size = len(points) * len(names)
    M, K = _matrix(mass, "mass matrix", size), _matrix(stiffness, "stiffness matrix", size)
    C = None if damping is None else _matrix(damping, "damping matrix", size)
    model = FiniteElementModel(
        nodes=points,
        components=names,
        stiffness=K,
        mass=M,
        mass_field=_lagrange_field(M, points, names),
        damping=C,
        cells=tuple(cells),
        groups={name: _group(name, numbers, points) for name, numbers in (groups or {}).items()},
        load_patterns=dict(load_patterns or {}),
        provenance={"source": "given matrices"},
    )
    for name, pattern in model.load_patterns.items():
        _check_pattern(model, name, pattern)
    _check_mass(model, expected_mass)
    _check_rigid_motions(model)
    if model.mass_field is None and any(c.startswith("r") for c in names):
        warnings.warn(
            "nodes rotate and no shape functions are known: the inertia of the moving body is the nodal "
            "form of Eq. 38, "
            "whose gyroscopic terms are wrong by some percent for one element and better with every finer mesh",
            NodalFormWarning,
            stacklevel=2,
        )
    return model


def mass_properties(model: FiniteElementModel) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass (kg), centre of mass (3,) and inertia (3, 3) about G's origin, from M and the rigid motions.

    For a planar model only the entries its components see are meaningful (Eq. 45-48 in general form).
    """
    R = model.rigid_modes()
    generalised = R.T @ (model.mass @ R)
    present = [COMPONENTS.index(c) for c in model.components if c in TRANSLATIONS]
    mass = float(np.mean(np.diag(generalised)[present])) if present else 0.0
    c = generalised[3:, :3]  # the first moment as m c~
    first = np.array((c[2, 1] or -c[1, 2], c[0, 2] or -c[2, 0], c[1, 0] or -c[0, 1]))
    return mass, first / mass if mass else first, generalised[3:, 3:]


def _matrix(given: Matrix, what: str, size: int) -> sp.csr_matrix:
    """Return a checked CSR matrix; its symmetric part, once it is symmetric to round-off."""
    matrix = sp.csr_matrix(_read(given, what) if isinstance(given, (str, Path)) else given, dtype=float)
    if matrix.shape != (size, size):
        raise ModelError(
            f"the {what} has shape {matrix.shape}, nodes and components give {size} degrees of freedom. "
            "Remedy: check the components of a node, and that no degree of freedom was condensed"
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


def _read(path: str | Path, what: str) -> Any:
    path = Path(path)
    if not path.is_file():
        raise FileError(f"there is no file {path} for the {what}")
    try:
        if path.suffix == ".mtx":
            return scipy.io.mmread(path)
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


def _lagrange_field(M: sp.csr_matrix, points: np.ndarray, components: tuple[str, ...]) -> MassField | None:
    """Return the mass field if M is one scalar matrix for every translation, else None."""
    width = len(components)
    if not set(components) <= set(TRANSLATIONS):
        return None
    blocks = [M[a::width][:, a::width] for a in range(width)]
    scalar = sum(blocks[1:], blocks[0]) / width
    kron = sp.kron(scalar, sp.identity(width), format="csr")
    if abs(M - kron).max() > ROUND_OFF * abs(M).max():
        return None
    rows = 3 * np.repeat(np.arange(len(points)), width) + np.tile(
        [TRANSLATIONS.index(c) for c in components], len(points)
    )
    columns = np.arange(len(points) * width)
    interpolation = sp.csr_matrix((np.ones(len(rows)), (rows, columns)), (3 * len(points), len(columns)))
    return MassField(points, scalar.tocsr(), interpolation)


def _check_pattern(model: FiniteElementModel, name: str, pattern: NodalPattern) -> None:
    """Check that the nodal forces of a load pattern do the work of its resultants on rigid motions."""
    if not isinstance(pattern, NodalPattern):
        raise ModelError(f"load pattern {name!r} must be a NodalPattern, such as of NodalPattern.of_nodes")
    pressure = np.zeros(model.size) if pattern.pressure is None else np.asarray(pattern.pressure)
    if np.shape(pattern.traction) != (model.size, 3) or pressure.shape != (model.size,):
        raise ModelError(
            f"load pattern {name!r} has forces of shape {np.shape(pattern.traction)} and {pressure.shape}, the model "
            f"has {model.size} degrees of freedom. Remedy: the nodes and components of the matrices, in their order"
        )
    if not pattern.measure > 0 or not np.all(np.isfinite(np.column_stack((pattern.traction, pressure)))):
        raise ModelError(f"load pattern {name!r} must have finite forces and an area or length above zero")
    present = [TRANSLATIONS.index(c) for c in model.components if c in TRANSLATIONS]
    seen = present + [3 + a for a in range(3) if {0, 1, 2} - {a} <= set(present)]  # rotations the translations show
    given = np.vstack((pattern.measure * np.eye(3), skew(pattern.first)))[:, present]
    given = np.column_stack((given, np.concatenate((pattern.pressure_force, pattern.pressure_moment))))[seen]
    forces = np.column_stack((np.asarray(pattern.traction)[:, present], pressure))
    error = abs((model.rigid_modes().T @ forces)[seen] - given)
    reach = 1.0 + np.linalg.norm(model.nodes, axis=1).max()
    if error.max() > ROUND_OFF * pattern.measure * reach:
        raise ModelError(
            f"the nodal forces of load pattern {name!r} have another resultant than its area, first moment and "
            f"pressure say (they differ by {error.max():.3g}). Remedy: check the order of the nodes"
        )


def _check_mass(model: FiniteElementModel, expected: float | None) -> None:
    diagonal = model.mass.diagonal()
    if diagonal.min() < 0:
        raise ModelError(
            f"the mass matrix has a negative diagonal entry ({diagonal.min():.3g}, row {diagonal.argmin()})"
        )
    R = model.rigid_modes()
    generalised = R.T @ (model.mass @ R)
    present = [COMPONENTS.index(c) for c in model.components if c in TRANSLATIONS]
    masses = np.diag(generalised)[present]
    if not present or masses.min() <= 0:
        raise ModelError(f"the body's mass by its matrix is {masses} kg along its translations: it must be above zero")
    if np.ptp(masses) > ROUND_OFF * masses.max():
        raise ModelError(
            f"the body's mass by its matrix differs between directions: {masses} kg. "
            "Remedy: check the order of components, and that no row or column is missing"
        )
    if expected is not None and abs(masses.mean() - expected) > 1e-3 * abs(expected):
        raise ModelError(
            f"the body's mass by its matrix is {masses.mean():.6g} kg, {expected:.6g} kg was expected. "
            "Remedy: check units (a model in mm and tonnes has M in tonnes)"
        )
    if len(present) == 3:
        _, com, inertia = mass_properties(model)
        about_com = inertia - masses.mean() * (com @ com * np.eye(3) - np.outer(com, com))
        moments = np.linalg.eigvalsh(0.5 * (about_com + about_com.T))
        if moments[0] < -ROUND_OFF * abs(moments[2]) or moments[2] > (1 + ROUND_OFF) * (moments[0] + moments[1]):
            raise ModelError(
                f"the body's principal moments of inertia by its matrix, {moments} kg m2, belong to no body. "
                "Remedy: check that nodes and matrix are in the same order and units"
            )


def _check_rigid_motions(model: FiniteElementModel) -> None:
    """Check that K leaves the rigid motions of the nodes free, and nothing else."""
    center = model.nodes.mean(axis=0)
    R = model.rigid_modes(about=center)
    norms = np.linalg.norm(R, axis=0)
    kept = norms > 1e-12 * norms.max()
    R = R[:, kept] / norms[kept]
    forces = np.linalg.norm(model.stiffness @ R, axis=0)
    scale = spla.norm(model.stiffness, np.inf)
    worst = int(np.argmax(forces))
    if forces[worst] > ROUND_OFF * scale:
        motion = np.array(
            ["translation x", "translation y", "translation z", "rotation x", "rotation y", "rotation z"]
        )[kept]
        raise ModelError(
            f"the stiffness matrix resists the rigid {motion[worst]} of the nodes (force "
            f"{forces[worst] / scale:.2g} of its "
            "largest). Remedy: check that nodes and matrix are in the same order, and that the body was "
            "exported unsupported"
        )
    expected = int(np.linalg.matrix_rank(R, tol=1e-9))
    squares = _lowest_squares(model, expected + 1)
    if len(squares) > expected and squares[expected] <= 1e3 * max(abs(squares[:expected]).max(), np.finfo(float).tiny):
        raise ModelError(
            f"the stiffness matrix leaves more than the {expected} rigid motions free: it has a mechanism, "
            "loose parts or a weak support. "
            "Remedy: check hinges, grounding springs and unconnected nodes in the exporting program"
        )


def _lowest_squares(model: FiniteElementModel, count: int) -> np.ndarray:
    K, M = model.stiffness, model.mass
    if model.size <= 400:
        # K against the diagonal of M: M may be singular (massless rotations), and only the number of zeros counts
        scale = 1.0 / np.sqrt(np.maximum(M.diagonal(), 1e-12 * M.diagonal().max()))
        return np.sort(np.abs(np.linalg.eigvalsh(K.toarray() * np.outer(scale, scale))))[:count]
    shift = 1e-6 * K.diagonal().sum() / M.diagonal().sum()
    start = np.random.default_rng(0).standard_normal(model.size)
    return np.sort(
        np.abs(spla.eigsh(K.tocsc(), k=count, M=M.tocsc(), sigma=-shift, v0=start, return_eigenvectors=False))
    )
