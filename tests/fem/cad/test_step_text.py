"""What the text of a STEP file says, and names of parts from the paths of OpenCASCADE."""

from __future__ import annotations

import pytest

from kanefe_fem.cad.shapes import names_of
from kanefe_fem.cad.step_text import colours, name_of_unit, names_of_faces, units_of_shapes

TEXT = """ISO-10303-21;
DATA;
#1 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT({prefix},.METRE.) );
#2 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(2.54E+01),#3); /* an inch; of #3 */
#3 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );
#4 = ( CONVERSION_BASED_UNIT('IN;CH',#2) LENGTH_UNIT() NAMED_UNIT(#9) );
#5 = ( GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNIT_ASSIGNED_CONTEXT((#7,{unit})) REPRESENTATION_CONTEXT('','') );
#6 = ( GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNIT_ASSIGNED_CONTEXT((#3)) REPRESENTATION_CONTEXT('','') );
#7 = ( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) );
#8 = ADVANCED_BREP_SHAPE_REPRESENTATION('a part',(#20,
 #21),#5);
#10 = DRAUGHTING_MODEL('notes',(#22),#6);
#11 = COLOUR_RGB('',0.8,1.,0.E+00);
ENDSEC;
END-ISO-10303-21;
"""


@pytest.mark.parametrize(
    ("prefix", "unit", "name"),
    [("$", "#1", "m"), (".CENTI.", "#1", "cm"), (".MILLI.", "#1", "mm"), ("$", "#4", "in")],
)
def test_the_unit_is_that_of_shapes_and_not_of_notes(tmp_path, prefix, unit, name):
    path = tmp_path / "part.step"
    path.write_text(TEXT.format(prefix=prefix, unit=unit))
    assert [name_of_unit(length) for length in units_of_shapes(path)] == [name]
    assert colours(path) == [(204, 255, 0)]


def test_equal_parts_are_told_apart_by_instance_or_number():
    paths = [
        "Shapes/press/arm_1/arm",
        "Shapes/press/pin_1/pin & & 256",
        "Shapes/press/pin_2/pin & & 1",
        "Shapes/press/side_1/side/bolt_1/bolt",
        "Shapes/press/side_2/side/bolt_1/bolt",
        "Shapes/press/lid/=>[0:1:1:3]/SOLID",
        "",
        "Shapes/Open CASCADE STEP translator 7.6 1.2",
        "Shapes/press/8/Open CASCADE STEP translator 7.6 5.1",
        "Shapes/press/3/eye",
        "Shapes/press/4/eye",
    ]
    names = names_of(paths)
    parts = ["arm", "pin_1", "pin_2", "bolt 1", "bolt 2", "lid", "part 1", "part 2", "part 3", "eye 1", "eye 2"]
    assert [name for name, _ in names] == parts
    products = ["arm", "pin", "pin", "bolt", "bolt", "lid", "part", "part", "part", "eye", "eye"]
    assert [product for _, product in names] == products
    assert names_of(["Shapes/11752"]) == [("11752", "11752")]


def test_names_of_faces_are_decoded_and_those_that_say_nothing_left_out(tmp_path):
    path = tmp_path / "part.step"
    given = ("root", "", "NONE", "B\\X2\\00F600DF\\X0\\e''s", "\\X\\C4rm")
    path.write_text("".join(f"#{i} = ADVANCED_FACE ( '{name}',(#9),#8,.T.);\n" for i, name in enumerate(given)))
    assert names_of_faces(path) == ("root", "B\u00f6\u00dfe's", "\u00c4rm")
    path.write_text("#1=ADVANCED_FACE('SHAPE',(#9),#8,.T.);\n" * 3 + "#1=ADVANCED_FACE('',(#9),#8,.T.);")
    assert names_of_faces(path) == ()
