"""Reduced bodies as superelements of other programs: matrices over the motion of interfaces, and modes with these held.

The coordinates of a body are those that suit Kane's equations. A superelement has the six motions u of each boundary
node and modal coordinates q (Craig & Bampton 1968). With B the motion of the boundary by the coordinates eta,

    eta = S u + N q,    B S = 1,    B N = 0,    N^T K S = 0,

so S are the static shapes of unit motions and N the modes with the boundary held: a change of coordinates, which loses
nothing unless modes are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.bodies.mass_moments import MassMoments
from kanefe.errors import ModelError
from kanefe.imports.superelement_text import FORMS, Superelement
from kanefe.storage.files import write_whole
from kanefe.storage.scipy_later import scipy

INDEPENDENT = 1e-9
"""Smallest singular value of the motion of a boundary that moves by itself, relative to the largest."""

RIGID = 1e-8
"""Largest stiffness against a rigid motion, relative to the largest there is."""


@checked
def write_superelement(
    body: FlexibleBody,
    path: str | Path,
    form: Literal["openfast", "nastran", "abaqus"],
    *,
    boundary: Sequence[str] | None = None,
    modes: int | None = None,
) -> dict[str, int]:
    """Write a body as a superelement: mass, damping and stiffness over its interfaces and modes with these held.

    ============  ====================================================================================================
    "openfast"    the file of ExtPtfm (Guyan and Craig-Bampton) with one interface of six motions, and loads of zero
    "nastran"     a bulk data file: GRID, SPOINT for modes, and DMIG cards KAAX, MAAX and BAAX (K2GG, M2GG, B2GG)
    "abaqus"      a linear ``*USER ELEMENT`` with ``*MATRIX``: a node for each interface, and one of freedom 1 for modes
    ============  ====================================================================================================

    Parameters
    ----------
    body : FlexibleBody
        With exact inertia, and a reduction that has static shapes of the interfaces, such as `CraigBampton`.
    path : path
    form : {"openfast", "nastran", "abaqus"}
    boundary : sequence of str, optional
        Interfaces that become nodes, with motions in the axes of the mesh. One that is fixed in the body's frame and
        not named stays held: the ground of a jacket. Default: all, which gives a free body; of "openfast" the one that
        is not fixed.
    modes : int, optional
        How many modes are kept, by frequency; default: all.

    Returns
    -------
    dict of str to int
        Number of the node of each interface, and of that of each mode as "mode 1".

    Raises
    ------
    ModelError
        If a name is unknown, an interface does not move by itself, or the body has no such matrices.
    FileError
        If the folder cannot be written, or the disk is full.

    Notes
    -----
    The matrices are those of small motions: what depends on the state of the body (centrifugal stiffening, inertia of
    the bent shape) is in SID and not here. Units are m, kg, s, rad.

    Examples
    --------
    >>> kf.write_superelement(jacket, "jacket_SE.dat", "openfast")  # doctest: +SKIP
    {'top': 1, 'mode 1': 1001, 'mode 2': 1002}
    """
    found = superelement(body, _boundary(body, form, boundary), modes)
    write_whole(path, lambda file: file.write(FORMS[form](found).encode("ascii", "replace")))
    return found.numbers


def _boundary(body: FlexibleBody, form: str, given: Sequence[str] | None) -> list[InterfaceFrame]:
    """Return the interfaces that become nodes."""
    if isinstance(given, str):
        raise ModelError(f"boundary must be a list of interfaces, such as [{given!r}]")
    if given is None:
        frames = [frame for frame in body.interfaces if form != "openfast" or not frame.is_held]
    else:
        frames = [body.interface(name) for name in dict.fromkeys(given)]
    if form == "openfast" and not (len(frames) == 1 and frames[0].turns):
        raise ModelError(
            "a superelement of OpenFAST has one interface, of six motions. Remedy: boundary=[one interface], of kind "
            f"'rigid' or 'clamped', not {[frame.name for frame in frames]!r}"
        )
    if not frames:
        raise ModelError("a superelement needs an interface. Remedy: interfaces= of the body, and boundary= here")
    return frames


def superelement(body: FlexibleBody, frames: Sequence[InterfaceFrame], modes: int | None = None) -> Superelement:
    """Return the matrices of a body over the motion of interfaces, and modes with these held.

    Raises
    ------
    ModelError
        As `write_superelement`.
    """
    if body.bends_far or not isinstance(body.moments, MassMoments):
        raise ModelError(
            "a superelement is made of a body with exact inertia and small deformation; this one is an exact beam, has "
            "the nodal approximation or is not reduced. Remedy: a body of solids or beams, reduction=CraigBampton(...)"
        )
    fixed = [column for frame in frames for column in frame.fixed_columns]
    columns = [*range(body.free_count), *fixed]
    if body.relaxation is not None or body.structural is not None:
        raise ModelError(
            "a superelement has a damping matrix, and no place for a Prony series or a loss factor. Remedy: materials "
            "without, and damping= of the body"
        )
    M, K = (matrix[np.ix_(columns, columns)] for matrix in (body.moments.elastic_mass, body.stiffness))
    C = _damping(body, K, len(fixed))
    rows = [(i, c) for i, frame in enumerate(frames) for c in range(6) if frame.turns or c < 3]
    B = np.array([frames[i].motion[c, columns] for i, c in rows])
    S, N = _shapes(B, K, M, [frames[i].name for i, _ in rows])
    T = np.hstack((S, N[:, : N.shape[1] if modes is None else modes]))
    M, C, K = (0.5 * (A + A.T) for A in (T.T @ M @ T, T.T @ C @ T, T.T @ K @ T))
    return Superelement(tuple(frames), tuple(rows), M, C, K)


def _shapes(B: np.ndarray, K: np.ndarray, M: np.ndarray, names: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return static shapes of unit motions of the boundary, and modes with it held, of unit mass."""
    _, values, right = np.linalg.svd(B)
    if len(values) < len(B) or values[-1] < INDEPENDENT * values[0]:
        raise ModelError(
            f"the interfaces {list(dict.fromkeys(names))} do not move by themselves: the body has no static shape for "
            "each of their motions. Remedy: reduction=CraigBampton(...), and 'clamped', 'rigid' or 'node' for them"
        )
    N = right[len(B) :].T
    S = np.linalg.pinv(B)
    if not N.shape[1]:
        return S, N
    inner = N.T @ K @ N
    S = S - N @ np.linalg.solve(inner, N.T @ K @ S)
    return S, N @ scipy.linalg.eigh(inner, N.T @ M @ N)[1]


def _damping(body: FlexibleBody, K: np.ndarray, fixed: int) -> np.ndarray:
    """Return the damping over free and fixed coordinates: of what the body moves beyond its frame, which is held."""
    k = body.free_count
    damping: np.ndarray = body.damping[:k, :k]
    if not fixed:
        return damping
    values, vectors = np.linalg.eigh(K)
    if fixed != 6 or values[5] > RIGID * values[-1]:
        raise ModelError(
            "a free superelement needs an interface with all six components fixed in the body's frame, of a reduction "
            "with static shapes. Remedy: kind 'clamped' and reduction=CraigBampton(...), or leave it out of boundary="
        )
    rigid = vectors[:, :6]
    beyond = np.hstack((np.eye(k), -rigid[:k] @ np.linalg.inv(rigid[k:])))
    return np.asarray(beyond.T @ damping @ beyond)
