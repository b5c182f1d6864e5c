"""Interfaces and loaded surfaces by place; meshes without groups; the element sets of Abaqus."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from fem_meshes import STEEL, box
from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.skin import group_at, skin
from kanefe_fem import box_mesh, cylinder_mesh, read_mesh, solid_body, solid_model
from kanefe_fem.mesh.mesh import Mesh

meshio = pytest.importorskip("meshio")
BOX = box_mesh((1.0, 0.1, 0.1), (6, 2, 2))
NAMED = {"root": "clamped", "tip": "rigid"}
PLACED = {
    "root": kf.Interface("all", at=kf.OnPlane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))),
    "tip": kf.Interface(at=lambda x: x[:, 0] > 1.0 - 1e-9),
}


def without_groups(mesh: Mesh) -> Mesh:
    return Mesh(mesh.nodes, 3, mesh.cells)


@pytest.mark.fenicsx
@pytest.mark.parametrize("cache", [True, False])
def test_interfaces_by_place_are_those_by_name(cache):
    reduction = kf.CraigBampton(modes=3)
    named = solid_body(BOX, STEEL, NAMED, reduction=reduction, cache=cache)
    placed = solid_body(without_groups(BOX), STEEL, PLACED, reduction=reduction, cache=cache)
    assert placed.frequencies == pytest.approx(named.frequencies, rel=1e-9)
    for one, other in zip(placed.interfaces, named.interfaces, strict=True):
        assert one.name == other.name
        assert one.position == pytest.approx(other.position, abs=1e-12)  # the centroid of the facets


@pytest.mark.fenicsx
def test_a_surface_by_place_carries_the_load_of_the_group():
    top = kf.OnPlane((0.0, 0.0, 0.1), (0.0, 0.0, 1.0))
    by_place = solid_model(without_groups(BOX), STEEL, surfaces={"over": top}).load_patterns["over"]
    by_name = solid_model(BOX, STEEL, surfaces=["top"]).load_patterns["top"]
    assert by_place.measure == pytest.approx(0.1, rel=1e-12)
    assert by_place.pressure == pytest.approx(by_name.pressure, abs=1e-15)
    with pytest.raises(ModelError, match="already"):
        solid_model(BOX, STEEL, surfaces={"top": top})
    with pytest.raises(ModelError, match="no facet of the outside"):
        solid_model(BOX, STEEL, surfaces={"over": kf.Near((0.5, 0.05, 0.1), 0.01)})


def test_places_hold_what_is_in_them():
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.3, 0.0], [0.5, 0.0, 0.2]])
    for place, expected in (
        (kf.Near((1, 0, 0), 0.3), [False, True, True, False]),
        (kf.OnPlane((1, 0, 0), (2, 0, 0)), [False, True, True, False]),
        (kf.OnPlane((1, 0, 0), (1, 0, 0), distance=0.5), [False, True, True, True]),
        (kf.InBox((0.4, -1, 0), (2, 0.2, np.inf)), [False, True, False, True]),
        (kf.InCylinder((0, 0, 0), (1, 0, 0), 0.25), [True, True, False, True]),
        (kf.InCylinder((0, 0, 0), (1, 0, 0), 0.25, inner_radius=0.1), [False, False, False, True]),
    ):
        assert place.contains(points, 1e-9).tolist() == expected, place


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: kf.Near((1, 0), 0.3),
        lambda: kf.Near((1, 0, 0), -1.0),
        lambda: kf.OnPlane((1, 0, 0), (0, 0, 0)),
        lambda: kf.InBox((1, 0, 0), (0, 1, 1)),
        lambda: kf.InCylinder((0, 0, 0), (0, 0, 0), 1.0),
        lambda: kf.InCylinder((0, 0, 0), (1, 0, 0), 1.0, inner_radius=2.0),
        lambda: kf.Interface(at="tip"),
        lambda: kf.Interface(at=kf.Near((0, 0, 0), 1.0), groups="tip"),
    ],
)
def test_what_is_no_place_is_refused(wrong):
    with pytest.raises(ModelError):
        wrong()


def test_a_place_takes_the_skin_only_and_single_nodes_where_no_facet_fits():
    mesh = cylinder_mesh(1.0, 0.05, (4, 2, 8), inner_radius=0.03)
    bore = group_at(mesh.nodes, mesh.cell_blocks, kf.InCylinder((0, 0, 0), (1, 0, 0), 0.03), "bore")
    assert bore.measure.sum() == pytest.approx(2 * np.pi * 0.03, rel=5e-4)  # arcs of 45 degrees by parabolas
    outer = np.unique(np.concatenate([block.nodes.ravel() for block in skin(BOX.cell_blocks)]))
    inside = group_at(BOX.nodes, BOX.cell_blocks, kf.Near((0.5, 0.05, 0.05), 0.06), "middle")
    assert inside.measure is None
    assert len(inside.nodes) == 4  # of the nine nodes of the section without its middle, those at the sides
    assert np.isin(inside.nodes, outer).all()
    with pytest.raises(ModelError, match="no node on the outside"):
        group_at(BOX.nodes, BOX.cell_blocks, kf.Near((0.5, 0.05, 0.05), 0.01), "middle")
    with pytest.raises(ModelError, match="one bool for each"):
        group_at(BOX.nodes, BOX.cell_blocks, lambda x: x[:, 0], "middle")


def test_beams_and_matrices_have_interfaces_by_place():
    from kanefe_fem import Rectangle, beam_body, straight_beam

    beam = straight_beam(1.0, Rectangle(0.05, 0.1), STEEL, elements=4)
    ends = {"root": kf.Interface("all", kind="node", at=kf.Near((0, 0, 0), 1e-3)), "tip": "node"}
    assert beam_body(beam, ends).frequencies == pytest.approx(
        beam_body(beam, {"root": "clamped", "tip": "node"}).frequencies, rel=1e-9
    )


@pytest.mark.parametrize("suffix", [".vtu", ".vtk"])
def test_a_file_without_groups_is_one_body(tmp_path: Path, suffix: str):
    path = tmp_path / f"bar{suffix}"
    mesh = box("tetra", (2, 1, 1), (1, 1, 1))
    meshio.Mesh(mesh.nodes, [("tetra", mesh.connectivity), ("triangle", mesh.connectivity[:2, :3])]).write(path)
    read = read_mesh(path)
    assert {name: sum(len(b.nodes) for b in blocks) for name, blocks in read.cells.items()} == {"body": 12}


@pytest.mark.gmsh
@pytest.mark.parametrize("groups", ["", 'Physical Surface("root") = {out[5]};'])
def test_a_source_without_volume_groups_is_one_body(geo, groups):
    read = read_mesh(geo(groups=groups))
    assert list(read.cells) == ["body"]
    assert list(read.facets) == (["root"] if groups else [])


@pytest.mark.gmsh
@pytest.mark.parametrize(
    ("options", "kinds"),
    [
        ({"prisms": True}, ["wedge"]),
        ({"prisms": True, "options": "Mesh.ElementOrder = 2; Mesh.SecondOrderIncomplete = 1;"}, ["wedge15"]),
        ({"prisms": True, "options": "Mesh.ElementOrder = 2;"}, ["wedge18"]),
        ({"hexes": True, "options": "Mesh.ElementOrder = 2; Mesh.SecondOrderIncomplete = 1;"}, ["hexahedron20"]),
    ],
)
def test_wedges_and_serendipity_bricks_of_gmsh(geo, options, kinds):
    mesh = read_mesh(geo(**options))
    assert list(mesh.kinds) == kinds
    model = solid_model(mesh, STEEL, order=mesh.order)
    assert model.mass_field.mass.sum() == pytest.approx(STEEL.rho * 0.3 * 0.1 * 0.08, rel=1e-12)
    assert abs(model.stiffness @ model.rigid_modes()).max() < 1e-11 * abs(model.stiffness).max()


CAE = """*Heading
** Job name: bracket, Model name: Model-1
*Part, name=Part-1
*Node
{nodes}
*Element, type=C3D8R
{elements}
*Nset, nset=Set-1, generate
 1, {node_count}, 1
*Elset, elset=Set-1, generate
 1, 4, 1
*Elset, elset=_Load_S4, internal
 4,
*Surface, type=ELEMENT, name=Load
_Load_S4, S4
*Elset, elset=ALL, generate
 1, 4, 1
** Section: Section-1
*Solid Section, elset=Set-1, material=Steel
,
*End Part
"""


def test_an_input_of_abaqus_has_the_parts_that_its_sections_name(tmp_path: Path):
    bar = box("hexahedron", (4, 1, 1), (1.0, 0.1, 0.1))
    cells = bar.cell_blocks[0].nodes
    text = CAE.format(
        nodes="\n".join(f"{i + 1}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(bar.nodes.tolist())),
        elements="\n".join(", ".join(map(str, [i + 1, *(row + 1).tolist()])) for i, row in enumerate(cells)),
        node_count=len(bar.nodes),
    )
    path = tmp_path / "bracket.inp"
    path.write_text(text)
    read = read_mesh(path)
    assert list(read.cells) == ["Set-1"]
    # face S4 of a brick is 2-6-7-3: the one towards +x of the last
    assert sorted(read.facets["Load"][0].nodes.ravel().tolist()) == np.flatnonzero(bar.nodes[:, 0] > 0.99).tolist()
    path.write_text(text.replace("*Solid Section", "*Shell Section"))
    with pytest.raises(MeshError, match=r"read_mesh\(..., cells='"):
        read_mesh(path)
    assert list(read_mesh(path, cells="Set-1").cells) == ["Set-1"]


@pytest.mark.parametrize("size", ["long", (1.0, 0.1), (1.0, 0.1, 0.0), (1.0, 0.1, float("nan")), (1.0, 0.1, "thick")])
def test_a_box_has_three_edges(size):
    with pytest.raises(ModelError, match=r"^box_mesh: size=.* Remedy: finite lengths in m, above zero"):
        box_mesh(size, (1, 1, 1))
