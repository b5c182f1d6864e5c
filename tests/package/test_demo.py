"""The demonstration: its geometry is that of the mesh source, both arms run, and the table is true."""

import runpy

import pytest

import kanefe as kf
from kanefe_fem import demo
from repository import ARM, ROOT


def test_geometry_is_that_of_the_mesh_source():
    source = runpy.run_path(str(ROOT / "meshes" / "arm.py"), run_name="arm")
    geometry = demo.GEOMETRY
    assert (geometry.length, geometry.root_width, geometry.tip_width, geometry.thickness, geometry.holes) == (
        source["LENGTH"],
        source["ROOT_WIDTH"],
        source["TIP_WIDTH"],
        source["THICKNESS"],
        source["HOLES"],
    )
    # two closed forms of the same volume: round-off
    assert geometry.mass_properties(1.0)[0] == pytest.approx(source["VOLUME"], rel=1e-14)


def test_beam_demo_writes_its_files_and_prints_its_table(tmp_path, capsys):
    demo.demo(demo.ArmKind.beam, None, tmp_path)
    printed = capsys.readouterr().out
    for row in ("mass", "first frequencies", "energy balance", "root coupling force", "time"):
        assert row in printed
    names = {path.name for path in tmp_path.iterdir()}
    assert {"overview.png", "energy.png", "root_force.png", "arm.pvd", "run.h5", "run.html"} <= names
    assert "run.html (open it in a browser)" in printed
    loaded = kf.load_result(tmp_path / "run.h5")
    # the hub stops where a rigid arm would, but for bending (some 1e-5 rad)
    assert loaded.joint_coordinates("hub")[-1, 0] == pytest.approx(0.7045, abs=0.01)


@pytest.mark.fenicsx
def test_mass_and_inertia_of_the_mesh_are_those_of_the_geometry():
    arm = demo.solid_arm(ARM)
    mass, x, J = demo.GEOMETRY.mass_properties(demo.ALUMINIUM.rho)
    # second-order cells approximate the round holes to some 1e-5 of their area
    assert arm.mass == pytest.approx(mass, rel=1e-4)
    assert arm.center_of_mass[0] == pytest.approx(x, rel=1e-4)
    assert arm.inertia[2, 2] == pytest.approx(J, rel=1e-4)


def test_beam_with_a_mesh_is_refused(tmp_path):
    with pytest.raises(kf.ModelError, match=r"--mesh has no meaning.*Remedy"):
        demo.demo(demo.ArmKind.beam, tmp_path / "any.msh", tmp_path / "out")
    assert not (tmp_path / "out").exists()
