"""Joints, one kinematic pair per file."""

from typing import TYPE_CHECKING

from kanefe._public import lazy

if TYPE_CHECKING:
    from kanefe.joints.base import Joint as Joint
    from kanefe.joints.coordinate_force import CoordinateForce as CoordinateForce
    from kanefe.joints.cylindrical import Cylindrical as Cylindrical
    from kanefe.joints.fixed import Fixed as Fixed
    from kanefe.joints.free import Free as Free
    from kanefe.joints.held import Held as Held
    from kanefe.joints.joint_friction import JointFriction as JointFriction
    from kanefe.joints.link import Link as Link
    from kanefe.joints.link import LinkKernel as LinkKernel
    from kanefe.joints.motion import Motion as Motion
    from kanefe.joints.planar import Planar as Planar
    from kanefe.joints.point_on_curve import PointOnCurve as PointOnCurve
    from kanefe.joints.pose_motion import PoseMotion as PoseMotion
    from kanefe.joints.pose_table import PoseTable as PoseTable
    from kanefe.joints.prismatic import Prismatic as Prismatic
    from kanefe.joints.revolute import Revolute as Revolute
    from kanefe.joints.screw import Screw as Screw
    from kanefe.joints.spherical import Spherical as Spherical
    from kanefe.joints.start import Guess as Guess
    from kanefe.joints.translation import Translation as Translation
    from kanefe.joints.universal import Universal as Universal

_names, __getattr__, __dir__ = lazy(__file__, globals())

__all__ = [
    "CoordinateForce",
    "Cylindrical",
    "Fixed",
    "Free",
    "Guess",
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
