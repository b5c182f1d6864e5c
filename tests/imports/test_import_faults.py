"""Faults in matrices of other programs: each is named with its remedy, before anything is made of it."""

from __future__ import annotations

import re
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import import_writers as write
import kanefe as kf
from kanefe.errors import FileError, KanefeError, MissingDependency, ModelError
from kanefe.imports import read_abaqus, read_ansys, read_matrices, read_nastran, write_matrices
from scenes import lattice_model

SOLID = lattice_model(0)
LABELS = np.array([3, 4, 10, 11, 17, 101, 102, 400, 9001])


def edited(path: Path, edit: Callable[[str], str]) -> None:
    path.write_text(edit(path.read_text()))


ABAQUS_FAULTS: list[tuple[int, Callable[[str], str], str]] = [
    (0, lambda t: t.replace("9001,", "9002,"), r"1 node\(s\) that the table of nodes does not hold: 9001\. Remedy"),
    (0, lambda t: t + "*INSTANCE, NAME=a, PART=p\n1., 0., 0.\n", r"\(line \d+\) is of part p, which is not there"),
    (0, lambda t: t + "*TRANSFORM, NSET=TIP\n1,1,0,-1,1,0\n", "differs between directions"),
    (0, lambda t: t.replace("*NODE, NSET=ALL", "*NODE, SYSTEM=S"), r"\*NODE \(line 4\) is in the system 'S'"),
    (0, lambda t: t + "*NMAP, NSET=TIP\n1.\n", r"\*NMAP \(line \d+\) places nodes"),
    (0, lambda t: "*HEADING\n", r"has no \*NODE"),
    (1, lambda t: t[: int(0.6 * len(t))], r"truncated|resists|leaves more than|has 1 nodes"),
    (1, lambda t: t[: t.rindex(",")], r"truncated"),
    (1, lambda t: "", r"is empty\. Remedy"),
    (1, lambda t: t.replace("e+0", "x+0"), r"holds something that is not a number, or is truncated"),
    (1, lambda t: t + "3,11, 3,11, 1.0\n", r"degree of freedom 11 \(temperature\) at node 3\. Remedy"),
    (1, lambda t: t + "-1,1, -1,1, 1.0\n", r"1 internal node\(s\) .*Lagrange multipliers.* Remedy"),
    (
        1,
        lambda t: re.sub(r"\n3,1, 3,1, .*", "\n3,1, 3,1, 1e36", t),
        r"holds 1 degree\(s\) of freedom by huge entries, first 1 of node 3",
    ),
    (1, lambda t: t + "3,1, 3,1, 5.\n", r"entry of \[3, 1\] and \[3, 1\] .* is there twice"),
    (1, lambda t: re.sub(r"\n3,1, 3,1, .*", "\n3,1, 3,1, 1e9", t), "resists the rigid .* exported unsupported"),
    (2, lambda t: re.sub(r"\n3,1, 3,1, .*", "\n3,1, 3,1, 5.", t), "differs between directions"),
]


@pytest.mark.parametrize(("which", "edit", "message"), ABAQUS_FAULTS)
def test_abaqus_faults_are_named(which: int, edit: Callable[[str], str], message: str, tmp_path: Path) -> None:
    paths = write.abaqus_job(tmp_path, SOLID, LABELS)
    edited(paths[which], edit)
    with pytest.raises(KanefeError, match=message):
        read_abaqus(*paths)


def test_nodes_of_another_order_are_found_by_the_rigid_motions(tmp_path: Path) -> None:
    paths = write.abaqus_job(tmp_path, SOLID, LABELS)
    swapped = dict(zip(LABELS.tolist(), SOLID.nodes[::-1], strict=True))
    with pytest.raises(ModelError, match=r"resists the rigid rotation .*translations are free, .* another order"):
        read_abaqus(swapped, *paths[1:])


ANSYS_FAULTS: list[tuple[int, Callable[[str], str], str]] = [
    (0, lambda t: t.replace("9001", "x"), "holds something that is not a number"),
    (0, lambda t: t + "\n7 1.0 2.0", "is not a table of nodes"),
    (1, lambda t: t[: int(0.7 * len(t))], r"is truncated: \d+ of \d+ numbers|damaged number"),
    (1, lambda t: t.replace("RSA", "CSA"), r"is of type CSA .* real, square and assembled"),
    (1, lambda t: "no header", "is not a Harwell-Boeing file"),
    (3, lambda t: t[: t.rindex("\n", 0, len(t) - 1) + 1], r"has 27 rows, the mapping .* 26\. Remedy"),
    (3, lambda t: t.replace("UZ", "PRES"), r"degrees of freedom PRES, which are not motions"),
    (3, lambda t: t.replace("           1 ", "           2 ", 1), "is truncated or not a mapping file"),
    (3, lambda t: t.replace("UX", "XX").replace("UY", "UX").replace("XX", "UY"), "resists|differs"),
]


@pytest.mark.parametrize(("which", "edit", "message"), ANSYS_FAULTS)
def test_ansys_faults_are_named(which: int, edit: Callable[[str], str], message: str, tmp_path: Path) -> None:
    paths = write.ansys_job(tmp_path, SOLID, LABELS)
    edited(paths[which], edit)
    with pytest.raises(KanefeError, match=message):
        read_ansys(*paths)


NASTRAN_FAULTS: list[tuple[int, Callable[[str], str], str]] = [
    (0, lambda t: "BEGIN BULK\nENDDATA\n", "has no GRID"),
    (0, lambda t: t.replace("            9001", "            9002"), r"does not hold: 9001"),
    (1, lambda t: t.replace("MAAX", "MXYZ"), r"no mass matrix called .* it has KAAX, MXYZ\. Remedy: names="),
    (1, lambda t: t.replace("DMIG", "GRID"), r"has no DMIG cards\. Remedy: EXTSEOUT"),
    (1, lambda t: t[: int(0.3 * len(t))], r"no mass matrix called|truncated"),
]


@pytest.mark.parametrize(("which", "edit", "message"), NASTRAN_FAULTS)
def test_nastran_faults_are_named(which: int, edit: Callable[[str], str], message: str, tmp_path: Path) -> None:
    paths = write.nastran_job(tmp_path, SOLID, LABELS)
    edited(paths[which], edit)
    with pytest.raises(KanefeError, match=message):
        read_nastran(*paths)


OP4_FAULTS: list[tuple[str, Callable[[bytes], bytes], str]] = [
    ("mystran", lambda c: c[:1000], r"a record has not the length that it says \(byte 976\)"),
    ("mystran", lambda c: c[:976], r"it ends within a matrix \(byte 976\)"),
    ("mystran", lambda c: c[:32] + c[268:], r"matrix KGG has lost column 1 of 27 \(byte 0\)"),
    ("mystran", lambda c: c[:268] + c[32:], r"column 1 of 27 follows column 1 \(byte 268\)"),
    ("mystran", lambda c: c.replace(b"KGG ", b"MGG "), r"has two matrices MGG, which differ \(the second: byte"),
    ("mystran", lambda c: c[:16] + b"\4" + c[17:], r"matrix KGG in .* is complex"),
    ("strings", lambda c: c[:48] + b"\0" + c[49:], r"column 1 has .* words from row 0 of 27"),
    ("text", lambda c: c.replace(b"E+0", b"X+0", 1), r"there are not \d numbers \(line \d+\)"),
    ("text", lambda c: b"\n".join(c.split(b"\n")[:20]), r"it ends within a matrix \(line 21\)"),
    ("text", lambda c: b"\n".join(c.split(b"\n")[:2] + c.split(b"\n")[3:]), r"\(line \d+\): it is damaged"),
    ("mystran", lambda c: b"\1\0\0\0" + c, r"is binary, and neither an op4 nor an op2 file"),
]


@pytest.mark.parametrize(("style", "edit", "message"), OP4_FAULTS)
def test_op4_faults_are_named(style: str, edit: Callable[[bytes], bytes], message: str, tmp_path: Path) -> None:
    bulk, _ = write.nastran_job(tmp_path, SOLID, LABELS)
    pair = {"KGG": SOLID.stiffness.toarray(), "MGG": SOLID.mass.toarray()}
    path = write.output4(tmp_path / "m.OU2", pair, style)
    with pytest.raises(ModelError, match=r"shape \(27, 27\), its points make 54 .* Remedy: export the g-set"):
        read_nastran(bulk, path)
    path.write_bytes(edit(path.read_bytes()))
    with pytest.raises(KanefeError, match=message):
        read_nastran(bulk, path)
    with pytest.raises(FileError, match="there is no file"):
        read_nastran(bulk, tmp_path / "none.op4")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "truncated"),
        (b"garbage", "truncated"),
        (b"0.5", "truncated"),
        ("version", "has format 'kanefe matrices 9'"),
        ("lacks", "must hold both"),
    ],
)
def test_npz_faults_are_named(content: bytes | str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "arm.npz"
    if content == b"0.5":
        write_matrices(SOLID, path)
        path.write_bytes(path.read_bytes()[:2000])
    elif isinstance(content, bytes):
        path.write_bytes(content)
    else:
        version = 9 if content == "version" else 1
        np.savez(path, format=f"kanefe matrices {version}", nodes=SOLID.nodes, components=["x", "y", "z"])
    with pytest.raises(FileError, match=message):
        read_matrices(path)


def test_bad_arguments_are_named(tmp_path: Path) -> None:
    paths = write.abaqus_job(tmp_path, SOLID, LABELS)
    for options, message in (
        ({"units": "furlong"}, r"units 'furlong' are not known\. Remedy: one of 'm, kg, s'"),
        ({"units": (0.0, 1.0)}, "units must be"),
        ({"groups": {"g": [5]}}, r"group 'g' must be labels of nodes that the matrices have"),
        ({"substructure": "x.mtx"}, "not both"),
        ({"expected_mass": 5.0}, r"kg, 5 kg was expected"),
    ):
        with pytest.raises(ModelError, match=message):
            read_abaqus(*paths, **options)
    with pytest.raises(ModelError, match=r"give stiffness= and mass="):
        read_abaqus(paths[0])
    with pytest.raises(FileError, match="there is no file"):
        read_abaqus(tmp_path / "none.inp", *paths[1:])


@pytest.mark.parametrize(
    ("package", "reader", "extra"),
    [
        ("pyyeti", "read_nastran('arm.bdf', 'arm.op2')", "nastran"),
        ("pandas", "read_nastran('arm.bdf', 'arm.op2')", "nastran"),
        ("mapdl_archive", "read_ansys('a.cdb', 'K', 'M', 'K.mapping')", "ansys"),
    ],
)
def test_missing_packages_name_the_extra(package: str, reader: str, extra: str, tmp_path: Path) -> None:
    if package == "pandas":
        pytest.importorskip("pyyeti", reason="pyyeti needs pandas")
    write.ansys_job(tmp_path, SOLID, LABELS)
    write.nastran_job(tmp_path, SOLID, LABELS)
    (tmp_path / "arm.op2").write_bytes(b"\4\0\0\0")
    code = f"""
import sys
sys.modules[{package!r}] = None
from kanefe.imports import *
from kanefe.errors import MissingDependency
try:
    {reader.replace("'K'", "'K.matrix'").replace("'M'", "'M.matrix'")}
except MissingDependency as error:
    print(error)
"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=60,
        cwd=tmp_path,
        env={"PYTHONPATH": str(Path(kf.__file__).parents[1])},
    )
    assert package.replace("_", "-") in done.stdout, done.stderr
    assert f"pip install 'kanefe[{extra}]'" in done.stdout
    assert issubclass(MissingDependency, KanefeError)


def test_arrays_beyond_memory_are_told(tmp_path: Path) -> None:
    market = tmp_path / "k.mtx"
    market.write_text("%%MatrixMarket matrix array real general\n1000000000 1000000\n1\n")
    with pytest.raises(FileError, match=r"cannot read the stiffness matrix from .*Remedy"):
        kf.read_matrix_market([[0, 0, 0], [1, 0, 0]], market, market)
    path = tmp_path / "k.npz"
    write_matrices(SOLID, path)
    content = path.read_bytes()
    with zipfile.ZipFile(path, "a") as members:
        shape = np.lib.format.header_data_from_array_1_0(np.zeros(1)) | {"shape": (10**15,)}
        with members.open("damping_data.npy", "w") as member:
            np.lib.format.write_array_header_1_0(member, shape)
    with pytest.raises(FileError, match=r"k\.npz is truncated or not a file of matrices.*Remedy"):
        read_matrices(path)
    path.write_bytes(content)
    assert read_matrices(path).size == SOLID.size


def test_a_directory_that_has_lost_an_array_is_refused(tmp_path: Path) -> None:
    """One bit in the length of a comment hides the array behind it; groups and damping may be missing."""
    path = tmp_path / "k.npz"
    write_matrices(SOLID, path)
    content = bytearray(path.read_bytes())
    *_, entry, last = (found.start() for found in re.finditer(b"PK\1\2", content))
    content[entry + 32] = content.rindex(b"PK\5\6") - last
    path.write_bytes(content)
    with pytest.raises(FileError, match=r"the directory has lost what lies before"):
        read_matrices(path)
