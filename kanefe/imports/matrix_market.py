"""Matrices in Matrix Market files, which have no labels: the user gives the order of the rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Unpack

import numpy as np

from kanefe.arguments import checked
from kanefe.fe_model.model import COMPONENTS, TRANSLATIONS, FiniteElementModel
from kanefe.frames import numbers
from kanefe.imports.from_matrices import Order, model_from_matrices
from kanefe.imports.labelled import mirrored
from kanefe.imports.node_table import given_nodes
from kanefe.imports.self_check import Expected
from kanefe.imports.text import read_market
from kanefe.imports.units import Units, in_si, scales


@checked
def read_matrix_market(
    nodes: str | Path | np.ndarray | Sequence[Sequence[float]],
    stiffness: str | Path,
    mass: str | Path,
    *,
    components: Sequence[str] = TRANSLATIONS,
    order: Order = "nodes",
    damping: str | Path | None = None,
    groups: Mapping[str, int | Sequence[int]] | None = None,
    units: Units = "m, kg, s",
    **expected: Unpack[Expected],
) -> FiniteElementModel:
    """Return the model of matrices in Matrix Market files.

    Parameters
    ----------
    nodes : path or ndarray, shape (n, 3)
        Coordinates in the order of the rows; a path names a text file of rows label, x, y, z, taken in ascending
        labels.
    stiffness, mass, damping : path
        Files of shape (N, N), with one or both triangles.
    components : sequence of str
        Degrees of freedom of every node, in order.
    order : "nodes" or "components"
        All components of the first node first, or the first component of all nodes.
    groups : dict of str to node numbers, optional
        Row numbers in `nodes`, or labels if nodes are from a file.
    units : optional
        See `read_abaqus`.
    **expected
        See `read_abaqus`.

    Raises
    ------
    FileError
        If a file does not exist, is truncated, or in another format.
    ModelError
        If the order of the matrices differs from that of the nodes, or the self-check fails otherwise.

    Examples
    --------
    >>> arm = kf.read_matrix_market("nodes.txt", "K.mtx", "M.mtx", groups={"tip": [7, 8]})  # doctest: +SKIP
    """
    length = scales(units)[0]
    numbered = groups
    if isinstance(nodes, (str, Path)):
        table = given_nodes(nodes)
        points = table.points
        numbered = {
            name: table.places(np.atleast_1d(np.asarray(labels)), f"group {name!r}").tolist()
            for name, labels in (groups or {}).items()
        }
    else:
        points = np.atleast_2d(numbers(nodes))
    names = tuple(components)
    matrices = {
        what: mirrored(read_market(path, f"{what} matrix"))
        for what, path in (("stiffness", stiffness), ("mass", mass), ("damping", damping))
        if path is not None
    }
    if set(names) <= set(COMPONENTS) and all(m.shape[0] == len(points) * len(names) for m in matrices.values()):
        rowwise = np.arange(len(points) * len(names))
        by_node = rowwise.reshape(len(names), -1).T.ravel() if order == "components" else rowwise
        matrices = {what: in_si(m[by_node][:, by_node], names, units) for what, m in matrices.items()}
        order = "nodes" if order == "components" else order
    model = model_from_matrices(
        matrices["mass"],
        matrices["stiffness"],
        points * length,
        components=names,
        damping=matrices.get("damping"),
        groups=numbered,
        order=order,
        source=f"Matrix Market {Path(stiffness).name}",
        **expected,
    )
    return replace(model, provenance={**model.provenance, "units": str(units)})
