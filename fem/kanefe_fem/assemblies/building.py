"""A scene from an assembly: bodies along a tree of joints, and joints that close loops. All frames start parallel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.contact.geometry.look import Look
from kanefe.errors import ModelError
from kanefe.joints.base import Joint
from kanefe.system import System
from kanefe_fem.assemblies.parts import Part
from kanefe_fem.assemblies.proposals import ProposedJoint
from kanefe_fem.cad.shapes import without_noise
from kanefe_fem.solids.body import solid_body

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody


class Builder:
    """A scene that grows along joints.

    Attributes
    ----------
    scene : System
    bodies : dict of str to body
        Those that are in the scene.
    origins : dict of str to ndarray, shape (3,)
        Where their frames are in the axes of the assembly, m.
    """

    def __init__(
        self,
        parts: Mapping[str, Part],
        scene: System,
        taken: Mapping[str, str | Joint | None],
        reduction: Any,
        damping: Any,
    ) -> None:
        self.parts, self.scene, self.taken = parts, scene, taken
        self.reduction, self.damping = reduction, damping
        self.bodies: dict[str, Any] = {}
        self.origins: dict[str, np.ndarray] = {}
        self.flexible: dict[str, FlexibleBody] = {}

    def follow(self, proposed: ProposedJoint, every: Sequence[ProposedJoint]) -> None:
        """Add the part at the other end of a joint, of which one part is in the scene."""
        parent, child = proposed.parts if proposed.parts[0] in self.bodies else proposed.parts[::-1]
        frame, at = self._place(parent, proposed)
        self.add(child, proposed, self._joint(proposed), every, parent=frame, at=at)

    def add(
        self, name: str, held_by: ProposedJoint | None, joint: Joint, every: Sequence[ProposedJoint], **where: Any
    ) -> None:
        """Add a part, whose frame is at its joint."""
        part = self.parts[name]
        origin = part.center if held_by is None else held_by.point
        self.origins[name] = origin
        where = {"at": tuple(origin.tolist())} | where
        if part.mesh is not None:
            self.bodies[name] = self._flexible(part, held_by, joint, every, where)
            return
        com = tuple(without_noise(part.center - origin, float(np.ptp(part.vertices, axis=0).max())).tolist())
        look = Look(part.vertices - origin, part.triangles)
        self.bodies[name] = self.scene.add_rigid_body(
            name, part.mass, part.inertia, joint=joint, com=com, look=look, **where
        )

    def _flexible(
        self, part: Part, held_by: ProposedJoint | None, joint: Joint, every: Sequence[ProposedJoint], where: Any
    ) -> Any:
        if held_by is None:
            raise ModelError(f"{part.name!r} is flexible and stands still. Remedy: ground= a rigid part")
        kinds = {one.name: "rigid" for one in every if part.name in one.parts} | {held_by.name: "clamped"}
        if part.mesh is None:
            raise ModelError(f"part {part.name!r} is rigid and has no mesh. Remedy: flexible=[{part.name!r}]")
        mesh = replace(part.mesh, nodes=np.asarray(part.mesh.nodes) - held_by.point)
        body = solid_body(mesh, part.material, kinds, self.reduction, self.damping)  # type: ignore[arg-type]
        self.flexible[part.name] = body
        return self.scene.add_flexible_body(part.name, body, joint=joint, **where)

    def _place(self, name: str, proposed: ProposedJoint) -> tuple[Any, tuple[float, ...]]:
        """Return the frame of a part that carries a joint, and where the joint is in it, m."""
        body, origin = self.bodies[name], self.origins[name]
        if self.parts[name].mesh is None:
            return body, tuple((proposed.point - origin).tolist())
        interface = body.interface(proposed.name)
        position = self.flexible[name].interface(proposed.name).position
        return interface, tuple((proposed.point - origin - position).tolist())

    def close(self, proposed: ProposedJoint) -> None:
        """Close a loop by a joint between two parts of the scene."""
        ends = []
        for name in proposed.parts:
            frame, at = self._place(name, proposed)
            ends.append(frame.frame(at=at))
        joint = self._joint(proposed)
        self.scene.add_loop_joint(proposed.name, joint, *ends)

    def _joint(self, proposed: ProposedJoint) -> Joint:
        kind = self.taken[proposed.name]
        return kind if isinstance(kind, Joint) else proposed.joint(kind)
