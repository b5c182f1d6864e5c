"""STEP and BREP files for tests, written by gmsh; names and colours, which it does not write, are put into the text."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from kanefe_fem import _gmsh
from kanefe_fem.mesh.step_unit import own_unit

MILLIMETRE = re.compile(r"\(\s*LENGTH_UNIT\(\)\s*NAMED_UNIT\(\*\)\s*SI_UNIT\(\.MILLI\.,\.METRE\.\)\s*\)")
INCH = (
    "#{0} = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#{2});\n"
    "#{1} = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n#{2} = {3};\n"
)
STYLE = """#{0}=COLOUR_RGB('',{2},{3},{4});
#{0}1=FILL_AREA_STYLE_COLOUR('',#{0});
#{0}2=FILL_AREA_STYLE('',(#{0}1));
#{0}3=SURFACE_STYLE_FILL_AREA(#{0}2);
#{0}4=SURFACE_SIDE_STYLE('',(#{0}3));
#{0}5=SURFACE_STYLE_USAGE(.BOTH.,#{0}4);
#{0}6=PRESENTATION_STYLE_ASSIGNMENT((#{0}5));
#{0}7=STYLED_ITEM('color',(#{0}6),#{1});
#{0}8=MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',(#{0}7),#{5});
"""


def write_step(
    path: Path,
    build: Callable[[Any], object],
    names: Sequence[str] = (),
    colours: Mapping[tuple[str, int], tuple[float, float, float]] | None = None,
    unit: str = "mm",
    faces: Sequence[str] = (),
) -> Path:
    """Write what `build` makes in ``gmsh.model.occ``, in units of the file.

    Parameters
    ----------
    names : sequence of str
        Of the solids, in their order.
    colours : dict of (str, int) to (float, float, float)
        By "MANIFOLD_SOLID_BREP" or "ADVANCED_FACE" and its number in the order of the file.
    unit : {"mm", "m", "inch"}
    faces : sequence of str
        Names of the first faces in the order of the file.
    """
    with _gmsh.session() as gmsh, own_unit(gmsh):
        build(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    if path.suffix == ".brep":
        return path
    text = path.read_text()
    products = re.findall(r"PRODUCT\('(Open CASCADE STEP translator [0-9.]+ [0-9.]+)'", text)
    for name, product in zip(names, products[-len(names) :] if names else (), strict=True):
        text = re.sub(rf"'{re.escape(product)}'(\s*,\s*)'{re.escape(product)}'", rf"'{name}'\1'{name}'", text)
    text = in_unit(text, unit)
    for face in faces:
        text = text.replace("ADVANCED_FACE(''", f"ADVANCED_FACE('{face}'", 1)
    for i, ((kind, number), colour) in enumerate((colours or {}).items()):
        item = re.findall(rf"#(\d+) = {kind}\(", text)[number]
        context = re.findall(r"#(\d+) = \( GEOMETRIC_REPRESENTATION_CONTEXT", text)[0]
        at = text.rindex("ENDSEC;")
        text = text[:at] + STYLE.format(900 + i, item, *colour, context) + text[at:]
    path.write_text(text)
    return path


def in_unit(text: str, unit: str) -> str:
    """Return a STEP file in mm with the same numbers in another unit."""
    old = MILLIMETRE.search(text)
    if unit == "mm" or old is None:
        return text
    if unit == "m":
        return MILLIMETRE.sub(lambda found: found.group(0).replace(".MILLI.", "$"), text)
    last = max(int(number) for number in re.findall(r"^#(\d+)", text, re.MULTILINE))
    inch = f"( CONVERSION_BASED_UNIT('INCH',#{last + 1}) LENGTH_UNIT() NAMED_UNIT(#{last + 2}) )"
    at = text.rindex("ENDSEC;")
    return MILLIMETRE.sub(inch, text[:at]) + INCH.format(last + 1, last + 2, last + 3, old.group(0)) + text[at:]


def plate(occ: Any) -> None:
    """Make a plate of 100 x 60 x 10 with a hole of 12 at (30, 30)."""
    occ.cut([(3, occ.addBox(0, 0, 0, 100, 60, 10))], [(3, occ.addCylinder(30, 30, -1, 0, 0, 12, 6))])


def two_boxes(occ: Any) -> None:
    """Make two boxes of 10 x 20 x 30 and 10 x 10 x 10 that touch."""
    occ.addBox(0, 0, 0, 10, 20, 30)
    occ.addBox(10, 5, 5, 10, 10, 10)


def loose_faces(occ: Any, gap: float = 0.0, missing: int = 0) -> None:
    """Make the faces of a box of 10 x 20 x 30 as six surfaces, each moved outwards by a gap, some missing."""
    box = occ.addBox(0, 0, 0, 10, 20, 30)
    occ.synchronize()
    faces = [(2, tag) for _, tag in occ.getEntities(2)]
    copies = occ.copy(faces)
    occ.remove([(3, box)], recursive=True)
    for entity in copies:
        centre = occ.getCenterOfMass(*entity)
        offset = [one - middle for one, middle in zip(centre, (5.0, 10.0, 15.0), strict=True)]
        length = sum(one * one for one in offset) ** 0.5
        occ.translate([entity], *(gap * one / length for one in offset))
    if missing:
        occ.remove(copies[:missing], recursive=True)


def hinge(occ: Any) -> None:
    """Make a fork with two lugs, an arm between them with play, and a pin of the same radius in both."""
    base = (3, occ.addBox(-10, -10, 0, 20, 20, 5))
    lugs = [(3, occ.addBox(-10, y, 5, 20, 5, 25)) for y in (-10, 5)]
    fork, _ = occ.fuse([base], lugs)
    occ.cut(fork, [(3, occ.addCylinder(0, -20, 22, 0, 40, 0, 4))])
    occ.cut([(3, occ.addBox(-6, -4.9, 16, 60, 9.8, 12))], [(3, occ.addCylinder(0, -20, 22, 0, 40, 0, 4))])
    occ.addCylinder(0, -12, 22, 0, 24, 0, 4)


def shaft_with_play(occ: Any) -> None:
    """Make a bearing, and a shaft with a flange that is thinner than its hole."""
    occ.cut([(3, occ.addBox(-20, -20, 0, 40, 40, 15))], [(3, occ.addCylinder(0, 0, -1, 0, 0, 20, 10))])
    occ.fuse([(3, occ.addCylinder(0, 0, -5, 0, 0, 40, 9.9))], [(3, occ.addCylinder(0, 0, 15, 0, 0, 4, 16))])


def slider(occ: Any) -> None:
    """Make a slot, and a box in it that its floor and both its sides touch."""
    occ.cut([(3, occ.addBox(-30, -15, 0, 60, 30, 20))], [(3, occ.addBox(-31, -6, 8, 62, 12, 13))])
    occ.addBox(-8, -6, 8, 16, 12, 20)


def decoys(occ: Any) -> None:
    """Make two plates with coaxial holes and no bolt, a shaft farther along their axis, and a rod beside them."""
    for z in (0, 10):
        occ.cut([(3, occ.addBox(-20, -20, z, 40, 40, 10))], [(3, occ.addCylinder(8, 8, z - 1, 0, 0, 12, 3))])
    occ.addCylinder(8, 8, 60, 0, 0, 20, 3)
    occ.addCylinder(-30, 0, 0, 0, 0, 20, 3)


def turned_hinge(occ: Any) -> None:
    """Make the hinge, turned by odd angles and far from the origin."""
    hinge(occ)
    everything = occ.getEntities(3)
    occ.rotate(everything, 0, 0, 0, 0.3, 0.5, 0.8, 0.7)
    occ.translate(everything, 1234.5, -987.6, 345.6)
