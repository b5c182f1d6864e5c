"""Loads, one concept a file."""

from kanefe.loads.bushing import Bushing
from kanefe.loads.field_load import FieldLoad
from kanefe.loads.joint_load import JointLoad
from kanefe.loads.point_load import PointLoad
from kanefe.loads.spring import SpringDamper

__all__ = ["Bushing", "FieldLoad", "JointLoad", "PointLoad", "SpringDamper"]
