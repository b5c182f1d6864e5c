"""What a shell is told and warned of: its mesh, its thickness, and what it prints; interfaces inside its surface."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import AccuracyWarning, ModelError
from kanefe.fe_model.model import Cells
from kanefe_fem import Laminate, Material, Orthotropic, Ply, shell_body, shell_model, surface_mesh
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.groups import check_interfaces
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.shells.checks import check_surface
from kanefe_fem.shells.measures import of_bending, shortest_wave
from kanefe_fem.shells.sections import section

pytestmark = pytest.mark.fenicsx

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
PLATE = surface_mesh(lambda s, r: (s, 0.5 * r, 0.0 * s), (4, 2))
STATICS = kf.CraigBampton(modes=0)


def quad(*corners):
    return Mesh(np.array(corners, dtype=float), 2, {"sheet": (Cells("quad", np.array([[0, 1, 2, 3]])),)})


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        (Mesh(np.vstack((PLATE.nodes, (0.0, 0.0, 5.0))), 2, PLATE.cells), "1 nodes are in no cell of the shell"),
        (
            Mesh(
                np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (1, 1, 1e-9), (0, 1, 1e-9)]),
                2,
                {"hem": (Cells("quad", np.array([[0, 1, 2, 3], [1, 0, 5, 4]])),)},
            ),
            r"1 cells lie on another one, the first at \[0.5, 0.5, 0.0\] m",
        ),
        (quad((0, 0, 0), (1, 0, 0), (1, 1, 1), (0, 1, -1)), "1 cells of group 'sheet' are warped.*up to 90 degrees"),
        (quad((0, 0, 0), (1, 0, 0), (1, 1e-4, 0), (0, 1e-4, 0)), "are slivers.*squared 0.0001"),
        (quad((0, 0, 0), (1, 0, 0), (2, 0.02, 0), (1, 1, 0)), "are slivers.*sharpest angle"),
        (Mesh(PLATE.nodes, 2, PLATE.cells, facets={"root": 2 * PLATE.facets["root"]}), "2 lines of group 'root' are"),
    ],
)
def test_a_doubtful_mesh_is_told(mesh, words):
    with pytest.warns(MeshWarning, match=words):
        check_surface(mesh, is_whole=True)


def test_the_warp_of_cells_is_told():
    """Two opposite corners lifted by h turn the normals at the corners by 2 atan(h sqrt(2)) from each other."""
    mesh = quad((0, 0, 0), (1, 0, 0.1), (1, 1, 0), (0, 1, 0.1))
    model = shell_model(mesh, STEEL, 1e-2)
    # normals (-+h, -+h, 1): of opposite corners
    expected = 2.0 * np.arctan(0.1 * np.sqrt(2.0))
    assert model.provenance["shell"]["turn in a cell"] == pytest.approx(expected, rel=1e-9)
    assert any(f"up to {np.degrees(expected):.2g} degrees in a cell" in line for line in model.provenance["told"])


def test_lines_that_are_there_twice_count_once():
    twice = Mesh(PLATE.nodes, 2, PLATE.cells, facets={"root": 2 * PLATE.facets["root"]})
    with pytest.warns(MeshWarning, match="count once"):
        checked = check_surface(twice, is_whole=True)
    assert sum(len(block.nodes) for block in checked.facets["root"]) == 2


def test_a_shell_too_thick_for_its_radius_or_size_is_told():
    pipe = surface_mesh(lambda s, r: (s, 0.05 * np.cos(3.0 * r), 0.05 * np.sin(3.0 * r)), (2, 4))
    with pytest.warns(AccuracyWarning, match=r"is 0.2 of a radius of curvature at"):
        model = shell_model(pipe, STEEL, 0.01)
    assert model.provenance["shell"]["t/R"]["value"] == pytest.approx(0.2, rel=0.02)
    with pytest.warns(AccuracyWarning, match=r"is 0.14 of the root of its area"):
        shell_model(PLATE, STEEL, 0.1)
    with pytest.raises(ModelError, match="that is no shell"):
        shell_model(PLATE, STEEL, lambda x: np.full(len(x), 5.0))


def test_a_laminate_that_shears_is_told():
    carbon = Orthotropic.transversely_isotropic(E1=140e9, E2=9e9, nu12=0.3, nu23=0.4, G12=5e9, rho=1600.0)
    stack = Laminate([Ply(carbon, 0.0165, angle) for angle in (0.0, np.pi / 2, np.pi / 2, 0.0)])
    with pytest.warns(AccuracyWarning, match="first-order theory is off"):
        shell_model(PLATE, {"body": stack})


def test_the_wave_of_modes_is_told():
    """A mode whose bending wave is as short as five thicknesses is none of a shell."""
    length, ratio, name = shortest_wave({"sheet": of_bending(section(STEEL), 0.01)}, 1000.0)
    D = 210e9 * 0.01**3 / 12.0 / (1.0 + 0.3)  # of the saddle, the softest
    assert length == pytest.approx(2.0 * np.pi * (D / (78.5 * (2000.0 * np.pi) ** 2)) ** 0.25)
    assert (ratio, name) == (pytest.approx(0.01 / length), "sheet")
    with pytest.warns(AccuracyWarning, match="waves of about"):
        shell_body(PLATE, STEEL, {"root": "clamped"}, 0.06, kf.CraigBampton(modes=14))


def test_a_body_prints_what_it_is():
    body = shell_body(PLATE, STEEL, {"root": "clamped"}, 2e-3, kf.CraigBampton(modes=2))
    text = str(body)
    assert repr(body) in text
    assert f"thickness body 2 mm, {7850.0 * 0.5 * 2e-3:.4g} kg" in text
    assert "0 nodes on folds, 0 cells turned" in text
    assert "t/L up to 0.0028" in text


@pytest.mark.parametrize(
    ("place", "centre", "nodes"),
    [
        (kf.OnPlane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), (0.0, 0.25), 5),  # an edge
        (kf.OnPlane((0.5, 0.0, 0.0), (1.0, 0.0, 0.0)), (0.5, 0.25), 5),  # a line between cells
        (kf.Near((0.5, 0.25, 0.0), 0.01), (0.5, 0.25), 1),  # a node
        (kf.InBox((0.25, 0.0, -1.0), (0.75, 0.25, 1.0)), (0.5, 0.125), 15),  # cells
        (kf.InCylinder((0.5, 0.25, -1.0), (0.5, 0.25, 1.0), 0.26), (0.5, 0.25), 9),  # lines
    ],
)
@pytest.mark.parametrize("kind", ["rigid", "average"])
def test_places_find_what_is_inside_the_surface(place, centre, nodes, kind):
    spec = kf.Interface("all", kind=kind, at=place)
    check_interfaces(PLATE, {"pad": spec}, is_shell=True)
    body = shell_body(PLATE, STEEL, {"pad": spec}, 2e-3, STATICS)
    np.testing.assert_allclose(body.interfaces[0].position, (*centre, 0.0), atol=1e-12)
    assert len(next(one for one in body.groups if one.name == "pad").nodes) == nodes


def test_a_group_of_cells_is_an_interface():
    table = PLATE.connectivity
    parts = {"pad": (Cells("quad9", table[:1]),), "sheet": (Cells("quad9", table[1:]),)}
    mesh = Mesh(PLATE.nodes, 2, parts)
    body = shell_body(mesh, dict.fromkeys(parts, STEEL), {"pad": "average"}, 2e-3, kf.CraigBampton(modes=3))
    np.testing.assert_allclose(body.interfaces[0].position, (0.125, 0.125, 0.0), atol=1e-12)


def test_a_mesh_gets_groups_of_lines_between_its_cells():
    mesh = PLATE.with_groups({"rib": kf.OnPlane((0.0, 0.25, 0.0), (0.0, 1.0, 0.0))})
    (block,) = mesh.facets["rib"]
    assert (block.kind, len(block.nodes)) == ("line3", 4)
    np.testing.assert_allclose(mesh.nodes[block.nodes][..., 1], 0.25)
