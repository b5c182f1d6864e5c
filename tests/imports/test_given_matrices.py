"""Models from given matrices and nodes: what is taken over, and what is found wrong on entry."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import AccuracyWarning, FileError, KanefeError, ModelError
from kanefe.imports.mass_properties import mass_properties
from kanefe.imports.nodal_inertia import NodalFormWarning
from kanefe.reduction import flexible_body
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Rectangle
from scenes import lattice_model
from steel_beams import STEEL, steel_beam

LATTICE = lattice_model(0)
GROUPS = {name: group.nodes.tolist() for name, group in LATTICE.groups.items()}
BEAM = steel_beam(6)


def given(M: Any = None, K: Any = None, nodes: Any = None, **options: Any) -> kf.FiniteElementModel:
    return kf.model_from_matrices(
        LATTICE.mass if M is None else M,
        LATTICE.stiffness if K is None else K,
        LATTICE.nodes if nodes is None else nodes,
        **{"groups": GROUPS, **options},
    )


def test_translations_give_the_exact_body() -> None:
    model = given()
    assert model.mass_field is not None
    interfaces = {"root": "clamped", "tip": "rigid"}
    ours, reference = flexible_body(model, interfaces), flexible_body(LATTICE, interfaces)
    assert ours.is_exact
    for name, array in reference.moments.arrays().items():
        assert ours.moments.arrays()[name] == pytest.approx(array, abs=1e-14), name
    assert ours.frequencies == pytest.approx(reference.frequencies, rel=1e-12)


@pytest.mark.parametrize("kind", [sp.csr_matrix, sp.coo_matrix, sp.csc_matrix, np.asarray], ids=lambda k: k.__name__)
def test_any_form_of_matrix_is_taken(kind: Any) -> None:
    model = given(kind(LATTICE.mass.toarray()), kind(LATTICE.stiffness.toarray()))
    assert abs(model.stiffness - LATTICE.stiffness).max() < 1e-15
    assert sp.isspmatrix_csr(model.mass)


@pytest.mark.parametrize("suffix", [".npz", ".mtx"])
def test_files_are_read(suffix: str, tmp_path: Path) -> None:
    paths = [tmp_path / f"M{suffix}", tmp_path / f"K{suffix}"]
    for path, matrix in zip(paths, (LATTICE.mass, LATTICE.stiffness), strict=True):
        if suffix == ".npz":
            sp.save_npz(path, matrix)
        else:
            scipy.io.mmwrite(path, matrix, symmetry="symmetric", precision=17)
    model = given(*paths)
    assert abs(model.stiffness - LATTICE.stiffness).max() < 1e-12
    assert abs(model.mass - LATTICE.mass).max() < 1e-15


def test_seven_digits_are_round_off() -> None:
    rounded = [np.vectorize(lambda x: float(f"{x:.7g}"))(m.toarray()) for m in (LATTICE.mass, LATTICE.stiffness)]
    skewed = rounded[1].copy()
    skewed[0, 1] *= 1 + 1e-7
    model = given(rounded[0], skewed)
    assert abs(model.stiffness - model.stiffness.T).max() == 0.0


def test_nodes_that_rotate_have_exact_inertia() -> None:
    model = given(BEAM.mass, BEAM.stiffness, BEAM.nodes, components=BEAM.components, groups={"root": 0, "tip": 6})
    body = flexible_body(model, {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=3))
    reference = flexible_body(BEAM, {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=3))
    assert body.is_exact
    assert body.frequencies == pytest.approx(reference.frequencies, rel=1e-9)
    assert body.mass == pytest.approx(reference.mass, rel=1e-12)


def test_no_warning_without_rotations() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        given()


def test_of_a_matrix_with_directions_of_their_own_the_rest_is_estimated() -> None:
    M = LATTICE.mass.toarray()
    M[0, 3] += 1e-3
    M[3, 0] += 1e-3
    M[0, 0] -= 1e-3
    M[3, 3] -= 1e-3  # the mass along x is the same, but M is not a scalar matrix
    with (
        pytest.warns(AccuracyWarning, match=r"mass between nodes 0 and 0 \(from 0\) differs between x and y"),
        pytest.warns(NodalFormWarning, match=r"0\.\d+ is estimated"),
    ):
        model = given(M)
    assert model.mass_field is not None
    assert abs(model.mass_field.mass_matrix() - M).max() < 1e-12 * M.max()


def without(matrix: sp.csr_matrix, i: int, j: int) -> sp.csr_matrix:
    changed = matrix.tolil()
    changed[i, j] = changed[j, i] = 0.0
    return changed.tocsr()


def test_entries_that_are_missing_are_seen() -> None:
    beam = steel_beam(4)
    for (i, j), message in (
        ((1, 5), "first moment by its matrix differs between axes: translation along y and rotation about z"),
        ((4, 4), r"between rows \d+ and \d+ \(from 0\) is larger than the root of the product of their own"),
    ):
        with pytest.raises(ModelError, match=message):
            kf.model_from_matrices(without(beam.mass, i, j), beam.stiffness, beam.nodes, components=beam.components)
    uneven = beam.mass.tolil()
    uneven[4, 10] *= 1.001
    with pytest.raises(ModelError, match=r"rows 4 and 10 \(from 0\) has another value than its mirror"):
        kf.model_from_matrices(uneven.tocsr(), beam.stiffness, beam.nodes, components=beam.components)


def test_planar_bodies() -> None:
    flat = lattice_model(1, planar=True)
    model = kf.model_from_matrices(flat.mass, flat.stiffness, flat.nodes, components=("x", "y"))
    assert model.mass_field is not None
    assert flexible_body(model, {}, reduction=kf.CraigBampton(modes=2)).free_count == 2


def test_mass_properties_are_those_of_the_points() -> None:
    mass, com, inertia = mass_properties(LATTICE)
    scalar = LATTICE.mass.toarray()[::3, ::3]
    second = LATTICE.nodes.T @ scalar @ LATTICE.nodes
    assert mass == pytest.approx(scalar.sum(), rel=1e-13)
    assert com == pytest.approx(scalar.sum(axis=0) @ LATTICE.nodes / mass, abs=1e-13)
    assert inertia == pytest.approx(np.trace(second) * np.eye(3) - second, abs=1e-13)


def test_mass_properties_with_the_centre_on_an_axis_and_in_the_plane() -> None:
    # a zero of the first moment must not be taken for a missing entry, nor a missing row for a zero
    for model in (BEAM, lattice_model(1, planar=True)):
        width = len(model.components)
        ones = model.mass.toarray()[::width, ::width]
        mass, com, _ = mass_properties(model)
        assert mass == pytest.approx(ones.sum(), rel=1e-12)
        expected = flexible_body(model, {}, reduction=kf.CraigBampton(modes=1)).center_of_mass
        assert com == pytest.approx(expected, abs=1e-12)


def changed(matrix: sp.csr_matrix, *entries: tuple[int, int, float]) -> np.ndarray:
    dense = matrix.toarray()
    for row, column, value in entries:
        dense[row, column] = value
    return dense


def shuffled(nodes: np.ndarray) -> np.ndarray:
    return nodes[np.random.default_rng(0).permutation(len(nodes))]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: given(nodes=np.zeros((9, 2))),
            r"nodes must be finite numbers of shape \(n, 3\) in m, not of shape \(9, 2\)",
        ),
        (lambda: given(nodes=LATTICE.nodes * np.nan), "nodes must be finite numbers"),
        (lambda: given(components=("x", "y", "w")), "components must be different names among x, y, z, rx, ry, rz"),
        (lambda: given(components=("x", "x", "z")), "components must be different names"),
        (
            lambda: given(nodes=LATTICE.nodes[:8]),
            r"mass matrix has shape \(27, 27\), nodes and components give 24 .* Remedy",
        ),
        (lambda: given(K=np.eye(26)), r"the stiffness matrix has shape \(26, 26\)"),
        (lambda: given(damping=np.eye(3)), r"the damping matrix has shape \(3, 3\)"),
        (lambda: given(changed(LATTICE.mass, (2, 2, np.nan))), "the mass matrix has 1 entries that are not finite"),
        (
            lambda: given(K=changed(LATTICE.stiffness, (0, 1, np.inf))),
            "the stiffness matrix has 1 entries that are not finite",
        ),
        (
            lambda: given(K=np.triu(LATTICE.stiffness.toarray())),
            "stiffness matrix is not symmetric.* Remedy: export the full",
        ),
        (lambda: given(changed(LATTICE.mass, (0, 5, 0.5))), "the mass matrix is not symmetric"),
        (lambda: given(-LATTICE.mass), "the mass matrix has a negative diagonal entry"),
        (lambda: given(changed(LATTICE.mass, (4, 4, -0.1))), r"negative diagonal entry \(-0\.1, row 4\)"),
        (lambda: given(0 * LATTICE.mass), r"mass by its matrix is .* it must be above zero"),
        (
            lambda: given(changed(LATTICE.mass, (4, 4, 5.0))),
            "differs between directions: .* Remedy: check the order of comp",
        ),
        (
            lambda: given(expected_mass=2000.0),
            r"mass by its matrix is 2 kg, 2000 kg was expected\. Remedy: check units",
        ),
        (
            lambda: given(nodes=shuffled(LATTICE.nodes)),
            "resists the rigid rotation .* nodes and matrix are in the same order",
        ),
        (
            lambda: given(K=LATTICE.stiffness + sp.identity(27)),
            "resists the rigid translation .* Remedy: .*exported unsupported",
        ),
        (
            lambda: given(K=0 * LATTICE.stiffness),
            "leaves more than the rigid motions free: the body falls into 9 loose .* Remedy: check hinges",
        ),
        (lambda: given(groups={"tip": [0, 99]}), r"group 'tip' must be node numbers from 0 to 8, not \[0, 99\]"),
        (lambda: given(groups={"tip": []}), "group 'tip' must be node numbers from 0 to 8"),
        (lambda: given(groups={"tip": [0.5]}), "group 'tip' must be node numbers from 0 to 8"),
    ],
)
def test_bad_input_is_named(make: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        make()


def test_an_order_of_dofs_by_component_is_detected() -> None:
    # All x, then all y, then all z, as some programs export.
    order = np.arange(27).reshape(9, 3).T.ravel()
    with pytest.raises(ModelError, match=r"differs between directions|resists the rigid|are not those of a body"):
        given(LATTICE.mass[order][:, order], LATTICE.stiffness[order][:, order])


def test_an_unbalanced_weak_support_is_detected() -> None:
    # 1e-5 of the stiffness to ground at one node: above round-off of seven digits
    K = LATTICE.stiffness.toarray()
    K[:3, :3] += 1e-4 * abs(K).max() * np.eye(3)
    with pytest.raises(ModelError, match="resists the rigid"):
        given(K=K)


def test_inertia_that_no_body_has_is_detected() -> None:
    M = LATTICE.mass.toarray() * 0
    M[np.diag_indices(27)] = np.repeat(np.linspace(0.1, 0.3, 9), 3)
    # an off-diagonal pair that makes a principal moment negative
    for a in range(3):
        M[a, 24 + a] = M[24 + a, a] = 3.0
    with pytest.raises(ModelError, match=r"principal moments of inertia .* are not those of a body\. Remedy"):
        given(M)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("none.npz", None, r"there is no file .*none\.npz for the mass matrix"),
        ("M.txt", b"1 2 3", r"the mass matrix cannot be read from a \.txt file\. Remedy: \.npz \(scipy\) or \.mtx"),
        ("M.npz", b"garbage", r"cannot read the mass matrix from .*M\.npz: .* Remedy: export it again"),
        ("M.npz", b"", r"cannot read the mass matrix from .*M\.npz: .* Remedy: export it again"),
        ("M.mtx", b"garbage", r"cannot read the mass matrix from .*M\.mtx: .* Remedy: export it again"),
        ("M.mtx", b"%%MatrixMarket matrix coordinate real general\n27 27 3\n1 1 1.0\n", "cannot read the mass matrix"),
    ],
)
def test_bad_files_are_named(name: str, content: bytes | None, message: str, tmp_path: Path) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(FileError, match=message):
        given(path)


def test_a_truncated_npz_is_named(tmp_path: Path) -> None:
    path = tmp_path / "M.npz"
    sp.save_npz(path, LATTICE.mass)
    content = path.read_bytes()
    for share in (0.3, 0.7, 0.95):
        path.write_bytes(content[: int(share * len(content))])
        with pytest.raises(KanefeError, match=r"M\.npz.*Remedy"):
            given(path)


def test_mechanisms_are_detected_in_large_models() -> None:
    # above 400 degrees of freedom the lowest eigenvalues come from a sparse solve
    model = steel_beam(80)
    kf.model_from_matrices(model.mass, model.stiffness, model.nodes, components=model.components)
    K = model.stiffness.toarray()
    half = 6 * 40
    # cut the beam in two: the element between nodes 39 and 40 goes
    element = straight_beam(1.0 / 80, Rectangle(0.02, 0.03), STEEL, elements=1).stiffness
    K[half - 6 : half + 6, half - 6 : half + 6] -= element.toarray()
    with pytest.raises(ModelError, match="leaves more than the 6 rigid motions free"):
        kf.model_from_matrices(model.mass, sp.csr_matrix(K), model.nodes, components=model.components)
