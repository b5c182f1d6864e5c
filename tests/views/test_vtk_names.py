"""What files for ParaView call their bodies, contacts and loads; read by VTK itself where it is installed."""

import dataclasses

import numpy as np
import pytest

import kanefe as kf
from kanefe.fe_model.model import Cells
from kanefe.views import vtk
from result_scenes import robot
from vtk_files import read_fields, read_grid, read_series


def contact_and_springs() -> kf.Result:
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    far = scene.add_rigid_body("far & away", 1.0, 1e-2, com=(0.1, 0, 0), joint=kf.Revolute("y", position=0.1))
    block = scene.add_rigid_body("blöck", 2.0, 0.01, joint=kf.Free(position=(0, 0, 0.05)))
    box = scene.add_surface("box", block, kf.shapes.Box((0.2, 0.1, 0.1)))
    scene.add_contact("stands", box, floor, normal=kf.HuntCrossley(1e6, damping=1.0))
    scene.add_spring("tie", far, block.frame(at=(0.05, 0, 0)), stiffness=1.0)
    return scene.simulate((0.0, 0.01), output_step=0.01)


def test_each_file_has_its_time_and_names_by_number(tmp_path):
    result = contact_and_springs()
    entries = read_series(result.to_vtk(tmp_path / "run.pvd"))
    assert [name for _, name, _ in entries[:3]] == ["rigid bodies", "contacts", "loads along lines"]
    for time, name, file in entries:
        fields, grid = read_fields(file), read_grid(file)
        assert fields["TimeValue"] == [time]
        kind, names = next(pair for pair in fields.items() if pair[0] != "TimeValue")
        assert (kind, names) == {
            "rigid bodies": ("bodies", ["far & away", "blöck"]),
            "contacts": ("contacts", ["stands"]),
            "loads along lines": ("loads", ["tie"]),
        }[name]
        number = {"bodies": "body", "contacts": "contact", "loads": "load"}[kind]
        assert grid[number].tolist() == list(range(len(names)))
        assert {"body", "contact", "load"} & set(grid) == {number}


def test_wedges_have_a_number_that_keeps_its_sense(tmp_path):
    """VTK's wedge 13 has volume -0.5 up to 9.6.2 and +0.5 from 9.7 on; 73, seen in both, +0.5, with faces outwards."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)], dtype=float)
    shape = dataclasses.replace(robot().body("arm"), cells=(Cells("wedge", np.arange(6)[None]),))
    grid = vtk._mesh_grid(shape, 0)
    assert grid.types.tolist() == [73]
    file = vtk._write_grid(tmp_path / "wedge", corners, grid, {}, {}, "")
    pyvista = pytest.importorskip("pyvista")
    found = pyvista.read(file)
    assert found.compute_cell_sizes()["Volume"].tolist() == pytest.approx([0.5], rel=1e-12)


def test_vtk_reads_names_and_time(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    entries = read_series(contact_and_springs().to_vtk(tmp_path / "run.pvd"))
    last = pyvista.read(entries[-3][2])
    assert list(last.field_data["bodies"]) == ["far & away", "blöck"]
    assert last.field_data["TimeValue"].tolist() == [0.01]
