"""Recovery from runs of scenes with solids: a spinning bar (case E02a), dolfinx's own evaluation, files, ParaView."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import kanefe as kf
from fem_meshes import STEEL, box
from kanefe.fe_model.model import Cells, Elasticity
from kanefe.kane.assemble import accelerations
from kanefe.states.state import State
from kanefe.views.player.drawn_modes import von_mises
from kanefe.views.player.page import page_of
from kanefe.views.player.skins import skin_of
from kanefe_fem import _fenicsx
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.recovery.expressions import _Evaluator
from kanefe_fem.recovery.recovery import recover
from kanefe_fem.recovery.strain_fields import StrainFields
from kanefe_fem.solids.body import solid_body
from player_pages import body_of, placed, read_page
from vtk_files import read_grid, read_series

pytestmark = pytest.mark.fenicsx

OMEGA, LENGTH = 100.0, 2.0
ALLOY = Material(E=70e9, nu=0.0, rho=2700.0)
CELLS = 4


def spun(body: kf.FlexibleBody, eta: np.ndarray | None) -> kf.System:
    scene = kf.System()
    hub = scene.add_rigid_body("hub", mass=1.0, joint=kf.Revolute("z", motion=kf.Motion.steady(OMEGA)))
    scene.add_flexible_body("bar", body, parent=hub, at=(0, -0.05, -0.05), modal_coordinates=eta)  # axis through it
    return scene


@cache
def spinning_bar() -> kf.Result:
    """A bar of 4 quadratic hexahedra, clamped on an axis that turns at 100 rad/s, in its steady state."""
    mesh = box("hexahedron", (CELLS, 1, 1), (LENGTH, 0.1, 0.1))
    free = 9 * 2 * CELLS * 3  # all of them, so that nothing is lost: sections of 3 x 3 nodes but for the root
    body = solid_body(mesh, ALLOY, interfaces={"root": "clamped"}, reduction=kf.CraigBampton(modes=free))
    k = body.free_count
    K, M, eta = body.stiffness[:k, :k], body.moments.elastic_mass[:k, :k], np.zeros(k)
    for _ in range(3):  # spin softening, (OMEGA / w_1)^2 = 3e-4, is in the accelerations: each round gains 3 digits
        model = spun(body, eta).freeze()
        rates = accelerations(State(model, 0.0, model.initial_coordinates, model.initial_speeds))
        eta = eta + np.linalg.solve(K, M @ rates)
    return spun(body, eta).simulate((0.0, 2e-5), output_step=1e-5, method="generalised-alpha")


def steady_stress(x: np.ndarray) -> np.ndarray:
    """With spin softening: u = sin(kx)/(k cos(kL)) - x, k = OMEGA sqrt(rho/E); 54 MPa at the root without it."""
    k = OMEGA * np.sqrt(ALLOY.rho / ALLOY.E)
    return ALLOY.E * (np.cos(k * x) / np.cos(k * LENGTH) - 1.0)


class TestSpinningBar:
    def test_the_stress_at_gauss_points_is_that_of_the_closed_form(self):
        fields = recover(spinning_bar(), "bar", frames=[0])
        stress = fields.stress_at_cells("gauss")[0]
        shape = spinning_bar().body("bar")
        corners = np.sort(shape.nodes[shape.cells[0].nodes][:, :, 0], axis=1)
        left, right = corners[:, 0], corners[:, -1]
        half = (right - left) / (2 * np.sqrt(3))
        x = np.repeat(0.5 * (left + right), 8).reshape(-1, 8)
        near, far = steady_stress(x - half[:, None]), steady_stress(x + half[:, None])
        found = np.sort(stress[..., 0], axis=1)[:, ::-1]
        expected = np.hstack((near[:, :4], far[:, 4:]))
        # at these points a linear stress meets the quadratic one; softening and the 7th digit of time steps are left
        np.testing.assert_allclose(found, expected, atol=2e-4 * 54e6)
        # across the bar only rho w^2 (b/2)^2 / 2 = 34 kPa of its own centrifugal load
        assert abs(stress[..., 1:]).max() < 40e3

    def test_the_root_carries_54_MPa_and_the_error_of_four_cells(self):
        envelope = recover(spinning_bar(), "bar").envelope("von_mises")
        # between Gauss points the stress is linear, so at the end of a cell it is off by rho w^2 h^2 / 12
        excess = 54e6 / (6 * CELLS**2)
        assert envelope.peak == pytest.approx(54e6 + excess, rel=1e-3)
        assert envelope.peak_position[0] == 0.0

    def test_a_gauge_along_the_bar(self):
        fields = recover(spinning_bar(), "bar")
        strain = fields.gauge((0.9, 0.05, 0.03), (1, 0, 0))
        assert strain.shape == (3,)
        # within a cell the mean nodal strain is off by h^2/12 of the second derivative at most
        sexcess = OMEGA**2 * ALLOY.rho / ALLOY.E * (LENGTH / CELLS) ** 2 / 12
        np.testing.assert_allclose(strain, steady_stress(0.9) / ALLOY.E, atol=sexcess)


@cache
def cantilever() -> kf.Result:
    """A steel bar that shakes at its clamped root, with a surface that carries a pressure."""
    mesh = box("tetra", (4, 2, 2), (0.3, 0.06, 0.04))
    body = solid_body(mesh, STEEL, interfaces={"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=3))
    scene = kf.System(gravity=(0, 0, -9.81))
    bar = scene.add_flexible_body("bar", body)
    scene.add_rigid_body("mass", mass=1.0, inertia=1e-3, parent=bar.interface("tip"))
    return scene.simulate((0.0, 2e-3), output_step=5e-4, method="generalised-alpha")


class TestExpressions:
    def test_dolfinx_finds_the_same_stress(self):
        fields = recover(cantilever(), "bar", frames=[2, 4])
        for at, mine in (("cells", fields.stress_at_cells()), ("gauss", fields.stress_at_cells("gauss"))):
            theirs = fields.expression(lambda f: f.stress, at=at)
            for number, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]):
                np.testing.assert_allclose(theirs[..., i, j], mine[..., number], atol=1e-9 * abs(mine).max())

    def test_at_nodes_an_expression_is_the_mean_of_the_cells(self):
        fields = recover(cantilever(), "bar", frames=[4])
        # straight cells of order 2: their strain is linear, so values at nodes and those carried there are the same
        theirs = fields.expression(lambda f: f.stress[0, 0])
        mine = fields.stress_at_nodes()[..., 0]
        np.testing.assert_allclose(theirs, mine, atol=1e-9 * abs(mine).max())

    def test_displacement_position_and_functions_of_them(self):
        fields = recover(cantilever(), "bar", frames=[1, 3])
        np.testing.assert_allclose(fields.expression(lambda f: f.u), fields.displacement(), atol=1e-15)
        nodes = cantilever().body("bar").nodes
        np.testing.assert_allclose(fields.expression(lambda f: f.x)[0], nodes, atol=1e-15)
        energy = fields.expression(lambda f: 0.5 * f.ufl.inner(f.stress, f.strain), at="cells")
        product = 0.5 * (fields.stress_at_cells() * fields.strain_at_cells()).sum(axis=-1)
        np.testing.assert_allclose(energy, product, rtol=1e-9)

    @pytest.mark.parametrize("kind", ["tetra", "hexahedron", "triangle"])
    def test_nodes_in_any_order_keep_their_displacements(self, kind):
        d = 2 if kind == "triangle" else 3
        mesh = box(kind, (3, 2, 2)[:d], (0.3, 0.1, 0.08)[:d]).with_order(2)
        cells, rng = Cells(mesh.kind, mesh.connectivity), np.random.default_rng(0)
        u = rng.standard_normal((len(mesh.nodes), 3))
        material = Elasticity(np.zeros((1, 6, 6)), np.zeros(mesh.cell_count, dtype=int))
        fx = _fenicsx.load()
        with _fenicsx.quiet(), _fenicsx.compiling(fx):
            values = _Evaluator(fx, mesh.nodes, cells, material, lambda f: f.u, "nodes").values(u)
        np.testing.assert_allclose(values, u[mesh.connectivity][..., :d], atol=1e-14)

    def test_a_function_that_gives_no_expression_is_refused(self):
        with pytest.raises(kf.ModelError, match=r"not a UFL expression.*Remedy"):
            recover(cantilever(), "bar", frames=[0]).expression(lambda f: 3.0)


def test_a_saved_result_gives_the_same_stresses(tmp_path):
    result = cantilever()
    result.save(tmp_path / "run.h5")
    again = kf.load_result(tmp_path / "run.h5")
    mine, theirs = (recover(r, "bar", frames=[3]).von_mises for r in (result, again))
    np.testing.assert_allclose(mine, theirs, rtol=1e-12)


def test_two_results_of_one_body_share_its_modes():
    shape = cantilever().body("bar")
    assert shape.flexible is not None
    assert StrainFields.of_body("bar", shape) is StrainFields.of_body("bar", cantilever().body("bar"))


def test_the_series_carries_the_fields_of_the_body(tmp_path):
    fields = recover(cantilever(), "bar", frames=[1, 4])
    path = fields.to_vtk(tmp_path / "bar.pvd", quantities=["von_mises", "stress"], scale=5.0)
    entries = [(time, file) for time, name, file in read_series(path) if name == "bar"]
    assert [time for time, _ in entries] == pytest.approx([5e-4, 2e-3])
    grid = read_grid(entries[1][1])
    stress = fields.stress_at_nodes()[1]
    np.testing.assert_allclose(grid["stress xy [Pa]"], stress[:, 5], atol=1e-12 * abs(stress).max())
    assert grid["sizes"].tolist() == [len(stress), 4 * 2 * 2 * 6]
    np.testing.assert_array_equal(grid["displacement [m]"].shape, stress[:, :3].shape)
    with pytest.raises(kf.ModelError, match=r"quantities=.*von_mises"):
        fields.to_vtk(tmp_path / "b.pvd", quantities=["mises"])
    assert not (tmp_path / "b.pvd").exists()


def test_a_picture_shows_the_colours_of_the_stress(tmp_path):
    pytest.importorskip("pyvista")
    from PIL import Image

    fields = recover(cantilever(), "bar")
    path = fields.picture(tmp_path / "bar.png", title="bar")
    image = np.asarray(Image.open(path).convert("RGB")).astype(int)
    assert image.shape == (800, 1200, 3)
    colourful = np.ptp(image, axis=2) > 60
    # the left three quarters hold the body, beyond them stands the bar of colours
    assert colourful[:, :900].mean() > 0.02
    assert image[0, 0].tolist() == [255, 255, 255]
    fields.picture(tmp_path / "frame.png", "max_principal", frame=2)
    assert (tmp_path / "frame.png").stat().st_size > 5000


def test_a_page_has_the_stress_of_the_recovery():
    # more coordinates than a page draws by: those of the motion
    result = spinning_bar()
    fields = recover(result, "bar")
    told = read_page(page_of(result, stress=fields).html)
    assert told["stress_name"] == f"von Mises stress (error of mesh {100.0 * fields.envelope().mesh_error:.2g} %)"
    part = body_of(told, "bar")["parts"][0]
    assert len(part["factors"]) < 4
    stress = np.tensordot(part["amplitudes"][1] * part["stress_factors"], part["stresses"].astype(float), axes=1)
    nodes = skin_of(result.body("bar")).nodes
    expected = fields.von_mises[1, nodes]
    np.testing.assert_allclose(von_mises(stress), expected, atol=1e-3 * expected.max())
    moved = placed(told, part, 1) - result.nodal_positions("bar", frames=1, nodes=nodes)
    # digits of places in a room of some metres
    assert np.abs(moved).max() < 1e-6


def test_fields_say_of_what_they_are():
    fields = recover(cantilever(), "bar", frames=[0, 1])
    assert repr(fields) == f"Recovery('bar', 2 times from 0 to {fields.times[1]:g} s)"
