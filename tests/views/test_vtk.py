"""Series for ParaView, read back from the files themselves."""

import dataclasses
import sys
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from disk_faults import full_disk
from kanefe.fe_model.model import Cells
from kanefe.frames import rotation_matrix
from kanefe.results.selection import spread_frames
from kanefe.views import vtk
from kanefe.views.cuboids import equivalent_cuboid
from result_scenes import pendulum, robot, turntable
from vtk_files import read_grid, read_series


def volume(corners: np.ndarray) -> float:
    """Return the signed volume of a box whose corners stand in VTK's order: around the bottom, then around the top."""
    for face in corners.reshape(2, 4, 3):
        np.testing.assert_allclose(face[0] + face[2], face[1] + face[3], atol=1e-13)
    edges = corners[[1, 3, 4]] - corners[0]
    np.testing.assert_allclose(corners[4:] - corners[:4], np.tile(edges[2], (4, 1)), atol=1e-13)
    return float(np.linalg.det(edges))


def test_the_series_lists_every_frame_by_a_relative_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = robot().to_vtk("out/arm.pvd", every=10)
    assert path == Path("out/arm.pvd")
    assert "/" + "out" not in path.read_text()
    entries = read_series(path)
    assert sorted({t for t, *_ in entries}) == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert {name for _, name, _ in entries} == {"arm", "rigid bodies"}
    assert all(file.is_file() for *_, file in entries)


def test_frames_of_an_earlier_series_go_and_other_files_stay(tmp_path):
    robot().to_vtk(tmp_path / "arm.pvd", every=10)
    own = tmp_path / "arm_frames" / "mine.vtu"
    own.write_text("")
    entries = read_series(robot().to_vtk(tmp_path / "arm.pvd", every=20))
    assert set(own.parent.iterdir()) == {own, *(file for *_, file in entries)}


def test_a_mesh_is_written_where_it_is(tmp_path):
    result = robot()
    entries = read_series(result.to_vtk(tmp_path / "arm.pvd", every=10))
    file = next(file for time, name, file in entries if name == "arm" and time == pytest.approx(0.2))
    grid = read_grid(file)
    assert grid["sizes"].tolist() == [7, 6]
    np.testing.assert_allclose(grid["points"], result.nodal_positions("arm", frames=20), atol=1e-15)
    A_NG = rotation_matrix(result.rotation("arm")[20])
    np.testing.assert_allclose(grid["displacement [m]"], result.nodal_displacements("arm", 20) @ A_NG.T, atol=1e-16)
    assert grid["types"].tolist() == [3] * 6
    np.testing.assert_array_equal(grid["connectivity"].reshape(-1, 2), np.column_stack((np.arange(6), np.arange(1, 7))))
    assert grid["offsets"].tolist() == [2, 4, 6, 8, 10, 12]
    assert grid["body"].tolist() == [1] * 6


def test_scale_multiplies_the_displacements_only(tmp_path):
    result = robot()
    plain, scaled = (
        read_grid(read_series(result.to_vtk(tmp_path / f"{s}.pvd", every=40, scale=s))[-2][2]) for s in (1.0, 10.0)
    )
    np.testing.assert_array_equal(plain["displacement [m]"], scaled["displacement [m]"])
    moved = scaled["points"] - plain["points"]
    np.testing.assert_allclose(moved, 9.0 * plain["displacement [m]"], atol=1e-14)
    assert abs(moved).max() > 1e-3


def test_rigid_bodies_are_boxes_of_their_inertia(tmp_path):
    result = robot()
    entries = read_series(result.to_vtk(tmp_path / "arm.pvd", every=40))
    grid = read_grid(entries[-1][2])
    assert grid["types"].tolist() == [12, 12]
    assert grid["body"].tolist() == [0, 2]
    hub, tip = grid["points"].reshape(2, 8, 3)
    sides = np.sqrt(6 / 4.0 * (0.07 - 2 * np.array([0.02, 0.02, 0.03])))
    assert volume(hub) == pytest.approx(sides.prod(), rel=1e-12)
    np.testing.assert_allclose(hub.mean(axis=0), result.position("hub")[-1], atol=1e-15)
    com = result.position("tip")[-1] + 0.02 * rotation_matrix(result.rotation("tip")[-1])[:, 0]
    np.testing.assert_allclose(tip.mean(axis=0), com, atol=1e-14)
    assert volume(tip) > 0


def test_a_point_is_shown_and_a_body_without_mass_is_not(tmp_path):
    scene = kf.System()
    carrier = scene.add_rigid_body("carrier", mass=0.0, joint=kf.Revolute("z"))
    scene.add_rigid_body("bob & <co>", mass=1.0, parent=carrier, at=(2.0, 0, 0))
    entries = read_series(scene.simulate((0.0, 0.1), output_step=0.1).to_vtk(tmp_path / 'a & "b".pvd'))
    grid = read_grid(entries[0][2])
    assert grid["body"].tolist() == [1]
    assert volume(grid["points"]) == pytest.approx(0.04**3, rel=1e-9)  # 2 % of the scene's 2 m


@pytest.mark.parametrize("seed", range(5))
def test_the_box_has_the_inertia_it_stands_for(seed):
    rng = np.random.default_rng(seed)
    sides = rng.uniform(0.1, 2.0, 3)
    axes, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    inertia = axes @ np.diag(3.0 / 12 * (sides @ sides - sides**2)) @ axes.T
    found, turned = equivalent_cuboid(3.0, inertia)
    np.testing.assert_allclose(np.sort(found), np.sort(sides), rtol=1e-10)
    again = turned @ np.diag(3.0 / 12 * (found @ found - found**2)) @ turned.T
    np.testing.assert_allclose(again, inertia, atol=1e-12)
    assert np.linalg.det(turned) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("kind", "number", "count"),
    [
        ("tetra10", 24, 10),
        ("wedge", 73, 6),
        ("hexahedron27", 29, 27),
        ("quad9", 28, 9),
        ("tetra", 10, 4),
        ("vertex", 1, 1),
    ],
)
def test_cells_keep_their_order_of_nodes(kind, number, count, tmp_path):
    result, nodes = robot(), np.random.default_rng(0).permutation(27)[:count][None] % 7
    shape = dataclasses.replace(result.body("arm"), cells=(Cells(kind, nodes),))
    file = vtk._write_mesh(result, (shape, None), vtk._mesh_grid(shape, 0), 1.0, None, tmp_path / "a", 0, "")
    grid = read_grid(file)
    assert grid["types"].tolist() == [number]
    assert grid["connectivity"].tolist() == nodes[0].tolist()


def test_a_body_without_cells_is_a_cloud_of_points(tmp_path):
    shape = dataclasses.replace(robot().body("arm"), cells=())
    grid = read_grid(
        vtk._write_mesh(robot(), (shape, None), vtk._mesh_grid(shape, 0), 1.0, None, tmp_path / "a", 0, "")
    )
    assert grid["types"].tolist() == [1] * 7


def test_frames_are_chosen_by_rate_or_step():
    times = np.linspace(2.0, 3.0, 501)
    assert spread_frames(times, 25.0, None, 200).tolist() == list(range(0, 501, 20))
    assert spread_frames(times, 1e5, None, 200).tolist() == list(range(501))
    assert len(spread_frames(times, None, None, 200)) <= 200
    assert spread_frames(times, None, 250, 200).tolist() == [0, 250, 500]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fps": 0.0}, "fps must be above zero"),
        ({"fps": "25"}, "fps must be above zero, not '25'"),
        ({"every": 0}, "every must be"),
        ({"every": "5"}, "every must be"),
        ({"every": 1.5}, "every must be"),
        ({"fps": 25, "every": 2}, "not both"),
        ({"scale": np.inf}, "scale"),
    ],
)
def test_options_without_sense_are_refused_before_anything_is_written(options, message, tmp_path):
    with pytest.raises(kf.ModelError, match=message):
        turntable().to_vtk(tmp_path / "a.pvd", **options)
    with pytest.raises(kf.ModelError, match=r"must end in \.pvd"):
        turntable().to_vtk(tmp_path / "a.vtu")
    assert list(tmp_path.iterdir()) == []


def test_a_failure_of_the_disk_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(vtk, "VtkFile", full_disk)
    with pytest.raises(kf.FileError, match=r"a.pvd: No space left.*Remedy"):
        pendulum().to_vtk(tmp_path / "a.pvd")
    assert not (tmp_path / "a.pvd").exists()


def test_without_pyevtk_the_remedy_is_named(monkeypatch, tmp_path):
    monkeypatch.delitem(sys.modules, "kanefe.views.vtk")
    monkeypatch.setitem(sys.modules, "pyevtk.vtk", None)
    with pytest.raises(kf.MissingDependency, match=r"Result.to_vtk needs pyevtk.*pip install"):
        pendulum().to_vtk(tmp_path / "a.pvd")
