"""What notebooks show: cards that are well-formed, true to what they show, and quick to make."""

import re
import subprocess
import sys
import types
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import kanefe as kf
from kanefe.linear.linearisation import linearise
from kanefe.storage import watched
from kanefe.views import thumbnail
from kanefe.views.still import picture_of_body, picture_of_run
from png_files import read_png
from result_scenes import beam_arm, four_bar, pendulum, robot


def read_card(html: str) -> list[list[str]]:
    """Return the rows of all tables of a card, which must be well-formed."""
    root = ET.fromstring(re.sub(r"(<img [^>]*)>", r"\1/>", html))  # HTML leaves pictures open
    return [["".join(cell.itertext()) for cell in row] for row in root.iter("tr")]


def test_a_scene_lists_its_bodies_and_what_acts():
    scene = kf.System(gravity=(0, 0, -9.81))
    hub = scene.add_rigid_body("hub <1>", 4.0, 0.02, joint=kf.Revolute("z"))
    arm = scene.add_flexible_body("arm", beam_arm(), parent=hub)
    tip = scene.add_rigid_body("tip", 0.2, 1e-4, parent=arm.interface("tip"))
    scene.add_torque(hub, lambda t: 1.0)
    scene.add_spring("string", scene.ground, tip, stiffness=10.0)
    rows = read_card(scene._repr_html_())
    assert ["hub <1>", "rigid, 4 kg", "revolute z"] in rows
    assert ["arm", "flexible, 0.96 kg, 7 modes", "fixed"] in rows
    assert ["spring", "string: the ground and 'tip'"] in rows
    assert ["load", "the torque on 'hub <1>'"] in rows
    assert not scene.is_frozen


def test_a_scene_without_bodies_is_shown_too():
    assert "scene of 0 bodies" in kf.System()._repr_html_()


def test_a_body_tells_mass_frequencies_and_interfaces():
    body = beam_arm()
    rows = dict(row for row in read_card(body._repr_html_()) if len(row) == 2)
    assert rows["mass"] == "0.96 kg"
    assert float(rows["frequencies"].split(",")[0]) == pytest.approx(body.frequencies[0], rel=1e-3)
    assert rows["interfaces"] == "root (fixed), tip"


def test_a_run_tells_how_it_ended_and_who_took_part():
    html = robot()._repr_html_()
    rows = read_card(html)
    assert "the run finished at t = 0.4 s" in html
    assert ["arm", "flexible, 0.96 kg, 7 modes", "fixed"] in rows
    assert any(row[0] == "method" and row[1].startswith("generalised-alpha") for row in rows)


def test_modes_are_listed_with_frequency_and_damping():
    scene = kf.System()
    cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x"))
    scene.add_spring("spring", scene.ground.frame(at=(-1, 0, 0)), cart, stiffness=8.0, damping=0.4)
    modes = linearise(scene).modes()
    (row,) = [row for row in read_card(modes._repr_html_()) if row[0] == "0"]
    # damping ratio c / (2 sqrt(k m)) = 0.05
    assert row[2:] == ["5 %", "cart 100 %"]
    assert float(row[1].removesuffix(" Hz")) == pytest.approx(modes.frequencies[0], rel=1e-5)


def test_damping_that_is_round_off_is_none():
    scene = kf.System()
    blade = kf.Revolute("z", motion=kf.Motion.steady(20.0))
    scene.add_flexible_body("blade", beam_arm(), joint=blade)
    rows = read_card(linearise(scene).modes()._repr_html_())
    assert {row[2] for row in rows if row[0].isdigit()} == {"0 %"}


def test_a_thumbnail_shows_the_nearest_surface():
    up = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    square = np.array([(0, 1, 2), (0, 2, 3)])
    none = np.zeros((0, 2), dtype=int)
    red = thumbnail.Piece(up, square, none, (200, 0, 0))
    blue = thumbnail.Piece(up + np.array((0, 0, 0.3)), square, none, (0, 0, 200))
    image = read_png(thumbnail.thumbnail([red, blue]))
    seen = image[image[..., 3] == 255]
    assert (seen[:, 2] > 90).any()
    # above hides below where both are, whatever is drawn first
    np.testing.assert_array_equal(image, read_png(thumbnail.thumbnail([blue, red])))
    centre = image[image.shape[0] // 2, image.shape[1] // 2]
    assert centre[2] > 90
    assert centre[0] == 0


def test_a_thumbnail_fills_its_width_or_height():
    for png in (picture_of_body(beam_arm()), picture_of_run(robot()), picture_of_run(pendulum(), 0)):
        opaque = read_png(png)[..., 3] > 0
        columns = np.flatnonzero(opaque.any(axis=0))
        assert np.ptp(columns) > 0.8 * thumbnail.SIZE[0] or len(opaque) > 0.8 * thumbnail.SIZE[1]


def test_a_still_is_that_of_its_time():
    first, last = read_png(picture_of_run(four_bar(), 0)), read_png(picture_of_run(four_bar(), -1))
    assert first.shape != last.shape or (first != last).any()


def test_cards_need_no_library_of_pictures():
    code = (
        "import sys, kanefe as kf\n"
        "scene = kf.System(); scene.add_rigid_body('a', 1.0, 0.1, joint=kf.Revolute('z'))\n"
        "scene._repr_html_(); scene.simulate((0.0, 0.1))._repr_html_()\n"
        "print(*sorted({'matplotlib', 'pyvista', 'IPython', 'PIL'} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.stdout.strip() == "", done.stderr


@pytest.fixture
def notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    shell = types.SimpleNamespace(kernel=object())
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=lambda: shell))


def test_a_notebook_is_watched_and_its_bars_wait(notebook, monkeypatch):
    assert watched.is_watched()
    monkeypatch.setattr(watched, "find_spec", lambda name: None)
    with watched.progress_bar(total=3) as bar:
        assert bar.delay == watched.DELAY


def test_a_run_in_a_notebook_shows_a_bar(notebook, monkeypatch):
    made = []

    class Bar:
        n = 0.0

        def __init__(self, **options: object) -> None:
            made.append(options)

        def update(self, seconds: float) -> None:
            self.n += seconds

        def __enter__(self) -> "Bar":
            return self

        def __exit__(self, *error: object) -> None:
            made.append(self.n)

    monkeypatch.setattr("kanefe.integrate.run.progress_bar", Bar)
    scene = kf.System()
    scene.add_rigid_body("a", 1.0, 0.1, joint=kf.Revolute("z", speed=1.0))
    scene.simulate((0.0, 0.1))
    assert made[0]["desc"] == "simulate"
    assert made[1] == pytest.approx(0.1)
