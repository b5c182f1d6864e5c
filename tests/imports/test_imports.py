"""Matrices of other programs: each format gives the body that was written, and what is wrong is named and refused."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

import import_writers as write
import kanefe as kf
from kanefe.errors import ModelError, UnitWarning
from kanefe.fe_model.model import rigid_motion
from kanefe.frames import rotation_matrix
from kanefe.imports import (
    read_abaqus,
    read_ansys,
    read_matrices,
    read_matrix_market,
    read_nastran,
    write_matrices,
)
from kanefe.imports.nodal_inertia import NodalFormWarning
from scenes import lattice_model
from steel_beams import steel_beam

SOLID = lattice_model(0)
BEAM = steel_beam(4)
LABELS = np.array([3, 4, 10, 11, 17, 101, 102, 400, 9001])
TIP = SOLID.groups["tip"].nodes


def assert_same(model: kf.FiniteElementModel, original: kf.FiniteElementModel, digits: float = 1e-14) -> None:
    """The same nodes, matrices and frequencies, to the digits of the file."""
    assert model.nodes == pytest.approx(original.nodes, abs=1e-9)
    for ours, theirs in ((model.mass, original.mass), (model.stiffness, original.stiffness)):
        assert abs(ours - theirs).max() <= digits * abs(theirs).max()
    assert model.components == original.components
    check = model.provenance["self_check"]
    assert check["rigid_motions"] == check["zero_modes"] == 6


@pytest.mark.parametrize("style", ["input", "coordinate"])
def test_abaqus_matrices(style: str, tmp_path: Path) -> None:
    model = read_abaqus(*write.abaqus_job(tmp_path, SOLID, LABELS, style), groups={"corner": [3, 4]})
    assert_same(model, SOLID)
    assert model.mass_field is not None
    assert model.groups["TIP"].nodes.tolist() == [7, 8]
    assert model.groups["FIRST"].nodes.tolist() == [0, 1] == model.groups["corner"].nodes.tolist()
    assert model.groups["BOTH"].nodes.tolist() == [0, 1, 7, 8]
    assert kf.flexible_body(model).frequencies == pytest.approx(kf.flexible_body(SOLID).frequencies, rel=1e-9)


def test_abaqus_labels_in_any_order(tmp_path: Path) -> None:
    labels = LABELS[np.random.default_rng(4).permutation(9)]
    model = read_abaqus(*write.abaqus_job(tmp_path, SOLID, labels))
    assert model.nodes == pytest.approx(SOLID.nodes[np.argsort(labels)], abs=1e-15)
    assert kf.flexible_body(model).frequencies == pytest.approx(kf.flexible_body(SOLID).frequencies, rel=1e-9)


@pytest.mark.parametrize("original", [SOLID, BEAM], ids=["solid", "beam"])
def test_abaqus_substructure(original: kf.FiniteElementModel, tmp_path: Path) -> None:
    labels = LABELS[: len(original.nodes)]
    inp = write.abaqus_input(tmp_path / "job.inp", original.nodes, labels, {"TIP": [int(labels[-1])]})
    path = write.abaqus_substructure(tmp_path / "sub.mtx", original, labels)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NodalFormWarning)
        assert_same(read_abaqus(inp, substructure=path), original)


@pytest.mark.parametrize("rhs", [False, True])
def test_ansys_harwell_boeing(rhs: bool, tmp_path: Path) -> None:
    assert_same(read_ansys(*write.ansys_job(tmp_path, SOLID, LABELS, rhs), groups={"tip": 9001}), SOLID)


def test_ansys_matrix_market_and_archive(tmp_path: Path) -> None:
    archive = pytest.importorskip("mapdl_archive", reason="Ansys archives are read by mapdl-archive")
    _, _, _, mapping = write.ansys_job(tmp_path, SOLID, LABELS)
    order = np.random.default_rng(2).permutation(SOLID.size)
    for name, m in (("K", SOLID.stiffness), ("M", SOLID.mass)):
        lower = sp.tril(m.tocsr()[order][:, order])
        scipy.io.mmwrite(tmp_path / f"{name}.mtx", lower, precision=17)  # one triangle, and no word of symmetry
    cdb = tmp_path / "job.cdb"
    archive.write_nblock(str(cdb), LABELS.astype(np.int32), np.ascontiguousarray(SOLID.nodes), mode="w")
    with cdb.open("a") as file:
        archive.write_cmblock(file, np.array([400, 9001], dtype=np.int32), "TIP", "NODE")
    model = read_ansys(cdb, tmp_path / "K.mtx", tmp_path / "M.mtx", mapping)
    assert_same(model, SOLID)
    assert model.groups["TIP"].nodes.tolist() == [7, 8]


def in_solver_order(folder: Path, commas: bool) -> tuple[Path, Path, Path, Path, Path]:
    """K, M, nodes and the mappings of APDL Math, of a solver that neither keeps the order of nodes nor of rows."""
    rng = np.random.default_rng(4)
    internal = rng.permutation(len(SOLID.nodes))
    rows = rng.permutation(SOLID.size)
    by_node = (internal[:, None] * 3 + np.arange(3)).ravel()
    paths = []
    for name, m in (("K", SOLID.stiffness), ("M", SOLID.mass)):
        path = folder / f"{name}.mtx"
        solver = m.tocsr()[by_node][:, by_node][rows][:, rows]
        scipy.io.mmwrite(str(path), sp.tril(solver), precision=17)
        paths.append(path)
    back, forward = folder / "back.mmf", folder / "forward.mmf"
    back.write_text("%%MatrixMarket matrix array integer general\n" + f"{len(internal)} 1\n")
    with back.open("a") as file:
        file.writelines(f"{label}\n" for label in LABELS[internal])
    places = np.zeros(LABELS.max(), dtype=int)
    places[LABELS[internal] - 1] = np.arange(1, len(internal) + 1)
    forward.write_text(f"%%MatrixMarket matrix array integer general\n{len(places)} 1\n")
    with forward.open("a") as file:
        file.writelines(f"{place}\n" for place in places)
    solver_path = folder / "nod2bcs.mtx"
    choice = sp.csr_matrix((np.ones(SOLID.size), (np.arange(SOLID.size), rows)))
    scipy.io.mmwrite(str(solver_path), choice)
    if commas:
        for path in paths:
            head, *data = path.read_text().splitlines()
            path.write_text("\n".join([head, *(line.replace(".", ",") for line in data)]))
    return paths[0], paths[1], back, forward, solver_path


@pytest.mark.parametrize(("name", "commas"), [("back", False), ("forward", True)])
def test_ansys_mappings_of_apdl_math_and_decimal_commas(name: str, commas: bool, tmp_path: Path) -> None:
    stiffness, mass, back, forward, solver = in_solver_order(tmp_path, commas)
    nodes = write.node_rows(tmp_path / "nodes.txt", SOLID.nodes, LABELS)
    if commas:
        nodes.write_text(nodes.read_text().replace(",", " ").replace(".", ","))
    mapping = {name: back if name == "back" else forward, "solver": solver}
    assert_same(read_ansys(nodes, stiffness, mass, mapping), SOLID)
    if not commas:
        with pytest.raises(ModelError, match="differs between directions"):
            read_ansys(nodes, stiffness, mass, back)  # the rows are not in the internal order
        with pytest.raises(ModelError, match="'back' or 'forward'"):
            read_ansys(nodes, stiffness, mass, {"solver": solver})


def test_more_mass_than_matter_has_is_told(tmp_path: Path) -> None:
    with pytest.warns(UnitWarning, match=r"units look wrong: .* kg in a box of"):
        read_abaqus(*write.abaqus_job(tmp_path, SOLID, LABELS), units="mm, t, s")


def test_nastran_dmig(tmp_path: Path) -> None:
    model = read_nastran(*write.nastran_job(tmp_path, SOLID, LABELS), groups={"tip": [400, 9001]})
    assert_same(model, SOLID, 1e-9)  # cards carry ten digits
    assert model.groups["tip"].nodes.tolist() == [7, 8]


@pytest.mark.parametrize("style", ["mystran", "big", "wide", "strings", "bigmat", "text"])
def test_nastran_op4(style: str, tmp_path: Path) -> None:
    bulk, _ = write.nastran_job(tmp_path, SOLID, LABELS)
    rows = np.add.outer(6 * np.arange(9), np.arange(3)).ravel()
    whole = []
    for m in (SOLID.stiffness, SOLID.mass):
        g = np.zeros((54, 54))  # the g-set has six rows a grid point, empty where elements know no rotation
        g[np.ix_(rows, rows)] = m.toarray()
        whole.append(g)
    # known by what is in it, whatever its name
    file = write.output4(tmp_path / "m.OU1", dict(zip(("KGG", "MGG"), whole, strict=True)), style)
    assert_same(read_nastran(bulk, file), SOLID, 1e-9)  # coordinates have ten digits
    write.output4(tmp_path / "a.op4", {"K1": SOLID.stiffness.toarray(), "M1": SOLID.mass.toarray()}, style)
    model = read_nastran(
        bulk,
        tmp_path / "a.op4",
        names={"stiffness": "K1", "mass": "m1"},
        freedoms=[(int(n), c) for n in LABELS for c in (1, 2, 3)],
    )
    assert_same(model, SOLID, 1e-9)


def test_nastran_displacements_in_axes_of_their_own(tmp_path: Path) -> None:
    A = rotation_matrix(np.array((0.8, 0.0, 0.36, 0.48)))
    origin, z, x = np.array((0.3, -0.2, 0.5)), A[:, 2], A[:, 0]
    fields = [f"{v:16.9E}" for v in (*origin, *(origin + z), *(origin + x))]
    card = f"{'CORD2R*':8s}{5:16d}{0:16d}" + "".join(fields[:2]) + "\n"
    card += f"{'*':8s}" + "".join(fields[2:6]) + "\n" + f"{'*':8s}" + "".join(fields[6:])
    turn = sp.block_diag([sp.csr_matrix(A)] * 9, format="csr")
    turned = {"KAAX": turn.T @ SOLID.stiffness @ turn, "MAAX": turn.T @ SOLID.mass @ turn}
    bulk = write.nastran_bulk(tmp_path / "arm.bdf", SOLID.nodes, LABELS, card, system=5)
    model = read_nastran(bulk, write.dmig(tmp_path / "arm.pch", SOLID, LABELS, turned))
    assert_same(model, SOLID, 1e-8)  # the system has ten digits


@pytest.mark.parametrize("order", ["nodes", "components"])
def test_matrix_market(order: str, tmp_path: Path) -> None:
    rows = np.arange(27).reshape(9, 3).T.ravel() if order == "components" else np.arange(27)
    for name, m in (("K", SOLID.stiffness), ("M", SOLID.mass)):
        scipy.io.mmwrite(tmp_path / f"{name}.mtx", m[rows][:, rows], precision=17)
    files = tmp_path / "K.mtx", tmp_path / "M.mtx"
    assert_same(read_matrix_market(SOLID.nodes, *files, order=order, groups={"tip": [8]}), SOLID)
    if order == "components":
        with pytest.raises(ModelError, match=r"seem to be all x, then all y, \.\.\.: say order='components'"):
            read_matrix_market(SOLID.nodes, *files)
    table = tmp_path / "nodes.txt"
    write.node_rows(table, SOLID.nodes, LABELS)
    model = read_matrix_market(table, *files, order=order, groups={"tip": [9001]})
    assert model.groups["tip"].nodes.tolist() == [8]


def test_npz(tmp_path: Path) -> None:
    path = tmp_path / "arm.npz"
    write_matrices(SOLID, path)
    model = read_matrices(path, expected_mass=SOLID.mass.toarray()[::3, ::3].sum())
    assert_same(model, SOLID)
    assert set(model.groups) == set(SOLID.groups)
    np.savez(
        path,
        format="kanefe matrices 1",
        nodes=SOLID.nodes,
        components=["x", "y", "z"],
        stiffness=SOLID.stiffness.toarray(),
        mass=SOLID.mass.toarray(),
    )
    assert_same(read_matrices(path), SOLID)


@pytest.mark.parametrize(
    ("units", "length", "mass"),
    [("mm, t, s", 1e-3, 1e3), ("in, lbf, s", 0.0254, 175.126835), ((0.1, 2.0), 0.1, 2.0)],
)
def test_units(units: Any, length: float, mass: float, tmp_path: Path) -> None:
    # oracle: forces F = K u by hand. A force of 1 unit is mass * length newton, a moment mass * length^2
    force, moment = mass * length, mass * length**2
    translations = np.tile([1, 1, 1, 0, 0, 0], len(BEAM.nodes)).astype(bool)
    load = np.where(translations, 1 / force, 1 / moment)  # their numbers of SI forces
    motion = np.where(translations, length, 1.0)  # SI motions of their unit motions
    theirs = [sp.diags(load) @ m @ sp.diags(motion) for m in (BEAM.stiffness, BEAM.mass)]
    labels = LABELS[:5]
    inp = write.abaqus_input(tmp_path / "a.inp", BEAM.nodes / length, labels, {"TIP": [17]})
    files = [
        write.abaqus_matrix(tmp_path / f"{n}.mtx", BEAM, m, labels) for n, m in zip(("K", "M"), theirs, strict=True)
    ]
    model = read_abaqus(inp, *files, units=units, expected_mass=4.71)
    assert_same(model, BEAM, 1e-8)  # pound-force has nine digits here


def test_rotations_of_solid_nodes_follow_their_neighbours(tmp_path: Path) -> None:
    # a node with six freedoms stands off the lattice, tied elastically to the mean motion of four of its nodes
    rng = np.random.default_rng(8)
    n = len(SOLID.nodes)
    nodes = np.vstack((SOLID.nodes, (1.6, 0.1, 0.2)))
    size = 6 * len(nodes)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    solid_rows = np.add.outer(6 * np.arange(n), np.arange(3)).ravel()
    for whole, solid in ((K, SOLID.stiffness), (M, SOLID.mass)):
        whole[np.ix_(solid_rows, solid_rows)] = solid.toarray()
    fit = np.linalg.pinv(rigid_motion(nodes[5:9], nodes[n]))
    gap = np.zeros((6, size))
    gap[:, 6 * n :] = np.eye(6)
    gap[:, np.add.outer(6 * np.arange(5, 9), np.arange(3)).ravel()] = -fit
    K += gap.T @ np.diag((900, 800, 700, 30, 20, 10)) @ gap
    M[range(6 * n, size), range(6 * n, size)] = (0.3, 0.3, 0.3, 0.01, 0.01, 0.01)
    kept = np.union1d(solid_rows, np.arange(6 * n, size))  # degrees of freedom that Abaqus would write
    labels = np.arange(1, len(nodes) + 1)
    names = [(int(label), c) for label in labels for c in range(1, 7)]
    inp = write.abaqus_input(tmp_path / "a.inp", nodes, labels, {"TIP": [int(labels[-1])]})
    paths = []
    for name, m in (("K", K), ("M", M)):
        lines = [
            f"{names[i][0]},{names[i][1]},{names[j][0]},{names[j][1]},{float(m[i, j])!r}"
            for i in kept
            for j in kept
            if j <= i and m[i, j]
        ]
        paths.append(tmp_path / f"{name}.mtx")
        paths[-1].write_text("\n".join(lines) + "\n")
    model = read_abaqus(inp, *paths)
    assert model.provenance["following_rotations"] == 3 * n
    # statics do not feel the rotations that were added: displacements under self-equilibrated loads are the same
    R = model.rigid_modes()
    load = np.zeros(size)
    load[kept] = rng.standard_normal(len(kept))
    full_R = R[kept]
    load[kept] -= full_R @ np.linalg.solve(full_R.T @ full_R, full_R.T @ load[kept])
    ours = np.linalg.lstsq(model.stiffness.toarray(), load, rcond=1e-13)[0]
    theirs = np.zeros(size)
    theirs[kept] = np.linalg.lstsq(K[np.ix_(kept, kept)], load[kept], rcond=1e-13)[0]
    error = (ours - theirs)[kept]
    error -= full_R @ np.linalg.lstsq(full_R, error, rcond=None)[0]
    assert abs(error).max() < 1e-9 * abs(theirs).max()


@pytest.mark.parametrize("style", ["input", "D exponents"])
def test_abaqus_exponents(style: str, tmp_path: Path) -> None:
    paths = write.abaqus_job(tmp_path, SOLID, LABELS)
    if style == "D exponents":
        for path in paths[1:]:
            path.write_text(path.read_text().replace("e-", "D-").replace("e+", "D+"))
    assert_same(read_abaqus(*paths), SOLID)
