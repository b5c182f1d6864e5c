"""Damping of solids from materials: matrices against sums of those of groups, a constrained layer, bad input."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from fem_meshes import shown
from kanefe.errors import ModelError, SimulationWarning
from kanefe.fe_model.model import Cells
from kanefe.reduction.build import LARGEST_DENSE
from kanefe_fem import (
    Anisotropic,
    Laminate,
    LumpedSpring,
    Material,
    Mesh,
    Oriented,
    Orthotropic,
    Ply,
    Rectangle,
    attach,
    beam_model,
    exact_beam,
    prony_of_loss_factor,
    segmented,
    solid_body,
    solid_model,
    straight_beam,
)
from kanefe_fem.materials.damping import losses_of

FACE = {"E": 69e9, "nu": 0.0, "rho": 2766.0}
CORE = {"E": 2.0 * 1.3 * 0.896e6, "nu": 0.3, "rho": 968.1}
LENGTH, WIDTH, FACES, LAYER = 177.8e-3, 12.7e-3, 1.524e-3, 0.127e-3


def sandwich(elements: int, kind: str = "hexahedron") -> Mesh:
    """A cantilever of two faces with a core between them, groups "face" and "core", and the facets of its root."""
    heights = np.cumsum([0.0, FACES, LAYER, FACES])
    steps = np.linspace(0.0, LENGTH, elements + 1)
    nodes = np.array([(x, y, z) for x in steps for y in (0.0, WIDTH) for z in heights])

    def number(i: int, j: int, k: int) -> int:
        return (2 * i + j) * len(heights) + k

    def cell(i: int, k: int) -> list[int]:
        ring = (i, 0), (i + 1, 0), (i + 1, 1), (i, 1)
        return [number(*at, k + up) for up in (0, 1) for at in ring]

    cells = {
        "face": [cell(i, k) for i in range(elements) for k in (0, 2)],
        "core": [cell(i, 1) for i in range(elements)],
    }
    root = [[number(0, 0, k), number(0, 1, k), number(0, 1, k + 1), number(0, 0, k + 1)] for k in range(3)]
    return Mesh(
        nodes=nodes,
        dimension=3,
        cells={name: (Cells(kind, np.array(ids)),) for name, ids in cells.items()},
        facets={"root": (Cells("quad", np.array(root)),)},
    )


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return sandwich(3)


def of_groups(mesh: Mesh, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and mass of a group, the other one being without (to 1e-12 of it)."""
    materials = {
        group: Material(**(kind if group == name else {"E": 1e-3, "nu": 0.0, "rho": 1e-12}))
        for group, kind in (("face", FACE), ("core", CORE))
    }
    with pytest.warns():  # of its units
        model = solid_model(mesh, materials)
    return model.stiffness.toarray(), model.mass.toarray()


class TestMatrices:
    def test_they_are_sums_over_the_groups(self, mesh: Mesh):
        rayleigh = kf.RayleighDamping(mass=3.0, stiffness=2e-4)
        arms = [(0.3, 0.01), (0.2, 0.1)]
        face = Material(**FACE, damping=rayleigh, loss_factor=0.02)
        core = Material(**CORE, damping=kf.RayleighDamping(stiffness=1e-3), prony=arms)
        model = solid_model(mesh, {"face": face, "core": core})
        (K_f, M_f), (K_c, _) = of_groups(mesh, "face"), of_groups(mesh, "core")
        for found, expected in (
            (model.stiffness, K_f + 0.5 * K_c),
            (model.damping, 3.0 * M_f + 2e-4 * K_f + 1e-3 * K_c),
            (model.structural, 0.02 * K_f),
            (model.viscoelastic[0].stiffness, K_c),
        ):
            np.testing.assert_allclose(found.toarray(), expected, rtol=0, atol=1e-9 * np.abs(expected).max())
        assert len(model.viscoelastic) == 1
        assert (model.viscoelastic[0].weights, model.viscoelastic[0].times) == ((0.3, 0.2), (0.01, 0.1))

    def test_oriented_and_anisotropic_materials_have_theirs(self, mesh: Mesh):
        wood = Orthotropic(
            E1=11e9, E2=0.9e9, E3=0.5e9, nu12=0.37, nu13=0.42, nu23=0.47, G12=0.75e9, G13=0.7e9, G23=0.04e9, rho=450.0,
            loss_factor=0.01,
        )  # fmt: skip
        stiff = Anisotropic(Material(**CORE).stiffness, rho=968.1, prony=[(0.25, 0.1)])
        assert losses_of(Oriented(wood, np.eye(3))).loss_factor == 0.01
        model = solid_model(mesh, {"face": Oriented(wood, np.eye(3)), "core": stiff})
        whole = solid_model(mesh, {"face": wood, "core": Anisotropic(stiff.stiffness, rho=968.1)}).stiffness
        core = model.viscoelastic[0].stiffness
        left = whole - 0.25 * core - model.stiffness
        assert abs(left).max() < 1e-12 * abs(whole).max()
        assert abs(100.0 * model.structural + core - whole).max() < 1e-12 * abs(whole).max()

    def test_cells_that_numpy_assembles_have_the_same(self, mesh: Mesh):
        """Of wedges, two for each brick, the total strain energy of a stretch is that of the bricks."""
        bricks = mesh.cells
        halves = ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7))
        wedges = {
            name: (Cells("wedge", np.vstack([blocks[0].nodes[:, half] for half in halves])),)
            for name, blocks in bricks.items()
        }
        split = Mesh(nodes=mesh.nodes, dimension=3, cells=wedges)
        materials = {"face": Material(**FACE, loss_factor=0.02), "core": Material(**CORE, prony=[(0.3, 0.1)])}
        whole, cut = (solid_model(one, materials, order=1) for one in (mesh, split))
        for name in ("stiffness", "structural"):
            energies = []
            for model in (whole, cut):
                u = np.zeros_like(model.nodes)
                u[:, 0] = model.nodes[:, 0]
                energies.append(u.ravel() @ (getattr(model, name) @ u.ravel()))
            assert energies[0] == pytest.approx(energies[1], rel=1e-12)

    def test_beams_have_those_of_their_elements(self):
        section, nodes = Rectangle(0.05, 0.01), [[0, 0, 0], [0.5, 0, 0], [1, 0, 0]]
        stiff = Material(E=210e9, nu=0.3, rho=7850.0)
        damped = Material(E=70e9, nu=0.3, rho=2700.0, loss_factor=0.1)
        relaxing = Material(E=70e9, nu=0.3, rho=2700.0, prony=[(0.4, 0.1)])
        lines = [[0, 1], [1, 2]]
        first = beam_model(nodes, lines, section, [damped, stiff])
        second = beam_model(nodes, lines, section, [relaxing, stiff])
        part = second.viscoelastic[0].stiffness
        assert abs(10.0 * first.structural - part).max() < 1e-12 * abs(part).max()
        assert abs(second.stiffness + 0.4 * part - first.stiffness).max() < 1e-12 * abs(part).max()
        with pytest.raises(ModelError, match="different damping proportional to mass"):
            beam_model(nodes, lines, section, [Material(1e9, 0.3, 1e3, damping=kf.RayleighDamping(mass=1.0)), stiff])

    def test_dampers_between_groups(self):
        steel = Material(E=210e9, nu=0.3, rho=7850.0)
        beam = straight_beam(1.0, Rectangle(0.05, 0.01), steel, elements=2)
        damper = LumpedSpring(
            "root", stiffness=(0.0, 0.0, 0.0), to="tip", damping=(0.0, 0.0, 7.0), position=(0.5, 0, 0)
        )
        bushing = LumpedSpring("tip", stiffness=(1e3, 0.0, 0.0), damping=(2.0, 0.0, 0.0))
        model = attach(beam, [damper, bushing])
        u = np.zeros((3, 6))
        u[2, 2], u[2, 0] = 2.0, 3.0
        assert u.ravel() @ (model.damping @ u.ravel()) == pytest.approx(7.0 * 4.0 + 2.0 * 9.0)
        rigid = model.rigid_modes()
        held = LumpedSpring("root", stiffness=(0.0, 0.0, 0.0), to="tip", damping=(1.0, 2.0, 3.0))
        assert np.abs(attach(beam, [held]).damping @ rigid).max() < 1e-12
        with pytest.raises(ModelError, match="damping is zero or negative"):
            LumpedSpring("tip", stiffness=(1.0, 0.0, 0.0), damping=(-1.0, 0.0, 0.0))

    def test_damping_of_the_body_replaces_that_of_its_materials(self, mesh: Mesh):
        materials = {"face": Material(**FACE, damping=kf.RayleighDamping(stiffness=1e-3)), "core": Material(**CORE)}
        options = {"interfaces": {"root": "clamped"}, "reduction": kf.CraigBampton(modes=2), "cache": False}
        own, given = (solid_body(mesh, materials, damping=d, **options) for d in (None, kf.ModalDamping(0.01)))
        np.testing.assert_allclose(np.diag(given.damping) / (4e-2 * np.pi * given.frequencies), 1.0, rtol=1e-9)
        assert own.damping[0, 0] < 1e-3 * own.stiffness[0, 0]
        assert own.damping[0, 0] > 0.9e-3 * own.stiffness[0, 0] * (1.0 - 0.5)


class TestConstrainedLayer:
    def test_frequency_and_loss_of_the_first_modes(self):
        """Sixth-order beam of Mead and Markus, solved apart from kanefe: 66.4434 Hz and 0.25853 of the core's loss."""
        eta = 0.1
        materials = {"face": Material(**FACE), "core": Material(**CORE, loss_factor=eta)}
        body = solid_body(sandwich(20), materials, {"root": "clamped"}, kf.CraigBampton(modes=6), cache=False)
        scene = kf.System()
        scene.add_flexible_body("beam", body)
        modes = kf.linearise(scene).modes()
        bending = [i for i in range(6) if modes.loss_factors[i] > 1e-2 * eta][:3]
        np.testing.assert_allclose(modes.frequencies[bending], (66.4434, 306.651, 760.859), rtol=5e-3)
        np.testing.assert_allclose(modes.loss_factors[bending] / eta, (0.25853, 0.26259, 0.18185), rtol=1e-2)

    def test_the_basis_has_what_the_relaxing_core_needs(self):
        """Roots of the reduced body, against those of the whole one with the complex modulus."""
        arms = [(0.5, 0.002)]
        model = solid_model(sandwich(4), {"face": Material(**FACE), "core": Material(**CORE, prony=arms)})
        body = kf.flexible_body(model, {"root": "clamped"}, reduction=kf.CraigBampton(modes=4))
        scene = kf.System()
        scene.add_flexible_body("beam", body)
        roots = kf.linearise(scene).modes().eigenvalues
        first = roots[roots.imag > 0.0][0]
        free = np.flatnonzero(model.nodes[:, 0] > 1e-9)
        dofs = (free[:, None] * 3 + np.arange(3)).ravel()
        K, M, P = (X[dofs][:, dofs].toarray() for X in (model.stiffness, model.mass, model.viscoelastic[0].stiffness))
        s, x = 1.001 * first, np.ones(len(M), dtype=complex)
        for _ in range(8):  # inverse iteration, with the modulus at the root that is found
            stiffness = K + 0.5 * s * 0.002 / (1.0 + s * 0.002) * P
            x = np.linalg.solve(stiffness + s**2 * M, M @ x)
            x /= np.linalg.norm(x)
            s = 1j * np.sqrt((x @ stiffness @ x) / (x @ M @ x))
        assert np.linalg.norm(stiffness @ x + s**2 * M @ x) < 1e-6 * np.linalg.norm(stiffness @ x)
        assert abs(first - s) < 1e-4 * abs(s)


class TestFit:
    @pytest.mark.parametrize("eta", [0.01, 0.3, 1.0])
    def test_the_loss_factor_in_the_band_is_that_of_the_series(self, eta: float):
        fit = prony_of_loss_factor(eta, (5.0, 500.0))
        f = np.geomspace(5.0, 500.0, 57)
        s = 2j * np.pi * f[:, None]
        weights, times = np.array(fit.prony).T
        modulus = fit.stiffness * (1.0 - weights.sum() + (weights * s * times / (1.0 + s * times)).sum(axis=1))
        assert np.abs(modulus.imag / modulus.real / eta - 1.0).max() < fit.loss_error * 1.1 + 1e-9
        assert fit.loss_error < 0.03
        assert np.abs(modulus.real - 1.0).max() < fit.stiffness_error + 1e-3
        material = Material(**CORE, loss_factor=eta).viscoelastic((5.0, 500.0))
        assert (material.E, material.loss_factor) == (CORE["E"] * fit.stiffness, 0.0)

    def test_a_run_tells_that_it_is_without_a_loss_factor(self, mesh: Mesh):
        materials = {"face": Material(**FACE), "core": Material(**CORE, loss_factor=0.1)}
        body = solid_body(mesh, materials, {"root": "clamped"}, kf.CraigBampton(modes=1), cache=False)
        scene = kf.System()
        scene.add_flexible_body("beam", body)
        with pytest.warns(SimulationWarning, match="viscoelastic"):
            scene.simulate((0.0, 1e-4))
        small = kf.linearise(scene)
        assert small.modes().eigenvalues[0].real < -1.0
        whole = kf.linearise(scene, inputs="force beam/root x", outputs="modal_speeds beam")
        for told in (whole.h2_norm, whole.to_control):
            with pytest.warns(SimulationWarning, match="goes without"):
                told()
        assert abs(small.undamped().modes().eigenvalues[0].real) < 1e-6 * abs(small.modes().eigenvalues[0])


class TestBadInput:
    @pytest.mark.parametrize(
        ("given", "words"),
        [
            ({"prony": [(-0.1, 1.0)]}, ("weight -0.1", "energy")),
            ({"prony": [(0.0, 1.0)]}, ("weight 0",)),
            ({"prony": [(0.6, 1.0), (0.4, 2.0)]}, ("add up to 1", "below 1")),
            ({"prony": [(0.1, 0.0)]}, ("relaxation time 0 s",)),
            ({"prony": [(0.1, -1.0)]}, ("relaxation time -1 s",)),
            ({"prony": [(0.1, np.nan)]}, ("finite",)),
            ({"prony": [(0.1, np.inf)]}, ("finite",)),
            ({"prony": [(0.1, 1.0), (0.1, 1.0)]}, ("twice",)),
            ({"prony": (0.1, 1.0)}, ("pairs",)),
            ({"prony": "rubber"}, ("pairs",)),
            ({"prony": None}, ("pairs",)),
            ({"loss_factor": -0.1}, ("loss_factor=-0.1", "2 %")),
            ({"loss_factor": 5.0}, ("loss_factor=5", "from 0 to 2")),
            ({"loss_factor": np.nan}, ("loss_factor=nan",)),
            ({"loss_factor": "high"}, ("loss_factor='high'",)),
            ({"loss_factor": 0.1, "prony": [(0.1, 1.0)]}, ("one of them",)),
            ({"damping": 0.02}, ("RayleighDamping",)),
            ({"damping": kf.ModalDamping(0.02)}, ("RayleighDamping",)),
        ],
    )
    def test_materials(self, given, words):
        with pytest.raises(ModelError) as error:
            Material(1e9, 0.3, 1e3, "putty", **given)
        shown(error, "putty", *words)
        with pytest.raises(ModelError):
            Anisotropic(np.eye(6), 1e3, "putty", **given)

    def test_fits(self):
        for eta, band in ((0.0, (1.0, 2.0)), (-1.0, (1.0, 2.0)), (0.1, (2.0, 1.0)), (0.1, (0.0, 1.0)), (0.1, 3.0)):
            with pytest.raises(ModelError):
                prony_of_loss_factor(eta, band)
        with pytest.raises(ModelError, match="loss factor to be fitted"):
            Material(1e9, 0.3, 1e3).viscoelastic((1.0, 2.0))

    def test_what_does_not_take_the_damping_of_materials_says_so(self):
        rubber = Material(1e9, 0.3, 1e3, prony=[(0.3, 0.1)])
        with pytest.raises(ModelError, match="group of cells"):
            Laminate([Ply(rubber, 1e-3)])
        with pytest.raises(ModelError, match="damping=RayleighDamping"):
            exact_beam(1.0, Rectangle(0.05, 0.01), rubber)
        beam = straight_beam(1.0, Rectangle(0.05, 0.01), rubber, elements=8)
        with pytest.raises(ModelError, match="cut into segments"):
            segmented(beam, {"root": "clamped"}, segments=2, reduction=kf.CraigBampton(modes=2))
        long = straight_beam(1.0, Rectangle(0.05, 0.01), rubber, elements=LARGEST_DENSE // 6 + 2)
        with pytest.raises(ModelError, match="Prony series, which unreduced"):
            kf.flexible_body(long, {"root": "clamped"})

    def test_files_without_room_for_it_are_refused(self, tmp_path):
        rubber = Material(1e9, 0.3, 1e3, prony=[(0.3, 0.1)])
        beam = straight_beam(1.0, Rectangle(0.05, 0.01), rubber, elements=8)
        body = kf.flexible_body(beam, {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=2))
        with pytest.raises(ModelError, match="Prony series"):
            kf.write_superelement(body, tmp_path / "b.bdf", "nastran")
        with pytest.raises(ModelError, match="Prony series"):
            kf.write_matrices(beam, tmp_path / "b.npz")
        assert not list(tmp_path.iterdir())
