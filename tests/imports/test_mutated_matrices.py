"""Files of matrices with lines lost, doubled, cut and swapped: an error with a remedy, or the body that was written."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import import_writers as write
import kanefe as kf
from kanefe.errors import AccuracyWarning, KanefeError
from scenes import lattice_model
from steel_beams import steel_beam

BODIES = {"solid": lattice_model(0), "beam": steel_beam(8)}
LABELS = np.array([3, 4, 10, 11, 17, 101, 102, 400, 9001])
SAME = 1e-6
"""Difference of an entry, relative to the largest of its matrix, that counts as round-off: files have seven digits."""

Job = tuple[list[Path], Callable[[list[Path]], kf.FiniteElementModel]]


def op4_job(folder: Path, body: kf.FiniteElementModel, style: str) -> Job:
    names = [write.NUMBER[c] for c in body.components]
    rows = (6 * np.arange(len(body.nodes))[:, None] + np.array(names) - 1).ravel()
    pair = {}
    for name, m in (("KGG", body.stiffness), ("MGG", body.mass)):
        pair[name] = np.zeros((6 * len(body.nodes),) * 2)
        pair[name][np.ix_(rows, rows)] = m.toarray()
    bulk = write.nastran_bulk(folder / "arm.bdf", body.nodes, LABELS)
    return [bulk, write.output4(folder / "arm.op4", pair, style)], lambda p: kf.read_nastran(*p)


def jobs(folder: Path, body: kf.FiniteElementModel) -> dict[str, Job]:
    """Every layout: its files, and their reader."""
    made: dict[str, Job] = {}
    for style in ("mystran", "big", "wide", "strings", "bigmat", "text"):
        (folder / style).mkdir()
        made[f"op4 {style}"] = op4_job(folder / style, body, style)
    for style in ("input", "coordinate"):
        (folder / style).mkdir()
        made[f"mtx {style}"] = (write.abaqus_job(folder / style, body, LABELS, style), lambda p: kf.read_abaqus(*p))
    (folder / "sub").mkdir()
    inp = write.abaqus_input(folder / "sub" / "job.inp", body.nodes, LABELS, {"TIP": [9001]})
    paths = [inp, write.abaqus_substructure(folder / "sub" / "sub.mtx", body, LABELS)]
    made["substructure"] = paths, lambda p: kf.read_abaqus(p[0], substructure=p[1])
    (folder / "dmig").mkdir()
    made["dmig"] = list(write.nastran_job(folder / "dmig", body, LABELS)), lambda p: kf.read_nastran(*p)
    (folder / "ansys").mkdir()
    made["hbmat"] = list(write.ansys_job(folder / "ansys", body, LABELS)), lambda p: kf.read_ansys(*p)
    return made


def mutated(content: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    """One change: of lines and fields of text, of runs of bytes and words of a binary file."""
    kind = ("lost", "doubled", "cut", "swapped")[rng.integers(4)]
    is_text = b"\0" not in content
    if kind == "cut":
        return kind, content[: rng.integers(1, len(content))]
    parts = content.splitlines(keepends=True) if is_text else [content[i : i + 4] for i in range(0, len(content), 4)]
    at = int(rng.integers(len(parts)))
    if kind == "lost":
        return kind, b"".join(parts[:at] + parts[at + (1 if is_text else int(rng.integers(1, 40))) :])
    if kind == "doubled":
        end = at + (1 if is_text else int(rng.integers(1, 40)))
        return kind, b"".join(parts[:end] + parts[at:])
    if not is_text:
        other = int(rng.integers(len(parts)))
        parts[at], parts[other] = parts[other], parts[at]
        return kind, b"".join(parts)
    for comma in (b",", None):
        fields = parts[at].split(comma)
        if len(fields) > 1:
            a, b = rng.choice(len(fields), 2, replace=False)
            line = parts[at]
            first, second = fields[a].strip(), fields[b].strip()
            fields[a], fields[b] = fields[b], fields[a]
            joined = (comma or b" ").join(f.strip() if comma else f for f in fields)
            if first == second or (not comma and len(line.rstrip()) > 40):
                # fields of a fixed width keep their columns
                i, j = sorted((line.find(fields[a]), line.find(fields[b])))
                wide = max(len(fields[a]), len(fields[b]))
                one, two = line[i : i + wide], line[j : j + wide]
                joined = line[:i] + two + line[i + wide : j] + one + line[j + wide :] if i + wide <= j else joined
            parts[at] = joined.rstrip() + b"\n"
            return kind, b"".join(parts)
    return kind, b"".join(parts)


def verdict(read: Callable[[], kf.FiniteElementModel], right: kf.FiniteElementModel) -> str:
    """What came: "named" by an error or a warning, "right", or what is wrong."""
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        try:
            found = read()
        except KanefeError as error:
            return "named" if "Remedy" in str(error) else f"no remedy: {error}"
    if any(isinstance(one.message, AccuracyWarning) for one in given):
        return "named"
    if found.components != right.components or found.nodes.shape != right.nodes.shape:
        return "other nodes or components"
    if abs(found.nodes - right.nodes).max() > SAME:
        return "other places"
    for what in ("stiffness", "mass"):
        ours, theirs = getattr(found, what), getattr(right, what)
        if (abs(ours - theirs) > SAME * abs(theirs).max()).nnz:
            return f"other {what}"
    return "right"


def told(folder: Path, name: str, count: int, seed: int) -> Counter[str]:
    """Verdicts of mutations of the files of one body, all layouts in turn."""
    body = BODIES[name]
    rng = np.random.default_rng(seed)
    found: Counter[str] = Counter()
    for layout, (paths, reader) in jobs(folder, body).items():
        whole = [path.read_bytes() for path in paths]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            right = reader(paths)
        for _ in range(count):
            which = int(rng.integers(1, len(paths)))  # the deck with the nodes has its own tests
            kind, changed = mutated(whole[which], rng)
            paths[which].write_bytes(changed)
            got = verdict(lambda paths=paths, reader=reader: reader(paths), right)
            found[got if got in ("named", "right") else f"{layout}, {paths[which].name} {kind}: {got}"] += 1
            paths[which].write_bytes(whole[which])
    return found


def test_some_mutations(tmp_path: Path) -> None:
    found = told(tmp_path, "solid", 6, 3)
    assert set(found) <= {"named", "right"}, found
    assert found["named"] > found["right"]


@pytest.mark.slow
@pytest.mark.parametrize("name", BODIES)
def test_two_thousand_mutations(name: str, tmp_path: Path) -> None:
    found = told(tmp_path, name, 91, 5)  # 11 layouts
    assert set(found) <= {"named", "right"}, found


@pytest.mark.filterwarnings("ignore:nodes rotate and no shape functions are known")
def test_an_entry_of_rotary_inertia_that_was_lost_or_moved_is_told() -> None:
    """What the beam shows as a body does not depend on it to the digits of a file; elements like it have it."""
    body = BODIES["beam"]
    for lost, moved, message in (
        ((17, 23), None, r"between nodes 2 and 3 \(from 0\) has no entry of rz and rz, unlike that of 7 other pairs"),
        ((21, 27), None, r"between nodes 3 and 4 .* has no entry of rx and rx"),
        ((23, 29), (21, 29), r"between nodes 3 and 4 .* has no entry of rz and rz"),
    ):
        M = body.mass.tolil()
        for i, j in (lost, lost[::-1]):
            entry, M[i, j] = M[i, j], 0.0
        if moved is not None:
            M[moved], M[moved[::-1]] = entry, entry
        with pytest.warns(AccuracyWarning, match=message):
            kf.model_from_matrices(M.tocsr(), body.stiffness, body.nodes, components=body.components)
