"""Matrices that CalculiX 2.20 (Debian 12) stored: jobs of one and two elements, and the program itself where it is."""

from __future__ import annotations

import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

import kanefe as kf
from kanefe.errors import FileError, ModelError
from kanefe.imports import read_calculix
from kanefe.imports.included import DeckWarning

JOBS = Path(__file__).with_name("calculix_2_20.zip")
"""Files of jobs with steel (E = 210 GPa, nu = 0.3, 7850 kg/m3), in m, kg, s, by the names of folders."""

RIGID = 1e-13
"""Force of K for a unit rigid motion, relative to its largest row sum: round-off of 14 digits."""

TYPICAL = 1e9
"""A square of frequencies of these bodies, (rad/s)^2."""


@pytest.fixture(scope="module")
def jobs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("jobs")
    with zipfile.ZipFile(JOBS) as archive:
        archive.extractall(folder)
    return folder


def stored(folder: Path, suffix: str) -> np.ndarray:
    """The matrix of a file, read as the layout says, without kanefe."""
    i, j, values = np.loadtxt(folder / f"job.{suffix}", unpack=True)
    size = int(j.max())
    matrix = np.zeros((size, size))
    matrix[i.astype(int) - 1, j.astype(int) - 1] = values
    return matrix + np.triu(matrix, 1).T


def checked(model: kf.FiniteElementModel, mass: float) -> dict[str, object]:
    """Free, of the mass of its deck; what its provenance says."""
    check = model.provenance["self_check"]
    assert check["rigid_residual"] < RIGID
    assert check["zero_modes"] == 6
    assert check["mass"] == pytest.approx(mass, rel=1e-12)  # sums of numbers of 14 digits
    return dict(model.provenance)


def test_incompatible_modes_are_condensed_with_their_mass(jobs: Path) -> None:
    model = read_calculix(jobs / "inner" / "job.inp")
    assert checked(model, 0.125 * 7850.0)["condensed"] == 18  # two elements of nine
    K, M = (stored(jobs / "inner", suffix) for suffix in ("sti", "mas"))
    follow = -np.linalg.solve(K[36:, 36:], K[36:, :36])
    T = np.vstack((np.eye(36), follow))
    assert abs(model.stiffness - T.T @ K @ T).max() < 1e-12 * K.max()
    assert abs(model.mass - T.T @ M @ T).max() < 1e-12 * M.max()
    assert model.mass_field is not None  # exact inertia of the body that moves
    assert abs(model.mass_field.mass_matrix() - model.mass).max() == 0.0
    assert model.elasticity is None  # displacements of nodes do not give the strains
    assert len(model.groups["TIP"].nodes) == 4


def squares(K: np.ndarray, M: np.ndarray, count: int) -> np.ndarray:
    """The first squared elastic frequencies, (rad/s)^2, also where some motions have no mass."""
    shares = np.sort(scipy.linalg.eigvalsh(M, K / TYPICAL + M))[::-1]  # of mass in both, rigid motions first
    return TYPICAL * (1.0 / shares[6 : 6 + count] - 1.0)


def test_incompatible_modes_that_follow_by_statics_raise_frequencies_little(jobs: Path) -> None:
    """Of two elements none to round-off where inner modes take no part; it falls with the square of their size."""
    model = read_calculix(jobs / "inner" / "job.inp")
    theirs = squares(stored(jobs / "inner", "sti"), stored(jobs / "inner", "mas"), 4)
    ratio = squares(model.stiffness.toarray(), model.mass.toarray(), 4) / theirs
    assert (ratio > 1.0 - 1e-9).all()  # eight digits are stored
    assert ratio[0] < 1.02


def test_motions_without_stiffness_and_mass_are_held(jobs: Path) -> None:
    """One C3D20R has six; of all others squared frequencies are those of the matrices in their complement."""
    model = read_calculix(jobs / "reduced" / "job.inp")
    assert checked(model, 7850.0)["held_null_vectors"] == 6
    K, M = (stored(jobs / "reduced", suffix) for suffix in ("sti", "mas"))
    _, vectors = np.linalg.eigh(K / K.max() + M / M.max())
    left = vectors[:, 6:]
    theirs = squares(left.T @ K @ left, left.T @ M @ left, 12)
    ours = squares(model.stiffness.toarray(), model.mass.toarray(), 12)
    np.testing.assert_allclose(ours, theirs, rtol=1e-9)
    u = np.zeros((20, 3))
    u[:, 0] = model.nodes[:, 0]  # a stretch of 1 along x
    assert model.elasticity is not None
    energy = u.ravel() @ model.stiffness @ u.ravel()
    assert energy == pytest.approx(model.elasticity.table[0, 0, 0] * 1.0, rel=1e-9)  # moduli times 1 m3
    assert model.cells[0].kind == "hexahedron20"


def test_rigid_bodies_turn_at_their_reference_nodes(jobs: Path) -> None:
    """One without REF NODE is made at the origin, its nodes behind the highest label; masses of no rows are told."""
    with pytest.warns(DeckWarning, match=r"job\.inp: nodes 200 of \*MASS are of no other element"):
        model = read_calculix(jobs / "rigid" / "job.inp", groups={"tip": 100})
    assert checked(model, 0.125 * 7850.0 + 3.0)["following_rotations"] == 12  # four nodes between the rigid ends
    assert len(model.components) == 6
    assert model.nodes[model.groups["tip"].nodes[0]] == pytest.approx([1.2, 0.25, 0.125])
    assert len(model.nodes) == 6
    assert not model.cells  # all have nodes that follow


@pytest.mark.parametrize(
    ("name", "error", "match"),
    [
        ("held", ModelError, r"node 1 has no row 2: \*BOUNDARY \(line 34\) holds it"),
        ("equation", ModelError, r"node 6 has no row 1, which a constraint takes: \*EQUATION \(line 33\)"),
        ("knot", ModelError, r"elements meet at an angle at 2, in rigid knots of CalculiX\. Remedy: mesh"),
    ],
)
def test_rows_that_lack_are_named(jobs: Path, name: str, error: type[Exception], match: str) -> None:
    with pytest.raises(error, match=match):
        read_calculix(jobs / name / "job.inp")


def test_shells_are_the_solids_that_they_become(jobs: Path) -> None:
    """A cylinder's eighth of one S8: places by the binary results; mass of the solid, area times thickness."""
    model = read_calculix(jobs / "shell" / "job.inp")
    assert checked(model, float(model.provenance["self_check"]["mass"]))["condensed"] == 0
    assert [(block.kind, block.nodes.shape) for block in model.cells] == [("hexahedron20", (1, 20))]
    root = model.nodes[model.groups["ROOT"].nodes]
    assert len(root) == 8  # two corners of three layers, one between of two
    assert root[:, 1] == pytest.approx(np.zeros(8), abs=0.01)
    assert np.hypot(*model.nodes[:, :2].T).min() == pytest.approx(0.65, abs=1e-3)


def test_shells_of_first_order_have_incompatible_modes(jobs: Path) -> None:
    model = read_calculix(jobs / "quad" / "job.inp")
    assert checked(model, 1.0 * 0.5 * 0.1 * 7850.0)["condensed"] == 9
    assert model.nodes[:, 2].tolist() == [-0.05, 0.05] * 4


LATER = "*END STEP\n*STEP, PERTURBATION\n"


def changed(jobs: Path, folder: Path, name: str, suffix: str, old: str, new: str) -> Path:
    """A job with one file changed."""
    shutil.copytree(jobs / name, folder / name)
    path = folder / name / f"job.{suffix}"
    text = path.read_text(encoding="latin-1")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="latin-1")
    return folder / name / "job.inp"


@pytest.mark.parametrize(
    ("name", "suffix", "old", "new", "match"),
    [
        ("inner", "dof", "1.1\n", "", "has 54 diagonal entries, and .* names 53 rows"),
        ("inner", "dof", "1.1\n", "1.2\n", "names rows twice"),
        ("inner", "dof", "1.1\n", "1,1\n", "does not name rows, as node.direction"),
        ("inner", "dof", "1.1\n1.2\n1.3\n", "99.1\n99.2\n99.3\n", r"7 in all\), and its 2 elements .* would make 6"),
        ("inner", "inp", "C3D8I", "C3D8", r"nodes that the deck does not have: 13 to 18 \(6 in all\)"),
        ("inner", "sti", "1 1  ", "2 1  ", "is no upper triangle with each entry once"),
        ("inner", "sti", "54 54", "", "is truncated"),
        (
            "inner",
            "inp",
            "*STEP\n",
            "*STEP\n*STATIC\n*END STEP\n*STEP, PERTURBATION\n",
            "in a perturbation .* of .STATIC",
        ),
        ("quad", "frd", "    2C", "    3C", r"job\.frd has no nodes\. Remedy: a step .*NODE OUTPUT, OUTPUT=3D"),
        ("quad", "12d", "C3D8I", "C3D9I", "has elements of type C3D9I"),
        ("quad", "inp", "TYPE=S4", "TYPE=CPS4", "is of plane elements"),
    ],
)
def test_files_that_do_not_belong_together(
    jobs: Path, tmp_path: Path, name: str, suffix: str, old: str, new: str, match: str
) -> None:
    with pytest.raises((FileError, ModelError), match=match):
        read_calculix(changed(jobs, tmp_path, name, suffix, old, new))


def test_matrices_in_axes_of_nodes_are_refused(jobs: Path, tmp_path: Path) -> None:
    old, new = "SOLVER=MATRIXSTORAGE", "SOLVER=MATRIXSTORAGE, GLOBAL=NO\n*TRANSFORM, NSET=TIP\n1,1,0,-1,1,0"
    with pytest.raises(ModelError, match=r"GLOBAL=NO, by which CalculiX 2\.20 stores K in axes of nodes and M"):
        read_calculix(changed(jobs, tmp_path, "inner", "inp", old, new))


def test_substructures_of_calculix_are_refused(jobs: Path, tmp_path: Path) -> None:
    path = tmp_path / "part.mtx"
    path.write_text("**\n** GENERATION OF SUBSTRUCTURE\n**\n*USER ELEMENT, NODES=1, LINEAR\n")
    with pytest.raises(FileError, match="with all others held"):
        kf.read_abaqus(jobs / "inner" / "job.inp", substructure=path)
    with pytest.raises(FileError, match=r"kf\.read_calculix"):
        kf.read_abaqus(jobs / "inner" / "job.inp", jobs / "inner" / "job.sti", jobs / "inner" / "job.mas")


BOX = (8, 2, 2)
"""Numbers of C3D8 along a cantilever of 1 m."""


def box() -> str:
    places = [(x, y, z) for z in range(BOX[2] + 1) for y in range(BOX[1] + 1) for x in range(BOX[0] + 1)]
    label = {place: i for i, place in enumerate(places, 1)}
    text = "*NODE, NSET=ALL\n" + "".join(f"{label[p]},{p[0] / 8},{p[1] / 20},{p[2] / 10}\n" for p in places)
    text += "*ELEMENT, TYPE=C3D8, ELSET=E\n"
    ring = ((0, 0), (1, 0), (1, 1), (0, 1))
    cells = [(x, y, z) for x in range(BOX[0]) for y in range(BOX[1]) for z in range(BOX[2])]
    for i, (x, y, z) in enumerate(cells, 1):
        text += f"{i}," + ",".join(str(label[x + a, y + b, z + c]) for c in (0, 1) for a, b in ring) + "\n"
    text += "*MATERIAL, NAME=S\n*ELASTIC\n2.1E11,.3\n*DENSITY\n7850.\n*SOLID SECTION, ELSET=E, MATERIAL=S\n"
    return text + "*NSET, NSET=ROOT\n" + "".join(f"{label[p]}\n" for p in places if p[0] == 0)


def eigenvalues(path: Path, count: int) -> np.ndarray:
    """Squared frequencies as STORAGE=YES keeps them: behind their number, in double precision."""
    data = path.read_bytes()
    for at in (match.start() for match in re.finditer(re.escape(np.int32(count).tobytes()), data)):
        found = np.frombuffer(data, "<f8", count, at + 4)
        if (np.diff(found) > 0.0).all() and found[0] > 1.0:
            return found
    raise AssertionError("no eigenvalues")


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
def test_frequencies_of_calculix_itself(tmp_path: Path) -> None:
    """The first eight of a box that is clamped: to the tolerance of ARPACK in CalculiX, below 1e-9 in 2.20."""
    steps = {
        "free": "*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n*END STEP\n",
        "held": "*BOUNDARY\nROOT,1,3\n*STEP\n*FREQUENCY, STORAGE=YES\n20\n*END STEP\n",
    }
    for name, step in steps.items():
        (tmp_path / f"{name}.inp").write_text(box() + step)
        subprocess.run(["ccx", name], cwd=tmp_path, check=True, capture_output=True, timeout=60)
    model = read_calculix(tmp_path / "free.inp")
    body = kf.flexible_body(model, {"ROOT": "clamped"}, reduction=kf.CraigBampton(modes=8))
    theirs = np.sqrt(eigenvalues(tmp_path / "held.eig", 20)[:8]) / (2.0 * np.pi)
    np.testing.assert_allclose(body.frequencies[:8], theirs, rtol=1e-8)
