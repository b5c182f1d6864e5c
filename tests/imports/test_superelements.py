"""Superelements with generalised coordinates: Craig-Bampton matrices of a beam, made here, in files of each program."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
import scipy.linalg

import import_writers as write
import kanefe as kf
from kanefe.bodies.mass_moments import MassMoments
from kanefe.errors import FileError, KanefeError, ModelError
from kanefe.fe_model.model import NodeGroup
from kanefe.imports.nodal_inertia import NodalFormWarning
from steel_beams import craig_bampton, steel_beam

FULL = steel_beam(20)
ENDS = [0, 20]
LABELS = np.array([7, 1003])
MODES = 12


def superelement(boundary: list[int] = ENDS, modes: int = MODES) -> kf.FiniteElementModel:
    """The superelement as matrices, without a file."""
    T = craig_bampton(FULL, boundary, modes)
    with pytest.warns(NodalFormWarning, match=f"superelement with {modes} generalised coordinates"):
        return kf.model_from_matrices(
            T.T @ FULL.mass @ T,
            T.T @ FULL.stiffness @ T,
            FULL.nodes[boundary],
            components=FULL.components,
            generalised=modes,
        )


SUPER = superelement()


def read_quietly(reader: Callable[..., Any], *args: Any, **options: Any) -> kf.FiniteElementModel:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NodalFormWarning)
        model = reader(*args, **options)
    assert isinstance(model, kf.FiniteElementModel)
    return model


def assert_superelement(model: kf.FiniteElementModel, digits: float) -> None:
    """The superelement above, to the digits of the file: matrices, frequencies, and the full model when rigid."""
    assert model.generalised == MODES
    for ours, theirs in ((model.mass, SUPER.mass), (model.stiffness, SUPER.stiffness)):
        assert abs(ours - theirs).max() <= digits * abs(theirs).max()
    body, full = kf.flexible_body(model), kf.flexible_body(FULL)
    assert body.mass == pytest.approx(full.mass, rel=digits)
    assert body.center_of_mass == pytest.approx(full.center_of_mass, abs=digits)
    # of a reduced body the inertia about its thin axis is the small difference of larger numbers: absolute
    assert body.inertia == pytest.approx(full.inertia, abs=digits * full.inertia.max())
    squares = scipy.linalg.eigh(SUPER.stiffness.toarray(), SUPER.mass.toarray(), eigvals_only=True)[6:]
    assert body.frequencies == pytest.approx(np.sqrt(squares) / (2 * np.pi), rel=max(100 * digits, 1e-9))


def test_nastran_dmig_of_scalar_points(tmp_path: Path) -> None:
    bulk = write.nastran_bulk(tmp_path / "arm.bdf", SUPER.nodes, LABELS)
    punch = write.dmig(tmp_path / "arm.pch", SUPER, LABELS, {"KAAX": SUPER.stiffness, "MAAX": SUPER.mass})
    model = read_quietly(kf.read_nastran, bulk, punch, groups={"tip": 1003})
    assert_superelement(model, 1e-8)  # cards carry ten digits
    assert model.groups["tip"].nodes.tolist() == [1]


def op4_job(folder: Path, cards: str) -> tuple[Path, Path]:
    """A bulk file with more cards, and KXX, MXX with rows in the order of the labels of their points."""
    bulk = write.nastran_bulk(folder / "arm.pch", SUPER.nodes, LABELS, cards)
    pair = {"KXX": SUPER.stiffness.toarray(), "MXX": SUPER.mass.toarray()}
    return bulk, write.output4(folder / "arm.op4", pair, "strings")


SPOINTS = f"SPOINT  {write.SCALAR:8d}THRU    {write.SCALAR + MODES - 1:8d}"
EXTRN = "EXTRN          7  123456    1003  123456" + "".join(
    ("" if i % 4 != 2 else "\n        ") + f"{write.SCALAR + i:8d}{0:8d}" for i in range(MODES)
)


@pytest.mark.parametrize("cards", [SPOINTS, SPOINTS + "\n" + EXTRN], ids=["scalar points", "EXTRN"])
def test_nastran_op4_with_rows_of_scalar_points(cards: str, tmp_path: Path) -> None:
    model = read_quietly(kf.read_nastran, *op4_job(tmp_path, cards))
    assert_superelement(model, 1e-9)  # coordinates carry ten digits
    by_hand = [(int(label), c) for label in LABELS for c in range(1, 7)] + [(99000 + i, 0) for i in range(MODES)]
    assert_superelement(read_quietly(kf.read_nastran, *op4_job(tmp_path, ""), freedoms=by_hand), 1e-9)


def test_nastran_grid_points_that_carry_modes(tmp_path: Path) -> None:
    bulk, op4 = op4_job(tmp_path, "GRID     9000001\nGRID     9000002")
    options = {"generalised": [9000001, 9000002]}
    assert_superelement(read_quietly(kf.read_nastran, bulk, op4, **options), 1e-9)
    with pytest.raises(ModelError, match="resists the rigid"):
        kf.read_nastran(bulk, op4)
    with pytest.raises(ModelError, match=r"generalised names \[5\], which have no row"):
        kf.read_nastran(bulk, op4, generalised=[5])


def test_unnamed_rows_are_refused(tmp_path: Path) -> None:
    with pytest.raises(
        ModelError, match=r"its points make 12 degrees of freedom. Remedy: .* say boundary=.* EXTRN card"
    ):
        kf.read_nastran(*op4_job(tmp_path, ""))


def ansys_job(folder: Path) -> tuple[list[Path], list[tuple[int, int]]]:
    """Nodes and matrices in an order of rows that is not that of the nodes, and the rows."""
    order = np.random.default_rng(3).permutation(SUPER.size)
    paths = [write.node_rows(folder / "nodes.txt", SUPER.nodes, LABELS)]
    for name, matrix in (("K", SUPER.stiffness), ("M", SUPER.mass)):
        paths.append(folder / f"{name}.mtx")
        scipy.io.mmwrite(str(paths[-1]), matrix.toarray()[np.ix_(order, order)], precision=17)
    rows = write.freedoms(SUPER, LABELS)
    return paths, [rows[i] for i in order]


def test_ansys_rows_of_a_superelement(tmp_path: Path) -> None:
    paths, rows = ansys_job(tmp_path)
    assert_superelement(read_quietly(kf.read_ansys, *paths, rows), 1e-12)
    # the same with the coordinates in the places of components of nodes that stand nowhere
    theirs = [(n, c) if c else (9001 + (n - write.SCALAR) // 6, 1 + (n - write.SCALAR) % 6) for n, c in rows]
    assert_superelement(read_quietly(kf.read_ansys, *paths, theirs, generalised=[9001, 9002]), 1e-12)


def test_npz_keeps_generalised_coordinates(tmp_path: Path) -> None:
    kf.write_matrices(SUPER, tmp_path / "arm.npz")
    assert_superelement(read_quietly(kf.read_matrices, tmp_path / "arm.npz"), 1e-12)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (lambda paths, rows: (paths, rows[:-1]), ModelError, "mapping= has 23"),
        (lambda paths, rows: (paths, [*rows[:-1], rows[0]]), ModelError, "names a row twice"),
        (lambda paths, rows: ([paths[0], "job.sub", paths[2]], rows), FileError, r"binary .* \*DMAT"),
        (lambda paths, rows: (paths, [(n, 0 if n == 7 else c) for n, c in rows]), ModelError, "twice"),
        (lambda paths, rows: (paths, [(n, c or 7) for n, c in rows]), ModelError, "freedom 7 .warping."),
    ],
)
def test_faults_are_named(change: Callable[..., Any], error: type[KanefeError], message: str, tmp_path: Path) -> None:
    paths, rows = change(*ansys_job(tmp_path))
    with pytest.raises(error, match=message):
        kf.read_ansys(*paths, rows)


def test_units_of_a_superelement(tmp_path: Path) -> None:
    # in mm and t: forces in N, moments in N mm; the generalised coordinates in any measure
    scale = np.append(np.tile([1.0, 1.0, 1.0, 1e3, 1e3, 1e3], 2), np.full(MODES, 0.3))
    paths, _ = ansys_job(tmp_path)
    write.node_rows(paths[0], 1e3 * SUPER.nodes, LABELS)
    for path, matrix in ((paths[1], SUPER.stiffness), (paths[2], SUPER.mass)):
        theirs = 1e-3 * scale[:, None] * matrix.toarray() * scale
        scipy.io.mmwrite(str(path), theirs, precision=17)
    model = read_quietly(kf.read_ansys, *paths, write.freedoms(SUPER, LABELS), units="mm, t, s")
    body, same = kf.flexible_body(model), kf.flexible_body(SUPER)
    assert body.inertia == pytest.approx(same.inertia, abs=1e-12)
    assert body.frequencies == pytest.approx(same.frequencies, rel=1e-9)


def test_rigid_motions_are_not_for_generalised_coordinates() -> None:
    T = np.hstack((craig_bampton(FULL, ENDS, 2), FULL.rigid_modes()[:, :1]))
    with pytest.raises(ModelError, match="leave rigid motions out of the generalised coordinates"):
        kf.model_from_matrices(
            T.T @ FULL.mass @ T + np.diag(np.append(np.zeros(14), 1.0)),
            T.T @ FULL.stiffness @ T,
            FULL.nodes[ENDS],
            components=FULL.components,
            generalised=3,
        )


def moments(model: kf.FiniteElementModel, shapes: np.ndarray) -> MassMoments:
    field = model.mass_field
    assert field is not None
    return MassMoments.of_points(field.points, field.mass, field.interpolation @ shapes)


@pytest.mark.parametrize("boundary", [ENDS, [0]], ids=["both ends", "one end"])
def test_inertia_is_that_of_the_full_model_as_far_as_the_matrices_hold_it(boundary: list[int]) -> None:
    model = superelement(boundary)
    shapes = craig_bampton(FULL, boundary, MODES)
    exact = moments(FULL, shapes)
    ours = moments(model, np.eye(model.size))
    for name in ("mass", "first", "second", "shape_first", "elastic_mass"):
        expected = getattr(exact, name)
        assert getattr(ours, name) == pytest.approx(expected, abs=1e-9 * abs(expected).max()), name
    turning = [d - d.transpose(1, 0, 2) for d in (ours.shape_second, exact.shape_second)]
    assert abs(turning[0] - turning[1]).max() < 1e-9 * abs(exact.shape_second).max()
    # estimates: a uniform strain of the nodes is that of the beam between two ends, and unknown from one; the first
    # modes of a cantilever carry most of their products with their momenta
    lost = 1e-3 if len(boundary) == 2 else 0.15
    assert abs(ours.shape_second - exact.shape_second).max() < lost * abs(exact.shape_second).max()
    # what a rigid turn about z shares with the coordinates: the turned field of the above
    R, turn = model.rigid_modes(), (slice(None), slice(None), slice(0, 6))
    exact_R = moments(FULL, np.hstack((shapes @ R, shapes))).shape_product[turn]
    ours_R = moments(model, np.hstack((R, np.eye(model.size)))).shape_product[turn]
    assert abs(ours_R - exact_R).max() < lost * abs(exact_R).max()
    if len(boundary) == 1:
        pair = np.ix_(range(3), range(3), (6, 7), (6, 7))  # the first bending modes in y and z
        assert abs(ours.shape_product[pair] - exact.shape_product[pair]).max() < 0.03


def swung(model: kf.FiniteElementModel, ends: list[int], joint: Any, reduction: Any) -> np.ndarray:
    """Path of the tip of the arm that falls for half a second from its joint."""
    groups = {name: NodeGroup(np.array([node]), model.nodes[node]) for name, node in zip("ab", ends, strict=True)}
    body = kf.flexible_body(replace(model, groups=groups), {"a": "clamped", "b": "node"}, reduction=reduction)
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_flexible_body("arm", body, joint=joint)
    return scene.simulate((0.0, 0.5), rtol=1e-9, output_step=0.01).position("arm", "b")


@pytest.mark.parametrize(
    ("joint", "tolerance"), [(kf.Revolute("y"), 1e-7), (kf.Universal("z", "y", speed=(2.0, 0.0)), 5e-6)]
)
def test_run_is_that_of_the_full_model(joint: Any, tolerance: float) -> None:
    # both have the same motions: only the estimated part of the inertia differs, by (w / omega)^2 = (5 / 105)^2 of a
    # deflection of 1.4 mm in space; in the plane the motions of a beam carry it all, and the integrator's error is left
    ours = swung(SUPER, [0, 1], joint, None)
    theirs = swung(FULL, ENDS, joint, kf.CraigBampton(modes=MODES))
    assert abs(ours - theirs).max() < tolerance


def test_reduced_again() -> None:
    groups = {"a": NodeGroup(np.array([0]), SUPER.nodes[0])}
    model = replace(SUPER, groups=groups)
    few = kf.flexible_body(model, {"a": "clamped"}, reduction=kf.CraigBampton(modes=4))
    whole = kf.flexible_body(model, {"a": "clamped"})
    assert few.free_count == 4
    assert few.frequencies == pytest.approx(whole.frequencies[:4], rel=1e-9)
    with pytest.raises(ModelError, match="has no geometric stiffness"):
        kf.flexible_body(model, {"a": "clamped"}, stiffening="inertial")
