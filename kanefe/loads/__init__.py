"""Loads, one concept a file."""

from kanefe.loads.joint_load import JointLoad
from kanefe.loads.point_load import PointLoad

__all__ = ["JointLoad", "PointLoad"]
