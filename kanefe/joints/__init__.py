"""Joints, one kinematic pair a file."""

from kanefe.joints.base import Joint, Motion
from kanefe.joints.fixed import Fixed
from kanefe.joints.free import Free
from kanefe.joints.planar import Planar
from kanefe.joints.prismatic import Prismatic
from kanefe.joints.revolute import Revolute

__all__ = ["Fixed", "Free", "Joint", "Motion", "Planar", "Prismatic", "Revolute"]
