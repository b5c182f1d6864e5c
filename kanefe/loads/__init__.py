"""Loads, one concept a file."""

from kanefe.loads.point_load import PointLoad
from kanefe.loads.joint_load import JointLoad

__all__ = ["JointLoad", "PointLoad"]
