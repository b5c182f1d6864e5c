"""Plots: what is drawn, with which units, and that nothing needs a display."""

import subprocess
import sys

import numpy as np
import pytest

import kanefe as kf
from kanefe.results.quantities import QUANTITIES
from result_scenes import four_bar, pendulum, robot, turntable


def test_the_overview_has_four_labelled_diagrams(tmp_path):
    figure = robot().plot(path=tmp_path / "new" / "overview.png")
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["angle [rad]", "deflection [mm]", "energy [J]", "force [N]"]
    assert [axes.get_xlabel() for axes in figure.axes[2:]] == ["time [s]", "time [s]"]
    assert (tmp_path / "new" / "overview.png").read_bytes().startswith(b"\x89PNG")


def test_legends_do_not_cover_the_curves():
    figure = robot().plot()
    figure.canvas.draw()
    for axes in figure.axes:
        legend = axes.get_legend().get_window_extent()
        assert legend.x0 >= axes.get_window_extent().x1 - 1.0


def test_a_coupling_force_is_drawn_by_force_and_moment():
    result = robot()
    figure = result.plot("coupling_force", "arm", "root")
    assert [axes.get_ylabel() for axes in figure.axes] == ["force [N]", "moment [N m]"]
    for axes, columns in zip(figure.axes, (slice(0, 3), slice(3, 6)), strict=True):
        assert [line.get_label() for line in axes.lines] == ["x", "y", "z"]
        drawn = np.column_stack([line.get_ydata() for line in axes.lines])
        np.testing.assert_array_equal(drawn, result.coupling_force("arm", "root")[:, columns])
        np.testing.assert_array_equal(axes.lines[0].get_xdata(), result.times)


def test_energy_is_drawn_with_its_balance():
    figure = robot().plot("energy")
    np.testing.assert_array_equal(figure.axes[1].lines[0].get_ydata(), robot().energy.balance_error)
    assert {line.get_label() for line in figure.axes[0].lines} >= {"kinetic", "elastic", "work", "mechanical"}


def test_gravity_is_drawn_from_its_start():
    """Far from N's origin all other energies would be a flat line beside it."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_point("ball", 1.0, joint=kf.Prismatic("z", position=1e6))
    axes = scene.simulate((0.0, 0.1), output_step=0.01).plot("energy").axes[0]
    curves = {line.get_label(): line.get_ydata() for line in axes.lines}
    assert abs(curves["gravity, from its start"]).max() < 1.0
    np.testing.assert_allclose(curves["mechanical"], 0.0, atol=1e-8)


def test_an_overview_says_what_it_leaves_out():
    scene = kf.System()
    for i in range(12):
        scene.add_rigid_body(f"b{i}", 1.0, 1.0, joint=kf.Free(velocity=(i, 0, 0)))
    axes = scene.simulate((0.0, 0.1), output_step=0.01).plot().axes
    assert "(the first 4 of 12)" in axes[0].get_title(loc="left")
    assert axes[1].get_legend().get_texts()[-1].get_text() == "and 1 more" or len(axes[1].lines) <= 12


def hung():
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    ball = scene.add_point("ball", 1.0, joint=kf.Prismatic("z"))
    scene.add_spring("spring", scene.ground.frame(at=(0.0, 0.0, 1.0)), ball, stiffness=50.0)
    return scene.simulate((0.0, 0.1), output_step=0.01)


def standing():
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_point("ball", 1.0, joint=kf.Prismatic("z"))
    scene.add_contact("c", ball, floor, normal=kf.KelvinVoigt(1e4))
    return scene.simulate((0.0, 0.1), output_step=0.01)


def geared():
    scene = kf.System()
    wheels = [scene.add_rigid_body(name, 1.0, 0.1, joint=kf.Revolute("z")) for name in ("small", "large")]
    scene.add_gear("pair", dict.fromkeys(wheels, 1))
    scene.add_motor(wheels[0], 1.0)
    return scene.simulate((0.0, 0.1), output_step=0.01)


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_every_quantity_can_be_drawn_without_a_name(quantity):
    scenes = {"driving_force": turntable, "loop_force": four_bar, "load": hung, "contact_points": standing}
    scenes["gear_force"] = geared
    result = scenes.get(quantity, robot)()
    figure = result.plot(quantity)
    assert all("[" in axes.get_ylabel() and "]" in axes.get_ylabel() for axes in figure.axes)
    assert all(axes.lines for axes in figure.axes)


def test_rigid_and_free_scenes_have_an_overview():
    scene = kf.System()
    scene.add_rigid_body("stone", mass=1.0, inertia=1.0, joint=kf.Free(velocity=(1, 0, 0)))
    flight = scene.simulate((0.0, 0.1), output_step=0.01)
    assert [a.get_ylabel() for a in flight.plot().axes][:2] == ["position [m]", "speed [m/s]"]
    assert [a.get_ylabel() for a in pendulum().plot().axes] == ["angle [rad]", "speed [m/s]", "energy [J]", "force [N]"]
    assert flight.plot("joint_coordinates").axes[1].get_ylabel() == "joint coordinates [1]"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("colour",), "no picture 'colour'.*overview"),
        (("position", "leg"), "'leg'.*hub, arm, tip"),
        (("coupling_force", "arm", "end"), "'end'.*root, tip"),
        (("energy", "arm"), "whole scene"),
        (("work", "arm"), "whole scene"),
        (("position", "arm", "tip", "x"), "a body and an interface"),
        (("joint_coordinates", "arm", "tip"), "takes a body"),
        (("driving_force",), "no body of the run has driving force"),
        (("coupling_force", "hub"), "'hub' is rigid"),
    ],
)
def test_a_picture_that_cannot_be_is_refused(arguments, message, tmp_path):
    with pytest.raises(kf.ModelError, match=message):
        robot().plot(*arguments, path=tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_cannot_be_drawn_to_is_refused(tmp_path):
    with pytest.raises(kf.ModelError, match=r"'doc' is none of.*png"):
        pendulum().plot("energy", path=tmp_path / "a.doc")
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(kf.FileError, match=r"cannot write .*a.png"):
        pendulum().plot("energy", path=tmp_path / "file" / "a.png")


def test_plotting_leaves_pyplot_alone_and_says_what_is_missing():
    script = """
import sys, kanefe as kf
scene = kf.System()
scene.add_rigid_body("a", mass=1.0, inertia=1.0, joint=kf.Revolute("z"))
result = scene.simulate((0.0, 0.1), output_step=0.1)
assert not {"matplotlib", "h5py", "pyevtk"} & set(sys.modules)
result.plot("energy")
assert "matplotlib.pyplot" not in sys.modules
sys.modules["matplotlib.axes"] = None
del sys.modules["kanefe.views.plots"]
try:
    result.plot("energy")
except kf.MissingDependency as error:
    assert "Result.plot needs matplotlib" in str(error) and "pip install" in str(error), error
else:
    raise SystemExit("no error")
"""
    subprocess.run([sys.executable, "-c", script], check=True)


def test_a_notebook_shows_a_figure_by_itself():
    assert pendulum().plot("energy")._repr_png_().startswith(b"\x89PNG")
