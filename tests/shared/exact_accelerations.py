"""Accelerations of a chain of hinged links in extended precision, as a judge of long chains.

Nothing is shared with kanefe: six-vectors (angular part first) in the frame of each link, forward dynamics by
articulated bodies, checked and improved by inverse dynamics (Featherstone, "Rigid body dynamics algorithms", 2008).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

Extended = np.longdouble
AXES = {"y": 1, "z": 2}


def is_extended() -> bool:
    """Tell whether this machine computes with more than double precision."""
    return bool(np.finfo(Extended).eps < 1e-3 * np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class _Link:
    transform: np.ndarray  # (6, 6): from the parent's frame to the link's
    axis: int  # of the six components, the one along the hinge
    inertia: np.ndarray  # (6, 6) about the hinge


def exact_accelerations(
    links: list[dict[str, Any]], gravity: tuple[float, float, float], q: np.ndarray, u: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return du of a chain without applied torques, and a bound of its relative error.

    Parameters
    ----------
    links : list of dict
        "axis", "at" (hinge from the parent's hinge), "com", "mass", "inertia" (diagonal, about the centre of mass).
    gravity : (float, float, float)
        m/s2.
    q, u : ndarray, shape (links,)
        Angles in rad and speeds in rad/s.

    Returns
    -------
    du : ndarray of extended precision, shape (links,)
        rad/s2.
    error : float
        The change that a second improvement by inverse dynamics would make, relative to the largest du.
    """
    chain = [_link(link, angle) for link, angle in zip(links, q.astype(Extended), strict=True)]
    speeds = u.astype(Extended)
    still, weightless = np.zeros_like(speeds), np.zeros(3, dtype=Extended)
    g = np.array(gravity, dtype=Extended)
    du = _forward(chain, g, speeds, still)
    du -= _forward(chain, weightless, still, _inverse(chain, g, speeds, du))
    change = _forward(chain, weightless, still, _inverse(chain, g, speeds, du))
    return du, float(abs(change).max() / abs(du).max())


def _link(link: dict[str, Any], angle: Any) -> _Link:
    axis = AXES[link["axis"]]
    turned = np.eye(3, dtype=Extended)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    turned[a, a] = turned[b, b] = np.cos(angle)
    turned[a, b], turned[b, a] = np.sin(angle), -np.sin(angle)
    transform = np.zeros((6, 6), dtype=Extended)
    transform[:3, :3] = transform[3:, 3:] = turned
    transform[3:, :3] = -turned @ _skew(link["at"])
    com, mass = _skew(link["com"]), Extended(link["mass"])
    inertia = np.zeros((6, 6), dtype=Extended)
    inertia[:3, :3] = np.diag(np.array(link["inertia"], dtype=Extended)) - mass * com @ com
    inertia[:3, 3:], inertia[3:, :3] = mass * com, -mass * com
    inertia[3:, 3:] = mass * np.eye(3, dtype=Extended)
    return _Link(transform, axis, inertia)


def _skew(v: Any) -> np.ndarray:
    x, y, z = np.array(v, dtype=Extended)
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=Extended)


def _cross(v: np.ndarray) -> np.ndarray:
    """Return the matrix of v x; that of forces is its negative transpose."""
    full = np.zeros((6, 6), dtype=Extended)
    full[:3, :3] = full[3:, 3:] = _skew(v[:3])
    full[3:, :3] = _skew(v[3:])
    return full


def _outward(chain: list[_Link], u: np.ndarray) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return the accelerations that speeds alone bring at each hinge, and the forces that they need."""
    velocity = np.zeros(6, dtype=Extended)
    carried, forces = [], []
    for link, rate in zip(chain, u, strict=True):
        relative = np.zeros(6, dtype=Extended)
        relative[link.axis] = rate
        velocity = link.transform @ velocity + relative
        carried.append(_cross(velocity) @ relative)
        forces.append(-_cross(velocity).T @ (link.inertia @ velocity))
    return carried, forces


def _base(gravity: np.ndarray) -> np.ndarray:
    return np.concatenate((np.zeros(3, dtype=Extended), -gravity))


def _forward(chain: list[_Link], gravity: np.ndarray, u: np.ndarray, torques: np.ndarray) -> np.ndarray:
    carried, forces = _outward(chain, u)
    inertias = [link.inertia.copy() for link in chain]
    columns, pivots, rests = [], [], []
    for i in reversed(range(len(chain))):
        link = chain[i]
        column = inertias[i][:, link.axis].copy()
        pivot = column[link.axis]
        rest = torques[i] - forces[i][link.axis]
        if i:
            inertia = inertias[i] - np.outer(column, column) / pivot
            force = forces[i] + inertia @ carried[i] + column * (rest / pivot)
            inertias[i - 1] += link.transform.T @ inertia @ link.transform
            forces[i - 1] += link.transform.T @ force
        columns.append(column)
        pivots.append(pivot)
        rests.append(rest)
    acceleration = _base(gravity)
    du = np.zeros_like(torques)
    for i, link in enumerate(chain):
        acceleration = link.transform @ acceleration + carried[i]
        du[i] = (rests[-1 - i] - columns[-1 - i] @ acceleration) / pivots[-1 - i]
        acceleration[link.axis] += du[i]
    return du


def _inverse(chain: list[_Link], gravity: np.ndarray, u: np.ndarray, du: np.ndarray) -> np.ndarray:
    """Return the torques that accelerations need."""
    carried, forces = _outward(chain, u)
    acceleration = _base(gravity)
    for i, link in enumerate(chain):
        acceleration = link.transform @ acceleration + carried[i]
        acceleration[link.axis] += du[i]
        forces[i] = forces[i] + link.inertia @ acceleration
    torques = np.zeros_like(du)
    for i in reversed(range(len(chain))):
        torques[i] = forces[i][chain[i].axis]
        if i:
            forces[i - 1] = forces[i - 1] + chain[i].transform.T @ forces[i]
    return torques
