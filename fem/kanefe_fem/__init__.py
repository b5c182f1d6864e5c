"""kanefe_fem: flexible bodies for kanefe from meshes (gmsh, dolfinx, PETSc) and from beam elements (numpy, scipy).

Importing the package loads nothing heavy: each public name is imported when it is first used, and dolfinx, PETSc and
gmsh only when a function needs them.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from kanefe_fem.beam_mesh import beam_model_from_mesh as beam_model_from_mesh
    from kanefe_fem.beams import beam_body as beam_body
    from kanefe_fem.beams import beam_model as beam_model
    from kanefe_fem.beams import straight_beam as straight_beam
    from kanefe_fem.material import Material as Material
    from kanefe_fem.mesh import Mesh as Mesh
    from kanefe_fem.mesh import read_mesh as read_mesh
    from kanefe_fem.sections import Box as Box
    from kanefe_fem.sections import Rectangle as Rectangle
    from kanefe_fem.sections import Section as Section
    from kanefe_fem.sections import SolidCircle as SolidCircle
    from kanefe_fem.sections import Tube as Tube
    from kanefe_fem.solid import solid_body as solid_body
    from kanefe_fem.solid import solid_model as solid_model

_HOMES = {
    "Box": "sections",
    "Material": "material",
    "Mesh": "mesh",
    "Rectangle": "sections",
    "Section": "sections",
    "SolidCircle": "sections",
    "Tube": "sections",
    "beam_body": "beams",
    "beam_model": "beams",
    "beam_model_from_mesh": "beam_mesh",
    "read_mesh": "mesh",
    "solid_body": "solid",
    "solid_model": "solid",
    "straight_beam": "beams",
}

__all__ = [*_HOMES]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'kanefe_fem' has no attribute {name!r}")
    value = getattr(import_module(f"kanefe_fem.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
