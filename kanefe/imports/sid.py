"""Flexible bodies as Standard Input Data (SID), the exchange format of multibody programs.

A SID contains the data of a `FlexibleBody` with exact inertia: constants of order 0 and 1 in the modal coordinates. Of
the mesh it has only node frames. It does not contain terms of second order in the coordinates, except those that the
first-order terms imply (the quadratic part of J is implied by Gr of order 1; the change of mdCM, J and Gr by the
second-order displacement of a stiffened body by Ct, Cr and Oe of order 1), load patterns, cells, and the coordinates
that are fixed in G: forces there are recovered only if a single frame holds the body.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.bodies.mass_moments import MassMoments
from kanefe.bodies.wet_moments import WetMoments
from kanefe.errors import ModelError
from kanefe.fe_model.model import COMPONENTS, rigid_motion
from kanefe.frames import skew
from kanefe.imports.mass_completion import abstract_field
from kanefe.imports.self_check import STATED
from kanefe.imports.sid_file import SYMMETRIC, ZERO, SidFile, Taylor, parse_sid, sid_text
from kanefe.imports.sid_terms import AGREEMENT, moments_of_terms, terms_of_moments
from kanefe.storage.files import write_whole


@checked
def write_sid(body: FlexibleBody, path: str | Path, *, nodes: Sequence[int] = ()) -> dict[str, str]:
    """Write a body as Standard Input Data.

    Parameters
    ----------
    body : FlexibleBody
        With exact inertia (from solids or beams, not the nodal form).
    path : path
    nodes : sequence of int, optional
        Nodes of the mesh that become frames in addition to the interfaces.

    Returns
    -------
    dict of str to str
        Identifier of the node frame of each interface, and of each node as "node 7": the format has numbers only.

    Raises
    ------
    ModelError
        If the inertia of the body is the nodal approximation, or it has no free coordinates.
    FileError
        If the folder cannot be written, or the disk is full.

    Examples
    --------
    >>> frames = kf.write_sid(body, "arm.SID_FEM")  # doctest: +SKIP
    """
    count = body.free_count
    if body.bends_far:
        raise ModelError(
            "an exact beam cannot be written as SID, which has motions of first order only. Remedy: "
            "kanefe_fem.beam_body with a reduction, for small deformation"
        )
    if not isinstance(body.moments, MassMoments):
        raise ModelError(
            "only a body with exact inertia can be written as SID, this one has the nodal approximation or is not "
            "reduced. Remedy: make it from a mesh or from beams, with reduction=CraigBampton(...)"
        )
    if body.relaxation is not None or body.structural is not None:
        raise ModelError(
            "a body with a Prony series or a loss factor cannot be written as SID, which has a damping matrix alone. "
            "Remedy: materials without, and damping= of the body"
        )
    if isinstance(body.moments, WetMoments):
        raise ModelError("SID has no place for an added mass. Remedy: the body without it")
    if count == 0:
        raise ModelError("a body without free coordinates is rigid. Remedy: reduction=CraigBampton(modes=...)")
    moments = body.moments.leading(count)
    frames = [*body.interfaces, *(body.node_frame(int(node)) for node in nodes)]
    data = SidFile(
        mass=float(moments.mass),
        modes=[f"Eigen Mode {i} : {f:.9g} Hz" for i, f in enumerate(body.frequencies, 1)],
        nodes={str(i): _node_terms(frame, count) for i, frame in enumerate(frames, 1)},
        terms={
            **terms_of_moments(moments),
            "ksigma": Taylor(np.zeros((count, 1)), None, ZERO),
            "Ke": Taylor(body.stiffness[:count, :count], None, SYMMETRIC),
            "De": Taylor(body.damping[:count, :count], None, SYMMETRIC),
        },
    )
    write_whole(path, lambda file: file.write(sid_text(data).encode("ascii")))
    return {frame.name: str(i) for i, frame in enumerate(frames, 1)}


def _node_terms(frame: InterfaceFrame, count: int) -> dict[str, Taylor]:
    motion = frame.motion[:, :count]
    quadratic = None if frame.quadratic is None else frame.quadratic[:, :count, :count]
    turned = np.stack([skew(column) @ frame.axes for column in motion[3:].T], axis=2)
    return {
        "origin": Taylor(frame.position[:, None], motion[:3, None, :]),
        "phi": Taylor(motion[:3], None if quadratic is None else quadratic[:3]),
        "psi": Taylor(motion[3:], None if quadratic is None else quadratic[3:]),
        "AP": Taylor(frame.axes, turned),
    }


@checked
def read_sid(
    path: str | Path,
    *,
    names: Mapping[str, str] | None = None,
    fixed: str | Literal[False] | None = None,
    expected_mass: float | None = None,
) -> FlexibleBody:
    """Return the flexible body of a file of Standard Input Data.

    Parameters
    ----------
    path : path
        In m, kg, s.
    names : dict of str to str, optional
        Names of interfaces and the identifiers of their node frames, as returned by `write_sid`. Other frames have
        their identifiers as names.
    fixed : str or False, optional
        Frame that is fixed in G and carries the body: its coupling forces can be recovered. None: the first frame that
        no mode moves; if no mode has rigid momenta (mean axes) the body floats; else a frame "reference" at
        the origin of G. False: the body floats in any case.
    expected_mass : float, optional
        kg.

    Returns
    -------
    FlexibleBody
        With the node frames as nodes and interfaces; cells and load patterns are not in a SID.

    Raises
    ------
    FileError
        If the file does not exist, is truncated, or damaged.
    ModelError
        If terms contradict each other, stiffness or mass are not those of a body, or a name is unknown.

    Warns
    -----
    SidWarning
        If a part of the inertia had to be assumed.

    Examples
    --------
    >>> body = kf.read_sid("arm.SID_FEM", names={"root": "1", "tip": "2"})  # doctest: +SKIP
    """
    data = parse_sid(path)
    count = len(data.modes)
    _check_total_mass(data.mass, expected_mass, path)
    moments = moments_of_terms(data.terms, data.mass)
    _check(data, moments, path)
    frames = _frames(data, names or {}, path)
    root = _root(frames, moments, fixed, path)
    if root is not None and root.name not in [frame.name for frame in frames]:
        frames.append(root)
    field = abstract_field(moments)
    points, point_mass, point_basis = field.points, field.mass, field.interpolation.toarray()
    fixed_count = 0
    if root is not None:
        point_basis = np.hstack((point_basis, rigid_motion(points, root.position) @ _along(root.axes)))
        fixed_count = 6
    whole = MassMoments.of_points(points, point_mass, point_basis)
    total = count + fixed_count
    if moments.quadratic_first is not None and moments.quadratic_second is not None:
        quadratics = [_padded(x, total) for x in (moments.quadratic_first, moments.quadratic_second)]
        whole = MassMoments(*list(whole.arrays().values())[:6], *quadratics)
    interfaces = tuple(_interface(frame, root, count, total) for frame in frames)
    damping = data.terms["De"].m0 if "De" in data.terms else np.zeros((count, count))
    return FlexibleBody(
        nodes=np.array([frame.position for frame in interfaces]).reshape(-1, 3),
        components=COMPONENTS,
        basis=np.concatenate([frame.motion for frame in interfaces]) if interfaces else np.zeros((0, total)),
        free_count=count,
        stiffness=_padded(data.terms["Ke"].m0, total),
        damping=np.array(damping, dtype=float),
        moments=whole,
        interfaces=interfaces,
        inertia_points=points,
        inertia_mass=point_mass,
        inertia_basis=point_basis,
        provenance={"source": f"SID {Path(path).name}", "modes": list(data.modes)},
    )


def _check_total_mass(mass: float, expected: float | None, path: str | Path) -> None:
    if not mass > 0 or (expected is not None and abs(mass - expected) > STATED * abs(expected)):
        wanted = "above zero" if expected is None else f"{expected:.6g} kg"
        raise ModelError(f"the mass in {path} is {mass:.6g} kg, it should be {wanted}. Remedy: check its units")


def _check(data: SidFile, moments: MassMoments, path: str | Path) -> None:
    """Check that the terms are those of a body with a positive mass in every motion."""
    count = len(data.modes)
    for name in ("Me", "Ke", "De"):
        if name not in data.terms:
            continue
        matrix = data.terms[name].m0
        scale = abs(matrix).max(initial=0.0)
        if matrix.shape != (count, count) or abs(matrix - matrix.T).max(initial=0.0) > AGREEMENT * scale:
            raise ModelError(f"{name} in {path} must be a symmetric matrix ({count}, {count}). Remedy: export it again")
        lowest = np.linalg.eigvalsh(matrix).min(initial=np.inf)
        if lowest < -AGREEMENT * scale or (name == "Me" and lowest <= 0):
            raise ModelError(f"{name} in {path} has the negative eigenvalue {lowest:.3g}: it is not that of a body")
    generalised, _ = moments.terms(np.zeros(count), np.zeros(count), np.zeros(3))
    scale = 1.0 / np.sqrt(np.maximum(np.diag(generalised), np.finfo(float).tiny))
    lowest = np.linalg.eigvalsh(generalised * np.outer(scale, scale)).min()
    if lowest < -AGREEMENT:
        raise ModelError(
            f"mass, mdCM, J, Ct, Cr and Me in {path} are not those of a body: their mass matrix has a negative "
            "eigenvalue. Remedy: check that all are about the same frame, and their units"
        )
    stress = data.terms.get("ksigma")
    if stress is not None and np.any(stress.m0):
        raise ModelError(f"{path} is prestressed (ksigma is not zero), which is not read. Remedy: put it into Ke")


def _frames(data: SidFile, names: Mapping[str, str], path: str | Path) -> list[InterfaceFrame]:
    """Return the node frames with the motion of the free coordinates alone."""
    unknown = sorted(set(map(str, names.values())) - set(data.nodes))
    if unknown:
        there = ", ".join(data.nodes) or "none"
        raise ModelError(f"names: {path} has no node frame {', '.join(unknown)}; it has {there}")
    called = {str(identifier): name for name, identifier in names.items()}
    count = len(data.modes)
    frames = []
    for identifier, terms in data.nodes.items():
        missing = {"origin", "phi", "psi"} - set(terms)
        if missing or terms["phi"].m0.shape != (3, count) or terms["psi"].m0.shape != (3, count):
            raise ModelError(f"node {identifier} in {path} needs origin, phi and psi of {count} modes")
        motion = np.vstack((terms["phi"].m0, terms["psi"].m0))
        moved = terms["origin"].m1
        if moved is not None and abs(moved[:, 0] - motion[:3]).max() > AGREEMENT * max(abs(motion[:3]).max(), 1e-300):
            raise ModelError(f"origin of order 1 and phi of node {identifier} in {path} contradict each other")
        second = [terms[name].m1 for name in ("phi", "psi")]
        quadratic = None
        if any(m is not None and np.any(m) for m in second):
            quadratic = np.concatenate([np.zeros((3, count, count)) if m is None else m for m in second])
            quadratic = 0.5 * (quadratic + quadratic.transpose(0, 2, 1))
        axes = terms["AP"].m0 if "AP" in terms and np.any(terms["AP"].m0) else np.eye(3)
        if abs(axes @ axes.T - np.eye(3)).max() > AGREEMENT:
            raise ModelError(f"AP of node {identifier} in {path} is not a rotation matrix")
        name = called.get(identifier, identifier)
        frames.append(InterfaceFrame(name, terms["origin"].m0[:, 0], motion, quadratic=quadratic, axes=axes))
    return frames


def _root(
    frames: list[InterfaceFrame], moments: MassMoments, fixed: str | Literal[False] | None, path: str | Path
) -> InterfaceFrame | None:
    """Return the frame that is fixed in G; None for a body in its mean axes."""
    if fixed is False:
        return None
    largest = max([abs(f.motion).max(initial=0.0) for f in frames], default=0.0)
    still = [f for f in frames if abs(f.motion).max(initial=0.0) <= 1e-9 * largest]
    if fixed is not None:
        chosen = next((f for f in frames if f.name == fixed), None)
        if chosen is None or chosen not in still:
            reason = "has no node frame" if chosen is None else "has modes that move its node frame"
            known = ", ".join(f.name for f in still) or "none"
            raise ModelError(f"{path} {reason} {fixed!r}. Remedy: fixed= one of those that no mode moves ({known})")
        return chosen
    if still:
        return still[0]
    rest = np.zeros(moments.shape_first.shape[1])
    generalised, _ = moments.terms(rest, rest, np.zeros(3))
    scale = 1.0 / np.sqrt(np.diag(generalised))
    coupling = (generalised * np.outer(scale, scale))[:6, 6:]
    if abs(coupling).max(initial=0.0) < AGREEMENT:
        return None
    return InterfaceFrame("reference", np.zeros(3), np.zeros((6, len(rest))))


def _along(axes: np.ndarray) -> np.ndarray:
    """Return the matrix (6, 6) from motions along axes to motions along those of G."""
    return np.kron(np.eye(2), axes)


def _interface(frame: InterfaceFrame, root: InterfaceFrame | None, count: int, total: int) -> InterfaceFrame:
    """Return a frame with the motion of all coordinates: free ones, and those of the frame that is fixed in G."""
    motion = np.zeros((6, total))
    motion[:, :count] = frame.motion
    if root is not None:
        motion[:, count:] = rigid_motion(frame.position[None], root.position, COMPONENTS) @ _along(root.axes)
    holds = root is not None and frame.name == root.name
    return InterfaceFrame(
        frame.name,
        frame.position,
        motion,
        fixed_components=tuple(range(6)) if holds else (),
        fixed_columns=tuple(range(count, total)) if holds else (),
        quadratic=None if frame.quadratic is None else _padded(frame.quadratic, total),
        axes=frame.axes,
    )


def _padded(matrix: np.ndarray, size: int) -> np.ndarray:
    """Return matrices with rows and columns of zeros added to `size` in the last two axes."""
    room = size - matrix.shape[-1]
    return np.pad(matrix, [(0, 0)] * (matrix.ndim - 2) + [(0, room), (0, room)])
