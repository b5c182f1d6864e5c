"""Matrices of shells as other programs give them: what is not in them is told, with its size."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import AccuracyWarning, FileError
from kanefe.fe_model.model import COMPONENTS
from kanefe.imports.nodal_inertia import NodalFormWarning
from kanefe_fem import Material, Rectangle, Stiffener, shell_model, surface_mesh

pytestmark = pytest.mark.fenicsx

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
THICKNESS = 0.04


def plate(nx: int = 6, ny: int = 5):
    return shell_model(surface_mesh(lambda s, r: (s, 0.8 * r, 0.0 * s), (nx, ny)), STEEL, THICKNESS)


def first(K: sp.csr_matrix, masses: np.ndarray) -> float:
    """Lowest elastic squared frequency of a free body; rotations without mass follow."""
    heavy = masses > 1e-12 * masses.max()
    k, light = K.toarray(), ~heavy
    own = k[np.ix_(heavy, heavy)]
    if light.any():
        own = own - k[np.ix_(heavy, light)] @ la.solve(k[np.ix_(light, light)], k[np.ix_(light, heavy)])
    return float(la.eigh(own, np.diag(masses[heavy]), eigvals_only=True, subset_by_index=(6, 6))[0])


def test_a_file_of_matrices_keeps_the_mass_field(tmp_path):
    """With a rib beside the surface, whose shape functions M and K alone do not tell."""
    rib = Stiffener(Rectangle(0.01, 0.05), STEEL, "below")
    model = shell_model(surface_mesh(lambda s, r: (s, 0.8 * r, 0.1 * s * r), (4, 3)), STEEL, 0.01, beams={"root": rib})
    kf.write_matrices(model, tmp_path / "panel.npz")
    with warnings.catch_warnings():
        warnings.simplefilter("error", NodalFormWarning)
        warnings.simplefilter("ignore", AccuracyWarning)  # a rib has entries that its neighbours have not
        read = kf.read_matrices(tmp_path / "panel.npz")
    assert "estimated_inertia" not in read.provenance
    for name in ("points", "mass", "interpolation", "turns", "arms"):
        own, found = (getattr(one.mass_field, name) for one in (model, read))
        assert abs(own - found).max() == 0.0, name
    arrays = dict(np.load(tmp_path / "panel.npz"))
    del arrays["field_mass_data"]
    np.savez(tmp_path / "half.npz", **arrays)
    with pytest.raises(FileError, match=r"the mass field has no masses"):
        kf.read_matrices(tmp_path / "half.npz")


def test_a_mass_without_rotary_inertia_is_told_with_its_size():
    """A lumped free plate: the thickness that makes 1 % of the first frequency, by frequencies with and without it."""
    model = plate()
    of_nodes = np.asarray(model.mass[::6, ::6].sum(axis=1)).ravel()
    lumped = np.kron(of_nodes, [1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    rotary = np.kron(of_nodes, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]) * THICKNESS**2 / 12.0
    read = kf.model_from_matrices(sp.diags(lumped).tocsr(), model.stiffness, model.nodes, components=COMPONENTS)
    slope = read.provenance["self_check"]["slope"]
    ratio = first(model.stiffness, lumped) / first(model.stiffness, lumped + rotary)
    # of the squared frequency; the mode is that of the diagonal, whose rotations have some inertia
    assert ratio - 1.0 == pytest.approx((THICKNESS * slope) ** 2 / 12.0, rel=0.05)
    (told,) = read.provenance["told"]
    assert f"the lowest mode 1 % if t is {np.sqrt(0.24) / slope:.2g} m" in told
    edge = kf.Interface("all", kind="average", at=kf.OnPlane((0, 0, 0), (1, 0, 0)))
    body = kf.flexible_body(read, {"edge": edge}, reduction=kf.CraigBampton(modes=4))
    assert "no rotary inertia" in str(body)
    whole = kf.model_from_matrices(model.mass, model.stiffness, model.nodes, components=COMPONENTS)
    assert "told" not in whole.provenance
