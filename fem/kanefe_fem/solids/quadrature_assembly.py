"""Assembly by numpy, for cells that dolfinx does not support: serendipity bricks, wedges, pyramids, and mixtures.

``K = int B^T C B`` and ``Ms = int rho N N^T`` cell by cell, in batches, by the quadratures of `kanefe.fe_model.shapes`:
full integration, exact on cells with straight parallel sides (Abaqus' C3D20, not its C3D20R). It is about ten times
slower than compiled forms, and UFL expressions cannot be evaluated on such bodies.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.model import Cells, StressStiffness
from kanefe.fe_model.shapes import Shape, quadrature, shape
from kanefe_fem.materials.moduli import IsotropicModuli, Moduli
from kanefe_fem.solids.forms import VOIGT, mass_degree, stiffness_degree

BATCH = 2**22
"""Number of values in the largest array of a batch of cells: 32 MiB."""


class QuadratureAssembly(NamedTuple):
    """Matrices of a body in the order of the nodes given, as `kanefe_fem.solids.problem.Assembly`.

    Attributes
    ----------
    stiffness : csr_matrix, shape (n d, n d)
        K in N/m, node-major.
    mass : csr_matrix, shape (n, n)
        Scalar mass matrix in kg.
    order_of_nodes : ndarray of int, shape (n,)
    stress_stiffness : StressStiffness
    seconds : dict
        Time of each stage.
    versions : dict
    nodes, blocks
        As given.
    """

    stiffness: sp.csr_matrix
    mass: sp.csr_matrix
    order_of_nodes: np.ndarray
    stress_stiffness: StressStiffness
    seconds: dict[str, float]
    versions: dict[str, str]
    nodes: np.ndarray
    blocks: Sequence[Cells]

    def stiffness_with(self, moduli: Moduli) -> sp.csr_matrix:
        """Return the stiffness with other moduli."""
        found = _stiffness(self.nodes, self.blocks, moduli)
        found.eliminate_zeros()
        return found

    def mass_with(self, density: np.ndarray) -> sp.csr_matrix:
        """Return the scalar mass matrix with other densities (m,)."""
        return _mass(self.nodes, self.blocks, density)


def assemble_by_quadrature(
    nodes: np.ndarray, blocks: Sequence[Cells], moduli: Moduli, density: np.ndarray
) -> QuadratureAssembly:
    """Assemble stiffness and scalar mass of a linear elastic body of cells of any shapes.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        m; all are used.
    blocks : sequence of Cells
        All of the same dimension d.
    moduli : IsotropicModuli or AnisotropicModuli
        Moduli of each cell, in the order of the blocks.
    density : ndarray, shape (m,)
        kg/m3 (times the thickness in 2D).
    """
    dimension = shape(blocks[0].kind).dimension
    C = _matrices(moduli, dimension)
    clock = [time.perf_counter()]
    K = _stiffness(nodes, blocks, moduli)
    clock.append(time.perf_counter())
    M = _mass(nodes, blocks, density)
    clock.append(time.perf_counter())

    def stress_stiffness(displacement: np.ndarray, load: np.ndarray | None = None) -> sp.csr_matrix:
        u = np.asarray(displacement).reshape(len(nodes), dimension)

        def geometric(element: Shape, nodes_of: np.ndarray, cells: slice) -> np.ndarray:
            total = np.zeros((len(nodes_of), nodes_of.shape[1], nodes_of.shape[1]))
            x, own = nodes[nodes_of][:, :, :dimension], u[nodes_of].reshape(len(nodes_of), -1)
            for gradient, weight in zip(*_rule(element), strict=True):
                by_x, jacobian = _jacobian(x, gradient)
                stress = np.einsum("mij,mj->mi", C[cells], np.einsum("mij,mj->mi", _strains(by_x), own))
                s = _tensor(stress, dimension)
                total += by_x @ ((weight * jacobian)[:, None, None] * s) @ np.swapaxes(by_x, 1, 2)
            return total

        scalar = _assembled(blocks, len(nodes), 1, geometric)
        return sp.kron(scalar, sp.identity(dimension), format="csr")

    seconds = dict(zip(("assemble stiffness", "assemble mass"), np.diff(clock).tolist(), strict=True))
    versions = {"numpy": np.__version__}
    return QuadratureAssembly(K, M, np.arange(len(nodes)), stress_stiffness, seconds, versions, nodes, blocks)


def _stiffness(nodes: np.ndarray, blocks: Sequence[Cells], moduli: Moduli) -> sp.csr_matrix:
    """Return K, shape (n d, n d)."""
    dimension = shape(blocks[0].kind).dimension
    C = _matrices(moduli, dimension)

    def of_cells(element: Shape, nodes_of: np.ndarray, cells: slice) -> np.ndarray:
        total = np.zeros((len(nodes_of), nodes_of.shape[1] * dimension, nodes_of.shape[1] * dimension))
        for gradient, weight in zip(*_rule(element), strict=True):
            by_x, jacobian = _jacobian(nodes[nodes_of][:, :, :dimension], gradient)
            B = _strains(by_x)
            total += np.swapaxes(B, 1, 2) @ ((weight * jacobian)[:, None, None] * (C[cells] @ B))
        return total

    return _assembled(blocks, len(nodes), dimension, of_cells)


def _mass(nodes: np.ndarray, blocks: Sequence[Cells], density: np.ndarray) -> sp.csr_matrix:
    """Return the scalar mass matrix, shape (n, n)."""
    dimension = shape(blocks[0].kind).dimension

    def of_cells(element: Shape, nodes_of: np.ndarray, cells: slice) -> np.ndarray:
        points, weights = quadrature(element.kind, mass_degree(element, element))
        x = nodes[nodes_of][:, :, :dimension]
        jacobians = np.stack([_jacobian(x, gradient)[1] for gradient in element.gradients(points)], axis=1)
        N = element.values(points)
        return np.einsum("mp,pi,pj->mij", density[cells, None] * weights * jacobians, N, N, optimize=True)

    return _assembled(blocks, len(nodes), 1, of_cells)


def _matrices(moduli: Moduli, dimension: int) -> np.ndarray:
    """Return the stiffness of each cell in the order of `VOIGT`, shape (m, 6, 6), or (m, 3, 3) in the plane."""
    if not isinstance(moduli, IsotropicModuli):
        return moduli.matrices
    size = len(VOIGT[dimension])
    C = np.zeros((len(moduli.lame), size, size))
    C[:, :dimension, :dimension] = moduli.lame[:, None, None]
    C[:, range(size), range(size)] += moduli.shear[:, None] * np.where(np.arange(size) < dimension, 2.0, 1.0)
    return C


def _assembled(
    blocks: Sequence[Cells], count: int, width: int, of_cells: Callable[[Shape, np.ndarray, slice], np.ndarray]
) -> sp.csr_matrix:
    """Return the sum of cell matrices, with `width` degrees of freedom per node."""
    total = sp.csr_matrix((count * width, count * width))
    start = 0
    for block in blocks:
        element = shape(block.kind)
        size = max(1, BATCH // (width * len(element.nodes)) ** 2)
        for first in range(0, len(block.nodes), size):
            nodes_of = block.nodes[first : first + size]
            values = of_cells(element, nodes_of, slice(start + first, start + first + len(nodes_of)))
            dofs = (nodes_of[:, :, None] * width + np.arange(width)).reshape(len(nodes_of), -1)
            rows, columns = np.repeat(dofs, dofs.shape[1], axis=1), np.tile(dofs, (1, dofs.shape[1]))
            total = total + sp.coo_matrix((values.ravel(), (rows.ravel(), columns.ravel())), total.shape).tocsr()
        start += len(block.nodes)
    return (0.5 * (total + total.T)).tocsr()


def _rule(element: Shape) -> tuple[np.ndarray, np.ndarray]:
    """Return the gradients of the shape functions at the points of the stiffness, and the weights."""
    points, weights = quadrature(element.kind, stiffness_degree(element, element))
    return element.gradients(points), weights


def _jacobian(x: np.ndarray, gradient: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return dN/dx (m, nodes, d) and the determinants (m,) from dN/ds (nodes, d)."""
    J = np.swapaxes(x, 1, 2) @ gradient
    return gradient @ np.linalg.inv(J), np.linalg.det(J)


def _strains(by_x: np.ndarray) -> np.ndarray:
    """Return B: engineering strains in the order of `VOIGT` from the degrees of freedom, node-major."""
    m, count, d = by_x.shape
    B = np.zeros((m, len(VOIGT[d]), count, d))
    for row, (a, b) in enumerate(VOIGT[d]):
        B[:, row, :, b] = by_x[:, :, a]
        B[:, row, :, a] = by_x[:, :, b]
    return B.reshape(m, len(VOIGT[d]), -1)


def _tensor(stress: np.ndarray, dimension: int) -> np.ndarray:
    s = np.empty((len(stress), dimension, dimension))
    for row, (a, b) in enumerate(VOIGT[dimension]):
        s[:, a, b] = s[:, b, a] = stress[:, row]
    return s
