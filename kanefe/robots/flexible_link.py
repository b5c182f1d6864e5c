"""A flexible body in place of a link: its mesh frame, and the interfaces that carry other links."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.errors import ModelError, outside
from kanefe.frames import Orientation
from kanefe.robots.description import RobotLink
from kanefe.robots.pose import Pose
from kanefe.scene.scene import orientation_matrix, three

NEAR = 0.05
"""Largest distance of an interface from the joint that it carries, relative to the size of the body. It
allows for the width of bearings; the other end of a link is further away."""

ODD_MASS = 2.0
"""Ratio of the masses of body and link above which one is probably wrong: other units, or another link."""


class LinkMassWarning(UserWarning):
    """A body from a mesh that is much heavier or lighter than the link that it replaces."""


@checked("body", "at", "interfaces")
@dataclass(frozen=True)
class FlexibleLink:
    """A flexible body that replaces a link of a robot.

    Parameters
    ----------
    body : FlexibleBody
        From a mesh or from matrices, with an interface fixed in G at the link's own joint, and one at each joint to a
        further link.
    at : array_like, shape (3,)
        Origin of the mesh frame G in the frame of the link, m. Default: G is the frame of the link, as usual for
        meshes of robots.
    orientation : array_like, shape (4,) or (3, 3), or Rotation of scipy
        Orientation of G relative to the link: Euler parameters (`rotation_about`, `euler_angles`) or a matrix.
    interfaces : dict of str to str, optional
        Name of a further link -> the interface that carries it. Default: the interface closest to its joint, within a
        twentieth of the body's size.

    Examples
    --------
    ``kf.read_urdf("robot.urdf", flexible={"forearm": kf.FlexibleLink(body, interfaces={"wrist": "flange"})})``
    """

    body: FlexibleBody
    at: Sequence[float] = (0.0, 0.0, 0.0)
    orientation: Orientation = (1.0, 0.0, 0.0, 0.0)
    interfaces: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse an invalid pose."""
        _ = self.pose

    @property
    def pose(self) -> Pose:
        """Pose of G relative to the frame of the link."""
        return Pose(three(self.at, "at of a flexible link"), orientation_matrix(self.orientation, "its orientation"))

    def carrier(self, link: str, child: str, joint: Pose) -> tuple[InterfaceFrame, Pose]:
        """Return the interface that carries a further link, and the pose of the joint relative to it.

        Parameters
        ----------
        link, child : str
            For messages, and to find the interface.
        joint : Pose
            Pose of the joint's fixed frame relative to the frame of the link.

        Raises
        ------
        ModelError
            If no interface is near the joint, or the named one does not exist.
        """
        in_body = self.pose.inverse @ joint
        if child in self.interfaces:
            frame = self.body.interface(self.interfaces[child])
        else:
            frame = self._nearest(in_body, f"flexible link {link!r} carries {child!r}", child)
        return frame, Pose(frame.position, frame.axes).inverse @ in_body

    def check(self, link: RobotLink, children: Sequence[str]) -> None:
        """Raise a ModelError if the body does not fit the link, and warn if the masses differ much."""
        if unknown := sorted(set(self.interfaces) - set(children)):
            raise ModelError(
                f"interfaces of flexible link {link.name!r} name {unknown[0]!r}, which it does not carry. It carries "
                f"{', '.join(children) or 'nothing'}"
            )
        held = [frame for frame in self.body.interfaces if frame.is_held]
        if held and link.moves and min(self._distance(frame, self.pose.inverse) for frame in held) > self._reach:
            where = "; ".join(f"{frame.name} at {_text(frame.position)}" for frame in held)
            raise ModelError(
                f"flexible link {link.name!r}: its joint is at {_text(self.pose.inverse.at)} m of the mesh frame, and "
                f"no interface fixed there is near ({where}). Remedy: FlexibleLink(body, at=..., orientation=...) with "
                "the pose of the mesh frame in the link"
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
