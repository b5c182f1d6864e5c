"""What rigid contacts do to their internal states, and the energy that friction takes and belts give."""

import numpy as np

from kanefe.kernels.constraints.loop_tables import head_of, unit_responses_in
from kanefe.kernels.contact.rigid_points import PointStates, RigidStates, given_points, is_closed, is_slipping
from kanefe.kernels.language import dot, kernel
from kanefe.kernels.scene import Rates, Scene, State, Work


@kernel
def put_contact_rates(scene: Scene, state: State, work: Work, rates: Rates) -> None:
    """Write the rates of the paths slid and of the work of friction, and add the power of that, taken and given."""
    points, z, multipliers = given_points(scene.loops.points), state.z, work.multipliers
    meetings = unit_responses_in(work.holding, scene.loops).met
    for p in range(len(points)):
        given, met, j = points[p], meetings[p], head_of(scene.loops, p)
        if not is_closed(given, z):
            continue
        x, y, slips = met.rates.y, met.rates.z, is_slipping(given, z)
        if slips:
            friction = multipliers[j] * met.tangential
        else:
            friction = multipliers[j + 1] * met.first + multipliers[j + 2] * met.second
        taken = dot(friction, x * met.first + y * met.second)
        rates.powers[0] -= taken
        rates.powers[1] += dot(friction, met.surface @ given.belt)
        if slips:
            contact = RigidStates(rates.dz, given.first_state)
            contact.slip += given.share * np.sqrt(x * x + y * y)
            contact.work -= taken
            PointStates(rates.dz, given.status).kept = PointStates(z, given.status).rate
