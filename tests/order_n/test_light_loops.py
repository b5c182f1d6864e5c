"""Light elastic bodies in loops are not near a singular position because their high modes could move them far."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.integrate.dynamics import Dynamics
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.order_n.route import OrderN
from kanefe_fem import Material, Rectangle, exact_beam

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
LENGTH = 0.5  # m
BENT = 6  # the first function of the bending about y, behind six of the twist


def strip_to(end: str, pin: float = LENGTH) -> kf.System:
    """Return a thin strip on the ground or a hub, whose other end is pinned to the ground or to a slider."""
    damping = kf.RayleighDamping(stiffness=1e-4)
    strip = exact_beam(LENGTH, Rectangle(0.02, 5e-4), STEEL, damping=damping, basis=6)
    scene = kf.System(gravity=(0, 0, -9.81))
    start = np.zeros(strip.free_count)
    held = scene.ground.frame(at=(pin, 0, 0))
    on = scene.ground
    if end == "slider":
        turned = kf.CoordinateForce(stiffness=20.0)
        on = scene.add_rigid_body("hub", 1.0, 0.01, joint=kf.Revolute("y", speed=2.0, forces=turned))
        joint = kf.Prismatic("x", forces=kf.CoordinateForce(stiffness=200.0, damping=2.0))
        held = scene.add_rigid_body("slider", 0.5, 1e-3, at=(pin, 0, 0), joint=joint)
    elif pin < LENGTH:
        start[BENT] = 3.0  # 1/m
    beam = scene.add_flexible_body("strip", strip, parent=on, modal_coordinates=start)
    scene.add_loop_joint("pin", kf.Revolute("y"), beam.interface("tip"), held)
    return scene


@pytest.mark.parametrize(("end", "pin"), [("slider", LENGTH), ("ground", 0.45), ("ground", 0.3)])
def test_a_strip_in_a_loop_is_evaluated_where_it_is(end: str, pin: float) -> None:
    """The weakest row has some tenths of its reach, and Jacobians are as few as far from singular positions."""
    scene = strip_to(end, pin)
    model = scene.freeze()
    assert isinstance(model.route, OrderN)
    assert model.route.held_rates(0.0, Dynamics(model).initial_state(0.0))[1] > 10 * NEAR_SINGULAR
    result = scene.simulate((0.0, 0.1), method="radau5", rtol=1e-4, output_step=0.1)
    assert result.statistics["jacobians"] < 15


def test_what_moves_a_row_by_round_off_does_not_hold_it() -> None:
    """Nothing moves the end of a straight strip along it: that row is left out, and it sags as on a guide."""
    model = strip_to("ground").freeze()
    assert isinstance(model.route, OrderN)
    y = Dynamics(model).initial_state(0.0)
    rates, _ = model.route.held_rates(0.0, y)
    literal = model.literal.evaluate(0.0, y).rates
    np.testing.assert_allclose(rates, literal, atol=1e-8 * np.abs(literal).max())
