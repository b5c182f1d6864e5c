"""Rows of matrices of shells and beams, which CalculiX expands to solids: translations of the nodes of these.

job.dof names such rows by the node of the deck, so several of one name follow each other. The nodes of the solids, in
the order of the rows, are in the results of a step with OUTPUT=3D (job.frd, with all digits by ``*NODE OUTPUT``), their
cells in job.12d, which is always written. Where shells or beams meet at an angle CalculiX makes rigid knots: refused.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from kanefe.errors import FileError, ModelError
from kanefe.imports.abaqus_cards import DEPENDENT
from kanefe.imports.abaqus_job import Job
from kanefe.imports.calculix_rows import INCOMPATIBLE, INNER_NODES, CellBlock, StoredRows, cells_of, unknown_nodes
from kanefe.imports.node_table import NodeTable
from kanefe.imports.text import read_text
from kanefe.storage.files import regular_file

REMEDY = (
    "Remedy: a step *FREQUENCY with *NODE OUTPUT, OUTPUT=3D before the one that stores, in the same deck, and job.frd "
    "and job.12d beside the matrices"
)

_NODES = re.compile(rb"^    2C +(\d+) +([0-3]) *\n", re.MULTILINE)
"""Head of the nodes of a results file: their number, and the format (1: text, 3: binary, double)."""

_TEXT, _BINARY = 1, 3

_RECORD = np.dtype([("label", "<i4"), ("point", "<f8", 3)])
"""A node of a binary results file."""

_ELEMENT = re.compile(
    r'ELEMENT\s+(\d+) with label "(\w+)[^"]*" and with nodes:\s*[\d\s]*is expanded into a "(\w+)[^"]*" element '
    r"with topology:([\d\s]*)"
)

_KINDS = {"C3D6": "wedge", "C3D8": "hexahedron", "C3D15": "wedge15", "C3D20": "hexahedron20"}
"""Cells of the solids to which elements are expanded."""


def expanded_rows(job: Job, freedoms: np.ndarray, path: Path) -> StoredRows:
    """Return what rows (node, direction) of a deck with shells or beams are, whose matrices are in a `path`.

    Raises
    ------
    FileError
        If the files of the expanded nodes are not there, or not as they should be.
    ModelError
        If the rows are not those of these nodes: supports, knots, or constraints.
    """
    labels, points = _nodes(path.with_suffix(".frd"))
    cells, count = _cells(path.with_suffix(".12d"))
    is_made = ~np.isin(freedoms[:, 0], job.nodes.labels)
    of_deck = freedoms[~is_made]
    _check_order(of_deck, labels, path, job)
    made = np.unique(freedoms[is_made, 0])
    if len(made) != INNER_NODES * count:
        raise unknown_nodes(path, made.tolist(), count)
    named = freedoms.copy()
    named[~is_made, 0] = np.repeat(labels, 3)
    named[is_made, 0] += labels[-1]  # no label of a node
    own = of_deck[::3, 0]
    sets = {name: labels[np.isin(own, members)] for name, members in job.nodes.sets.items()}
    table = NodeTable.of_rows(np.column_stack((labels, points)), str(path.with_suffix(".frd")), sets)
    return StoredRows(named, is_made, table, [*cells_of(job.parts), *cells], [])


def _check_order(rows: np.ndarray, labels: np.ndarray, path: Path, job: Job) -> None:
    """Check that rows are three translations of each node of the results."""
    if len(rows) == 3 * len(labels) and np.array_equal(rows[:, 1], np.tile((1, 2, 3), len(labels))):
        return
    taking = [block for block in job.blocks if block.name in ("BOUNDARY", *DEPENDENT)]
    names, times = np.unique(rows[:, 0], return_counts=True)
    knots = ", ".join(map(str, names[times == 3][:5].tolist()))
    frd = path.with_suffix(".frd").name
    if taking:
        why = f"*{taking[0].name} (line {taking[0].at}) takes some. Remedy: a free body without it"
    elif len(labels) < len(rows) // 3:
        why = f"{frd} has not the expanded ones. {REMEDY}"
    elif knots:
        why = f"elements meet at an angle at {knots}, in rigid knots of CalculiX. Remedy: mesh the body with solids"
    else:
        why = f"they are of two jobs. {REMEDY}"
    raise ModelError(
        f"{path.with_suffix('.dof')} names {len(rows)} rows of nodes of the deck, the {len(labels)} nodes of {frd} "
        f"make {3 * len(labels)}: {why}"
    )


def _nodes(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return labels (n,) and places (n, 3) of the first nodes of a results file."""
    if not path.is_file():
        raise FileError(f"there is no {path}, which has the nodes of the solids that shells and beams become. {REMEDY}")
    data = regular_file(path, "for the expanded nodes").read_bytes()
    head = _NODES.search(data)
    if head is None or int(head[2]) not in (_TEXT, _BINARY):
        raise FileError(f"{path} has no nodes. {REMEDY}")
    count = int(head[1])
    try:
        if int(head[2]) == _BINARY:
            found = np.frombuffer(data, dtype=_RECORD, count=count, offset=head.end())
            return found["label"].astype(np.int64), found["point"].astype(float)
        lines = data[head.end() :].split(b"\n", count)[:count]
        rows = [(line[3:13], line[13:25], line[25:37], line[37:49]) for line in lines if line.startswith(b" -1")]
        table = np.array([[float(field) for field in row] for row in rows]).reshape(-1, 4)
    except ValueError as error:
        raise FileError(f"{path} is truncated in its nodes ({error}). Remedy: run the job again") from error
    if len(table) != count:
        raise FileError(f"{path} has {len(table)} of the {count} nodes that it says. Remedy: run the job again")
    return table[:, 0].astype(np.int64), table[:, 1:]


def _cells(path: Path) -> tuple[list[CellBlock], int]:
    """Return the cells that elements become, and how many have incompatible modes."""
    found: dict[str, tuple[list[int], list[list[int]]]] = {}
    count = 0
    for label, _, solid, topology in _ELEMENT.findall(read_text(path, "cells of shells and beams")):
        kind = next((kind for name, kind in _KINDS.items() if re.fullmatch(name + "[A-Z]*", solid)), None)
        if kind is None:
            raise FileError(
                f"{path} has elements of type {solid}, which are not read. Remedy: mesh the body with solids"
            )
        count += solid.startswith(INCOMPATIBLE)
        elements, nodes = found.setdefault(kind, ([], []))
        elements.append(int(label))
        nodes.append([int(text) for text in topology.split() if text != "0"])
    if not found:
        raise FileError(f"{path} has no elements. Remedy: the file of the job that stored the matrices")
    return [CellBlock(kind, np.array(e), np.array(nodes)) for kind, (e, nodes) in found.items()], count
