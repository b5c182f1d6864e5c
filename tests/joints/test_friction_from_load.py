"""Friction in joints as large as the joints are loaded: what each kind feels, on both routes, against closed forms."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from decimal import Decimal
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kanefe as kf
from joint_scenes import assert_routes_agree, scene_of
from kanefe.equations.model import Model
from kanefe.integrate.auto.suited_method import candidates
from repository import surroundings

G = 9.81
RUBS = {"mu": 0.2, "static": 0.3, "stiffness": 400.0, "damping": 15.0, "load_time": 0.1}
JOINTS = {
    "revolute": lambda: kf.Revolute("y", position=0.2, speed=0.9, friction=kf.JointFriction(radius=0.02, **RUBS)),
    "collar": lambda: kf.Revolute(
        (1, 2, 3), speed=-0.9, friction=kf.JointFriction(radius=0.02, length=0.1, collar=0.05, preload=3.0, **RUBS)
    ),
    "prismatic": lambda: kf.Prismatic((1, 2, 0), position=0.2, speed=-0.7, friction=kf.JointFriction(**RUBS)),
    "rail": lambda: kf.Prismatic("x", speed=0.7, friction=kf.JointFriction(length=0.2, radius=0.03, **RUBS)),
    "cylindrical": lambda: kf.Cylindrical(
        "z", position=(0.1, 0.2), speed=(0.4, -8.0), friction=kf.JointFriction(radius=0.05, length=0.3, **RUBS)
    ),
    "screw": lambda: kf.Screw("x", lead=0.3, position=0.2, speed=0.9, friction=kf.JointFriction(radius=0.1, **RUBS)),
    "left-hand": lambda: kf.Screw("x", lead=-0.3, speed=-0.9, friction=kf.JointFriction(radius=0.1, **RUBS)),
    "spherical": lambda: kf.Spherical(
        orientation=(0.9, 0.1, 0.2, -0.3), angular_velocity=(1, -2, 0.5), friction=kf.JointFriction(radius=0.1, **RUBS)
    ),
    "driven": lambda: kf.Prismatic("x", motion=kf.Motion.steady(0.3), friction=kf.JointFriction(length=0.2, **RUBS)),
    "driven screw": lambda: kf.Screw(
        "z", lead=0.1, motion=kf.Motion.steady(0.3), friction=kf.JointFriction(radius=0.02, **RUBS)
    ),
}


def in_state(model: Model, stretch: float, load: float) -> Model:
    """Return a model in another state of its friction."""
    z = model.initial_states
    z.flags.writeable = True
    for number in model.bearings:
        friction, first = model.loads[number], model.load_states[number].start
        z[first : first + friction.count] = stretch * np.arange(1, friction.count + 1)
        z[first + friction.load_state : model.load_states[number].stop] = load, -0.3 * load
    z.flags.writeable = False
    return model


@pytest.mark.parametrize("is_flexible", [False, True])
@pytest.mark.parametrize(("stretch", "load"), [(0.001, 20.0), (-0.4, 7.0), (0.1, -1.0)])
@pytest.mark.parametrize("joint", JOINTS)
def test_both_routes_agree_in_every_joint(joint: str, stretch: float, load: float, is_flexible: bool) -> None:
    model = in_state(scene_of(JOINTS[joint](), is_flexible=is_flexible).freeze(), stretch, load)
    assert len(model.bearings) == 1
    assert_routes_agree(model)


def test_both_routes_agree_with_gears_and_loops() -> None:
    scene = scene_of(JOINTS["revolute"](), is_flexible=True)
    scene.add_gear("gear", {scene.body("base"): 1.0, scene.body("slider"): 2.0})
    assert_routes_agree(in_state(scene.freeze(), 0.01, 5.0))


@pytest.mark.parametrize("joint", ["collar", "rail", "cylindrical", "screw", "spherical"])
def test_the_exact_jacobian_is_that_of_differences(joint: str) -> None:
    model = in_state(scene_of(JOINTS[joint](), is_flexible=True).freeze(), -0.4, 7.0)
    y, exact = model.initial_state, model.jacobian(0.0, model.initial_state)
    for i in range(len(y)):
        step = 1e-6 * np.eye(len(y))[i]
        difference = (model.rhs(0.0, y + step) - model.rhs(0.0, y - step)) / 2e-6
        np.testing.assert_allclose(difference, exact[:, i], rtol=1e-5, atol=1e-5 * max(1.0, abs(exact).max() * 1e-3))


@pytest.mark.parametrize("method", ["auto", "dop853", "radau5", "dopri5"])
def test_a_wheel_on_a_journal_bearing_stops_when_the_textbook_says(method: str) -> None:
    mass, inertia, spin, mu, radius = 2.0, 0.02, 10.0, 0.1, 0.01
    scene = kf.System(gravity=(0, 0, -G))
    friction = kf.JointFriction(mu, radius)
    scene.add_rigid_body("wheel", mass, inertia, joint=kf.Revolute("y", speed=spin, friction=friction))
    result = scene.simulate((0.0, 12.0), rtol=1e-8, method=method)
    stops = spin * inertia / (mu * mass * G * radius)
    # the anchor's spring holds energy and lets go of it: it turns by a milliradian before it slips
    assert result.events["wheel stick"][-1] == pytest.approx(stops, abs=1e-4)
    assert result.load("friction of wheel")[1, 0] == pytest.approx(-mu * mass * G * radius, rel=1e-9)
    assert result.load("friction of wheel")[-1, 2:] == pytest.approx((1.0, 0.0, mass * G), rel=1e-9)
    assert abs(result.joint_speeds("wheel")[-1, 0]) < 1e-4
    assert result.energy.dissipated[-1] == pytest.approx(0.5 * inertia * spin**2, rel=1e-6)
    assert abs(result.energy.balance_error).max() < 1e-7


def test_an_eccentric_rotor_is_braked_by_what_turns_round_with_it() -> None:
    """Without gravity the load is that of the imbalance: dw/dt = -mu r N / I, N = m e sqrt(w^4 + (dw/dt)^2)."""
    mass, off, inertia, mu, radius, spin = 1.0, 0.1, 0.05, 0.3, 0.02, 20.0
    scene = kf.System()
    friction = kf.JointFriction(mu, radius, stiffness=1e7)
    scene.add_rigid_body("rotor", mass, inertia, com=(off, 0, 0), joint=kf.Revolute("z", speed=spin, friction=friction))
    result = scene.simulate((0.0, 5.0), rtol=1e-9)
    total, arm = inertia + mass * off**2, mu * radius
    # N^2 = (m e)^2 (w^4 + dw^2) and I dw = -mu r N give dw = -c w^2
    c = mass * off * arm / math.sqrt(total**2 - (mass * off * arm) ** 2)
    expected = spin / (1.0 + c * spin * result.times)
    assert result.joint_speeds("rotor")[:, 0] == pytest.approx(expected, rel=2e-5)
    assert abs(result.energy.balance_error).max() < 1e-7


def swing(load_time: float) -> float:
    """Return the angle at which a pendulum with friction in its pivot is after a second."""
    scene = kf.System(gravity=(0, 0, -G))
    friction = kf.JointFriction(0.4, 0.05, stiffness=1e8, damping=4e3, load_time=load_time)
    joint = kf.Revolute("y", position=1.2, friction=friction)
    scene.add_rigid_body("bob", 1.0, 0.01, com=(0, 0, -0.5), joint=joint)
    result = scene.simulate((0.0, 1.0), rtol=1e-10)
    return float(result.joint_coordinates("bob")[-1, 0])


def test_the_error_of_the_load_that_is_felt_falls_with_the_square_of_its_time() -> None:
    exact = swing(2e-4)
    errors = [abs(swing(time) - exact) for time in (1.6e-2, 8e-3, 4e-3)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.25)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.25)
    assert errors[2] < 5e-5


@pytest.mark.parametrize(("share", "jams"), [(0.97, False), (1.03, True)])
def test_a_drawer_jams_where_friction_is_above_length_over_twice_the_offset(share: float, jams: bool) -> None:
    length, offset = 0.2, 0.3
    scene = kf.System()
    friction = kf.JointFriction(share * length / (2 * offset), length=length, stiffness=1e6)
    drawer = scene.add_rigid_body("drawer", 2.0, 0.1, joint=kf.Prismatic("x", friction=friction))
    scene.add_force(drawer, lambda t: (50.0 * min(2.0 * t, 1.0), 0, 0), point=(0, offset, 0))
    result = scene.simulate((0.0, 2.0), rtol=1e-8)
    v, t = result.joint_speeds("drawer")[:, 0], result.times
    if jams:
        assert result.joint_coordinates("drawer")[-1, 0] < 1e-4
        assert result.load("friction of drawer")[-1] == pytest.approx(
            (-50.0, 50.0 / 1e6, 1.0, 0.0, 2 * 50.0 * offset / length), rel=1e-4
        )
    else:
        late = t > 0.6
        assert np.diff(v[late]) / np.diff(t[late]) == pytest.approx(50.0 * (1 - share) / 2.0, rel=1e-4)
    assert abs(result.energy.balance_error).max() < 1e-6


@pytest.mark.parametrize(("share", "holds"), [(0.98, False), (1.02, True)])
def test_a_screw_holds_its_load_where_friction_is_above_the_tangent_of_its_lead(share: float, holds: bool) -> None:
    lead, radius, mass, inertia = 0.05, 0.04, 3.0, 0.01
    tangent = lead / (2 * math.pi * radius)
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Screw("z", lead=lead, friction=kf.JointFriction(share * tangent, radius))
    scene.add_rigid_body("nut", mass, inertia, joint=joint)
    result = scene.simulate((0.0, 2.0), rtol=1e-8)
    turned = result.joint_coordinates("nut")[-1, 0]
    if holds:
        assert abs(turned) < 1e-2  # it came down at once, with twice its weight
        assert result.load("friction of nut")[-1, 2] == 1.0
    else:
        assert turned < -0.1
        with pytest.raises(kf.SimulationError, match=r"friction of nut needs .* N m and holds .* N m\. Remedy: more"):
            kf.equilibrium(scene)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_what_it_takes_to_raise_and_lower_by_a_screw(way: float) -> None:
    """Torque W r (mu + tan b)/(1 - mu tan b) to raise, W r (mu - tan b)/(1 + mu tan b) to lower."""
    lead, radius, mass, mu = 0.05, 0.04, 3.0, 0.4
    rise = lead / (2 * math.pi * radius)
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Screw("z", lead=lead, motion=kf.Motion.steady(2.0 * way), friction=kf.JointFriction(mu, radius))
    scene.add_rigid_body("nut", mass, 0.01, joint=joint)
    result = scene.simulate((0.0, 1.0), rtol=1e-8)
    wanted = way * mass * G * radius * (mu + way * rise) / (1 - way * mu * rise)
    assert result.driving_force("nut")[-1] == pytest.approx(wanted, rel=1e-6)


def test_a_shaft_that_slides_and_turns_is_braked_against_both() -> None:
    mass, radius, mu = 2.0, 0.05, 0.2
    inertia = mass * radius**2  # so that both directions have the same mass, and slip keeps its direction
    scene = kf.System(gravity=(0, 0, -G))
    friction = kf.JointFriction(mu, radius)
    joint = kf.Cylindrical("x", speed=(0.6, 0.8 / radius), friction=friction)
    scene.add_rigid_body("shaft", mass, inertia, joint=joint)
    result = scene.simulate((0.0, 0.4), rtol=1e-9)
    late = slice(len(result.times) // 4, None)
    slip = 1.0 - mu * G * result.times
    assert result.joint_speeds("shaft")[late, 0] == pytest.approx(0.6 * slip[late], abs=2e-4)
    assert result.joint_speeds("shaft")[late, 1] * radius == pytest.approx(0.8 * slip[late], abs=2e-4)
    assert abs(result.energy.balance_error).max() < 1e-6


def test_a_ball_joint_is_braked_against_its_spin() -> None:
    mass, inertia, mu, radius = 2.0, 0.02, 0.1, 0.03
    scene = kf.System(gravity=(0, 0, -G))
    spin = np.array((3.0, -4.0, 12.0))
    joint = kf.Spherical(angular_velocity=spin, friction=kf.JointFriction(mu, radius))
    scene.add_rigid_body("ball", mass, inertia, joint=joint)
    result = scene.simulate((0.0, 6.0), rtol=1e-9)
    deceleration = mu * mass * G * radius / inertia
    w, t = result.joint_speeds("ball"), result.times
    going = (t > 0.1) & (t < 13.0 / deceleration - 0.05)
    wanted = spin / 13.0 * (13.0 - deceleration * t[going, None])
    assert w[going] == pytest.approx(wanted, abs=2e-3)
    assert len(result.events["ball stick"]) >= 1
    assert abs(w[-1]).max() < 1e-3
    assert abs(result.energy.balance_error).max() < 1e-6
    with pytest.raises(kf.ModelError, match="their small motions are not supported"):
        kf.equilibrium(scene)


def test_what_sticks_does_not_creep() -> None:
    scene = kf.System(gravity=(0, 0, -G))
    friction = kf.JointFriction(0.5, 0.05, damping=2000.0)
    scene.add_rigid_body("arm", 2.0, 0.02, com=(0.01, 0, 0), joint=kf.Revolute("y", friction=friction))
    result = scene.simulate((0.0, 300.0), rtol=1e-6)
    angle = result.joint_coordinates("arm")[:, 0]
    assert abs(angle[100:] - angle[-1]).max() < 1e-13
    assert not len(result.events["arm slip"])


def test_a_run_starts_under_the_load_of_its_start() -> None:
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Revolute("y", position=0.4, speed=3.0, friction=kf.JointFriction(0.4, 0.2, length=0.1))
    scene.add_rigid_body("arm", 2.0, (0.02, 0.03, 0.04), com=(0.1, 0.05, -0.3), joint=joint)
    model = scene.freeze()
    y = model.initial_state
    # the load to round-off, over the time in which it is followed
    still = 1e-12 * y[3] / model.loads[0].load_time
    assert model.rhs(0.0, y)[-2:] == pytest.approx((0.0, 0.0), abs=still)
    # also from another state: of that state
    other = scene.freeze(start=np.array((0.1, -5.0)))
    assert other.initial_state[3] != pytest.approx(y[3], rel=0.1)
    assert other.rhs(0.0, other.initial_state)[-2:] == pytest.approx((0.0, 0.0), abs=still)


def test_a_rest_under_friction_from_the_load() -> None:
    scene = kf.System(gravity=(0, 0, -G))
    friction = kf.JointFriction(0.5, 0.05)
    scene.add_rigid_body("arm", 2.0, 0.02, com=(0.01, 0, 0), joint=kf.Revolute("y", friction=friction))
    rest = kf.equilibrium(scene)
    held, _, sticks, _, load = rest.load("friction of arm")
    angle = rest.joint_coordinates("arm")[0]
    assert held == pytest.approx(-2.0 * G * 0.01 * math.cos(angle), rel=1e-9)
    assert (sticks, load) == pytest.approx((1.0, 2.0 * G), rel=1e-9)
    result = scene.simulate((0.0, 1.0), start=rest)
    assert abs(result.joint_coordinates("arm")[:, 0] - angle).max() < 1e-12
    assert rest.linearise().modes().natural_frequencies[0] > 1.0


def test_a_chain_of_twenty_keeps_its_energy() -> None:
    scene, parent = kf.System(gravity=(0, 0, -G)), None
    for i in range(20):
        where = {"parent": parent, "at": (0, 0, -0.1)} if parent is not None else {}
        joint = kf.Revolute("xy"[i % 2], position=0.3, friction=kf.JointFriction(0.1, 0.005))
        parent = scene.add_rigid_body(f"b{i}", 0.2, (2e-4, 2e-4, 1e-5), com=(0, 0, -0.05), joint=joint, **where)
    result = scene.simulate((0.0, 0.1), rtol=1e-8, method="dop853")
    assert abs(result.energy.balance_error).max() < 1e-8
    assert result.load("friction of b0")[-1, -1] > 10.0 * result.load("friction of b19")[-1, -1]


@pytest.mark.parametrize("method", ["extrapolation", "energy-momentum"])
def test_methods_that_cannot_follow_it_say_so(method: str) -> None:
    scene = kf.System(gravity=(0, 0, -G))
    friction = kf.JointFriction(0.1, 0.01)
    scene.add_rigid_body("wheel", 2.0, 0.02, joint=kf.Revolute("y", friction=friction))
    step = {"step": 1e-3} if method == "energy-momentum" else {}
    with pytest.raises(kf.ModelError, match=r"'friction of wheel'.*Remedy"):
        scene.simulate((0.0, 1.0), method=method, **step)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"mu": -0.1}, "mu of JointFriction must be one number"),
        ({"mu": Decimal("0.2")}, r"mu of JointFriction must be one number, finite and >= 0, not Decimal\('0\.2'\)"),
        ({"mu": float("nan")}, "mu of JointFriction must be one number"),
        ({"mu": 0.1, "preload": -1.0}, "preload of JointFriction"),
        ({"mu": 0.1, "radius": 0.0}, "radius of JointFriction must be one number, finite and > 0"),
        ({"mu": 0.1, "load_time": 0.0}, "load_time of JointFriction"),
        ({"mu": 0.3, "static": 0.2}, "static of JointFriction, 0.2, is below mu, 0.3. Remedy"),
    ],
)
def test_bad_numbers_are_named(given: dict[str, Any], message: str) -> None:
    with pytest.raises(kf.ModelError, match=message):
        kf.JointFriction(**given)


def test_joints_name_what_they_lack() -> None:
    with pytest.raises(kf.ModelError, match="friction of a revolute joint needs the radius"):
        kf.Revolute("z", friction=kf.JointFriction(0.1))
    with pytest.raises(kf.ModelError, match="friction of a spherical joint needs the radius"):
        kf.Spherical(friction=kf.JointFriction(0.1))
    with pytest.raises(kf.ModelError, match=r"friction of a screw joint has no use for length=0.1"):
        kf.Screw("z", lead=0.1, friction=kf.JointFriction(0.1, 0.02, length=0.1))
    with pytest.raises(kf.ModelError, match=r"friction of a prismatic joint must be a JointFriction, not 0.1"):
        kf.Prismatic("z", friction=0.1)
    with pytest.raises(kf.ModelError, match="either friction from its load or a CoordinateForce with friction"):
        kf.Prismatic("z", friction=kf.JointFriction(0.1), forces=kf.CoordinateForce(friction=1.0))
    pose = kf.PoseTable(np.arange(4.0), orientations=[(1.0, 0, 0, 0)] * 4)
    with pytest.raises(kf.ModelError, match="spherical joint that follows a given pose has no friction"):
        kf.Spherical(motion=pose, friction=kf.JointFriction(0.1, 0.01))


def test_scenes_name_what_they_cannot_tell() -> None:
    scene = kf.System()
    scene.add_rigid_body("wheel", 2.0, 0.02, joint=kf.Revolute("y", friction=kf.JointFriction(0.1, 0.01)))
    with pytest.raises(kf.ModelError, match=r"nothing loads the joint of 'wheel' at the start.* Remedy: .*stiffness"):
        scene.freeze()
    joint = kf.Revolute("y", friction=kf.JointFriction(0.1, 0.01))
    with pytest.raises(kf.ModelError, match="friction is of joints of the tree"):
        scene.add_loop_joint("pin", joint, scene.ground, scene.body("wheel"))


def test_no_friction_costs_nothing() -> None:
    scene = kf.System(gravity=(0, 0, -G))
    joint = kf.Revolute("y", friction=kf.JointFriction(0.0, 0.01))
    scene.add_rigid_body("wheel", 2.0, 0.02, joint=joint)
    model = scene.freeze()
    assert not model.loads
    assert not model.bearings
    other = kf.System(gravity=(0, 0, -G))
    other.add_rigid_body("wheel", 2.0, 0.02, joint=kf.Prismatic("x", forces=kf.CoordinateForce(friction=1.0)))
    assert len(other.freeze().route.between.bearings) == 0


@pytest.mark.parametrize("count", [1, 10])
def test_auto_is_explicit_where_many_joints_slip_and_stick(count: int) -> None:
    """Each time that one of ten stops, Radau's method makes its steps short: 6,800 of them in two seconds."""
    scene, parent = kf.System(gravity=(0, 0, -G)), None
    for i in range(count):
        where = {"parent": parent, "at": (0.2, 0, 0)} if parent is not None else {}
        friction = kf.JointFriction(0.1, 0.01, stiffness=1e4, damping=5.0)
        joint = kf.Revolute("y", friction=friction)
        parent = scene.add_rigid_body(f"b{i}", 0.5, 1e-3, com=(0.1, 0, 0), joint=joint, **where)
    for span in (2.0, 10.0):
        assert candidates(scene.freeze(), 0.0, span, 1e-6, 1e-6).choose().name == (
            "dop853" if count == 10 else "radau5"
        )


def test_auto_is_explicit_where_many_joints_are_not_stiff() -> None:
    scene, parent = kf.System(gravity=(0, 0, -G)), None
    for i in range(20):
        where = {"parent": parent, "at": (0, 0, -0.1)} if parent is not None else {}
        friction = kf.JointFriction(0.1, 0.005, stiffness=1e5, damping=50.0)
        joint = kf.Revolute("xy"[i % 2], position=0.3, friction=friction)
        parent = scene.add_rigid_body(f"b{i}", 0.2, (2e-4, 2e-4, 1e-5), com=(0, 0, -0.05), joint=joint, **where)
    assert candidates(scene.freeze(), 0.0, 1.0, 1e-6, 1e-6).choose().name == "dop853"
    assert candidates(scene.freeze(), 0.0, 1e5, 1e-6, 1e-6).choose().name == "radau5"
    assert "friction from its load" in str(scene)


COUNTED = """
import json
import numpy as np
import kanefe as kf
from kanefe.kernels.evaluation import evaluation
from kanefe.kernels.loads import watching
counts = {}
def counted(module, name):
    function = getattr(module, name)
    def counting(*arguments):
        counts[name] = counts.get(name, 0) + 1
        return function(*arguments)
    setattr(module, name, counting)
counted(evaluation, "add_reactions")
counted(watching, "sweep_outward")
found = []
for kind in ("load", "given", "contact"):
    scene = kf.System(gravity=(0, 0, -9.81))
    friction = kf.JointFriction(0.1, 0.01) if kind == "load" else None
    forces = kf.CoordinateForce(friction=0.1) if kind == "given" else None
    wheel = scene.add_rigid_body("wheel", 2.0, 0.02, joint=kf.Revolute("y", friction=friction, forces=forces))
    if kind == "contact":
        floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
        scene.add_contact("contact", wheel, floor, normal=kf.HuntCrossley(1e5))
    model = scene.freeze()
    y = model.initial_state
    counts.clear()
    model.rhs(0.0, y)
    model.route.watching.values(np.zeros(3), np.tile(np.concatenate((y, (0.0, 0.0))), (3, 1)))
    found.append([counts.get("add_reactions", 0), counts.get("sweep_outward", 0)])
print(json.dumps(found))
"""


def test_what_is_not_felt_and_not_looked_at_costs_nothing() -> None:
    command = [sys.executable, "-c", COUNTED]
    run = subprocess.run(command, env=surroundings(KANEFE_JIT="0"), capture_output=True, text=True, check=True)
    # reactions only where they are felt; frames only where events of loads look at them
    from_load, given, contact = json.loads(run.stdout)
    assert (from_load, given) == ([1, 0], [0, 0])
    assert contact[0] == 0
    assert contact[1] >= 3


FALLS = RUBS | {"stribeck_speed": 0.01}


@pytest.mark.parametrize("mark", [0.0, 1.0], ids=["slips", "sticks"])
@pytest.mark.parametrize(
    "joint",
    [
        kf.Revolute("y", position=0.2, speed=0.9, friction=kf.JointFriction(radius=0.02, **FALLS)),
        kf.Cylindrical(
            "z", position=(0.1, 0.2), speed=(0.4, -8.0), friction=kf.JointFriction(radius=0.05, length=0.3, **FALLS)
        ),
        kf.Spherical(angular_velocity=(1, -2, 0.5), friction=kf.JointFriction(radius=0.1, **FALLS)),
    ],
    ids=["revolute", "cylindrical", "spherical"],
)
def test_friction_that_falls_is_the_same_on_both_routes(joint: kf.Joint, mark: float) -> None:
    """Slipping at speeds about that in which it falls; the Jacobian goes through the search for the slip speed."""
    model = in_state(scene_of(joint, is_flexible=True).freeze(), 0.002, 5.0)
    z = model.initial_states
    z.flags.writeable = True
    (number,) = model.bearings
    z[model.load_states[number].start + model.loads[number].count] = mark
    z.flags.writeable = False
    assert_routes_agree(model)
    y, exact = model.initial_state, model.jacobian(0.0, model.initial_state)
    for i in range(len(y)):
        step = 1e-7 * np.eye(len(y))[i]
        difference = (model.rhs(0.0, y + step) - model.rhs(0.0, y - step)) / 2e-7
        np.testing.assert_allclose(exact[:, i], difference, atol=2e-5 * max(1.0, np.abs(exact).max()))


def test_a_slider_is_braked_as_by_the_fall_of_stribeck() -> None:
    """Against scipy's integration of ``dv/dt = -g (mu + (static - mu) exp(-(v/speed)^2))``."""
    mu, static, speed = 0.1, 0.3, 0.3
    scene = kf.System(gravity=(0, 0, -G))
    law = kf.JointFriction(mu, static=static, stribeck_speed=speed)
    scene.add_rigid_body("slider", 2.0, 0.1, joint=kf.Prismatic("x", speed=1.0, friction=law))
    result = scene.simulate((0.0, 1.0), rtol=1e-8)

    def braked(t: float, v: np.ndarray) -> np.ndarray:
        return -G * (mu + (static - mu) * np.exp(-((v / speed) ** 2)))

    stops = lambda t, v: v[0]  # noqa: E731
    stops.terminal = True
    wanted = solve_ivp(braked, (0.0, 1.0), [1.0], rtol=1e-10, atol=1e-12, events=stops, dense_output=True)
    (stop,) = wanted.t_events[0]
    assert result.events["slider stick"][0] == pytest.approx(stop, abs=1e-3)  # the anchor's spring swings a little
    moves = result.times < stop - 0.01
    np.testing.assert_allclose(result.joint_speeds("slider")[moves, 0], wanted.sol(result.times[moves])[0], atol=1e-4)
    assert abs(result.energy.balance_error).max() < 1e-6


def test_what_moves_at_the_start_slips() -> None:
    """By the kinetic coefficient, not by the static one of what is held: ``v - mu g t``, until it sticks."""
    for forces, friction in (
        (None, kf.JointFriction(0.1, static=0.3)),
        (kf.CoordinateForce(friction=0.1 * 2.0 * G, static_friction=0.3 * 2.0 * G), None),
    ):
        scene = kf.System(gravity=(0, 0, -G))
        scene.add_rigid_body("slider", 2.0, 0.1, joint=kf.Prismatic("x", speed=0.5, forces=forces, friction=friction))
        result = scene.simulate((0.0, 0.7), rtol=1e-8)
        moves = result.times < 0.5
        wanted = 0.5 - 0.1 * G * result.times[moves]
        np.testing.assert_allclose(result.joint_speeds("slider")[moves, 0], wanted, atol=1e-4)  # w/k: the spring first
        assert result.events["slider stick"] == pytest.approx([0.5 / (0.1 * G)], abs=1e-3)
        assert len(result.events["slider slip"]) == 0


def test_what_a_fall_needs() -> None:
    with pytest.raises(kf.ModelError, match="needs a `static` above mu to fall from"):
        kf.JointFriction(0.1, stribeck_speed=0.1)
    with pytest.raises(kf.ModelError, match="stribeck_speed of JointFriction must be one number, finite and > 0"):
        kf.JointFriction(0.1, static=0.2, stribeck_speed=-0.1)
    with pytest.raises(kf.ModelError, match="has no use for stribeck_speed"):
        kf.Screw("x", lead=0.1, friction=kf.JointFriction(radius=0.1, **FALLS))
