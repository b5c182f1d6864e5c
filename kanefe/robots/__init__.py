"""Robots from URDF and MJCF files as scenes, whose links may be replaced by bodies from meshes."""

from kanefe.robots.flexible_link import FlexibleLink as FlexibleLink
from kanefe.robots.mjcf import read_mjcf as read_mjcf
from kanefe.robots.scene import RobotScene as RobotScene
from kanefe.robots.urdf import read_urdf as read_urdf

__all__ = ["FlexibleLink", "RobotScene", "read_mjcf", "read_urdf"]
