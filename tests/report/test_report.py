"""Reports of flexible bodies: mesh quality, effective masses against closed forms, the three formats, pictures."""

from __future__ import annotations

import re
import signal
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from importlib.util import find_spec

import numpy as np
import pytest

import kanefe as kf
from kanefe.documents.blocks import Heading, Histogram, Paragraph, Picture, Table
from kanefe.documents.document import Report
from kanefe.documents.record_tables import record_tables
from kanefe.fe_model.model import Cells
from kanefe.report.mesh_quality import mesh_quality
from kanefe.report.modes import body_modes, compliance_shares, interface_masses
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.exact import exact_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material
from result_scenes import beam_arm

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


@cache
def cantilever() -> kf.FlexibleBody:
    rod = straight_beam(1.0, Rectangle(0.01, 0.01), STEEL, elements=30, theory="euler-bernoulli")
    return beam_body(rod, {"root": "clamped"}, reduction=kf.CraigBampton(modes=40), damping=kf.ModalDamping(0.02))


class TestMeshQuality:
    @pytest.mark.parametrize(
        ("kind", "nodes"),
        [
            ("triangle", [[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(3) / 2, 0]]),
            ("quad", [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
            ("tetra", [[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]]),
            ("hexahedron", [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]),
        ],
    )
    def test_a_regular_cell_is_perfect_and_an_inverted_one_negative(self, kind, nodes):
        nodes = np.array(nodes, dtype=float)
        order = np.arange(len(nodes))
        quality = mesh_quality(nodes, (Cells(kind, order[None]),))
        assert quality.scaled_jacobian == pytest.approx([1.0])
        assert quality.aspect_ratio == pytest.approx([1.0])
        mirrored = mesh_quality(nodes * [-1.0, 1.0, 1.0], (Cells(kind, order[None]),))
        assert mirrored.scaled_jacobian == pytest.approx([-1.0])

    def test_a_long_brick_and_a_sheared_one(self):
        brick = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (4, 0), (4, 1), (0, 1))], dtype=float)
        table = np.arange(8)[None]
        quality = mesh_quality(brick, (Cells("hexahedron", table),))
        assert (quality.scaled_jacobian[0], quality.aspect_ratio[0]) == pytest.approx((1.0, 4.0))
        assert quality.edges[0] == pytest.approx([1.0, 4.0])
        sheared = brick / [4.0, 1.0, 1.0]
        sheared[:, 0] += sheared[:, 1]  # corners of 45 degrees
        assert mesh_quality(sheared, (Cells("hexahedron", table),)).scaled_jacobian == pytest.approx([np.sqrt(0.5)])

    def test_a_right_angled_corner_tetrahedron_by_hand(self):
        nodes = np.vstack((np.zeros(3), np.eye(3)))
        quality = mesh_quality(nodes, (Cells("tetra", np.arange(4)[None]),))
        # at the far corners: 6 V over the sides 1, sqrt 2, sqrt 2, times sqrt 2
        assert quality.scaled_jacobian == pytest.approx([np.sqrt(2) / 2])
        inscribed = 3 * (1 / 6) / (1.5 + np.sqrt(3) / 2)
        assert quality.aspect_ratio == pytest.approx([np.sqrt(2) / (2 * np.sqrt(6) * inscribed)])

    def test_bent_sides_are_measured(self):
        from kanefe.fe_model.shapes import shape

        nodes = shape("tetra10").nodes.copy()
        nodes[4] += [0.0, 0.0, 0.1]  # middle of the side from 0 to 1
        assert mesh_quality(nodes, (Cells("tetra10", np.arange(10)[None]),)).bend == pytest.approx([0.1])


class TestModes:
    def test_effective_masses_of_a_cantilever_are_those_of_the_books(self):
        shares = body_modes(cantilever()).effective_shares
        # Euler-Bernoulli: 0.6131, 0.1883, 0.0647 of the mass in the first bending modes, in pairs of one frequency
        total = np.sort(shares[1] + shares[2])[::-1]
        assert total[:2].sum() / 2 == pytest.approx(0.6131, abs=2e-3)
        assert total[2:4].sum() / 2 == pytest.approx(0.1883, abs=2e-3)
        assert total[4:6].sum() / 2 == pytest.approx(0.0647, abs=2e-3)

    def test_they_sum_to_the_mass_that_is_free_to_move(self):
        body = cantilever()
        shares = body_modes(body).effective_shares
        assert np.all(shares.sum(axis=1)[[1, 2]] > 0.97)
        assert np.all(shares.sum(axis=1) < 1.0 + 1e-12)

    def test_one_clamped_interface_has_the_effective_masses_of_the_body(self):
        body = cantilever()
        modes = body_modes(body)
        # its static shapes are the rigid motions about it, and it stands at the origin of G
        np.testing.assert_allclose(interface_masses(body, modes), modes.participation**2, atol=1e-9 * body.mass)

    def test_frequencies_and_damping(self):
        modes = body_modes(cantilever())
        np.testing.assert_allclose(modes.frequencies, cantilever().frequencies, rtol=1e-10)
        np.testing.assert_allclose(modes.damping_ratios, 0.02, rtol=1e-9)

    def test_shares_of_compliance_sum_to_one_where_something_moves(self):
        body = beam_arm()
        shares = compliance_shares(body.interface("tip").motion[:, : body.free_count], body_modes(body))
        np.testing.assert_allclose(shares.sum(axis=1), 1.0)
        nothing = compliance_shares(body.interface("root").motion[:, : body.free_count], body_modes(body))
        assert not nothing.any()


class TestText:
    def test_it_tells_what_the_body_is(self):
        text = str(cantilever().report())
        for words in (
            "Mesh quality",
            "30 line",
            "With the fixed interfaces held.",
            "Mass properties",
            "0.785",
            "Effective masses",
            "Interfaces",
            "root",
            "x, y, z, rx, ry, rz",
            "Reduction",
            "CraigBampton",
            "Conditioning",
            "What was skipped",
            "motion-induced stiffening",
            "Origin",
            "kanefe_fem.beam_model",
            "and 10 more modes",
        ):
            assert words in text, words
        first = re.search(r"^ +1 +(\S+) +2$", text, flags=re.MULTILINE)
        assert float(first[1]) == pytest.approx(cantilever().frequencies[0], rel=1e-5)
        assert max(len(line) for line in text.splitlines() if not line.startswith("  ")) <= 100

    def test_bodies_of_all_kinds_have_one(self):
        rod = straight_beam(1.0, Rectangle(0.01, 0.02), STEEL, elements=3)
        floating = str(kf.flexible_body(rod, {}, reduction=kf.CraigBampton(modes=4)).report())
        assert "The body floats" in floating
        assert "no interfaces" in floating
        held = str(
            kf.flexible_body(rod, {"root": "clamped", "tip": "hinged"}, reduction=kf.CraigBampton(modes=2)).report()
        )
        assert "only the interface 'tip' moves" in held
        assert "no free coordinates" in str(
            kf.flexible_body(rod, {"root": "clamped"}, reduction=kf.CraigBampton(modes=0)).report()
        )
        bends = str(exact_beam(1.0, Rectangle(0.01, 0.02), STEEL, basis=2).report())
        assert "With the root section held" in bends
        assert "rigid sections along the beam" in bends
        unreduced = kf.flexible_body(rod, {"root": "clamped"})
        assert "Mass properties" in str(unreduced.report())

    def test_a_saved_body_has_the_same_report(self, tmp_path):
        cantilever().save(tmp_path / "rod.npz")
        assert str(kf.FlexibleBody.load(tmp_path / "rod.npz").report()) == str(cantilever().report())

    def test_poor_cells_are_named(self):
        from kanefe.report import body as report_body

        nodes = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, 0.3, 0.01]], dtype=float)

        class Flat:
            cells = (Cells("tetra", np.arange(4)[None]),)

        Flat.nodes = nodes
        blocks = report_body._mesh(Flat)
        assert any(isinstance(b, Paragraph) and b.warning and "1 cells are flat" in b.text for b in blocks)

    def test_records_of_any_depth_become_tables(self):
        blocks = record_tables(
            {
                "method": "X",
                "error": {"value": 1e-3, "loads": [{"load": "tip", "static": 0.5}, {"load": "b"}]},
                "none": None,
            }
        )
        first, title, table = blocks
        assert [list(row) for row in first.rows] == [["method", "X"], ["error, value", "0.001"]]
        assert title.text == "error, loads:"
        assert table.rows == [["tip", "0.5"], ["b", ""]]


PIXEL = b"\x89PNG not really"
BLOCKS = (
    Heading("One & two"),
    Paragraph("Careful <now>", warning=True),
    Table(("a", "b|c"), [["1", "2"], ["3", "4"]]),
    Histogram("Cells:", [0.0, 0.5, 1.0], [1, 3]),
)


def small(draw=lambda: {"One & two": [Picture("mode 1", PIXEL)]}) -> Report:
    return Report("A <report>", BLOCKS, draw)


def without_pyvista() -> dict[str, list[Picture]]:
    raise kf.MissingDependency("pyvista", "a picture of a mesh", "pip install 'kanefe[report]'")


class Tags(HTMLParser):
    """Checks that tags close in order, and keeps the text and the images."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text: list[str] = []
        self.images: list[str] = []

    def handle_starttag(self, tag, attrs):
        if tag == "img":
            self.images.append(dict(attrs)["src"])
        elif tag != "meta":
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        assert tag == "rect"

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


class TestFormats:
    def test_text(self):
        text = str(small())
        assert "! Careful <now>" in text
        assert "0.50 to  1.00         3  " + 40 * "#" in text

    def test_html_is_one_page_with_its_pictures(self, tmp_path):
        path = small().to_html(tmp_path / "deep" / "a.html")
        page = path.read_text(encoding="utf-8")
        tags = Tags()
        tags.feed(page)
        assert tags.open == []
        assert "Careful <now>" in tags.text
        assert tags.images == ["data:image/png;base64,iVBORyBub3QgcmVhbGx5"]
        assert "http" not in page
        assert list(tmp_path.rglob("*.png")) == []

    def test_markdown_has_its_pictures_beside_it(self, tmp_path):
        text = small().to_markdown(tmp_path / "a.md").read_text(encoding="utf-8")
        assert "![mode 1](a_files/picture_01.png)" in text
        assert (tmp_path / "a_files" / "picture_01.png").read_bytes() == PIXEL
        assert "| a | b\\|c |\n| :-- | --: |" in text
        assert "**Careful <now>**" in text
        rule = next(line for line in text.splitlines() if line.startswith("| :--"))
        assert rule == "| :-- | --: |"

    def test_without_pyvista_the_report_says_so(self, tmp_path):
        report = small(without_pyvista)
        assert "pip install 'kanefe[report]'" in report.to_markdown(tmp_path / "a.md").read_text()
        assert "kanefe[report]" in report.to_html(tmp_path / "a.html").read_text()
        with pytest.raises(kf.MissingDependency, match="pyvista"):
            report.to_html(tmp_path / "b.html", pictures=True)
        assert not (tmp_path / "b.html").exists()
        assert "pyvista" not in report.to_html(tmp_path / "c.html", pictures=False).read_text()

    def test_text_to_a_file(self, tmp_path):
        assert small().to_text(tmp_path / "a.txt").read_text() == str(small())


class TestPictures:
    def test_a_machine_without_pyvista(self, monkeypatch, tmp_path):
        from kanefe.views import pictures

        monkeypatch.setattr(pictures, "find_spec", lambda name: None)
        with pytest.raises(kf.MissingDependency, match=r"needs pyvista.*kanefe\[report\]"):
            pictures.drawn([])
        assert "Mode shapes are not drawn" in cantilever_again().report().to_html(tmp_path / "a.html").read_text()

    def test_a_machine_without_graphics_has_an_error_and_no_crash(self, monkeypatch):
        from kanefe.views import artist, pictures

        monkeypatch.setattr(pictures, "find_spec", lambda name: name)
        monkeypatch.setattr(artist.sys, "executable", "/bin/false")
        artist.ARTIST.end()
        drawing = pictures.shape_drawing(np.zeros((1, 3)), (), np.zeros((1, 3)))
        with pytest.raises(kf.MissingDependency, match=r"graphics library.*stopped without a message"):
            pictures.drawn([drawing])

    @pytest.mark.skipif(find_spec("pyvista") is None, reason="pyvista is not installed: pip install 'kanefe[report]'")
    def test_mode_shapes_are_drawn(self):
        report = beam_arm().report()
        shown = [block for block in report.with_pictures(True) if isinstance(block, Picture)]
        assert [picture.caption.split(":")[0] for picture in shown] == [f"mode {i + 1}" for i in range(len(shown))]
        assert len(shown) == beam_arm().free_count
        from io import BytesIO

        from PIL import Image

        images = [np.asarray(Image.open(BytesIO(picture.png)).convert("RGB")).astype(int) for picture in shown]
        for image in images:
            assert image.shape == (260, 360, 3)
            assert 0.002 < (np.ptp(image, axis=2) > 40).mean() < 0.5  # something in colours on white
        assert abs(images[0] - images[2]).max() > 100

    @pytest.mark.skipif(find_spec("pyvista") is None, reason="pyvista is not installed: pip install 'kanefe[report]'")
    def test_one_process_draws_all_pictures_until_it_dies(self):
        from kanefe.views import artist, pictures

        def shape(length):
            bar = straight_beam(length, Rectangle(0.01, 0.1), STEEL, elements=3)
            return pictures.shape_drawing(bar.nodes, bar.cells, bar.nodes[:, [2, 1, 0]], size=(90, 60))

        artist.ARTIST.end()
        first = pictures.drawn([shape(1.0)])
        process = artist.ARTIST._process
        assert pictures.drawn([shape(1.0)]) == first
        assert artist.ARTIST._process is process
        process.kill()
        process.wait()
        heard = []  # PETSc takes the signal of a broken pipe for the end
        before = signal.signal(signal.SIGPIPE, lambda *arguments: heard.append(arguments))
        try:
            assert pictures.drawn([shape(1.0)]) == first
        finally:
            signal.signal(signal.SIGPIPE, before)
        assert not heard
        assert artist.ARTIST._process is not process
        with pytest.raises(kf.MissingDependency, match="'nothing'"):
            pictures.drawn([replace(shape(1.0), options={"nothing": 1})])
        assert pictures.drawn([shape(1.0)]) == first
        artist.ARTIST.end()
        assert artist.ARTIST._process is None


def cantilever_again() -> kf.FlexibleBody:
    rod = straight_beam(1.0, Rectangle(0.01, 0.01), STEEL, elements=3)
    return beam_body(rod, {"root": "clamped"}, reduction=kf.CraigBampton(modes=2))
