"""The unit to which OpenCASCADE converts geometry: it keeps the last one, whatever gmsh's option says afterwards.

``Geometry.OCCTargetUnit`` reaches OpenCASCADE with the next file that is imported or written, and only if it is not
empty. An empty one, the default, leaves the unit as it is, also in a later session of gmsh.
"""

from __future__ import annotations

import contextlib
import math
import tempfile
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

OPTION, SCALING = "Geometry.OCCTargetUnit", "Geometry.OCCScaling"

LENGTHS = {
    "MM": 1.0,
    "M": 1e3,
    "CM": 10.0,
    "KM": 1e6,
    "UM": 1e-3,
    "INCH": 25.4,
    "FT": 304.8,
    "MI": 1609344.0,
    "MIL": 0.0254,
    "UIN": 2.54e-5,
}
"""Units that OpenCASCADE knows, mm."""

POINT = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('','',(''),(''),'','','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));
ENDSEC;
DATA;
#1=APPLICATION_CONTEXT('');
#2=PRODUCT_CONTEXT('',#1,'');
#3=PRODUCT('','','',(#2));
#4=PRODUCT_DEFINITION_FORMATION('','',#3);
#5=PRODUCT_DEFINITION_CONTEXT('',#1,'');
#6=PRODUCT_DEFINITION('','',#4,#5);
#7=PRODUCT_DEFINITION_SHAPE('','',#6);
#8=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
#9=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
#10=(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());
#11=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#8,#9,#10))REPRESENTATION_CONTEXT('',''));
#12=CARTESIAN_POINT('',(1.,0.,0.));
#13=GEOMETRIC_CURVE_SET('',(#12));
#14=GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION('',(#13),#11);
#15=SHAPE_DEFINITION_REPRESENTATION(#7,#14);
ENDSEC;
END-ISO-10303-21;
"""
"""A STEP file with a point at x = 1 mm."""


@contextlib.contextmanager
def own_unit(gmsh: Any) -> Iterator[None]:
    """Let a source begin with gmsh's unit, mm, and leave that which was in force before, and the option, as they were.

    Without OpenCASCADE there is nothing to keep.
    """
    option = gmsh.option.getString(OPTION)
    at = _place_of_point(gmsh, "")
    unit = None if at is None else next((u for u, mm in LENGTHS.items() if math.isclose(at * mm, 1.0)), None)
    gmsh.option.setString(OPTION, "MM")
    try:
        yield
    finally:
        if unit is not None:
            _place_of_point(gmsh, unit)
        gmsh.option.setString(OPTION, option)


def _place_of_point(gmsh: Any, unit: str) -> float | None:
    """Return where `POINT` comes to lie if it is imported in a unit, which is in force then; None if it cannot be."""
    previous, scaling = gmsh.model.getCurrent(), gmsh.option.getNumber(SCALING)
    gmsh.option.setString(OPTION, unit)
    gmsh.option.setNumber(SCALING, 1.0)
    gmsh.model.add(f"kanefe-{uuid.uuid4().hex[:8]}")
    try:
        with tempfile.TemporaryDirectory(prefix="kanefe-") as folder:
            path = Path(folder) / "point.step"
            path.write_text(POINT, encoding="ascii")
            ((dimension, tag),) = gmsh.model.occ.importShapes(str(path), highestDimOnly=False)
        gmsh.model.occ.synchronize()
        return float(gmsh.model.getValue(dimension, tag, [])[0])
    except Exception:  # noqa: BLE001 - gmsh raises bare Exception, without OpenCASCADE of any import
        return None
    finally:
        gmsh.model.remove()
        gmsh.option.setNumber(SCALING, scaling)
        gmsh.model.setCurrent(previous)
