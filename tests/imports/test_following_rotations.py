"""Rotations without stiffness follow their neighbours, and no interface holds them."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from imported_bodies import Exported, folded_plate, solid_with_mast
from kanefe.errors import FileError, ModelError
from kanefe.frames import axis_rotation
from kanefe.imports.nodal_inertia import NodalFormWarning

TILTED = axis_rotation((2 / 3, 2 / 3, -1 / 3), 0.7)

MADE = {"solid with a mast": solid_with_mast, "folded plate": folded_plate}


def read(body: Exported, folder: Path, **groups: list[int]) -> kf.FiniteElementModel:
    """The body through files with labels; its root and others are groups."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NodalFormWarning)
        return kf.read_abaqus(
            *body.write(folder), groups={k: [i + 1 for i in v] for k, v in {"root": body.root, **groups}.items()}
        )


@pytest.mark.parametrize("tilt", [np.eye(3), TILTED], ids=["along axes", "tilted"])
@pytest.mark.parametrize("make", MADE.values(), ids=MADE)
def test_clamped_frequencies_are_those_of_the_matrices(
    make: Callable[[], Exported], tilt: np.ndarray, tmp_path: Path
) -> None:
    body = make()
    model = read(body.turned(tilt), tmp_path)
    for interface in ("clamped", kf.Interface("all", axes=axis_rotation((0.0, 0.0, 1.0), 0.4).tolist())):
        found = kf.flexible_body(model, {"root": interface}, reduction=kf.CraigBampton(modes=10)).frequencies
        # round-off of K over its lowest eigenvalue; held rotations made them 1e-3 (plate) and 0.26 (mast) too high
        assert found == pytest.approx(body.clamped_frequencies(10), rel=1e-9)


def test_an_average_and_a_single_node_hold_no_following_rotation(tmp_path: Path) -> None:
    model = read(solid_with_mast(), tmp_path, corner=[36])
    body = kf.flexible_body(model, {"root": "clamped", "corner": "node"}, reduction=kf.CraigBampton(modes=4))
    assert not body.interfaces[1].motion[3:].any()
    by_mass = kf.Interface("all", kind="average", weights="mass")
    mean = kf.flexible_body(model, {"root": by_mass}, reduction=kf.CraigBampton(modes=6)).frequencies
    even = kf.Interface("all", kind="average")
    assert mean[0] < kf.flexible_body(model, {"root": "clamped"}, reduction=kf.CraigBampton(modes=6)).frequencies[0]
    assert mean == pytest.approx(
        kf.flexible_body(model, {"root": even}, reduction=kf.CraigBampton(modes=6)).frequencies, rel=0.05
    )


def test_a_single_node_of_a_flat_shell_is_no_clamp(tmp_path: Path) -> None:
    plate = folded_plate()
    model = read(plate, tmp_path, one=[6], edge=[0, 1])
    with pytest.raises(ModelError, match=r"leave 1 rigid motion\(s\) of the body free"):
        kf.flexible_body(model, {"one": "clamped"})
    model = read(plate.turned(TILTED), tmp_path, one=[6])
    with pytest.raises(ModelError, match=r"'one' could turn about .* normal of a flat shell\. Remedy: more nodes, or"):
        kf.flexible_body(model, {"one": "clamped"})


def test_inertia_of_a_following_rotation_goes_to_what_it_follows(tmp_path: Path) -> None:
    plain = solid_with_mast()
    heavy = solid_with_mast()
    at = 6 * 20
    heavy.M[at + 3 : at + 6, at + 3 : at + 6] = np.diag((1e-3, 2e-3, 3e-3))
    model, bare = read(heavy, tmp_path), read(plain, tmp_path)
    R = model.rigid_modes(about=tuple(model.nodes[20]))
    assert model.following is not None
    assert abs(model.following @ model.mass).max() < 1e-15
    more = R.T @ (model.mass - bare.mass) @ R
    assert more == pytest.approx(np.diag((0, 0, 0, 1e-3, 2e-3, 3e-3)), abs=1e-12)


def test_files_keep_what_follows(tmp_path: Path) -> None:
    body = solid_with_mast()
    model = read(body, tmp_path)
    kf.write_matrices(model, tmp_path / "body.npz")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NodalFormWarning)
        same = kf.read_matrices(tmp_path / "body.npz")
    assert same.following is not None
    assert model.following is not None
    assert abs(same.following - model.following).max() == 0.0
    held = kf.flexible_body(same, {"root": "clamped"}, reduction=kf.CraigBampton(modes=4)).frequencies
    assert held == pytest.approx(body.clamped_frequencies(4), rel=1e-9)
    with np.load(tmp_path / "body.npz") as file:
        arrays = dict(file)
    np.savez(tmp_path / "body.npz", **{**arrays, "following_data": 2.0 * arrays["following_data"]})
    with pytest.raises(FileError, match="no directions of rotations"):
        kf.read_matrices(tmp_path / "body.npz")


def test_nodes_that_define_no_rotation_are_named(tmp_path: Path) -> None:
    body = solid_with_mast()
    lonely = Exported(np.vstack((body.points, (0.0, 0.0, 0.5))), body.root)
    lonely.add(list(range(len(body.points))), body.K, body.M)
    lonely.M[-6:-3, -6:-3] = np.eye(3)
    with pytest.raises(ModelError, match=rf"1 node\(s\) have mass, but no stiffness: {len(lonely.points)}\. Remedy"):
        read(lonely, tmp_path)
