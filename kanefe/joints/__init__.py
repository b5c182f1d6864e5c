"""Joints, one kinematic pair a file."""

from kanefe.joints.base import Joint
from kanefe.joints.coordinate_force import CoordinateForce
from kanefe.joints.cylindrical import Cylindrical
from kanefe.joints.fixed import Fixed
from kanefe.joints.free import Free
from kanefe.joints.held import Held
from kanefe.joints.joint_friction import JointFriction
from kanefe.joints.link import Link
from kanefe.joints.link import LinkKernel as LinkKernel
from kanefe.joints.motion import Motion
from kanefe.joints.planar import Planar
from kanefe.joints.point_on_curve import PointOnCurve
from kanefe.joints.pose_motion import PoseMotion
from kanefe.joints.pose_table import PoseTable
from kanefe.joints.prismatic import Prismatic
from kanefe.joints.revolute import Revolute
from kanefe.joints.screw import Screw
from kanefe.joints.spherical import Spherical
from kanefe.joints.translation import Translation
from kanefe.joints.universal import Universal

__all__ = [
    "CoordinateForce",
    "Cylindrical",
    "Fixed",
    "Free",
    "Held",
    "Joint",
    "JointFriction",
    "Link",
    "LinkKernel",
    "Motion",
    "Planar",
    "PointOnCurve",
    "PoseMotion",
    "PoseTable",
    "Prismatic",
    "Revolute",
    "Screw",
    "Spherical",
    "Translation",
    "Universal",
]
