"""Interfaces of meshed bodies: exact bars, sliding supports, several bodies on one mesh, errors of small rigid ties."""

from __future__ import annotations

import functools
import warnings
from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from fem_meshes import STEEL, box
from kanefe.checks.verification.scenes import system_modes
from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.model import Cells, FiniteElementModel, NodeGroup
from kanefe.fe_model.rigid_patch_error import TieWarning
from kanefe.fe_model.ties import tie_interfaces
from kanefe.reduction import flexible_body
from kanefe_fem.beams.body import beam_model, straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.mesh.groups import check_interfaces, node_groups
from kanefe_fem.mesh.mesh import Mesh, part_of
from kanefe_fem.solids.body import solid_body
from kanefe_fem.solids.model import solid_model

LENGTH, WIDTH, HEIGHT = 1.0, 0.2, 0.1
AREA, I_Y = WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12
CLAMPED_MEAN = kf.Interface("all", kind="average")
STATIC = kf.CraigBampton(modes=0)


@pytest.fixture(scope="module")
def bars() -> dict[tuple[str, int], FiniteElementModel]:
    """Return models of a bar along x by kind of cell and order."""
    size = (LENGTH, WIDTH, HEIGHT)
    return {
        (kind, order): solid_model(box(kind, (4, 3, 2), size), STEEL, order=order)
        for kind in ("tetra", "hexahedron")
        for order in (1, 2)
    }


def compliance(body: kf.FlexibleBody, name: str) -> np.ndarray:
    """Return the static motion of an interface under unit loads on it, both along its axes, shape (6, 6)."""
    k, frame = body.free_count, body.interface(name)
    motion = (np.kron(np.eye(2), frame.axes.T) @ frame.motion)[:, :k]
    return motion @ np.linalg.solve(body.stiffness[:k, :k], motion.T)


def with_group(model: FiniteElementModel, name: str, nodes: np.ndarray) -> FiniteElementModel:
    return replace(model, groups={**model.groups, name: NodeGroup(nodes, model.nodes[nodes].mean(axis=0))})


pytestmark = pytest.mark.fenicsx


@pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
@pytest.mark.parametrize("order", [1, 2])
def test_a_bar_on_a_clamped_average_contracts_freely(bars, kind: str, order: int) -> None:
    # F L / (E A): the field is linear, so that any mesh has it exactly, but only if nothing hinders the contraction
    model = bars[kind, order]
    soft = compliance(flexible_body(model, {"root": CLAMPED_MEAN, "tip": "average"}, reduction=STATIC), "tip")
    assert soft[0, 0] == pytest.approx(LENGTH / (STEEL.E * AREA), rel=1e-10)
    rigid = compliance(flexible_body(model, {"root": "clamped", "tip": "rigid"}, reduction=STATIC), "tip")
    assert rigid[0, 0] < 0.99 * soft[0, 0]  # the rigid patch is too stiff


@pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
@pytest.mark.parametrize("axes", [np.eye(3), np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])], ids=["G", "turned"])
def test_pure_bending_between_averages_is_exact(bars, kind: str, axes: np.ndarray) -> None:
    # M L / (E I): the displacement is quadratic with its anticlastic part, which quadratic cells hold exactly
    body = flexible_body(
        bars[kind, 2], {"root": CLAMPED_MEAN, "tip": kf.Interface(kind="average", axes=axes)}, reduction=STATIC
    )
    C = np.kron(np.eye(2), axes) @ compliance(body, "tip") @ np.kron(np.eye(2), axes.T)
    # round-off of a solve with condition number 1e6, seen through moments
    assert C[4, 4] == pytest.approx(LENGTH / (STEEL.E * I_Y), rel=1e-8)
    assert C[2, 4] == pytest.approx(-(LENGTH**2) / (2 * STEEL.E * I_Y), rel=1e-8)


def test_a_plate_slides_on_its_edges() -> None:
    # plane stress between two frictionless walls: eps_x = F / (E A), and the width follows by Poisson's ratio
    mesh = box("quad", (4, 3), (LENGTH, WIDTH))
    slider = kf.Interface(("x", "rz"), released=("y",))
    model = solid_model(mesh, STEEL, plane="stress", thickness=HEIGHT)
    corner = int(np.argmin(np.linalg.norm(model.nodes - [LENGTH / 2, 0, 0], axis=1)))
    body = flexible_body(
        with_group(model, "pin", np.array([corner])),
        {"root": slider, "tip": kf.Interface(("rz",), released=("y",)), "pin": kf.Interface(("y",), released=("x",))},
        reduction=STATIC,
    )
    assert compliance(body, "tip")[0, 0] == pytest.approx(LENGTH / (STEEL.E * AREA), rel=1e-9)
    eta = np.linalg.solve(
        body.stiffness[: body.free_count, : body.free_count], body.interface("tip").motion[0, : body.free_count]
    )
    u = body.node_displacements(eta)
    top = abs(model.nodes[:, 1] - WIDTH) < 1e-12
    assert u[top, 1] == pytest.approx(-STEEL.nu * WIDTH / (STEEL.E * AREA), rel=1e-8)


def test_measures_of_groups_are_integrals_of_shapes() -> None:
    for kind, dimension in (("tetra", 3), ("hexahedron", 3), ("triangle", 2)):
        mesh = box(kind, (2, 3, 2)[:dimension], (LENGTH, WIDTH, HEIGHT)[:dimension]).with_order(2)
        group = node_groups(mesh)["tip"]
        x = mesh.nodes[group.nodes]
        total, mean, square = WIDTH * HEIGHT, WIDTH / 2, WIDTH**2 / 3
        total = total if dimension == 3 else WIDTH
        assert group.measure.sum() == pytest.approx(total, rel=1e-13)
        assert group.position[:2] == pytest.approx([LENGTH, mean], rel=1e-13)
        assert x[:, 1] @ (group.measure @ x[:, 1]) == pytest.approx(total * square, rel=1e-13)


def test_weights_by_area_do_not_hang_on_the_mesh_of_the_patch(bars) -> None:
    # the same plane through a fine and a coarse half: by area the mean is the centroid's, by nodes it leans over
    mesh = box("tetra", (4, 3, 2), (LENGTH, WIDTH, HEIGHT))
    squeezed = np.array(mesh.nodes)
    squeezed[:, 1] = WIDTH * (squeezed[:, 1] / WIDTH) ** 2
    model = solid_model(Mesh(squeezed, 3, mesh.cells, mesh.facets), STEEL, order=2)
    tension = {}
    for weights in ("area", "uniform"):
        spec = kf.Interface(kind="average", weights=weights)
        body = flexible_body(
            model, {"root": kf.Interface("all", kind="average", weights=weights), "tip": spec}, reduction=STATIC
        )
        tension[weights] = compliance(body, "tip")[0, 0] * STEEL.E * AREA / LENGTH
    assert tension["area"] == pytest.approx(1.0, rel=1e-9)
    assert tension["uniform"] > 1.01


def test_a_bar_with_average_ends_is_the_beam_and_with_rigid_ones_stiffer(bars) -> None:
    # against Timoshenko's beam; rigid ends take some 0.2 of a width off its length; four cells along it are within 1 %
    beam = flexible_body(
        straight_beam(LENGTH, Rectangle(WIDTH, HEIGHT), STEEL), {"root": "clamped", "tip": "rigid"}, reduction=STATIC
    )
    expected = compliance(beam, "tip")[2, 2]
    stiff, soft = (
        compliance(flexible_body(bars["hexahedron", 2], {"root": root, "tip": tip}, reduction=STATIC), "tip")[2, 2]
        for root, tip in (("clamped", "rigid"), (CLAMPED_MEAN, "average"))
    )
    assert soft == pytest.approx(expected, rel=0.01)
    assert 0.96 * soft < stiff < 0.98 * soft


def test_lines_of_beams_are_interfaces() -> None:
    points = [[x, 0, 0] for x in np.linspace(0, 1, 11)]
    elements = [[i, i + 1] for i in range(10)]
    model = beam_model(
        points,
        elements,
        Rectangle(0.02, 0.02),
        STEEL,
        lines={"sleeve": range(2), "span": range(10)},
        groups={"tip": -1, "second": 2},
    )
    assert model.groups["sleeve"].nodes.tolist() == [0, 1, 2]
    assert model.groups["sleeve"].measure.sum() == pytest.approx(0.2)
    in_sleeve = flexible_body(model, {"sleeve": "clamped", "tip": "rigid"}, reduction=STATIC)
    at_node = flexible_body(model, {"second": "clamped", "tip": "rigid"}, reduction=STATIC)
    # what is inside the sleeve does not move: the beam begins at its end
    assert compliance(in_sleeve, "tip") == pytest.approx(compliance(at_node, "tip"), rel=1e-9, abs=1e-16)
    held_on_average = flexible_body(model, {"sleeve": CLAMPED_MEAN, "tip": "rigid"}, reduction=STATIC)
    assert compliance(held_on_average, "tip")[1, 1] > 1.05 * compliance(in_sleeve, "tip")[1, 1]


def test_every_component_of_a_beams_end_can_be_released() -> None:
    # a pin at the tip, whose rotation does not follow the frame: a propped beam, 5 EI_z v'' against the built-in end's
    model = straight_beam(LENGTH, Rectangle(WIDTH, HEIGHT), STEEL, elements=8, theory="euler-bernoulli")
    middle = 4
    model = with_group(model, "middle", np.array([middle]))
    stiffness = STEEL.E * HEIGHT * WIDTH**3 / 12
    for released, expected in (((), 1 / 192), (("rz",), 7 / 768)):
        body = flexible_body(
            model,
            {"root": "clamped", "tip": kf.Interface("all", released=released), "middle": "rigid"},
            reduction=STATIC,
        )
        assert compliance(body, "middle")[1, 1] == pytest.approx(expected * LENGTH**3 / stiffness, rel=1e-9)
        assert len(body.interface("tip").fixed_components) == 6 - len(released)


# --------------------------------------------------------------------------------------- several bodies on one mesh


def two_bodies(gap: bool = False) -> Mesh:
    """Return a bar whose halves are two groups of cells; the facets between them are "joint"."""
    whole = box("hexahedron", (4, 2, 1), (LENGTH, WIDTH, HEIGHT))
    cells = whole.cells["bar"][0].nodes
    left = whole.nodes[cells].mean(axis=1)[:, 0] < LENGTH / 2
    faces = cells[left][:, [1, 2, 6, 5]]
    joint = faces[(abs(whole.nodes[faces][:, :, 0] - LENGTH / 2) < 1e-12).all(axis=1)]
    nodes, right = np.array(whole.nodes), cells[~left]
    if gap:
        right, nodes = right + len(nodes), np.vstack((nodes, nodes + np.array([0.01, 0.0, 0.0])))
    below = cells[:, [0, 3, 2, 1]]
    if gap:
        below = below[left]
    facets = {**whole.facets, "joint": (Cells("quad", joint),), "floor": (Cells("quad", below),)}
    return Mesh(
        nodes,
        3,
        {"left": (Cells("hexahedron", cells[left]),), "right": (Cells("hexahedron", right),)},
        facets,
        points={"corner": np.array([0])},
    )


def test_two_bodies_of_one_mesh_joined_by_a_scene_are_the_whole() -> None:
    mesh = two_bodies()
    ends = {"root": "clamped", "joint": "rigid"}
    whole = solid_body(mesh, {"left": STEEL, "right": STEEL}, ends, None, order=1)
    left = solid_body(mesh, {"left": STEEL}, ends, None, order=1, cells="left")
    right = solid_body(mesh, STEEL, {"joint": "clamped", "tip": "rigid"}, None, order=1, cells=["right"])
    assert left.mass + right.mass == pytest.approx(whole.mass, rel=1e-12)
    free_right = solid_body(mesh, STEEL, {"joint": "clamped"}, None, order=1, cells=["right"])
    scene = kf.System()
    first = scene.add_flexible_body("left", left)
    where = -free_right.interface("joint").position
    scene.add_flexible_body("right", free_right, parent=first.interface("joint"), at=where)
    frequencies = system_modes(scene.freeze())[0] / (2 * np.pi)
    # one matrix assembled in two ways: round-off times the condition number 1e6 of K, halved by the square root
    assert frequencies == pytest.approx(whole.frequencies, rel=1e-8)


def test_parts_keep_what_is_on_them() -> None:
    mesh = two_bodies()
    left, right = part_of(mesh, "left"), part_of(mesh, ["right"])
    assert sorted(left.facets) == ["floor", "joint", "root"]
    assert sorted(right.facets) == ["floor", "joint", "tip"]
    assert node_groups(left)["floor"].measure.sum() == pytest.approx(LENGTH * WIDTH / 2)
    assert node_groups(right)["floor"].measure.sum() == pytest.approx(LENGTH * WIDTH / 2)
    assert list(left.points) == ["corner"]
    assert not right.points
    assert len(left.nodes) + len(right.nodes) == len(mesh.nodes) + 6  # those of the joint are in both
    assert part_of(mesh, None) is mesh
    with pytest.raises(ModelError, match=r"no group of cells called 'middle'\. Remedy: cells= some of 'left', 'right'"):
        solid_model(mesh, STEEL, cells="middle")


def test_bodies_that_do_not_touch_are_taken_one_by_one() -> None:
    mesh = two_bodies(gap=True)
    with pytest.raises(MeshError, match="2 parts that are not connected"):
        solid_model(mesh, {"left": STEEL, "right": STEEL}, order=1)
    model = solid_model(mesh, STEEL, order=1, cells="right")
    assert model.mass.sum() / 3 == pytest.approx(STEEL.rho * LENGTH * AREA / 2, rel=1e-12)


# ---------------------------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("interfaces", "message"),
    [
        ({"root": "clampd"}, r"interface 'root' cannot be 'clampd'"),
        (["root"], r"interfaces must be a dict of names to kinds"),
        ({"end": kf.Interface(groups=("root", "tipp"))}, r"no group of facets called 'tipp'"),
        ({"root": "clamped", "both": kf.Interface(groups=("root", "tip"))}, r"'root' and 'both' share node"),
        ({"ends": kf.Interface(groups=("tip", "edge"))}, r"groups 'tip', 'edge' of interface 'ends' are facets, lines"),
        ({"slope": "rigid"}, r"nodes of interface 'slope' lie on a line"),
        ({"root": kf.Interface(kind="node")}, r"interface 'root' is of kind 'node', but its group has \d+ nodes"),
    ],
)
def test_bad_interfaces_are_found_before_anything_is_assembled(no_assembly, interfaces: dict, message: str) -> None:
    mesh = box("tetra", (4, 3, 2), (LENGTH, WIDTH, HEIGHT))
    corner = [int(np.argmin(np.linalg.norm(mesh.nodes - at, axis=1))) for at in ([0, 0, 0], [0.25, WIDTH / 3, 0])]
    lines = {"edge": (Cells("line", np.array([[0, 1]])),), "slope": (Cells("line", np.array([corner])),)}
    mesh = Mesh(mesh.nodes, 3, mesh.cells, mesh.facets, lines)
    with pytest.raises(ModelError, match=message):
        solid_body(mesh, STEEL, interfaces, reduction=STATIC)


def test_groups_alone_are_checked_without_a_kind() -> None:
    mesh = box("tetra", (2, 1, 1), (LENGTH, WIDTH, HEIGHT))
    check_interfaces(mesh, {"root": None})
    with pytest.raises(ModelError, match="no group of facets called 'roof'"):
        check_interfaces(mesh, {"roof": None})


# ------------------------------------------------------------------------------------- rigid ties that are too small


def block() -> FiniteElementModel:
    """Return a cube with the small patch "pad" in the middle of one side and the single node "point"."""
    n = 6
    model = solid_model(box("hexahedron", (n, n, n), (1.0, 1.0, 1.0)), STEEL, order=1)
    on_side = abs(model.nodes[:, 0] - 1.0) < 1e-12
    pad = np.flatnonzero(on_side & (abs(model.nodes[:, 1:] - 0.5).max(axis=1) < 1.01 / n))
    facet = np.flatnonzero(on_side & (abs(model.nodes[:, 1:] - 0.5 + 0.5 / n).max(axis=1) < 0.51 / n))
    model = with_group(with_group(model, "pad", pad), "facet", facet)
    return with_group(model, "point", np.array([np.argmin(np.linalg.norm(model.nodes - [1, 0.5, 0.5], axis=1))]))


def test_the_error_of_a_small_rigid_tie_is_estimated() -> None:
    model = block()
    stiff = flexible_body(model, {"root": "clamped", "pad": "rigid"}, reduction=STATIC)
    soft = flexible_body(model, {"root": "clamped", "pad": "average"}, reduction=STATIC)
    true = np.max(np.diag(compliance(soft, "pad")) / np.diag(compliance(stiff, "pad")) - 1.0)
    # the estimate looks at a piece of the mesh only: a bound from below but for second-order terms
    assert stiff.provenance["tie_errors"] == {"pad": pytest.approx(true, rel=0.1)}
    assert true > 0.01
    assert soft.provenance["tie_errors"] == {}


def test_the_error_of_a_small_clamped_patch_is_that_of_what_hangs_on_it() -> None:
    # the pad is the foot, the far side carries: its reaction strains the foot
    model = block()
    stiff = flexible_body(model, {"pad": "clamped", "root": "rigid"}, reduction=STATIC)
    soft = flexible_body(model, {"pad": CLAMPED_MEAN, "root": "rigid"}, reduction=STATIC)
    true = np.max(np.diag(compliance(soft, "root")) / np.diag(compliance(stiff, "root")) - 1.0)
    assert stiff.provenance["tie_errors"] == {"pad": pytest.approx(true, rel=0.1)}


def test_the_error_of_a_tie_of_a_body_that_is_held_everywhere_is_under_its_own_weight() -> None:
    model = block()
    with pytest.warns(TieWarning, match="'point' is a single node.* compliance under gravity along [xyz] is") as seen:
        body = flexible_body(model, {"root": "clamped", "point": "clamped"}, reduction=STATIC)
    assert len(seen) == 1
    assert 0.0 < body.provenance["tie_errors"]["point"] < 1.0


@pytest.mark.parametrize("name", ["point", "facet"])
def test_a_single_node_or_facet_of_a_solid_is_warned_of(name: str) -> None:
    with pytest.warns(
        TieWarning, match=rf"interface '{name}' is a single node.* \d\d% of the body's compliance"
    ) as seen:
        body = flexible_body(block(), {"root": "clamped", name: "rigid"}, reduction=STATIC)
    assert len(seen) == 1
    assert 0.3 < body.provenance["tie_errors"][name] < 1.0
    # half of the energy and more is in the elements around: the estimate is about the dent that the force makes
    frame = body.interface(name).motion[0, : body.free_count]
    u = body.node_displacements(np.linalg.solve(body.stiffness[: body.free_count, : body.free_count], frame))
    near = np.linalg.norm(body.nodes - body.interface(name).position, axis=1) < 0.4
    assert abs(u[near, 0]).max() > 2 * abs(u[~near, 0]).max()


def test_a_mesh_that_is_too_small_for_a_part_around_a_node_is_left_out() -> None:
    model = solid_model(box("hexahedron", (3, 3, 3), (1.0, 1.0, 1.0)), STEEL, order=1)
    corner = np.array([np.argmax(model.nodes.sum(axis=1))])
    with warnings.catch_warnings():
        warnings.simplefilter("error", TieWarning)
        body = flexible_body(
            with_group(model, "corner", corner), {"root": "clamped", "corner": "rigid"}, reduction=STATIC
        )
    assert body.provenance["tie_errors"] == {}


@functools.cache
def bar_of(divisions: tuple[int, int, int]) -> FiniteElementModel:
    size = (LENGTH, WIDTH, HEIGHT) if divisions[1] > 1 else (LENGTH, 0.05, 0.05)
    return solid_model(box("hexahedron", divisions, size), STEEL, order=2)


@pytest.mark.parametrize(
    "interfaces",
    [
        {"root": "clamped", "tip": "rigid"},
        {"root": "clamped", "tip": "clamped"},
        {"tip": "rigid"},
        {"root": CLAMPED_MEAN, "tip": "average"},
    ],
)
@pytest.mark.parametrize("divisions", [(8, 4, 4), (60, 1, 1)], ids=["bar", "one element thick"])
def test_whole_ends_of_bars_are_not_warned_of(interfaces: dict, divisions: tuple[int, int, int]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", TieWarning)
        body = flexible_body(bar_of(divisions), interfaces, reduction=kf.CraigBampton(modes=1))
    assert body.provenance["tie_errors"] == {}


# ------------------------------------------------------------------------------------------------- cost and cache


def test_an_average_over_a_large_patch_keeps_the_matrices_sparse() -> None:
    model = solid_model(box("tetra", (2, 14, 14), (0.1, 1.0, 1.0)), STEEL, order=2)
    ties = tie_interfaces(model, {"root": "clamped", "tip": "average"})
    patch = 3 * len(ties.ties[1].nodes)
    K = ties.project(model.stiffness)
    dense = patch**2
    assert K.nnz - model.stiffness.nnz < 0.35 * dense
    assert abs(K - K.T).max() < 1e-9 * abs(K).max()
    inner = ties.transformation[:, : ties.interior_count]
    assert abs(inner.T @ inner - sp.identity(ties.interior_count)).max() < 1e-12


def test_interfaces_are_part_of_the_key_of_the_cache(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("KANEFE_CACHE", "1")
    monkeypatch.setenv("KANEFE_CACHE_DIR", str(tmp_path))
    mesh = two_bodies()
    found = []
    for spec in (
        kf.Interface(kind="average"),
        kf.Interface(kind="average", weights="uniform"),
        kf.Interface(kind="average"),
    ):
        for cells in ("left", "right"):
            body = solid_body(mesh, STEEL, {"joint": spec}, reduction=kf.CraigBampton(modes=2), order=1, cells=cells)
            found.append(body.provenance["cache"]["found"])
    assert found == [False] * 4 + [True] * 2
