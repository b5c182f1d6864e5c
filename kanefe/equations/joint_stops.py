"""Stops of joints with a coefficient of restitution, as loads of a frozen scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kanefe.bodies.marker import CoordinateMarker
from kanefe.errors import ModelError
from kanefe.joints.coordinate_force import limits_of
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.loads.coordinate_stop import CoordinateStop


def joint_stops(model: ModelData) -> tuple[CoordinateStop, ...]:
    """Return a load for each joint coordinate whose limits have a restitution, called "stop of <body>".

    If the joint has several coordinates, the name of the coordinate follows that of the body.

    Raises
    ------
    ModelError
        If another load has the name.
    """
    found, taken = [], {load.name for load in model.loads}
    for number, body in enumerate(model.bodies):
        names = body.joint.coordinate_names
        for i, law in enumerate(body.joint.coordinate_forces):
            if law is None or law.limit_restitution is None:
                continue
            # imported here because most scenes have none
            from kanefe.kernels.contact.laws.power_laws import LEAST_SPEED, impact_number
            from kanefe.loads.coordinate_stop import CoordinateStop

            coordinate = names[i].partition(" [")[0]
            subject = body.name if len(names) == 1 else f"{body.name} {coordinate}"
            lower, upper = limits_of(law)
            stop = CoordinateStop(
                f"stop of {subject}",
                (CoordinateMarker.of(number, i, f"the {coordinate} of {body.name!r}"),),
                coordinate=subject,
                unit=body.joint.units[i],
                lower=lower,
                upper=upper,
                stiffness=law.limit_stiffness,
                impact=impact_number(law.limit_restitution),
                least_speed=LEAST_SPEED,
            )
            if stop.name in taken:
                raise ModelError(f"a load is called {stop.name!r}, like the stop of that joint. Remedy: another name")
            found.append(stop)
    return tuple(found)
