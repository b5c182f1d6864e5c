"""Looks: triangles of STL and OBJ files that are drawn, weighed where they are closed, and touched by nothing."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import FileError, ModelError
from kanefe.results.surface_outline import outlines

CORNERS = np.array([(x, y, z) for z in (0, 2) for y in (0, 3) for x in (0, 1)], dtype=float)
BOX_OBJ = """# a box of 1 x 3 x 2
o box
{vertices}
vn 0 0 1
f 1 3 4 2
f 5//1 6//1 8//1 7//1
f 1/1/1 2/2/1 6/3/1 5/4/1
f 3 7 8 4
f 1 5 7 3
f -7 -5 -1 -3
""".format(vertices="\n".join(f"v {x} {y} {z}" for x, y, z in CORNERS))


@pytest.fixture
def box(tmp_path):
    path = tmp_path / "box.obj"
    path.write_text(BOX_OBJ)
    return path


def test_a_box_of_an_obj_file_is_weighed(box):
    weighed = kf.shapes.Look.from_file(box, scale=0.1).weighed(density=1000.0)
    assert weighed.mass == pytest.approx(6.0, rel=1e-12)
    assert weighed.com == pytest.approx([0.05, 0.15, 0.1], rel=1e-12)
    assert weighed.inertia == pytest.approx(np.diag([13.0, 5.0, 10.0]) * 6e-2 / 12.0, abs=1e-15)


def test_a_body_has_the_shape_of_its_file(box):
    scene = kf.System()
    scene.add_rigid_body("crate", 1.0, 0.1, joint=kf.Prismatic("x"), look=str(box))
    (surface,) = outlines(scene.freeze())
    assert (surface.name, surface.body) == ("crate", "crate")
    assert len(surface.triangles) == 12


def test_a_look_without_opposite_sides_has_no_mass(box):
    whole = kf.shapes.Look.from_file(box)
    tube = kf.shapes.Look(whole.vertices, whole.triangles[4:])  # areas of opposite holes cancel
    with pytest.raises(ModelError, match="not closed has no mass"):
        tube.weighed(1000.0)


def test_faces_with_vertices_of_their_own_are_closed(box):
    whole = kf.shapes.Look.from_file(box)
    apart = kf.shapes.Look(whole.vertices[whole.triangles].reshape(-1, 3), np.arange(36).reshape(12, 3))
    assert apart.weighed(1.0).mass == pytest.approx(whole.weighed(1.0).mass, rel=1e-12)


def test_nothing_touches_a_look(box):
    scene = kf.System()
    look = kf.shapes.Look.from_file(box)
    crate = scene.add_rigid_body("crate", 1.0, 0.1, joint=kf.Free(), look=look)
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    drawn = scene.add_surface("drawn", crate, look)
    for one, other in ((drawn, floor), (crate, drawn)):
        with pytest.raises(ModelError, match="'drawn' is a look, which nothing touches"):
            scene.add_contact("rest", one, other, normal=kf.HuntCrossley(1e5))
    with pytest.raises(ModelError, match="a look is drawn"):
        look.distance((0.0, 0.0, 0.0))


def test_what_is_no_look_is_named(tmp_path, box):
    text = box.read_text()
    box.write_text(text.replace("f 3 7 8 4", "f 3 7 9 4"))
    with pytest.raises(FileError, match=r"line 15 is 'f 3 7 9 4'"):
        kf.shapes.Look.from_file(box)
    box.write_text(text.replace("f 3 7 8 4\n", ""))
    with pytest.raises(ModelError, match="not closed has no mass"):
        kf.shapes.Look.from_file(box).weighed(1.0)
    (tmp_path / "part.dae").write_text("")
    with pytest.raises(FileError, match="Remedy: STL or OBJ"):
        kf.shapes.Look.from_file(tmp_path / "part.dae")
    with pytest.raises(ModelError, match="look of 'crate' must be"):
        kf.System().add_rigid_body("crate", 1.0, look=3)
    with pytest.raises(ModelError, match="name vertices that are none"):
        kf.shapes.Look(CORNERS, [(0, 1, 8)])
