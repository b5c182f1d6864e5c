"""A flexible body in the place of a link: its mesh frame, and which of its interfaces carries what."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.errors import ModelError, outside
from kanefe.frames import Orientation
from kanefe.robots.description import Pose, RobotLink
from kanefe.scene.scene import orientation_matrix, three

NEAR = 0.05
"""Largest distance of an interface from the joint that it carries, relative to the size of the body. Bearings have a
width; the wrong end of a link is further away."""

ODD_MASS = 2.0
"""Ratio of the masses of body and link above which one is probably wrong: other units, or another link."""


class LinkMassWarning(UserWarning):
    """A body from a mesh that is much heavier or lighter than the link whose place it takes."""


@checked("body", "at", "interfaces")
@dataclass(frozen=True)
class FlexibleLink:
    """A flexible body that takes the place of a robot's link.

    Parameters
    ----------
    body : FlexibleBody
        From a mesh or from matrices, with an interface fixed in G where the link's own joint is, and one where each
        joint to a further link is.
    at : array_like, shape (3,)
        Origin of the mesh frame G in the frame of the link, m. Default: G is the frame of the link, as meshes of robots
        are drawn.
    orientation : array_like, shape (4,) or (3, 3), or Rotation of scipy
        Of G, seen from the link: Euler parameters (`rotation_about`, `euler_angles`) or a matrix.
    interfaces : dict of str to str, optional
        Name of a link further out -> the interface that carries it. Default: the nearest to its joint, which must be
        within a twentieth of the body's size.

    Examples
    --------
    ``kf.read_urdf("robot.urdf", flexible={"forearm": kf.FlexibleLink(body, interfaces={"wrist": "flange"})})``
    """

    body: FlexibleBody
    at: Sequence[float] = (0.0, 0.0, 0.0)
    orientation: Orientation = (1.0, 0.0, 0.0, 0.0)
    interfaces: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse a pose that is none."""
        _ = self.pose

    @property
    def pose(self) -> Pose:
        """Pose of G, seen from the frame of the link."""
        return Pose(three(self.at, "at of a flexible link"), orientation_matrix(self.orientation, "its orientation"))

    def carrier(self, link: str, child: str, joint: Pose) -> tuple[InterfaceFrame, Pose]:
        """Return the interface that carries a further link, and where the joint is seen from its axes.

        Parameters
        ----------
        link, child : str
            For messages, and to find the interface.
        joint : Pose
            Of the joint's fixed frame, seen from the frame of the link.

        Raises
        ------
        ModelError
            If no interface is near the joint, or that named does not exist.
        """
        in_body = self.pose.inverse @ joint
        if child in self.interfaces:
            frame = self.body.interface(self.interfaces[child])
        else:
            frame = self._nearest(in_body, f"flexible link {link!r} carries {child!r}", child)
        return frame, Pose(frame.position, frame.axes).inverse @ in_body

    def check(self, link: RobotLink, children: Sequence[str]) -> None:
        """Raise a ModelError if it does not fit the link, and warn if the masses differ much."""
        if unknown := sorted(set(self.interfaces) - set(children)):
            raise ModelError(
                f"interfaces of flexible link {link.name!r} name {unknown[0]!r}, which it does not carry. It carries "
                f"{', '.join(children) or 'nothing'}"
            )
        held = [frame for frame in self.body.interfaces if frame.fixed_components]
        if held and link.moves and min(self._distance(frame, self.pose.inverse) for frame in held) > self._reach:
            where = "; ".join(f"{frame.name} at {_text(frame.position)}" for frame in held)
            raise ModelError(
                f"flexible link {link.name!r}: its joint is at {_text(self.pose.inverse.at)} m of the mesh frame, and "
                f"no interface fixed there is near ({where}). Remedy: FlexibleLink(body, at=..., orientation=...) says "
                "where the mesh frame is in the link"
            )
        ratio = self.body.mass / link.mass if link.mass else 1.0
        if not 1 / ODD_MASS < ratio < ODD_MASS:
            warnings.warn(
                f"link {link.name!r} has {link.mass:.4g} kg in the file, the body in its place {self.body.mass:.4g} "
                "kg. Remedy: check its units, density and name",
                LinkMassWarning,
                stacklevel=outside(),
            )

    @property
    def _reach(self) -> float:
        return NEAR * float(np.linalg.norm(np.ptp(self.body.nodes, axis=0)))

    def _distance(self, frame: InterfaceFrame, place: Pose) -> float:
        return float(np.linalg.norm(frame.position - place.at))

    def _nearest(self, place: Pose, what: str, child: str) -> InterfaceFrame:
        frame = min(self.body.interfaces, key=lambda frame: self._distance(frame, place), default=None)
        if frame is None or self._distance(frame, place) > self._reach:
            known = "; ".join(f"{frame.name} at {_text(frame.position)}" for frame in self.body.interfaces) or "none"
            raise ModelError(
                f"{what} at {_text(place.at)} m of the mesh frame, and no interface is near (there are: {known}). "
                f"Remedy: an interface there, FlexibleLink(body, at=..., orientation=...) if the mesh is drawn "
                f"elsewhere, or interfaces={{{child!r}: name}} to take one that is further away"
            )
        return frame


def _text(point: np.ndarray) -> str:
    return f"({', '.join(f'{x:.4g}' for x in point)})"
