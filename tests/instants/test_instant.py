"""One time of a run or an equilibrium: what it tells is the run's at that time, and an impulse makes speeds jump."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.kane.energy import kinetic_energy
from kanefe.states.state import State
from loop_scenes import four_bar, spatial_loop
from scenes import lattice_body


def test_an_instant_tells_what_the_run_tells_of_that_time():
    result = spatial_loop(0).simulate((0.0, 0.02), output_step=0.01, rtol=1e-6)
    found = result.at(0.01)
    names = {"crank": "", "arm": "tip", "ball": ""}
    for quantity in ("position", "rotation", "velocity", "angular_velocity", "acceleration", "joint_reaction"):
        for name in names:
            np.testing.assert_allclose(found.read(quantity, name), result.read(quantity, name)[1], atol=1e-9)
    for quantity in ("deflection", "coupling_force"):
        told, expected = (reader.read(quantity, "arm", "tip") for reader in (found, result))
        np.testing.assert_allclose(told, expected[1], atol=1e-9)
    # one time alone and among others: sums are in another order
    np.testing.assert_allclose(found.nodal_positions("arm"), result.nodal_positions("arm", 1), rtol=0, atol=1e-15)
    assert found.energy.total == pytest.approx(result.energy.total[1], rel=1e-13)
    assert found.momentum.linear.shape == (3,)
    assert found.loop_force("knee").shape == (6,)
    with pytest.raises(kf.ModelError, match="frames= chooses times"):
        found.nodal_positions("arm", 0)


def test_a_time_between_outputs_is_refused():
    result = four_bar().simulate((0.0, 0.1), output_step=0.05)
    with pytest.raises(kf.ModelError, match=r"not an output time; the nearest is 0\.05 s"):
        result.at(0.06)
    with pytest.raises(kf.ModelError, match="finite"):
        result.at(np.nan)


@pytest.mark.parametrize("scene", [four_bar, lambda: spatial_loop(2)])
def test_an_impulse_does_the_work_of_its_mean_speed(scene):
    """T' - T = p . (v + v') / 2 for whatever is struck, also in loops that stay closed; drives do none at rest."""
    model = scene().freeze()
    body = "coupler" if "coupler" in str([b.name for b in model.bodies]) else "lever"
    start = kf.Instant(model, 0.0, np.concatenate((model.initial_coordinates, 0.0 * model.initial_speeds)))
    if model.driven_count:  # a drive at the top of its swing
        turned = max(np.linspace(0.0, 3.0, 301), key=lambda t: -abs(model.driven_speeds(t)[0][0]))
        start = kf.Instant(scene().freeze(turned), turned, start.state)
        q = start.model.initial_coordinates
        start = kf.Instant(start.model, turned, np.concatenate((q, 0.0 * start.u)))
    p, point = np.array((0.3, -0.2, 0.1)), np.array((0.4, 0.1, -0.2))
    after = start.struck(body, p, point=point)
    np.testing.assert_array_equal(after.q, start.q)
    speeds = [state.velocity(body, point=point) for state in (State(i.model, i.time, i.q, i.u) for i in (start, after))]
    before, now = (kinetic_energy(State(i.model, i.time, i.q, i.u)) for i in (start, after))
    # what is left of the drive's speed there is 1e-2 of its largest
    assert now - before == pytest.approx(p @ (speeds[0] + speeds[1]) / 2.0, rel=5e-2 if model.driven_count else 1e-12)
    assert now > before


def test_an_impulse_on_a_free_body_gives_its_momenta():
    scene = kf.System()
    body = lattice_body(2, {"tip": "rigid"}, reduction=kf.CraigBampton(modes=6))
    scene.add_flexible_body("body", body, joint=kf.Free())
    start = kf.Instant(scene.freeze(), 0.0, scene.freeze().initial_state)
    p, moment = np.array((1.0, 2.0, -0.5)), np.array((0.1, 0.0, 0.3))
    after = start.struck("body", p, interface="tip", moment=moment)
    linear, angular = after.momentum
    np.testing.assert_allclose(linear, p, atol=1e-12)
    np.testing.assert_allclose(angular, np.cross(start.position("body", "tip"), p) + moment, atol=1e-12)
    with pytest.raises(kf.ModelError, match="acts on one of its interfaces"):
        start.struck("body", p)
    with pytest.raises(kf.ModelError, match="impulse on 'body' must be three finite"):
        start.struck("body", (1.0, 2.0), interface="tip")
