"""The car on four loops by the peer: bodies, hinges and rods in redundant coordinates."""

from __future__ import annotations

from typing import Any

import exudyn
import exudyn.itemInterface as items
import numpy as np
from exudyn.utilities import RigidBodyInertia

Answer = dict[str, Any]


class _Car:
    """A car as it is built up: each body with its centre of mass and its place."""

    def __init__(self, gravity: list[float]) -> None:
        self.mbs = exudyn.SystemContainer().AddSystem()
        self._gravity = gravity

    def body(self, of: Answer, place: np.ndarray, spin: list[float]) -> int:
        """Add a body whose frame is at a place, and return its number."""
        inertia = np.diag(np.broadcast_to(of["inertia"], 3))
        return int(
            self.mbs.CreateRigidBody(
                inertia=RigidBodyInertia(mass=of["mass"], inertiaTensor=inertia),
                referencePosition=list(place + np.array(of["com"])),
                initialAngularVelocity=spin,
                gravity=self._gravity,
                nodeType=exudyn.NodeType.RotationRotationVector,
            )
        )

    def hinge(self, one: int, other: int, place: np.ndarray, axis: list[float]) -> None:
        """Add a hinge."""
        self.mbs.CreateRevoluteJoint(itemNumbers=[one, other], position=list(place), axis=axis, useGlobalFrame=True)

    def joint(self, one: int, other: int, place: np.ndarray, fixed: list[int]) -> None:
        """Add a joint with some components fixed: three translations, three rotations."""
        self.mbs.CreateGenericJoint(
            itemNumbers=[one, other], position=list(place), constrainedAxes=fixed, useGlobalFrame=True
        )


def built_car(car: Answer) -> tuple[Any, int]:
    """Return the system of a car, ready to run, and the number of its last upright."""
    built, origin = _Car(car["gravity"]), np.array(car["position"])
    chassis = built.body(car["chassis"], origin, [0, 0, 0])
    for x, y in car["corners"]:
        side = np.sign(y)

        def placed(name: str, at: np.ndarray, spin: list[float], side: float = side) -> int:
            of = car[name]
            return built.body(of | {"com": np.array(of["com"]) * (1.0, side, 1.0)}, at, spin)

        low = origin + np.array((x, 0.5 * y, -0.1))
        knee, top = low + np.array((0, 0.3 * side, 0)), origin + np.array((x, 0.5 * y, 0.1))
        lower, upper = placed("lower arm", low, [0, 0, 0]), placed("upper arm", top, [0, 0, 0])
        upright = placed("upright", knee, [0, 0, 0])
        axle = knee + np.array((0, 0.05 * side, 0.1))
        wheel = placed("wheel", axle, [0, car["spin"], 0])
        built.hinge(chassis, lower, low, [1, 0, 0])
        built.mbs.CreateTorsionalSpringDamper(
            itemNumbers=[chassis, lower],
            position=list(low),
            axis=[1, 0, 0],
            stiffness=car["spring"]["stiffness"],
            damping=car["spring"]["damping"],
            offset=car["spring"]["rest"],
            useGlobalFrame=True,
        )
        built.joint(lower, upright, knee, [1, 1, 1, 0, 1, 0])
        built.hinge(chassis, upper, top, [1, 0, 0])
        built.hinge(upright, wheel, axle, [0, 1, 0])
        # its third row depends on the others, which the peer does not take
        built.joint(upper, upright, top + np.array((0, 0.3 * side, 0)), [0, 1, 1, 0, 0, 0])
        ends = ((chassis, np.array((x - 0.15, 0.5 * y, 0.0)) - car["chassis"]["com"]),)
        ends += ((upright, np.array((-0.15, 0.0, 0.1)) - car["upright"]["com"]),)
        markers = [
            built.mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=list(at))) for body, at in ends
        ]
        built.mbs.AddObject(items.ObjectConnectorDistance(markerNumbers=markers, distance=car["rod"]))
    built.mbs.Assemble()
    return built.mbs, upright
