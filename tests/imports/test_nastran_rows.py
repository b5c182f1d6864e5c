"""Rows of matrices without labels, as MYSTRAN writes them, and grid points that only rigid elements hold."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg

import import_writers as write
import kanefe as kf
from kanefe.errors import AccuracyWarning, ModelError
from kanefe.imports.included import DeckWarning
from kanefe.imports.nodal_inertia import NodalFormWarning
from scenes import lattice_model
from steel_beams import steel_beam

N = 10
BEAM = steel_beam(N)
LABELS = np.array([50, *range(1, N), 7 + N])
"""Those of the nodes along the beam: the root has a higher one than the tip."""

MODES = 8


def craig_bampton() -> tuple[np.ndarray, np.ndarray]:
    """K and M of boundary nodes at both ends, in their order along the beam, and of modes behind them."""
    K, M = BEAM.stiffness.toarray(), BEAM.mass.toarray()
    ends, rest = np.r_[0:6, 6 * N : 6 * N + 6], np.arange(6, 6 * N)
    inner = np.ix_(rest, rest)
    T = np.zeros((len(K), 12 + MODES))
    T[ends, range(12)] = 1.0
    T[rest, :12] = -np.linalg.solve(K[inner], K[np.ix_(rest, ends)])
    T[rest, 12:] = scipy.linalg.eigh(K[inner], M[inner], subset_by_index=(0, MODES - 1))[1]
    return T.T @ K @ T, T.T @ M @ T


def job(
    folder: Path, matrices: dict[str, np.ndarray], cards: str = "", labels: np.ndarray = LABELS
) -> tuple[Path, Path]:
    bulk = write.nastran_bulk(folder / "bar.bdf", BEAM.nodes, labels, cards)
    return bulk, write.output4(folder / "bar.OU1", matrices)


def read(*paths: Path, **options: Any) -> kf.FiniteElementModel:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NodalFormWarning)
        return kf.read_nastran(*paths, groups={"root": 50, "tip": 7 + N}, **options)


SUPORT = f"SUPORT  {7 + N:8d}  123456      50  123456"


@pytest.mark.parametrize(
    ("cards", "options"),
    [(SUPORT, {}), ("", {"boundary": [(7 + N, 123456), (50, "123456")]})],
    ids=["by SUPORT", "by boundary"],
)
def test_a_craig_bampton_model_of_mystran(cards: str, options: dict[str, Any], tmp_path: Path) -> None:
    K, M = craig_bampton()
    model = read(*job(tmp_path, {"KXX": K, "MXX": M}, cards), **options)
    assert model.generalised == MODES
    body = kf.flexible_body(model, {"root": "clamped", "tip": "node"})
    held = scipy.linalg.eigh(K[6:, 6:], M[6:, 6:], eigvals_only=True)
    assert body.frequencies == pytest.approx(np.sqrt(held) / 2 / np.pi, rel=1e-8)  # round-off of K over its lowest
    assert body.interfaces[1].position == pytest.approx((1.0, 0.0, 0.0), abs=1e-9)  # cards have ten digits


def test_what_a_craig_bampton_model_lacks_is_asked_for(tmp_path: Path) -> None:
    K, M = craig_bampton()
    paths = job(tmp_path, {"KXX": K, "MXX": M})
    with pytest.raises(ModelError, match=r"has shape \(20, 20\), .* say boundary=\[\(grid, components\), \.\.\.\]"):
        read(*paths)
    for boundary, message in (
        ([(7 + N, 123457), (50, 123456)], "boundary must be grid points and their components"),
        ([50], "boundary must be grid points and their components"),
        ([(51, 123456)], r"the boundary has 1 node\(s\) that the table of nodes does not hold: 51"),
        ([(n, 123456) for n in (1, 2, 3, 4)], "the boundary has 24 components, the matrices have 20 rows"),
    ):
        with pytest.raises(ModelError, match=message):
            read(*paths, boundary=boundary)


@pytest.mark.parametrize("by", ["cards", "labels"])
def test_grid_points_in_the_order_of_their_cards_or_labels(by: str, tmp_path: Path) -> None:
    at = np.arange(N + 1) if by == "cards" else np.argsort(LABELS)
    rows = (6 * at[:, None] + np.arange(6)).ravel()
    pair = {name: m.toarray()[np.ix_(rows, rows)] for name, m in (("KGG", BEAM.stiffness), ("MGG", BEAM.mass))}
    body = kf.flexible_body(read(*job(tmp_path, pair)), {"root": "clamped"})
    whole = BEAM.stiffness.toarray()[6:, 6:], BEAM.mass.toarray()[6:, 6:]
    right = np.sqrt(scipy.linalg.eigh(*whole, eigvals_only=True)[:6]) / 2 / np.pi
    assert body.frequencies[:6] == pytest.approx(right, rel=1e-7)  # cards have ten digits


def test_an_order_that_the_matrices_do_not_show_is_asked_for(tmp_path: Path) -> None:
    K, M = craig_bampton()
    K[:12], K[:, :12] = 0.0, 0.0  # as of a boundary that is statically determinate
    with pytest.raises(ModelError, match=r"in ascending labels or in the order of their cards: .* Remedy: freedoms="):
        read(*job(tmp_path, {"KXX": K, "MXX": M}, SUPORT))


SOLID = lattice_model(0)


def rigid_job(folder: Path, mass: float = 0.0) -> tuple[Path, Path]:
    """A solid with an RBE2 between its first three nodes and one more, 77, beside it, and a mass there."""
    labels = np.array([3, 4, 10, 11, 17, 101, 102, 400, 9001])
    cards = "RBE2, 60, 77, 123456, 3, 4, 10\nGRID, 77, , 0., 0., -1."
    rows = np.add.outer(6 * np.arange(9), np.arange(3)).ravel()
    pair = {}
    for name, m in (("KGG", SOLID.stiffness), ("MGG", SOLID.mass)):
        pair[name] = np.zeros((60, 60))
        pair[name][np.ix_(rows + 6, rows + 6)] = m.toarray()
    pair["MGG"][:3, :3] = mass * np.eye(3)
    bulk = write.nastran_bulk(folder / "arm.bdf", SOLID.nodes, labels, cards)
    return bulk, write.output4(folder / "arm.OU1", pair)


def test_cards_that_are_not_known_are_named(tmp_path: Path) -> None:
    K, M = craig_bampton()
    paths = job(tmp_path, {"KXX": K, "MXX": M}, f"{SUPORT}\nGRIT, 99\nPARAM, POST, -1\nGRIT, 98")
    with pytest.warns(DeckWarning, match=r"bar\.bdf has cards that are not known, and left out: GRIT \(line 3\)\. Rem"):
        assert read(*paths).generalised == MODES


def test_grid_points_of_rigid_elements_are_named(tmp_path: Path) -> None:
    paths = rigid_job(tmp_path)
    with pytest.warns(
        AccuracyWarning, match=r"KGG knows nothing of rigid elements and MPC: the body is without RBE2 60\."
    ):
        model = kf.read_nastran(*paths)
    assert kf.flexible_body(model).frequencies == pytest.approx(kf.flexible_body(SOLID).frequencies, rel=1e-7)
    with pytest.raises(
        ModelError, match=r"group 'hub' has grid point 77, which is in RBE2 60 \(arm.bdf, line 2\) only"
    ):
        kf.read_nastran(*paths, groups={"hub": 77})
    with pytest.raises(ModelError, match=r"grid point 77 has mass, which is in RBE2 60 .* only: KGG has no stiffness"):
        kf.read_nastran(*rigid_job(tmp_path, mass=1.0))
