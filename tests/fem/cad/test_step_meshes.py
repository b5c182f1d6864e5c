"""Meshes of STEP and BREP files: units, sizes, groups, limits, and files that are no solids."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import FileError, MeshError, ModelError, UnitWarning
from kanefe_fem import read_mesh
from kanefe_fem.cad import geometry
from kanefe_fem.cad.mesher import volumes_of
from kanefe_fem.mesh.checks import MeshWarning
from step_files import loose_faces, plate, two_boxes, write_step

pytestmark = pytest.mark.gmsh
VOLUME = 100 * 60 * 10 - np.pi * 36 * 10
"""Of the plate, in cubes of the unit of the file."""


@pytest.fixture(scope="module")
def step(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_step(tmp_path_factory.mktemp("step") / "plate.step", plate)


@pytest.mark.parametrize(("unit", "length"), [("mm", 1e-3), ("m", 1.0), ("inch", 0.0254)])
def test_lengths_are_those_of_the_unit_of_the_file(tmp_path, unit, length):
    path = write_step(tmp_path / "plate.step", plate, unit=unit)
    mesh = read_mesh(path, order=2, size=15 * length)
    assert np.ptp(mesh.nodes, axis=0) == pytest.approx(np.array([100, 60, 10]) * length, rel=1e-9)  # flat sides
    (volume,) = volumes_of(mesh).values()
    assert volume == pytest.approx(VOLUME * length**3, rel=1e-4)  # parabolas on a hole of a few sides


def test_a_given_unit_replaces_that_of_the_file_and_says_so(step):
    with pytest.warns(UnitWarning, match=r"says mm and is read in in, as unit= asks: 25\.4 times as large"):
        mesh = read_mesh(step, size=0.4, unit="in")
    assert np.ptp(mesh.nodes[:, 0]) == pytest.approx(2.54, rel=1e-9)
    assert mesh.provenance["unit"] == "in"


def test_a_session_of_the_user_and_its_unit_are_left_alone(step, gmsh_session):
    gmsh_session.model.occ.importShapes(str(step))
    gmsh_session.option.setNumber("Mesh.CharacteristicLengthMax", 7.0)
    mesh = read_mesh(step, size=0.02)
    assert np.ptp(mesh.nodes[:, 0]) == pytest.approx(0.1, rel=1e-9)
    assert gmsh_session.option.getNumber("Mesh.CharacteristicLengthMax") == 7.0
    gmsh_session.model.add("again")
    gmsh_session.model.occ.importShapes(str(step))
    gmsh_session.model.occ.synchronize()
    assert gmsh_session.model.getBoundingBox(-1, -1)[3] == pytest.approx(100.0, rel=1e-6)  # still mm


def test_brep_names_no_unit_and_needs_one(tmp_path):
    path = write_step(tmp_path / "plate.brep", plate)
    with pytest.raises(FileError, match=r"no unit.*unit='mm'"):
        read_mesh(path, size=0.01)
    mesh = read_mesh(path, size=0.02, unit="mm")
    assert np.ptp(mesh.nodes[:, 0]) == pytest.approx(0.1, rel=1e-9)


def test_faces_are_found_by_place_as_a_whole(step):
    faces = {
        "eye": kf.InCylinder((0.03, 0.03, 0), (0.03, 0.03, 0.01), 0.006, 0.005),
        "root": kf.OnPlane((0, 0, 0), (1, 0, 0)),
        "tip": kf.Near((0.1, 0.03, 0.005), 0.031),
        "top": lambda x: x[:, 2] > 0.0099,
    }
    mesh = read_mesh(step, order=2, size=0.02, faces=faces)
    assert set(mesh.facets) == set(faces)
    corners = {name: np.unique(blocks[0].nodes) for name, blocks in mesh.facets.items()}
    assert np.linalg.norm(mesh.nodes[corners["eye"]][:, :2] - 0.03, axis=1) == pytest.approx(0.006, rel=1e-9)
    assert mesh.nodes[corners["root"]][:, 0] == pytest.approx(0.0, abs=1e-12)
    assert mesh.nodes[corners["tip"]][:, 0] == pytest.approx(0.1, rel=1e-9)
    assert mesh.nodes[corners["top"]][:, 2] == pytest.approx(0.01, rel=1e-9)


def test_sizes_of_parts_and_faces_and_from_curvature(step, tmp_path):
    eye = {"eye": kf.InCylinder((0.03, 0.03, 0), (0.03, 0.03, 0.01), 0.006, 0.005)}
    coarse = read_mesh(step, size=0.02, faces=eye)
    fine = read_mesh(step, size={"*": 0.02, "eye": 0.002}, faces=eye)
    turned = read_mesh(step, size=0.01, faces=eye, per_turn=24)
    counts = [len(mesh.facets["eye"][0].nodes) for mesh in (coarse, fine, turned)]
    assert counts[1] > 4 * counts[0]
    rim = np.unique(turned.facets["eye"][0].nodes)
    assert np.count_nonzero(np.isclose(turned.nodes[rim, 2], 0.0)) == pytest.approx(24, abs=2)
    boxes = write_step(tmp_path / "boxes.step", two_boxes, names=("long", "cube"))
    mesh = read_mesh(boxes, size={"cube": 0.0015, "long": 0.01}, joined=True)
    both = read_mesh(boxes, size=0.01, joined=True)
    assert len(mesh.cells["cube"][0].nodes) > 4 * len(both.cells["cube"][0].nodes)


def test_parts_are_meshed_alone_or_joined_where_they_touch(tmp_path):
    boxes = write_step(tmp_path / "boxes.step", two_boxes, names=("long", "cube"))
    with pytest.raises(MeshError, match=r"has 2 parts, 'long', 'cube', which share no faces.* joined=True"):
        read_mesh(boxes, size=0.01)
    assert set(read_mesh(boxes, size=0.01, cells="cube").cells) == {"cube"}
    mesh = read_mesh(boxes, size=0.01, joined=True)
    assert {name: pytest.approx(volume) for name, volume in volumes_of(mesh).items()} == {"long": 6e-6, "cube": 1e-6}
    overlapping = write_step(tmp_path / "over.step", lambda occ: (two_boxes(occ), occ.addBox(0, 0, 25, 5, 5, 10)))
    with pytest.raises(MeshError, match=r"overlap by 125 mm\^3, and cannot be joined"):
        read_mesh(overlapping, size=0.01, joined=True)


def test_faces_of_a_colour_are_a_group(tmp_path):
    red = {("ADVANCED_FACE", 0): (0.8, 0.0, 0.2), ("MANIFOLD_SOLID_BREP", 0): (0.2, 0.6, 1.0)}
    path = write_step(tmp_path / "boxes.step", two_boxes, names=("long", "cube"), colours=red)
    mesh = read_mesh(path, size=0.02, cells="long")
    assert "#cc0033" in mesh.facets
    assert "#3399ff" in mesh.facets  # the other faces of the solid


def test_names_of_faces_are_groups_where_their_library_is_installed(tmp_path):
    """On one side of a door that most machines do not have, and on the other."""
    path = write_step(tmp_path / "plate.step", plate, faces=("root", "", "top"))
    if find_spec("OCP") is None:
        with pytest.warns(MeshWarning, match=r"names faces \('root', 'top'\), which only OCP reads. .*kanefe\[cad\]"):
            assert not read_mesh(path, size=0.02).facets
        return
    mesh = read_mesh(path, size={"*": 0.02, "top": 0.004})
    assert set(mesh.facets) == {"root", "top"}
    assert mesh.nodes[np.unique(mesh.facets["root"][0].nodes), 0] == pytest.approx(0.0, abs=1e-12)
    assert len(mesh.facets["top"][0].nodes) > 100  # its size is taken


def test_names_of_faces_follow_the_parts_of_an_assembly(tmp_path):
    pytest.importorskip("OCP", reason="kanefe[cad]")
    path = write_step(tmp_path / "boxes.step", two_boxes, names=("long", "cube"), faces=("left", "right"))
    mesh = read_mesh(path, size=0.01, cells="long")
    assert {name: float(np.ptp(mesh.nodes[blocks[0].nodes][..., 0])) for name, blocks in mesh.facets.items()} == {
        "left": pytest.approx(0.0, abs=1e-12),
        "right": pytest.approx(0.0, abs=1e-12),
    }


def test_surfaces_beside_solids_are_told_and_left_out(tmp_path):
    path = write_step(tmp_path / "stray.step", lambda occ: (two_boxes(occ), occ.addRectangle(50, 0, 0, 10, 10)))
    with pytest.warns(MeshWarning, match=r"has 1 surfaces beside its 2 solids, which are left out"):
        mesh = read_mesh(path, size=0.01, joined=True)
    assert mesh.nodes[:, 0].max() == pytest.approx(0.02)


def test_a_file_without_a_unit_says_so(step):
    path = step.with_name("unitless.step")
    path.write_text(re.sub(r"GLOBAL_UNIT_ASSIGNED_CONTEXT\s*\(\s*\(.*?\)\s*\)", "", step.read_text(), flags=re.DOTALL))
    with pytest.warns(UnitWarning, match=r"names no unit of length and is read in mm. Remedy: unit='mm' if"):
        mesh = read_mesh(path, size=0.02)
    assert np.ptp(mesh.nodes[:, 0]) == pytest.approx(0.1, rel=1e-9)


@pytest.mark.parametrize("content", ["", "solid a", "half"])
def test_files_that_are_no_step_are_refused(step, tmp_path, content):
    path = tmp_path / "part.step"
    path.write_text(step.read_text()[:9000] if content == "half" else content)
    with pytest.raises(FileError, match=r"cannot read part\.step.*Remedy: export it again"):
        read_mesh(path, size=0.02)


def test_gaps_between_faces_are_closed_and_told(tmp_path):
    path = write_step(tmp_path / "loose.step", lambda occ: loose_faces(occ, gap=1e-6))
    with pytest.warns(MeshWarning, match=r"not joined: gaps of up to .* 1 solids of 6e-06 m\^3"):
        mesh = read_mesh(path, size=0.01)
    assert sum(volumes_of(mesh).values()) == pytest.approx(6e-6, rel=1e-6)


def test_what_is_no_solid_is_refused_with_its_open_edges(tmp_path):
    path = write_step(tmp_path / "open.step", lambda occ: loose_faces(occ, missing=1))
    with pytest.raises(MeshError, match=r"5 faces and no solid.*4 edges bound one face only, the first at \("):
        read_mesh(path, size=0.01)
    path = write_step(tmp_path / "curve.step", lambda occ: occ.addLine(occ.addPoint(0, 0, 0), occ.addPoint(1, 0, 0)))
    with pytest.raises(MeshError, match="only curves and points"):
        read_mesh(path, size=0.01)
    path = tmp_path / "nothing.step"
    path.write_text("ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n")
    with pytest.raises((MeshError, FileError), match=r"nothing\.step"):
        read_mesh(path, size=0.01)


def test_a_part_of_a_strange_size_asks_for_its_unit(tmp_path):
    path = write_step(tmp_path / "plate.step", lambda occ: occ.addBox(0, 0, 0, 200, 1, 1), unit="m")
    with pytest.raises(ModelError, match=r"200 m large, if its numbers are m.*unit='m' if it is really so"):
        read_mesh(path, size=1.0)
    assert read_mesh(path, size=100.0, unit="m").cell_count
    path = write_step(tmp_path / "crumb.step", lambda occ: occ.addBox(0, 0, 0, 0.05, 0.01, 0.01))
    with pytest.raises(ModelError, match=r"5e-05 m large"):
        read_mesh(path, size=1e-6)


def test_a_mesh_for_which_memory_is_short_is_refused_before_it_is_made(step):
    with pytest.raises(MeshError, match=r"about .* nodes .* are free. Remedy: a larger size, such as"):
        read_mesh(step, size=1e-6)
    with pytest.raises(ModelError, match=r"needs a size of the cells. Remedy: size= .* such as size=0.00\d \(about"):
        read_mesh(step)


@pytest.mark.parametrize("order", [1, 2])
def test_the_estimate_is_near_the_mesh(step, order):
    mesh = read_mesh(step, order=order, size=0.004)
    told = float(mesh.provenance["estimate"].split()[1].replace(",", ""))
    assert told == pytest.approx(len(mesh.nodes), rel=0.3)  # an estimate


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"faces": {"far": kf.Near((1, 0, 0), 0.01)}}, "no whole face lies in .* The nearest face has its middle at"),
        ({"faces": {"a": lambda x: x[:, 0] < 1e-6, "b": lambda x: x[:, 0] < 2e-6}}, "in two groups, 'a' and 'b'"),
        ({"faces": {"": kf.OnPlane((0, 0, 0), (1, 0, 0))}}, "a group of faces has no name"),
        ({"faces": {"plate": lambda x: x[:, 0] < 1e-6}}, "'plate' is a part and cannot be a group of faces"),
        ({"size": {"plaat": 0.01, "*": 0.02}}, "names 'plaat'.*Did you mean 'plate'"),
        ({"size": {}}, "has none for 'plate'"),
        ({"size": -1.0}, "a length in m, > 0"),
        ({"per_turn": 2}, "at least 3"),
        ({"unit": "mil"}, "unit='mil' is not known"),
        ({"most_seconds": 0.0}, "must be > 0"),
        ({"cells": "bolt"}, "no part called 'bolt'"),
        ({"turns": 3}, "takes no turns="),
    ],
)
def test_bad_input_is_named(step, keywords, message):
    renamed = write_step(step.with_name("named.step"), plate)
    text = renamed.read_text()
    product = text.split("PRODUCT('")[1].split("'")[0]
    renamed.write_text(text.replace(product, "plate"))
    with pytest.raises(ModelError, match=message):
        read_mesh(renamed, **{"size": 0.02} | keywords)


def test_keywords_of_geometry_are_refused_for_meshes(geo):
    with pytest.raises(MeshError, match="no STEP or BREP file, so size= has no meaning"):
        read_mesh(geo(), size=0.1)


def test_straight_cells_that_lose_volume_are_told(tmp_path):
    path = write_step(tmp_path / "rod.step", lambda occ: occ.addCylinder(0, 0, 0, 50, 0, 0, 5))
    with pytest.warns(MeshWarning, match=r"% of volume, and so of mass"):
        read_mesh(path, size=0.01)


BUSY = """
import contextlib, os, signal, time
@contextlib.contextmanager
def opened():
    yield None
def read(state, path, scale, unit, joined, told):
    told("meshing faces")
    {0}
    time.sleep(600)
"""
"""A mesher that takes long."""


@pytest.fixture
def busy(tmp_path, monkeypatch):
    """Let the work be done by a module that is given what to do first."""

    def work(first: str) -> None:
        (tmp_path / "busy_worker.py").write_text(BUSY.format(first))
        monkeypatch.syspath_prepend(str(tmp_path))
        monkeypatch.setattr(geometry, "WORKER", "busy_worker")

    return work


def test_the_mesher_stops_when_its_time_is_over(step, busy):
    busy("pass")
    with pytest.raises(MeshError, match=r"stopped after most_seconds=3 while it was at: (meshing faces|start)"):
        read_mesh(step, size=0.001, most_seconds=3.0)


def test_ctrl_c_stops_the_mesher(step, busy, monkeypatch):
    """The signal comes from the process of the mesher, while it works: nothing of that stays."""
    children = []
    start = subprocess.Popen

    def noted(*args, **kwargs):
        children.append(start(*args, **kwargs))
        return children[-1]

    monkeypatch.setattr("kanefe_fem.machine.own_process.subprocess.Popen", noted)
    busy("os.kill(os.getppid(), signal.SIGINT)")
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # gmsh 4.8 takes it away where a test imports it
    try:
        with pytest.raises(KeyboardInterrupt):
            read_mesh(step, size=0.01)
    finally:
        signal.signal(signal.SIGINT, before)
    assert children[0].poll() is not None


def test_a_mesher_that_ends_the_program_is_followed_by_the_slower_one(step, tmp_path, monkeypatch):
    monkeypatch.setattr(geometry, "WORKER", "ending_worker")
    (tmp_path / "ending_worker.py").write_text(
        "import os\n"
        "from kanefe_fem.cad.worker import mesh as whole, opened, read\n"
        "def mesh(state, job, told):\n"
        "    if job.method == 10:  # HXT\n"
        "        os._exit(1)\n"
        "    return whole(state, job, told)\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    assert read_mesh(step, size=0.02).cell_count > 0


def test_a_mesher_that_gives_up_in_silence_is_followed_by_the_slower_one(step, tmp_path, monkeypatch):
    monkeypatch.setattr(geometry, "WORKER", "silent_worker")
    (tmp_path / "silent_worker.py").write_text(
        "from kanefe_fem.cad.worker import mesh as whole, opened, read\n"
        "def mesh(state, job, told):\n"
        "    generate = state.gmsh.model.mesh.generate\n"
        "    silent = lambda dimension: None if dimension == 3 and job.method == 10 else generate(dimension)\n"
        "    state.gmsh.model.mesh.generate = staticmethod(silent)\n"
        "    return whole(state, job, told)\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    mesh = read_mesh(step, size=0.02)
    assert mesh.dimension == 3
    assert sum(volumes_of(mesh).values()) == pytest.approx(VOLUME * 1e-9, rel=0.05)  # a hole of straight sides


def test_a_process_that_crashes_is_an_error(step, monkeypatch):
    monkeypatch.setattr(geometry, "WORKER", "crashing_worker")
    (step.parent / "crashing_worker.py").write_text(
        "import contextlib, os\n"
        "@contextlib.contextmanager\n"
        "def opened():\n"
        "    yield None\n"
        "def read(*args):\n"
        "    os.write(2, b'out of memory')\n"
        "    os.abort()\n"
    )
    monkeypatch.syspath_prepend(str(step.parent))
    with pytest.raises(FileError, match=r"ended with code -6 at: start \(.*out of memory"):
        read_mesh(step, size=0.01)
    assert sys.path[0] == str(step.parent)
