"""Matrices with six rows a node, of solids and shells, as programs export them: empty where elements know no turn."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import scipy.linalg


@dataclass(eq=False)
class Exported:
    """Matrices of nodes with six rows each, and the nodes that are held."""

    points: np.ndarray
    root: list[int]
    K: np.ndarray = field(init=False)
    M: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.K, self.M = np.zeros((2, 6 * len(self.points), 6 * len(self.points)))

    def add(self, nodes: list[int], K: np.ndarray, M: np.ndarray, turn: np.ndarray | None = None) -> None:
        """Add an element with six rows a node, whose axes are the columns of `turn`."""
        rows = (6 * np.array(nodes)[:, None] + np.arange(6)).ravel()
        A = np.kron(np.eye(2 * len(nodes)), np.eye(3) if turn is None else turn)
        self.K[np.ix_(rows, rows)] += A @ K @ A.T
        self.M[np.ix_(rows, rows)] += A @ M @ A.T

    def turned(self, turn: np.ndarray) -> Exported:
        """The same body in other axes."""
        other = Exported(self.points @ turn.T, self.root)
        other.add(list(range(len(self.points))), self.K, self.M, turn)
        return other

    def write(self, folder: Path) -> tuple[dict[int, np.ndarray], Path, Path]:
        """Nodes, K and M as files of lines of node, number, node, number, value."""
        paths = []
        for name, A in (("K", self.K), ("M", self.M)):
            entries = zip(*np.nonzero(np.tril(A)), strict=True)
            lines = [f"{i // 6 + 1},{i % 6 + 1},{j // 6 + 1},{j % 6 + 1},{float(A[i, j])!r}" for i, j in entries]
            paths.append(folder / f"{name}.mtx")
            paths[-1].write_text("\n".join([*lines, ""]))
        return {i + 1: x for i, x in enumerate(self.points)}, paths[0], paths[1]

    def clamped_frequencies(self, count: int) -> np.ndarray:
        """Oracle, Hz: all rows of the root held, rows without stiffness left out, those without mass condensed."""
        held = (6 * np.array(self.root)[:, None] + np.arange(6)).ravel()
        free = np.setdiff1d(np.flatnonzero(self.K.diagonal()), held)
        K, M = self.K[np.ix_(free, free)], self.M[np.ix_(free, free)]
        light = M.diagonal() == 0
        heavy = ~light
        across = K[np.ix_(heavy, light)]
        K = K[np.ix_(heavy, heavy)] - across @ np.linalg.solve(K[np.ix_(light, light)], across.T)
        squares = scipy.linalg.eigh(K, M[np.ix_(heavy, heavy)], eigvals_only=True, subset_by_index=(0, count - 1))
        return np.asarray(np.sqrt(squares) / (2 * np.pi))


def brick(sides: tuple[float, float, float], E: float = 7e10, nu: float = 0.3) -> np.ndarray:
    """K of a trilinear brick by 2 x 2 x 2 points, three rows a corner, corners in the order of their places."""
    D = np.pad(nu * np.ones((3, 3)), (0, 3)) + (1 - 2 * nu) * np.diag([1, 1, 1, 0.5, 0.5, 0.5])
    D *= E / (1 + nu) / (1 - 2 * nu)
    corners = np.array(list(itertools.product((-1, 1), repeat=3)))
    K = np.zeros((24, 24))
    for g in corners / np.sqrt(3):
        f = 1 + corners * g
        slopes = [corners[:, a] * np.prod(np.delete(f, a, 1), axis=1) / 4 / sides[a] for a in range(3)]
        B = np.zeros((6, 24))
        for a in range(3):
            B[a, a::3] = slopes[a]
        for row, (a, b) in enumerate(((0, 1), (1, 2), (2, 0))):
            B[3 + row, a::3], B[3 + row, b::3] = slopes[b], slopes[a]
        K += B.T @ D @ B * np.prod(sides) / 8
    return K


def flat_shell(
    a: float, b: float, t: float, E: float = 7e10, nu: float = 0.3, rho: float = 2700.0
) -> tuple[np.ndarray, np.ndarray]:
    """K and lumped M of a rectangle in x and y without drilling stiffness: membrane, and MITC4 (Bathe and Dvorkin)."""
    corners = np.array(((-1, -1), (1, -1), (1, 1), (-1, 1)))
    plane = E / (1 - nu**2) * np.array(((1, nu, 0), (nu, 1, 0), (0, 0, (1 - nu) / 2)))
    K = np.zeros((24, 24))

    def shapes(x: float, y: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        f, g = 1 + corners[:, 0] * x, 1 + corners[:, 1] * y
        return f * g / 4, corners[:, 0] * g / (2 * a), corners[:, 1] * f / (2 * b)

    def shear(x: float, y: float, axis: int) -> np.ndarray:
        N, *slopes = shapes(x, y)
        row = np.zeros(24)
        row[2::6] = slopes[axis]
        row[(4, 3)[axis] :: 6] = (N, -N)[axis]
        return row

    for x, y in corners / np.sqrt(3):
        _, dx, dy = shapes(x, y)
        stretch, bend = np.zeros((3, 24)), np.zeros((3, 24))
        stretch[0, 0::6], stretch[1, 1::6], stretch[2, 0::6], stretch[2, 1::6] = dx, dy, dy, dx
        bend[0, 4::6], bend[1, 3::6], bend[2, 4::6], bend[2, 3::6] = dx, -dy, dy, -dx
        slip = np.array(
            (
                ((1 - y) * shear(0, -1, 0) + (1 + y) * shear(0, 1, 0)) / 2,
                ((1 - x) * shear(-1, 0, 1) + (1 + x) * shear(1, 0, 1)) / 2,
            )
        )
        G = 5 / 6 * E / 2 / (1 + nu)
        K += a * b / 4 * (t * stretch.T @ plane @ stretch + t**3 / 12 * bend.T @ plane @ bend + G * t * slip.T @ slip)
    return K, np.diag(np.tile((1.0, 1, 1, 0, 0, 0), 4)) * rho * a * b * t / 4


def solid_with_mast(nx: int = 4, n: int = 2) -> Exported:
    """A block of 0.4 x 0.1 x 0.1 m, and a mass of 1 kg with inertia on three elastic legs beyond its end."""
    count = (nx + 1, n + 1, n + 1)
    points = [(0.4 * i / nx, 0.1 * j / n, 0.1 * k / n) for i, j, k in itertools.product(*map(range, count))]
    end = len(points)
    body = Exported(np.array([*points, (0.5, 0.05, 0.05)]), [i for i in range(end) if points[i][0] == 0])
    element = np.zeros((48, 48))
    rows = (6 * np.arange(8)[:, None] + np.arange(3)).ravel()
    element[np.ix_(rows, rows)] = brick((0.4 / nx, 0.1 / n, 0.1 / n))
    lumps = np.diag(np.tile((1.0, 1, 1, 0, 0, 0), 8)) * 2700 * 0.004 / (nx * n * n) / 8
    for cell in itertools.product(range(nx), range(n), range(n)):
        corners = np.array(cell) + list(itertools.product((0, 1), repeat=3))
        body.add(np.ravel_multi_index(tuple(corners.T), count).tolist(), element, lumps)
    for j, k in ((n // 2, n // 2), (0, n // 2), (n // 2, 0)):
        foot = int(np.ravel_multi_index((nx, j, k), count))
        x, y, z = body.points[end] - body.points[foot]
        gap = np.hstack((-np.eye(6), np.eye(6)))
        gap[:3, 3:6] = ((0, -z, y), (z, 0, -x), (-y, x, 0))
        body.add([foot, end], gap.T @ np.diag((5e7, 5e7, 5e7, 2e5, 2e5, 2e5)) @ gap, np.zeros((12, 12)))
    body.add([end], np.zeros((6, 6)), np.diag((1, 1, 1, 0.01, 0.01, 0.01)))
    return body


def folded_plate(n: int = 3) -> Exported:
    """Two strips of 2n x n shells, 0.4 m long, at right angles along an edge, held at one end."""
    along, width = 2 * n, 0.15
    flat = [(i / along * 0.4, j / n * width, 0.0) for i in range(along + 1) for j in range(n + 1)]
    upright = [(i / along * 0.4, 0.0, j / n * width) for i in range(along + 1) for j in range(1, n + 1)]
    points = np.array(flat + upright)
    body = Exported(points, np.flatnonzero(points[:, 0] == 0).tolist())
    K, M = flat_shell(0.4 / along, width / n, 0.004)
    for i, j in itertools.product(range(along), range(n)):
        first = i * (n + 1) + j
        body.add([first, first + n + 1, first + n + 2, first + 1], K, M)
        lower, upper = (
            [len(flat) + (i + d) * n + k if k >= 0 else (i + d) * (n + 1) for d in (0, 1)] for k in (j - 1, j)
        )
        body.add([lower[0], lower[1], upper[1], upper[0]], K, M, np.array(((1, 0, 0), (0, 0, -1), (0, 1, 0))))
    return body
