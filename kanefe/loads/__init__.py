"""Loads, one concept a file."""

from kanefe.loads.base import Action, End, Load, LoadEvent, LoadKernel, Tangent
from kanefe.loads.bushing import Bushing
from kanefe.loads.field_load import FieldLoad
from kanefe.loads.joint_load import JointLoad
from kanefe.loads.point_load import PointLoad
from kanefe.loads.spring import SpringDamper

__all__ = [
    "Action",
    "Bushing",
    "End",
    "FieldLoad",
    "JointLoad",
    "Load",
    "LoadEvent",
    "LoadKernel",
    "PointLoad",
    "SpringDamper",
    "Tangent",
]
