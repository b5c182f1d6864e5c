"""Pages that show runs: what they hold, read back as a browser does, is what the result says."""

import dataclasses
import hashlib
import html as html_module
import json
import re
import sys
import types

import numpy as np
import pytest

import kanefe as kf
from disk_faults import full_disk
from kanefe.contact.outlines import outline
from kanefe.fe_model.model import Cells
from kanefe.frames import rotation_matrix
from kanefe.views.player import drawn_modes, page
from kanefe.views.player.creases import shaded
from kanefe.views.player.drawn_modes import UNSEEN, von_mises
from kanefe.views.player.skins import skin_of
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Rectangle
from player_pages import body_of, placed, read_page
from repository import ROOT
from result_scenes import SOFT, four_bar, pendulum, robot, turntable

WEB = ROOT / "kanefe" / "views" / "player" / "web"
FLOAT32 = 2.0**-23


def told_of(result: kf.Result, **options: object) -> dict:
    return read_page(page.page_of(result, **options).html)


def ball_on_floor() -> kf.Result:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=kf.Free(position=(0.3, 0.2, 0.15)))
    shell = scene.add_surface("shell", ball, kf.shapes.Sphere(0.1))
    scene.add_spring("string", scene.ground.frame(at=(0, 0, 1)), ball, stiffness=10.0)
    scene.add_contact("drop", shell, floor, normal=kf.KelvinVoigt(1e4, damping=40.0))
    return scene.simulate((0.0, 0.3), output_step=5e-3)


def test_a_page_loads_nothing_and_says_so_to_the_browser(tmp_path):
    html = robot().to_html(tmp_path / "run.html", title="arm & <hub>").read_text(encoding="utf-8")
    assert "default-src 'none'" in html
    assert "<title>arm &amp; &lt;hub&gt;</title>" in html
    assert not re.search(r"""(src|href)\s*=\s*["']?(https?:|//)""", html)
    assert not re.search(r"\b(fetch|XMLHttpRequest|importScripts)\(\s*[\"'`]http", html)
    assert html.count("<script") == html.count("</script>") == 3
    assert read_page(html)["title"] == "arm & <hub>"


@pytest.mark.parametrize(
    "title", ["/* arrays */", "/* scene */", "/* player */", "<!-- title -->", "</script>", r"\1\g<0>"]
)
def test_a_title_that_looks_like_a_mark_of_the_page_stays_a_title(title):
    html, plain = (page.page_of(robot(), title=name).html for name in (title, "plain"))
    assert read_page(html)["title"] == title
    assert f"<title>{html_module.escape(title)}</title>" in html
    assert html.count("<script") == plain.count("<script")
    # the title, and its text among the data, are all by which the pages differ
    longer = len(html_module.escape(title)) + len(json.dumps(title).replace("<", "\\u003c"))
    assert len(html) - len(plain) == longer - len("plain") - len('"plain"')


def test_a_page_of_a_beam_is_small(tmp_path):
    path = robot().to_html(tmp_path / "run.html")
    player = (WEB / "player.js").stat().st_size
    assert player < 700_000
    assert path.stat().st_size < player + 60_000


def test_nodes_are_where_the_result_says():
    result = robot()
    told = told_of(result, every=3)
    shape, part = result.body("arm"), body_of(told, "arm")["parts"][0]
    rows = range(0, len(result.times), 3)
    np.testing.assert_array_equal(told["times"], result.times[::3])
    skin = skin_of(shape)
    assert np.abs(part["modes"].reshape(len(part["modes"]), -1)).max(axis=1) == pytest.approx(32767)
    # of each mode half a step of its numbers, what was left out, and the digits of places in a room of this size
    step = 0.5 * np.abs(part["amplitudes"]).max(axis=0) @ part["factors"]
    largest = np.abs(result.nodal_displacements("arm")).max()
    bound = np.sqrt(3) * (step + UNSEEN * largest) + 8 * FLOAT32 * told["size"]
    eta = result.modal_coordinates("arm")
    assert bound < 1e-3 * largest
    for row, frame in enumerate(rows):
        A_NG = rotation_matrix(result.rotation("arm")[frame])
        local = skin.points + skin.motion(shape, eta[frame][None])[0]
        there = result.position("arm")[frame] + local @ A_NG.T
        assert np.abs(placed(told, part, row) - there).max() < bound
    # a section's middle is its node
    nodes = result.nodal_positions("arm", frames=15)
    middles = placed(told, part, 5).reshape(-1, skin.fibres, 3).mean(axis=1)
    assert np.abs(middles - nodes[skin.nodes.reshape(-1, skin.fibres)[:, 0]]).max() < bound


def test_beams_have_the_sides_of_their_section():
    skin = skin_of(robot().body("arm"))
    np.testing.assert_allclose(np.ptp(skin.points, axis=0), (1.0, 0.02, 0.04), rtol=1e-9)


def test_a_twisted_beam_turns_its_sections():
    shape = robot().body("arm")
    basis = np.zeros((len(shape.nodes), 6, 1))
    basis[:, 3, 0] = 1.0  # all turn about x
    twisted = dataclasses.replace(shape, basis=basis.reshape(-1, 1))
    skin = skin_of(twisted)
    moved = skin.motion(twisted, np.array([[1e-3]]))[0]
    np.testing.assert_allclose(moved, 1e-3 * np.cross((1.0, 0.0, 0.0), skin.arms), atol=1e-18)


def test_rigid_bodies_move_as_in_the_result():
    result = turntable()
    told = told_of(result)
    part = body_of(told, "load")["parts"][0]
    for row in (0, 20, 50):
        corners = placed(told, part, row)
        np.testing.assert_allclose(corners.mean(axis=0), result.center_of_mass("load")[row], atol=1e-6)
    assert body_of(told, "load")["kind"] == "rigid"


def test_up_is_against_gravity():
    assert told_of(four_bar())["up"] == [0.0, 1.0, 0.0]
    assert told_of(robot())["up"] == [0.0, 0.0, 1.0]
    assert told_of(turntable())["up"] == [0.0, 0.0, 1.0]


def test_surfaces_contacts_and_springs_are_told():
    result = ball_on_floor()
    told = told_of(result)
    ball, ground = body_of(told, "ball"), body_of(told, "ground")
    assert [part["surface"] for part in ball["parts"]] == ["shell"]  # stands for the box
    assert [part["is_endless"] for part in ground["parts"]] == [True]
    row = 40
    np.testing.assert_allclose(
        np.linalg.norm(placed(told, ball["parts"][0], row) - result.position("ball")[row], axis=1), 0.1, atol=1e-6
    )
    assert np.abs(placed(told, ground["parts"][0], 0)[:, 2]).max() < 1e-6
    (arrow,), (link,) = told["arrows"], told["links"]
    np.testing.assert_allclose(arrow["f"], result.contact("drop").force, rtol=1e-6, atol=1e-6)
    assert arrow["largest"] == pytest.approx(result.contact("drop").normal.max(), rel=1e-6)
    np.testing.assert_allclose(link["p"][:, 1] + told["origin"], result.position("ball"), atol=1e-6)
    np.testing.assert_allclose(link["p"][3, 0] + told["origin"], (0.0, 0.0, 1.0), atol=1e-6)


def test_a_surface_on_an_interface_stands_in_its_axes():
    beam = straight_beam(1.0, Rectangle(0.02, 0.04), SOFT, elements=2)
    quarter = kf.rotation_about("z", np.pi / 2)
    interfaces = {"root": "clamped", "tip": kf.Interface(axes=quarter)}
    scene = kf.System()
    body = kf.flexible_body(beam, interfaces, reduction=kf.CraigBampton(modes=1))
    arm = scene.add_flexible_body("arm", body)
    scene.add_surface("knob", arm.interface("tip"), kf.shapes.Box((0.02, 0.04, 0.06)), at=(0.3, 0, 0))
    told = told_of(scene.simulate((0.0, 0.1)))
    assert body_of(told, "arm")["parts"][0]["factors"].shape == (0,)  # nothing moves it
    knob = placed(told, body_of(told, "arm")["parts"][1], 0)
    # x of the interface is y of the arm
    np.testing.assert_allclose(knob.mean(axis=0), (1.0, 0.3, 0.0), atol=1e-6)
    np.testing.assert_allclose(np.ptp(knob, axis=0), (0.04, 0.02, 0.06), atol=1e-6)


def test_surfaces_come_back_from_a_file(tmp_path):
    result = ball_on_floor()
    result.save(tmp_path / "run.h5", forces=False)
    loaded = kf.load_result(tmp_path / "run.h5")
    first, second = told_of(result), told_of(loaded)
    for name in ("ball", "ground"):
        for one, two in zip(body_of(first, name)["parts"], body_of(second, name)["parts"], strict=True):
            np.testing.assert_array_equal(placed(first, one, 7), placed(second, two, 7))
    with pytest.raises(kf.ModelError, match=r"saved without forces.*forces=False"):
        loaded.to_html(tmp_path / "run.html", forces=True)


def test_reactions_are_arrows_in_the_inertial_frame():
    result = pendulum()
    (arrow,) = told_of(result, forces=True)["arrows"]
    A_NR = rotation_matrix(result.rotation("rod")[30])
    np.testing.assert_allclose(arrow["f"][30], A_NR @ result.joint_reaction("rod")[30, :3], rtol=1e-5)
    assert told_of(result)["arrows"] == []


class Pressed:
    """A stress that is given: mode 0 has 1 GPa along x in every fibre but the first, where there is none."""

    def __init__(self, result: kf.Result) -> None:
        self.name, self.result = "arm", result

    def stress_of(self, eta: np.ndarray) -> np.ndarray:
        stress = np.zeros((len(eta), len(skin_of(self.result.body("arm")).points), 6))
        stress[:, :, 0] = 1e9 * eta[:, :1]
        stress[:, 0] = np.nan
        return stress

    def mesh_error_of(self, eta: np.ndarray) -> float:
        return np.nan


def test_stresses_are_told_by_mode():
    result = robot()
    told = told_of(result, stress=Pressed(result))
    part = body_of(told, "arm")["parts"][0]
    assert told["colour"] == "stress"
    row = 25
    stress = np.tensordot(part["amplitudes"][row] * part["stress_factors"], part["stresses"].astype(float), axes=1)
    expected = 1e9 * abs(result.modal_coordinates("arm")[row, 0])
    assert np.flatnonzero(part["bare"]).tolist() == [0]
    np.testing.assert_allclose(von_mises(stress)[1:], expected, rtol=2e-4)
    largest = 1e9 * np.abs(result.modal_coordinates("arm")[:, 0]).max()
    assert told["largest"]["stress"] == pytest.approx(largest, rel=1e-6)


def test_many_coordinates_become_the_principal_ones_of_the_motion(monkeypatch):
    result = robot()
    shape, eta = result.body("arm"), result.modal_coordinates("arm")
    skin = skin_of(shape)
    own = drawn_modes.drawn_modes(shape, skin, eta, None)
    monkeypatch.setattr(drawn_modes, "MOST_OWN", 0)
    principal = drawn_modes.drawn_modes(shape, skin, eta, None)
    moved = np.tensordot(own.amplitudes, own.shapes, axes=1)
    np.testing.assert_allclose(
        np.tensordot(principal.amplitudes, principal.shapes, axes=1), moved, atol=2 * UNSEEN * np.abs(moved).max()
    )
    assert len(principal.shapes) <= eta.shape[1]


def test_modes_that_nobody_sees_are_left_out():
    result = robot()
    shape, eta = result.body("arm"), np.array(result.modal_coordinates("arm"))
    main = int(np.argmax(np.abs(eta).max(axis=0)))
    two = dataclasses.replace(shape, basis=shape.basis[:, [main, main]])
    seen = [
        len(drawn_modes.drawn_modes(two, skin_of(two), eta[:, [main, main]] * (1.0, share), None).shapes)
        for share in (0.5 * UNSEEN, 2.0 * UNSEEN)
    ]
    assert seen == [1, 2]


@pytest.mark.parametrize(
    ("kind", "nodes", "area"),
    [
        ("tetra", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], 1.5 + 0.5 * np.sqrt(3)),
        (
            "hexahedron",
            [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
            6.0,
        ),
        ("triangle6", [(0, 0, 0), (2, 0, 0), (0, 2, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], 2.0),
        ("quad8", [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0)], 4.0),
    ],
)
def test_the_skin_has_the_area_of_the_body(kind, nodes, area):
    places = np.array(nodes, dtype=float)
    shape = dataclasses.replace(
        robot().body("arm"), nodes=places, cells=(Cells(kind, np.arange(len(places))[None]),), elasticity=None
    )
    skin = skin_of(shape)
    a, b, c = (skin.points[skin.triangles[:, i]] for i in range(3))
    normals = 0.5 * np.cross(b - a, c - a)
    assert np.linalg.norm(normals, axis=1).sum() == pytest.approx(area)
    if area > 4.0 or kind == "tetra":  # closed: its normals add up to nothing
        np.testing.assert_allclose(normals.sum(axis=0), 0.0, atol=1e-12)


def test_light_breaks_at_edges_only():
    box, ball = outline(kf.shapes.Box((1.0, 1.0, 1.0))), outline(kf.shapes.Sphere(1.0))
    split = shaded(box.vertices, box.triangles)
    assert (len(split.points), len(split.creases)) == (24, 12)
    smooth = shaded(ball.vertices, ball.triangles)
    assert (len(smooth.points), len(smooth.creases)) == (len(ball.vertices), 0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"colour": "red"}, "colour of a page must be one of displacement, stress, none"),
        ({"colour": "stress"}, r"needs the stress\. Remedy: stress=kanefe_fem\.recover"),
        ({"stress": 3.0}, r"stress must be what kanefe_fem\.recover"),
        ({"scale": float("nan")}, "scale of the displacements must be finite"),
        ({"fps": 25, "every": 2}, "not both"),
        ({"every": 0}, "every must be"),
        ({"title": 3}, "title of a page must be a text, not 3"),
    ],
)
def test_bad_options_are_named(tmp_path, options, message):
    with pytest.raises(kf.ModelError, match=message):
        robot().to_html(tmp_path / "run.html", **options)
    assert list(tmp_path.iterdir()) == []


def test_stress_of_an_unknown_body_or_of_another_run_is_refused(tmp_path):
    field = Pressed(robot())
    with pytest.raises(kf.ModelError, match=r"no body called 'arm'. It has: rod"):
        pendulum().to_html(tmp_path / "run.html", stress=field)
    field.result = pendulum()
    with pytest.raises(kf.ModelError, match="the stress of 'arm' is of another run"):
        robot().to_html(tmp_path / "run.html", stress=field)


@pytest.mark.parametrize("name", ["", "run", "run.png"])
def test_a_page_has_a_name_that_says_so(tmp_path, name):
    with pytest.raises(kf.ModelError, match=r"its name must end in \.html"):
        robot().to_html(tmp_path / name)


def test_a_full_disk_leaves_the_page_that_was_there(tmp_path, monkeypatch):
    path = robot().to_html(tmp_path / "run.html")
    before = path.read_bytes()
    monkeypatch.setattr("os.fsync", full_disk)
    with pytest.raises(kf.FileError, match="Remedy: free some space"):
        turntable().to_html(path)
    assert path.read_bytes() == before


def test_a_place_that_is_no_number_is_refused(tmp_path):
    class Lost:
        def __getattr__(self, name: str) -> object:
            return getattr(pendulum()._channels, name)

        def read(self, quantity: str, body: str = "", interface: str = "", of: str = "") -> np.ndarray:
            values = np.array(pendulum()._channels.read(quantity, body, interface))
            if quantity == "position":
                values[10] = np.nan
            return values

    with pytest.raises(kf.ModelError, match=r"the position of body 'rod' is not finite at t = 0\.2 s"):
        kf.Result.from_channels(Lost()).to_html(tmp_path / "run.html")


def test_view_opens_a_temporary_file_and_says_where(monkeypatch, capsys, tmp_path):
    opened = []
    monkeypatch.setattr(page.webbrowser, "open", lambda url: bool(opened.append(url)) or len(opened) == 1)
    monkeypatch.setattr(page.tempfile, "mkdtemp", lambda prefix: str(tmp_path))
    shown = pendulum().view()
    assert shown.path == tmp_path / "run.html"
    assert opened == [shown.path.as_uri()]
    assert capsys.readouterr().out == f"shown in the browser: {shown.path}\n"
    pendulum().view()
    assert "there is no browser to open: the page is" in capsys.readouterr().out


def test_view_in_a_notebook_is_a_frame_with_the_page_in_it(monkeypatch):
    shell = types.SimpleNamespace(kernel=object())
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=lambda: shell))
    monkeypatch.setattr(page.webbrowser, "open", lambda url: pytest.fail("opened a browser"))
    shown = pendulum().view()
    frame = shown._repr_html_()
    assert shown.path is None
    assert frame.startswith('<iframe srcdoc="&lt;!doctype html&gt;')
    assert "<script" not in frame


def test_the_built_player_is_that_of_its_source():
    sources = [WEB / "package.json", WEB / "package-lock.json", *sorted((WEB / "src").glob("*.js"))]
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()[:16]
    built = (WEB / "player.js").read_text(encoding="utf-8")
    assert f"Source {digest}" in built[:300], "run .ci/player, which builds it with npm"
    assert (WEB / "LICENSE.three").read_text(encoding="utf-8") in built
