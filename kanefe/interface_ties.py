"""Interfaces of a finite-element model: patches of nodes tied to six-component frames.

A solid has no nodal rotations, so an interface is a patch of nodes that moves as a rigid body with a frame (RBE2).
A single node with rotations is its own frame. Each component of a frame is fixed in G or free (released).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.finite_element_model import COMPONENTS, FiniteElementModel, rigid_motion

KINDS: dict[str, tuple[str, ...]] = {"clamped": COMPONENTS, "rigid": (), "hinged": ("x", "y", "z")}
"""Components that each kind of interface fixes in G."""


@dataclass(frozen=True)
class Interface:
    """An interface whose components are fixed in G one by one.

    Parameters
    ----------
    fixed : sequence of str
        Among "x", "y", "z", "rx", "ry", "rz". All of them: clamped; none: the frame moves freely.

    Examples
    --------
    A hinge about z: ``Interface(fixed=("x", "y", "z", "rx", "ry"))``.
    """

    fixed: Sequence[str] = ()

    def __post_init__(self) -> None:
        unknown = [c for c in self.fixed if c not in COMPONENTS]
        if unknown or isinstance(self.fixed, str):
            raise ModelError(f"an interface fixes components among {', '.join(COMPONENTS)}, not {self.fixed!r}")


@dataclass(frozen=True, eq=False)
class Tie:
    """One interface in the tied coordinates.

    Attributes
    ----------
    name : str
    position : ndarray, shape (3,)
        Undeformed position of the frame in G, m.
    components : tuple of int
        Components of the frame that the patch can follow (0..5).
    fixed : tuple of int
        Which of them, as positions in `components`, are fixed in G.
    rows : ndarray of int
        Their numbers in the tied coordinates.
    """

    name: str
    position: np.ndarray
    components: tuple[int, ...]
    fixed: tuple[int, ...]
    rows: np.ndarray

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the components."""
        return tuple(COMPONENTS[c] for c in self.components)


@dataclass(frozen=True, eq=False)
class InterfaceTies:
    """The change from all degrees of freedom to interior ones followed by interface components.

    Attributes
    ----------
    transformation : csr_matrix, shape (N, tied)
    interior_dofs : ndarray of int
        Degrees of freedom of the model that are tied coordinates themselves, the first ones.
    ties : tuple of Tie
    """

    transformation: sp.csr_matrix
    interior_dofs: np.ndarray
    ties: tuple[Tie, ...]

    @property
    def interior_count(self) -> int:
        """Number of interior coordinates."""
        return len(self.interior_dofs)

    @property
    def fixed(self) -> np.ndarray:
        """Tied coordinates fixed in G, in the order of the interfaces."""
        return np.array([row for tie in self.ties for row in tie.rows[list(tie.fixed)]], dtype=int)

    def project(self, matrix: sp.csr_matrix) -> sp.csr_matrix:
        """Return ``T^T matrix T``."""
        if not self.ties:
            return sp.csr_matrix(matrix)
        return (self.transformation.T @ matrix @ self.transformation).tocsr()


def tie_interfaces(model: FiniteElementModel, interfaces: Mapping[str, str | Interface]) -> InterfaceTies:
    """Tie each named group of nodes to a frame.

    Raises
    ------
    ModelError
        If a group or kind is unknown, a group has no nodes, two interfaces share nodes, or a patch cannot follow a
        frame (collinear nodes without rotations) or a component that is to be fixed.
    """
    if not isinstance(interfaces, Mapping):
        raise ModelError(
            f"interfaces must be a dict of names to kinds, such as {{'root': 'clamped'}}, not {interfaces!r}"
        )
    width = len(model.components)
    owner: dict[int, str] = {}
    blocks, ties, start = [], [], 0
    for name, spec in interfaces.items():
        fixed_names = _fixed_components(name, spec)
        group = model.group(name)
        if len(group.nodes) == 0:
            raise ModelError(f"interface {name!r} has no nodes. Remedy: give its physical group some facets")
        for node in group.nodes:
            if node in owner:
                raise ModelError(
                    f"interfaces {owner[node]!r} and {name!r} share node {node}: a node can follow one frame only. "
                    "Remedy: leave a row of elements between them"
                )
            owner[int(node)] = name
        motion = rigid_motion(model.nodes[group.nodes], group.position, model.components)
        components = _followed_components(name, motion)
        if isinstance(spec, Interface):
            missing = [c for c in spec.fixed if COMPONENTS.index(c) not in components]
            if missing:
                raise ModelError(
                    f"interface {name!r} fixes {', '.join(missing)}, which its nodes cannot follow. Remedy: leave out "
                    f"all but {', '.join(COMPONENTS[c] for c in components)}, or give it more nodes"
                )
        dofs = (np.asarray(group.nodes)[:, None] * width + np.arange(width)).ravel()
        blocks.append((dofs, motion[:, components]))
        fixed = tuple(i for i, c in enumerate(components) if COMPONENTS[c] in fixed_names)
        ties.append((name, np.array(group.position, dtype=float), tuple(components), fixed, start))
        start += len(components)
    tied = np.concatenate([dofs for dofs, _ in blocks]) if blocks else np.zeros(0, dtype=int)
    interior = np.setdiff1d(np.arange(model.size), tied)
    columns = [
        sp.csr_matrix((np.ones(len(interior)), (interior, np.arange(len(interior)))), (model.size, len(interior)))
    ]
    for dofs, motion in blocks:
        rows, cols = np.nonzero(motion)
        columns.append(sp.csr_matrix((motion[rows, cols], (dofs[rows], cols)), (model.size, motion.shape[1])))
    return InterfaceTies(
        transformation=sp.hstack(columns, format="csr"),
        interior_dofs=interior,
        ties=tuple(
            Tie(name, position, components, fixed, len(interior) + start + np.arange(len(components)))
            for name, position, components, fixed, start in ties
        ),
    )


def _fixed_components(name: str, spec: str | Interface) -> tuple[str, ...]:
    if isinstance(spec, Interface):
        return tuple(spec.fixed)
    if spec not in KINDS:
        raise ModelError(
            f"interface {name!r} cannot be {spec!r}. Remedy: one of {', '.join(KINDS)}, or Interface(fixed=(...))"
        )
    return KINDS[spec]


def _followed_components(name: str, motion: np.ndarray) -> list[int]:
    """Return the components of a frame that move the patch; refuse a patch that cannot tell two of them apart."""
    size = np.linalg.norm(motion, axis=0)
    components = [c for c in range(6) if size[c] > 1e-9 * size.max()]
    scaled = motion[:, components] / size[components]
    if np.linalg.matrix_rank(scaled, tol=1e-8) < len(components):
        raise ModelError(
            f"the nodes of interface {name!r} lie on a line, so its frame could turn about that line without moving "
            "them. Remedy: give the interface a group of facets, or a single node"
        )
    return components
