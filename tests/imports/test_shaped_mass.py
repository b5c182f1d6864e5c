"""Craig-Bampton models with the shapes of all nodes and their mass: the inertia of the full model, moved and bent."""

from __future__ import annotations

import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import ModelError, UnitWarning
from kanefe.fe_model.model import MassField
from kanefe.imports.nodal_inertia import NodalFormWarning
from kanefe.imports.output4 import output4_matrices
from kanefe.imports.rigid_parts import is_round_off, rigid_parts

FRAME = Path(__file__).with_name("mystran_18_0_0.zip")
"""A portal of six CBAR, deck and KXX, MXX, PHIXG, MGG of SOL 31: MYSTRAN 18.0.0; two grid points have own axes."""

HALF = 7850.0 * 4e-4 * 0.5 / 2.0
"""Mass of half a bar, kg: a lumped one."""

MASSES = np.array([1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 1.0]) * HALF
"""Of the grid points in the order of their cards."""

OFFSET, POINT_MASS, AT = np.array([0.05, 0.0, 0.0]), 2.0, 2
"""The CONM2, m and kg, and the row of its grid point."""


@pytest.fixture(scope="module")
def frame(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("frame")
    with zipfile.ZipFile(FRAME) as archive:
        archive.extractall(folder)
    return folder / "m.bdf"


def read(frame: Path, **options: object) -> kf.FiniteElementModel:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnitWarning)
        warnings.simplefilter("error", NodalFormWarning)  # nothing is estimated
        return kf.read_nastran(frame, frame.with_name("m.OU1"), groups={"root": 1, "tip": 99}, **options)  # type: ignore[arg-type]


def energy(field: MassField, spin: np.ndarray, q: np.ndarray, rate: np.ndarray) -> float:
    """Kinetic energy, J, of points that move with q and turn about the origin."""
    places = field.points + (field.interpolation @ q).reshape(-1, 3)
    v = np.cross(spin, places) + (field.interpolation @ rate).reshape(-1, 3)
    return float(0.5 * np.einsum("ia,ij,ja->", v, field.mass.toarray(), v))


def test_the_mass_points_of_a_frame_of_mystran(frame: Path) -> None:
    model = read(frame)
    assert model.mass_field is not None
    assert abs(model.mass_field.mass_matrix() - model.mass).max() < 1e-14 * abs(model.mass).max()
    rng = np.random.default_rng(3)
    q, rate = 0.1 * rng.standard_normal((2, model.size))
    spin = rng.standard_normal(3)

    # the same by the rows of the file and the masses of the deck; boundary rows there: GRID 1, then 99 in its axes
    shapes = output4_matrices(frame.with_name("m.OU1"), {"PHIXG"})["PHIXG"].toarray()
    z = np.ones(3) / np.sqrt(3.0)  # CORD2R: z along (1, 1, 1), x towards (1, 0, 0)
    x = np.array([1.0, 0.0, 0.0]) - z[0] * z
    axes = np.column_stack((x / np.linalg.norm(x), np.cross(z, x / np.linalg.norm(x)), z))
    to_G = np.kron(np.eye(2), axes)
    moved = []
    for coordinates in (q, rate):
        own = coordinates.copy()
        own[6:12] = to_G.T @ coordinates[6:12]
        u = (shapes @ own).reshape(7, 6)
        u[3], u[6] = to_G @ u[3], to_G @ u[6]  # GRID 197 and 99
        moved.append(u)
    points = np.array([(0, 0, 0), (0, 0, 0.5), (0, 0, 1), (0.5, 0, 1), (1, 0, 1), (1, 0, 0.5), (1, 0, 0)])
    u, v = moved
    velocity = np.cross(spin, points + u[:, :3]) + v[:, :3]
    expected = 0.5 * MASSES @ (velocity**2).sum(axis=1)
    place = points[AT] + u[AT, :3] + OFFSET + np.cross(u[AT, 3:], OFFSET)
    expected += 0.5 * POINT_MASS * ((np.cross(spin, place) + v[AT, :3] + np.cross(v[AT, 3:], OFFSET)) ** 2).sum()
    assert energy(model.mass_field, spin, q, rate) == pytest.approx(expected, rel=1e-12)


def test_units_scale_the_mass_points(frame: Path) -> None:
    """Read as if in mm and t: lengths a thousandth, masses a thousandfold."""
    model, small = read(frame), read(frame, units=(1e-3, 1e3))
    assert model.mass_field is not None
    assert small.mass_field is not None
    assert abs(small.mass_field.mass_matrix() - small.mass).max() < 1e-14 * abs(small.mass).max()
    np.testing.assert_allclose(small.mass_field.points, 1e-3 * model.mass_field.points)


def test_shapes_of_another_run_are_refused(frame: Path, tmp_path: Path) -> None:
    for name, old, new, match in (
        ("card", "GRID,198,,0.00", "GRID,198,,0.10", "does not move all grid points rigidly"),
        ("point", "ENDDATA", "GRID,500,,0.,0.,0.\nENDDATA", r"PHIXG has shape \(42, 18\) .* make \(48, 18\)"),
    ):
        deck = tmp_path / f"{name}.bdf"
        deck.write_text(frame.read_text().replace(old, new))
        with pytest.raises(ModelError, match=match):
            kf.read_nastran(deck, frame.with_name("m.OU1"), groups={"root": 1, "tip": 99})


def test_consistent_masses_of_solids_are_points_of_the_nodes() -> None:
    rng = np.random.default_rng(5)
    scalar = rng.standard_normal((4, 4))
    scalar = scalar @ scalar.T
    M = sp.csr_matrix(np.kron(scalar, np.diag((1.0, 1.0, 1.0, 0.0, 0.0, 0.0))))
    shapes, points = rng.standard_normal((24, 5)), rng.standard_normal((4, 3))
    field = rigid_parts(M, points, sp.csr_matrix(shapes)).field
    assert len(field.points) == 4
    np.testing.assert_allclose(field.mass_matrix().toarray(), shapes.T @ M @ shapes, rtol=1e-12)
    across = M.tolil()
    across[3, 6] = across[6, 3] = 1.0  # between a turn about x and a displacement along x: of no points
    assert not is_round_off(across - rigid_parts(across.tocsr(), points, sp.csr_matrix(shapes)).mass, across)
