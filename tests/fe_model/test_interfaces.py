"""Interfaces: patches tied to frames, released components, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.fe_model.model import FiniteElementModel, NodeGroup, rigid_motion
from kanefe.fe_model.ties import tie_interfaces
from kanefe.reduction import flexible_body
from scenes import lattice_model

CLAMPED = {"root": "clamped", "tip": "rigid"}


def with_groups(model: FiniteElementModel, **groups: list[int]) -> FiniteElementModel:
    """Return the model with more groups, each at the mean of its nodes."""
    numbers = {name: np.array(nodes, dtype=int) for name, nodes in groups.items()}
    added = {name: NodeGroup(n, model.nodes[n].mean(axis=0) if len(n) else np.zeros(3)) for name, n in numbers.items()}
    return replace(model, groups={**model.groups, **added})


@pytest.mark.parametrize("reduction", [None, kf.CraigBampton(modes=2)], ids=str)
def test_a_patch_moves_as_a_rigid_body_with_its_frame(reduction: kf.CraigBampton | None) -> None:
    model = lattice_model(0)
    body = flexible_body(model, CLAMPED, reduction=reduction)
    for name in CLAMPED:
        frame, nodes = body.interface(name), model.groups[name].nodes
        assert frame.position == pytest.approx(model.groups[name].position, abs=1e-15)
        motion = body.basis.reshape(len(model.nodes), 3, -1)[nodes].reshape(-1, body.count)
        expected = rigid_motion(model.nodes[nodes], frame.position) @ frame.motion
        assert motion == pytest.approx(expected, abs=1e-12 * abs(expected).max())


@pytest.mark.parametrize("reduction", [None, kf.CraigBampton(modes=2)], ids=str)
def test_fixed_components_are_the_last_coordinates_and_nothing_else_moves_them(
    reduction: kf.CraigBampton | None,
) -> None:
    body = flexible_body(lattice_model(0), {"tip": kf.Interface(("z", "rx")), "root": "clamped"}, reduction=reduction)
    tip, root = body.interface("tip"), body.interface("root")
    k = body.free_count
    assert (tip.fixed_components, tip.fixed_columns) == ((2, 3), (k, k + 1))
    assert (root.fixed_components, root.fixed_columns) == (tuple(range(6)), tuple(range(k + 2, k + 8)))
    for frame in (tip, root):
        rows = frame.motion[list(frame.fixed_components)]
        assert rows[:, :k] == pytest.approx(np.zeros_like(rows[:, :k]), abs=1e-15)
        assert rows[:, list(frame.fixed_columns)] == pytest.approx(np.eye(len(rows)), abs=1e-15)
    released = [c for c in range(6) if c not in tip.fixed_components]
    assert np.linalg.matrix_rank(tip.motion[released][:, :k]) == 4  # released components move, independently


def test_a_single_node_without_rotations_follows_translations_only() -> None:
    body = flexible_body(lattice_model(0), {"root": "clamped", "middle": "clamped"})
    assert body.interface("middle").fixed_components == (0, 1, 2)
    assert body.fixed_count == 9


def test_a_single_node_with_rotations_is_a_frame_of_its_own() -> None:
    body = flexible_body(lattice_model(0, rotations=True), {"root": "clamped", "middle": "clamped"})
    assert body.interface("middle").fixed_components == tuple(range(6))


def test_planar_interfaces_have_three_components() -> None:
    body = flexible_body(lattice_model(0, planar=True), CLAMPED)
    assert body.interface("root").fixed_components == (0, 1, 5)
    assert not body.interface("tip").motion[[2, 3, 4]].any()


def test_hinge_about_one_axis() -> None:
    body = flexible_body(lattice_model(0), {"root": kf.Interface(("x", "y", "z", "rx", "ry")), "tip": "hinged"})
    assert body.fixed_count == 8
    assert body.frequencies[0] > 0.1  # held: no rigid motion is left


def test_clamped_at_a_hinge_and_a_slider_is_held() -> None:
    # six components spread over two interfaces so that each rigid motion is held once
    body = flexible_body(lattice_model(0), {"root": "hinged", "tip": kf.Interface(("y", "z", "rx"))})
    assert body.fixed_count == 6
    assert body.frequencies[0] > 0.1


@pytest.mark.parametrize(
    ("interfaces", "message"),
    [
        (
            {"rooot": "clamped"},
            r"no group of facets or nodes called 'rooot'\. Remedy: .*\(empty, line, middle, root, shared, tip\)",
        ),
        ({"root": "clammped"}, r"interface 'root' cannot be 'clammped'\. Remedy: one of clamped, rigid, hinged"),
        ({"root": "clamped", "empty": "rigid"}, r"interface 'empty' has no nodes\. Remedy: give its physical group"),
        (
            {"root": "clamped", "shared": "rigid"},
            r"interfaces 'root' and 'shared' share node 2: .* Remedy: leave a row of elements",
        ),
        (
            {"line": "clamped"},
            r"nodes of interface 'line' lie on a line.* Remedy: give the interface a group of facets",
        ),
        ({"middle": "clamped"}, r"fixed in G \(middle\) leave 3 rigid motion"),
    ],
)
def test_bad_interfaces_are_named(interfaces: dict, message: str) -> None:
    model = lattice_model(0)
    nodes = model.nodes.copy()
    nodes[4], nodes[5] = nodes[0] + [0.1, 0.1, 0.1], nodes[0] + [0.3, 0.3, 0.3]
    model = with_groups(replace(model, nodes=nodes), empty=[], shared=[2, 4, 5], line=[0, 4, 5])
    with pytest.raises(ModelError, match=message):
        flexible_body(model, interfaces)


@pytest.mark.parametrize("fixed", [("x", "w"), "x", ("rot",)])
def test_unknown_components_are_refused(fixed: object) -> None:
    with pytest.raises(ModelError, match="an interface fixes components among x, y, z, rx, ry, rz"):
        kf.Interface(fixed)


def test_fixing_what_the_nodes_do_not_have_is_refused() -> None:
    # "middle" has no rotation: fixing it would be silently without effect
    with pytest.raises(
        ModelError,
        match=r"interface 'middle' fixes rz, which its nodes cannot follow: .* x, y, z\. Remedy: leave out rz",
    ):
        flexible_body(lattice_model(0), {"root": "clamped", "middle": kf.Interface(("x", "rz"))})


def test_planar_body_takes_a_frame_named_with_all_its_own_components() -> None:
    body = flexible_body(lattice_model(0, planar=True), {"root": kf.Interface(("x", "y", "rz"))})
    assert body.fixed_count == 3


def test_unknown_interface_of_a_body_lists_those_there_are() -> None:
    body = flexible_body(lattice_model(0), CLAMPED)
    with pytest.raises(ModelError, match=r"no interface called 'tipp'\. It has: root, tip"):
        body.interface("tipp")


def test_node_frames() -> None:
    model = lattice_model(0)
    body = flexible_body(model, CLAMPED)
    frame = body.node_frame(4)
    assert frame.motion[:3] == pytest.approx(body.basis[12:15], abs=0.0)
    assert not frame.motion[3:].any()
    for node in (-1, 9):
        with pytest.raises(ModelError, match=f"node {node} is not one of the 9 nodes"):
            body.node_frame(node)


def test_tied_coordinates_keep_stiffness_energy() -> None:
    model = lattice_model(0)
    ties = tie_interfaces(model, CLAMPED)
    x = np.random.default_rng(0).standard_normal(ties.transformation.shape[1])
    moved = ties.transformation @ x
    assert x @ ties.project(model.stiffness) @ x == pytest.approx(moved @ model.stiffness @ moved, rel=1e-12)
