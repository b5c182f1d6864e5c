"""Patches: the nodes of an interface, its frame, the components that the nodes can follow, and moments for averages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.interface import WORDS, Interface
from kanefe.fe_model.model import COMPONENTS, ROTATIONS, TRANSLATIONS, FiniteElementModel, NodeGroup, rigid_motion
from kanefe.frames import unit_vector

_SMALL = 1e-9
"""Length relative to the size of a patch or body below which it counts as zero."""


@dataclass(frozen=True, eq=False)
class Patch:
    """The nodes of an interface, its frame, and their kinematic relation.

    Attributes
    ----------
    name : str
    spec : Interface
    nodes : ndarray of int, shape (m,)
        In ascending order.
    measure : csr_matrix, shape (m, m), or None
        int N_i N_j over the facets or lines of the patch.
    position : ndarray, shape (3,)
        Position of the frame in G, m.
    axes : ndarray, shape (3, 3)
        Rotation matrix from the axes of the frame to those of G.
    follows : csc_matrix, shape (m * components of a node, h)
        Orthonormal motions of the nodes, in components of G, that follow the frame: along the axes of the interface.
    loose : csc_matrix, shape (m * components of a node, l)
        Those that do not: released ones, and rotations that only follow the neighbourhood of their node.
    owner : ndarray of int, shape (h,)
        The node that each of the first ones moves, as a position in `nodes`.
    components : tuple of int
        Components of the frame that move the nodes (0..5).
    fixed : tuple of int
        Components fixed in G, as positions in `components`.
    motion : ndarray, shape (h, components)
        R: each component of the frame in the motions that follow it.
    """

    name: str
    spec: Interface
    nodes: np.ndarray
    measure: sp.csr_matrix | None
    position: np.ndarray
    axes: np.ndarray
    follows: sp.csc_matrix
    loose: sp.csc_matrix
    owner: np.ndarray
    components: tuple[int, ...]
    fixed: tuple[int, ...]
    motion: np.ndarray


def patch_of(model: FiniteElementModel, name: str, spec: Interface) -> Patch:
    """Return the patch of an interface.

    Raises
    ------
    ModelError
        If it has no nodes, its nodes cannot follow the frame or a fixed component, or the axes do not fit.
    """
    group = _nodes(model, name, spec)
    position = group.position if spec.position is None or spec.kind == "node" else np.array(spec.position)
    axes = spec.rotation
    rows = [COMPONENTS.index(c) for c in model.components]
    turn = np.kron(np.eye(2), axes)[np.ix_(rows, rows)]
    if abs(turn @ turn.T - np.eye(len(rows))).max() > _SMALL:
        raise ModelError(
            f"the axes of interface {name!r} lead out of the components {', '.join(model.components)} that the body's "
            "nodes have. Remedy: turn them about z only"
        )
    follows, loose, owner = _directions(model, group.nodes, turn, np.isin(model.components, spec.released))
    moved = rigid_motion(model.nodes[group.nodes], position, model.components) @ np.kron(np.eye(2), axes)
    has_turns = loose.shape[1] > len(group.nodes) * len(set(spec.released) & set(model.components))
    components = _followed(name, spec, model.nodes[group.nodes], position, follows.T @ moved, has_turns)
    fixed = tuple(i for i, c in enumerate(components) if COMPONENTS[c] in _fixed(spec))
    return Patch(
        name=name,
        spec=spec,
        nodes=group.nodes,
        measure=group.measure,
        position=np.array(position, dtype=float),
        axes=axes,
        follows=follows,
        loose=loose,
        owner=owner,
        components=components,
        fixed=fixed,
        motion=np.asarray(follows.T @ moved[:, list(components)]),
    )


def _directions(
    model: FiniteElementModel, nodes: np.ndarray, turn: np.ndarray, released: np.ndarray
) -> tuple[sp.csc_matrix, sp.csc_matrix, np.ndarray]:
    """Return motions of the nodes of a patch that follow its frame and that do not, and the nodes of the first.

    `turn` leads from components along the axes of the interface to those of G, `released` is a mask of the former.
    Rotations that only follow their neighbourhood do not follow the frame.
    """
    width, count = len(turn), len(nodes)
    rows = (nodes[:, None] * width + np.arange(width)).ravel()
    free = None if model.following is None else model.following[:, rows].tocsc()
    if free is None or not free.nnz:
        each = sp.identity(count)
        owner = np.repeat(np.arange(count), np.sum(~released))
        follows, loose = (sp.kron(each, turn[:, mask], format="csc") for mask in (~released, released))
        return follows, loose, owner
    following, left_out = [turn[:, ~released]] * count, [turn[:, released]] * count
    for node in np.unique(free.tocoo().col // width):
        own = free[:, node * width : (node + 1) * width].toarray().T
        kept, sizes, _ = np.linalg.svd(own - left_out[node] @ (left_out[node].T @ own))
        left_out[node] = np.hstack((left_out[node], kept[:, : np.sum(sizes > _SMALL)]))
        following[node] = _beside(left_out[node], following[node])
    owner = np.repeat(np.arange(count), [block.shape[1] for block in following])
    kept, loose = (sp.block_diag([sp.csr_matrix(x) for x in own], format="csc") for own in (following, left_out))
    return kept, loose, owner


def _beside(basis: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return orthonormal columns of the span of others across a basis; columns that are across it stay as they are."""
    left = columns - basis @ (basis.T @ columns)
    whole = np.linalg.norm(left, axis=0) > 1.0 - _SMALL
    vectors, sizes, _ = np.linalg.svd(left[:, ~whole], full_matrices=False)
    return np.hstack((left[:, whole], vectors[:, sizes > _SMALL]))


def _nodes(model: FiniteElementModel, name: str, spec: Interface) -> NodeGroup:
    """Return the nodes of an interface as one group, in ascending order."""
    names = spec.group_names(name)
    if not names:
        return _node_at(model, name, spec)
    group = _united([model.group(given) for given in names], model.nodes)
    if len(group.nodes) == 0:
        raise ModelError(f"interface {name!r} has no nodes. Remedy: give its physical group some facets")
    if spec.kind != "node":
        return group
    if len(group.nodes) > 1:
        raise ModelError(
            f"interface {name!r} is of kind 'node', but its group has {len(group.nodes)} nodes. Remedy: a group of one "
            "node, Interface(kind='node', position=...) at a node of the mesh, or kind='rigid' or 'average'"
        )
    return NodeGroup(group.nodes, model.nodes[group.nodes[0]].copy())


def _node_at(model: FiniteElementModel, name: str, spec: Interface) -> NodeGroup:
    """Return the node of the mesh at the position of the interface."""
    distances = np.linalg.norm(model.nodes - np.array(spec.position), axis=1)
    nearest = int(distances.argmin())
    if distances[nearest] > 1e-6 * np.ptp(model.nodes, axis=0).max(initial=0.0):
        raise ModelError(
            f"interface {name!r}: there is no node at {spec.position} m; the nearest is node {nearest} at "
            f"{tuple(model.nodes[nearest].tolist())}. Remedy: give the place of a node, or groups=..."
        )
    return NodeGroup(np.array([nearest]), model.nodes[nearest].copy())


def _united(groups: list[NodeGroup], points: np.ndarray) -> NodeGroup:
    """Return groups of nodes as one, in ascending order."""
    nodes = np.unique(np.concatenate([np.asarray(group.nodes, dtype=int) for group in groups]))
    if len(groups) == 1 and np.array_equal(nodes, groups[0].nodes):
        return groups[0]
    measures = [group.measure for group in groups if group.measure is not None]
    if len(measures) < len(groups):
        position = groups[0].position if len(groups) == 1 else points[nodes].mean(axis=0)
        return NodeGroup(nodes, position)
    measure = sp.csr_matrix((len(nodes), len(nodes)))
    for group, own in zip(groups, measures, strict=True):
        coo, at = own.tocoo(), np.searchsorted(nodes, group.nodes)
        measure += sp.csr_matrix((coo.data, (at[coo.row], at[coo.col])), measure.shape)
    sizes = np.array([own.sum() for own in measures])
    return NodeGroup(nodes, sizes @ np.array([group.position for group in groups]) / sizes.sum(), measure)


def _followed(
    name: str, spec: Interface, points: np.ndarray, position: np.ndarray, motion: np.ndarray, has_turns: bool
) -> tuple[int, ...]:
    """Return the components of a frame that move the patch; refuse a patch that does not determine all of them.

    `has_turns`: some rotations of the nodes do not follow, since they have no stiffness.
    """
    size = np.linalg.norm(motion, axis=0)
    if not size.any():
        raise ModelError(f"interface {name!r} releases all that its nodes could follow. Remedy: release less")
    components = tuple(c for c in range(6) if size[c] > _SMALL * size.max())
    scaled = motion[:, components] / size[list(components)]
    if np.linalg.matrix_rank(scaled, tol=1e-8) < len(components):
        if has_turns:
            unseen = np.zeros(6)
            unseen[list(components)] = np.linalg.svd(scaled)[2][-1] / size[list(components)]
            _refuse_turn_without_stiffness(name, spec.rotation @ unseen[3:])
        _refuse_loose_turn(name, spec, points, position)
    if not isinstance(spec.fixed, str):
        missing = [c for c in spec.fixed if COMPONENTS.index(c) not in components]
        if missing:
            raise ModelError(
                f"interface {name!r} fixes {', '.join(missing)}, which its nodes cannot follow: they follow "
                f"{', '.join(COMPONENTS[c] for c in components)}. Remedy: leave out {', '.join(missing)}, or give it "
                "more nodes"
            )
    return components


def _fixed(spec: Interface) -> Sequence[str]:
    """Return the components that are fixed, as far as the nodes can follow."""
    return WORDS[spec.fixed] if isinstance(spec.fixed, str) else spec.fixed


def _refuse_loose_turn(name: str, spec: Interface, points: np.ndarray, position: np.ndarray) -> None:
    """Raise the error of a frame that could turn without moving the nodes, with the axes that would help, if any."""
    offsets = points - points.mean(axis=0)
    extent = np.linalg.norm(offsets, axis=1).max()
    if len(points) == 1 or extent == 0.0:
        raise ModelError(
            f"interface {name!r} is a single node without rotations, so its frame cannot be away from it, at "
            f"{position}. Remedy: leave out its position, or give it a group of facets"
        )
    line = np.linalg.svd(offsets)[2][0]
    if np.linalg.norm(offsets - np.outer(offsets @ line, line), axis=1).max() > 1e-6 * extent:
        raise ModelError(
            f"the nodes of interface {name!r} do not determine all components of its frame. Remedy: release less "
            f"than {', '.join(spec.released) or 'it does'}, or give it more nodes"
        )
    off = position - points.mean(axis=0)
    if np.linalg.norm(off - (off @ line) * line) > 1e-6 * extent:
        raise ModelError(
            f"the nodes of interface {name!r} lie on a line, and its frame, at {position}, does not. Remedy: leave "
            "out its position, or give the interface a group of facets"
        )
    raise ModelError(
        f"the nodes of interface {name!r} lie on a line, so its frame could turn about that line without moving them. "
        "Remedy: give the interface a group of facets, a single node, or axes of which one is along the line, such as "
        f"Interface(..., axes={_axes_along(line).tolist()}): then {ROTATIONS[0]} is left out of it"
    )


def _refuse_turn_without_stiffness(name: str, turn: np.ndarray) -> None:
    """Raise the error of a frame that could turn about an axis in G about which its nodes have no stiffness."""
    axis = unit_vector(turn, "an axis of rotation")
    raise ModelError(
        f"the frame of interface {name!r} could turn about {axis.round(6).tolist()} without moving its nodes, whose "
        "rotations about it have no stiffness, such as those of solids and about the normal of a flat shell. Remedy: "
        f"more nodes, or axes of which one is along it: Interface(..., axes={_axes_along(axis).tolist()}), then "
        f"{ROTATIONS[0]} is left out of it"
    )


def _axes_along(line: np.ndarray) -> np.ndarray:
    """Return axes of an interface of which the first is along a unit vector."""
    across = unit_vector(np.cross(line, np.eye(3)[np.argmin(abs(line))]), "a direction across")
    return np.asarray(np.column_stack((line, across, np.cross(line, across))).round(12))


def patch_moments(model: FiniteElementModel, patch: Patch) -> np.ndarray:
    """Return P = R^T W of the components that follow the frame, along its axes, shape (components, following).

    W is the L2 product over the facets (``weights="area"``), the rows and columns of the mass matrix, or one number for
    each node. Rotations of the nodes count only by mass, or where the translations leave the frame undetermined.

    Raises
    ------
    ModelError
        If there is no area, the numbers do not fit the nodes, or the weights leave a component undetermined.
    """
    motion = patch.motion
    moments = np.asarray((patch.follows.T @ _weights(model, patch) @ patch.follows @ motion).T)
    if not _determines(moments @ motion, motion):
        raise ModelError(
            f"the weights of interface {patch.name!r} leave a component of its frame undetermined. Remedy: weights "
            "above zero on at least three nodes that are not in line, or weights='uniform'"
        )
    return moments


def _determines(gram: np.ndarray, motion: np.ndarray) -> bool:
    """Return whether R^T W R is far from singular, however its components are scaled."""
    size = np.linalg.norm(motion, axis=0)
    scaled = gram / np.outer(size, size)
    squares = np.linalg.eigvalsh(0.5 * (scaled + scaled.T))
    return bool(squares[0] > 1e-12 * squares[-1])


def _weights(model: FiniteElementModel, patch: Patch) -> sp.csr_matrix:
    """Return W over all components of the nodes of a patch, in those of G."""
    rule, count, width = patch.spec.weights, len(patch.nodes), len(model.components)
    if rule == "mass":
        dofs = (patch.nodes[:, None] * width + np.arange(width)).ravel()
        return model.mass[dofs][:, dofs].tocsr()
    if rule == "area" and patch.measure is None:
        raise ModelError(
            f"interface {patch.name!r} has no facets or lines to be weighted by area. Remedy: weights='uniform', "
            "'mass', or one number for each node"
        )
    if isinstance(rule, tuple):
        if len(rule) != count:
            raise ModelError(
                f"interface {patch.name!r} has {count} nodes and {len(rule)} weights. Remedy: one for each node, in "
                "the order of their numbers"
            )
        scalar = sp.diags(np.array(rule), format="csr")
    else:
        scalar = sp.identity(count, format="csr") if rule == "uniform" or patch.measure is None else patch.measure
    moved = np.array([c in TRANSLATIONS for c in model.components])
    weights = sp.kron(scalar, np.diag(moved.astype(float)), format="csr")
    seen = patch.follows @ patch.motion
    if moved.all() or _determines(seen.T @ (weights @ seen), patch.motion):
        return weights
    # a length makes squares of rotations comparable with squares of displacements
    points = model.nodes[patch.nodes]
    length = np.linalg.norm(points - points.mean(axis=0), axis=1).max() or 1.0
    return weights + sp.kron(scalar, np.diag(length**2 * ~moved), format="csr")
