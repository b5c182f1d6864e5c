"""What a study of short runs varies: in a module of its own, since each of its processes imports that."""

from __future__ import annotations

import kanefe as kf


def chain(angle: float) -> kf.System:
    """Return five rods that swing from an angle in rad."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    body = scene.ground
    for i in range(5):
        at, joint = (1.0 if i else 0.0, 0.0, 0.0), kf.Revolute("z", position=angle)
        body = scene.add_rigid_body(f"rod {i}", 1.0, 1.0 / 12.0, com=(0.5, 0, 0), parent=body, at=at, joint=joint)
    return scene


def lowest(result: kf.Result) -> dict[str, float]:
    """Return the least angle of the first rod, rad."""
    return {"lowest": float(result.joint_coordinates("rod 0").min())}
