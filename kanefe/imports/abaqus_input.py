"""Keywords, nodes and node sets of an Abaqus input file, which the matrices refer to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from kanefe.errors import FileError, ModelError
from kanefe.imports.included import included_file
from kanefe.imports.node_table import NodeTable
from kanefe.imports.text import numbers, read_text

REFUSED = {
    "SYSTEM": "nodes in a system of their own",
    "TRANSFORM": "degrees of freedom in axes of their own",
    "NGEN": "generated nodes",
    "NFILL": "generated nodes",
    "NCOPY": "generated nodes",
    "NMAP": "mapped nodes",
    "ELGEN": "generated elements",
    "ELCOPY": "generated elements",
}
"""Unsupported keywords that move nodes or rotate their degrees of freedom."""


@dataclass(frozen=True)
class Keyword:
    """One keyword line of an input file with the lines that follow it.

    Attributes
    ----------
    name : str
        Upper case, without the star.
    options : dict of str to str
        Upper-case names; an option without a value has "".
    lines : list of str
        Data lines.
    comments : list of str
        Comment lines among them, without their stars.
    at : int
        Number of its line in its file.
    """

    name: str
    options: dict[str, str]
    lines: list[str] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)
    at: int = 0


def keywords(text: str) -> list[Keyword]:
    """Return the keywords of an input file in their order."""
    blocks: list[Keyword] = []
    is_continued = False
    for at, line in enumerate(map(str.lstrip, text.splitlines()), 1):
        if line.startswith("**"):
            if blocks:
                blocks[-1].comments.append(line.lstrip("*").strip())
        elif line.startswith("*") or is_continued:
            fields = [part.strip() for part in line.lstrip("*").split(",")]
            if not is_continued:
                blocks.append(Keyword(fields.pop(0).upper(), {}, at=at))
            for part in filter(None, fields):
                name, _, value = part.partition("=")
                blocks[-1].options[name.strip().upper()] = value.strip()
            is_continued = line.rstrip().endswith(",")
        elif line.strip() and blocks:
            blocks[-1].lines.append(line)
    return blocks


def node_table(path: str | Path, trusted: bool = False) -> NodeTable:
    """Return the nodes and node sets of an input file; if `trusted`, it may include any file.

    Raises
    ------
    FileError
        If the file does not exist or has no nodes, or includes a file outside its folder and is not trusted.
    ModelError
        If it has several instances, or moves nodes or rotates their degrees of freedom, which is not supported.
    """
    blocks = with_includes(keywords(read_text(path, "nodes")), Path(path), Path(path), trusted)
    check_places(blocks, path, "or give the nodes as a dict of labels to coordinates")
    rows: list[np.ndarray] = []
    sets: dict[str, list[int]] = {}
    for block in blocks:
        if block.name == "NODE" and block.lines:
            rows.append(node_rows(block, path))
            if "NSET" in block.options:
                sets.setdefault(block.options["NSET"], []).extend(rows[-1][:, 0].astype(int).tolist())
        elif block.name == "NSET":
            name = block.options.get("NSET", "")
            sets.setdefault(name, []).extend(members(block, sets, path))
    if not rows:
        raise FileError(f"{path} has no *NODE. Remedy: give the input file of the job that wrote the matrices")
    frozen = {name: np.unique(np.array(members, dtype=np.int64)) for name, members in sets.items() if members}
    return NodeTable.of_rows(np.concatenate(rows), str(path), frozen)


def check_places(blocks: list[Keyword], path: str | Path, otherwise: str, takes_turned: bool = False) -> None:
    """Refuse what places nodes elsewhere than where their coordinates are.

    Parameters
    ----------
    blocks : list of Keyword
    path : path
    otherwise : str
        Another remedy than an export, for the message.
    takes_turned : bool
        Whether degrees of freedom may have axes of their own.

    Raises
    ------
    ModelError
        Naming the keyword, and the line that it begins at.
    """
    instances = [block for block in blocks if block.name == "INSTANCE"]
    if len(instances) > 1 or any(block.lines for block in instances):
        at = next((block for block in instances if block.lines), instances[-1]).at
        raise ModelError(
            f"{path} is an assembly of {len(instances)} instance(s) that are placed or share labels (line {at}), so "
            "that its nodes are not where its parts have them. Remedy: export a flat input file (no parts and "
            f"assemblies), {otherwise}"
        )
    for block in blocks:
        is_end = block.name == "SYSTEM" and not block.lines
        if block.name in REFUSED and not is_end and not (takes_turned and block.name == "TRANSFORM"):
            raise ModelError(
                f"{path} has *{block.name} (line {block.at}): {REFUSED[block.name]}, which are not supported. Remedy: "
                f"export the model in global coordinates, {otherwise}"
            )
        if block.name == "NODE" and block.lines and block.options.get("SYSTEM", "R").upper() != "R":
            raise ModelError(
                f"{path} has nodes in cylindrical or spherical coordinates (line {block.at}). Remedy: SYSTEM=R"
            )


def node_rows(block: Keyword, path: str | Path) -> np.ndarray:
    """Return rows of label, x, y, z of a block; coordinates that are left out are zero."""
    rows, source = np.zeros((len(block.lines), 4)), f"{path} (*NODE, line {block.at})"
    if all(line.rstrip(", ").count(",") == 3 for line in block.lines):
        whole = numbers(" ".join(block.lines), source)
        if whole.size == rows.size:  # nothing is left out within a line
            return whole.reshape(rows.shape)
    for i, line in enumerate(block.lines):
        row = numbers(", ".join(part if part.strip() else "0" for part in line.rstrip(", ").split(",")), source)[:4]
        rows[i, : len(row)] = row
    return rows


def members(block: Keyword, sets: Mapping[str, list[int]], path: str | Path) -> list[int]:
    """Return the labels of a set of nodes or elements: labels, names of earlier sets, or ranges with GENERATE.

    Those of an instance may have its name and a point before them.

    Raises
    ------
    FileError
        If it names a set that is not there.
    """
    found: list[int] = []
    known = {name.upper(): labels for name, labels in sets.items()}
    for line in block.lines:
        fields = [part.strip() for part in line.split(",") if part.strip()]
        if "GENERATE" in block.options:
            first, last, *step = (int(x) for x in numbers(" ".join(fields), path))
            found += range(first, last + 1, step[0] if step else 1)
            continue
        for part in fields:
            bare = part.strip('"').rpartition(".")[2]
            if bare.lstrip("-").isdigit():
                found.append(int(bare))
                continue
            labels = known.get(part.strip('"').upper(), known.get(bare.upper()))
            if labels is None:
                raise FileError(
                    f"{path} has a set of {part!r} (*{block.name}, line {block.at}), which is no set before it. "
                    "Remedy: check the order of its sets"
                )
            found += labels
    return found


def with_includes(
    blocks: list[Keyword], path: Path, top: Path, trusted: bool, depth: int = 0, reader: str = "read_abaqus"
) -> list[Keyword]:
    """Return the keywords of a file that a user reads by `reader`, with those of each ``*INCLUDE, INPUT=file``."""
    if depth > 10:
        raise FileError(f"{path} includes itself. Remedy: check its *INCLUDE")
    found: list[Keyword] = []
    for block in blocks:
        found.append(block)
        if block.name == "INCLUDE":
            other = included_file(block.options.get("INPUT", ""), path, top=top, trusted=trusted, reader=reader)
            found += with_includes(keywords(read_text(other, "nodes")), other, top, trusted, depth + 1, reader)
    return found
