"""Views of contacts: table, picture, points for ParaView; a block slides to rest, another never lands."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.results.contact_history import STATUS
from vtk_files import read_grid, read_series


@pytest.fixture(scope="module")
def result():
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    law = kf.KelvinVoigt(1e5, damping=60.0)
    slider = scene.add_point("slider", 1.0, joint=kf.Translation(position=(0.0, 0.5, 1e-3), velocity=(0.5, 0.0, 0.0)))
    scene.add_contact("slide", slider, floor, normal=law, friction=kf.Coulomb(0.3))
    high = scene.add_point("high", 1.0, at=(0.0, 0.0, 5.0))
    scene.add_contact("high up", high, floor, normal=law)
    return scene.simulate((0.0, 0.4), output_step=2e-3)


def test_the_point_of_a_contact_is_where_the_normal_force_acts(result):
    touching = result.contact("slide").status != "open"
    below = result.position("slider")[touching] * (1.0, 1.0, 0.0)
    np.testing.assert_allclose(result.contact("slide").point[touching, :2], below[:, :2], atol=1e-14)


def test_the_table_tells_touch_forces_and_slip(result):
    assert result.contacts == ("slide", "high up")
    header, slide, high = result.contact_report().splitlines()
    assert header.split()[0] == "contact"
    history = result.contact("slide")
    cells = slide.split()
    assert float(cells[1]) == pytest.approx(result.events["slide touch"][0], rel=1e-5)
    assert float(cells[3]) == pytest.approx(history.normal.max(), rel=1e-4)
    assert float(cells[-2]) == pytest.approx(history.slip[-1], rel=1e-3)
    assert float(cells[-1]) == pytest.approx(history.work[-1], rel=1e-3)
    assert high.split()[2] == "never"


def test_the_picture_has_forces_slip_and_status(result, tmp_path):
    figure = result.plot("contacts", path=tmp_path / "contacts.png")
    upper = figure.axes[0]
    history = result.contact("slide")
    np.testing.assert_array_equal(upper.lines[0].get_ydata(), history.normal)
    np.testing.assert_array_equal(upper.lines[1].get_ydata(), history.tangential)
    assert {patch.get_label() for patch in upper.collections} == set(history.status) - {"open"}
    (slid,) = (axes for axes in figure.axes if axes.get_ylabel().startswith("slip"))  # the other one has no friction
    np.testing.assert_array_equal(slid.lines[0].get_ydata(), 1e3 * history.slip)
    turning = kf.System()
    turning.add_rigid_body("wheel", 1.0, 1.0, joint=kf.Revolute("z"))
    without = turning.simulate((0.0, 0.1))
    with pytest.raises(kf.ModelError, match="no contact"):
        without.plot("contacts")


def test_the_series_has_the_forces_of_contacts(result, tmp_path):
    entries = read_series(result.to_vtk(tmp_path / "slide.pvd", every=100))
    time, file = next((time, file) for time, name, file in entries if name == "contacts" and time > 0.3)
    row = int(np.argmin(np.abs(result.times - time)))
    grid, history = read_grid(file), result.contact("slide")
    np.testing.assert_allclose(grid["points"][0], history.point[row])
    np.testing.assert_allclose(grid["force [N]"].reshape(-1, 3)[0], history.force[row])
    assert grid["status"].tolist() == [STATUS.index(history.status[row]), 0]
