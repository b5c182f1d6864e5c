"""What each point of a contact does: forces, depth, slip with its sign, stretch of its anchor, and its events."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import kanefe as kf
from kanefe.frames import rotation_matrix
from kanefe.integrate.events.load_events import events_of_loads

G = 9.81
MASS = 2.0
LAW = kf.KelvinVoigt(1e6, damping=3000.0)
NORMALS = pytest.mark.parametrize("normal", [LAW, kf.Rigid()], ids=["yields", "rigid"])


def block_on(scene: kf.System, top: object, normal: object, **friction: float) -> object:
    """Return a block on four feet that rests on the surface; half a side is 0.05 m, its centre 0.1 m above it."""
    depth = 0.0 if isinstance(normal, kf.Rigid) else MASS * G / normal.stiffness
    block = scene.add_rigid_body("block", MASS, 0.02, joint=kf.Free(position=(0, 0, 0.1 - depth)))
    feet = [block.frame(at=(x, y, -0.1)) for x in (-0.05, 0.05) for y in (-0.05, 0.05)]
    scene.add_contact("feet", feet, top, normal=normal, friction=kf.Coulomb(**friction))
    return block


def pull(t: float) -> tuple[float, float, float]:
    """Return a force that rises by 10 N/s along x."""
    return 10.0 * t, 0.0, 0.0


def pulled(normal: object, height: float, force: object = pull, **friction: float) -> kf.System:
    """Return a block that is pulled so far above the table."""
    scene = kf.System(gravity=(0, 0, -G))
    table = scene.add_surface("table", scene.ground, kf.shapes.Plane("z"))
    block = block_on(scene, table, normal, **friction)
    scene.add_force(block, force, point=(0, 0, height - 0.1))
    return scene


def test_a_box_tips_over_an_edge_and_its_other_points_lift():
    """Where 10 t 0.1 m = m g 0.05 m; the contact as a whole does not lift."""
    result = pulled(kf.Rigid(), 0.1, mu=0.8).simulate((0.0, 1.02), rtol=1e-8, events="feet * of point *")
    events = result.events
    for point in (0, 1):
        assert events[f"feet lift of point {point}"] == pytest.approx([MASS * G * 0.05 / (10.0 * 0.1)], abs=1e-7)
    assert all(not len(events[f"feet lift{rest}"]) for rest in ("", " of point 2", " of point 3"))
    points = result.contact_points("feet")
    assert np.all(points.status[-1] == ("open", "open", "sticks", "sticks"))
    assert np.all(points.penetration[-1, :2] < -1e-6)
    assert points.normal[-1, :2] == pytest.approx(0.0)


def test_a_box_on_springs_lifts_there_too():
    result = pulled(LAW, 0.1, mu=0.8).simulate((0.0, 1.0), events="feet lift of point *")
    # it turns by 2e-5 m over 0.1 m before: 2e-4 of the arm, and dampers of 3000 N s/m follow the pull 3 ms behind
    assert result.events["feet lift of point 0"] == pytest.approx([MASS * G * 0.05], abs=2e-3)
    points, lifted = result.contact_points("feet"), result.events["feet lift of point 0"][0]
    assert np.all((points.penetration[1:, 0] > 0.0) == (result.times[1:] < lifted))
    assert not len(result.events["feet lift"])


@pytest.mark.parametrize("compile_force", [kf.compiled, lambda function: function], ids=["compiled", "in Python"])
def test_feet_that_lift_at_one_moment_are_both_told(compile_force):
    """Their roots differ by round-off: the later one is not lost from the step that begins at the earlier one."""
    force = compile_force(pull)
    for height in np.random.default_rng(7).uniform(0.08, 0.12, 16):
        end = 1.05 * MASS * G * 0.05 / (10.0 * height)
        run = pulled(LAW, height, force, mu=0.8).simulate((0.0, end), method="radau5", events="feet lift of point *")
        first, second = (run.events[f"feet lift of point {point}"] for point in (0, 1))
        assert len(first) == 1
        assert second == pytest.approx(first, abs=1e-9)


@pytest.mark.parametrize("method", ["radau5", "dop853", "generalised-alpha", "extrapolation"])
def test_points_touch_and_lift_in_their_turn(method):
    """A mass on two springs of k/2 falls on one, and 2 mm further on both; it comes back as it went."""
    k, gap, fall = 1e5, 2e-3, 0.05
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    mass = scene.add_rigid_body("mass", MASS, 0.1, joint=kf.Prismatic("z", position=fall))
    ends = [mass, mass.frame(at=(0.1, 0, gap))]
    scene.add_contact("c", ends, floor, normal=kf.KelvinVoigt(k))
    found = scene.simulate((0.0, 0.3), rtol=1e-9, method=method, events=["c * of point *"]).events
    first, w = math.sqrt(2.0 * fall / G), math.sqrt(0.5 * k / MASS)
    # m g / (k/2) (1 - cos wt) + v/w sin wt = gap
    a, b = G / w**2, G * first / w
    second = first + (math.atan2(b, -a) - math.acos((gap - a) / math.hypot(a, b))) / w
    near = {"abs": 2e-5 if method == "generalised-alpha" else 1e-8}  # of second order: steps of 1e-4 s at this rtol
    assert found["c touch of point 0"] == pytest.approx([first], **near)
    assert found["c touch of point 1"] == pytest.approx([second], **near)
    assert found["c touch"] == pytest.approx([first], **near)
    there_and_back = [found[f"c {what} of point {i}"][0] for i in (0, 1) for what in ("touch", "lift")]
    assert there_and_back[0] + there_and_back[1] == pytest.approx(there_and_back[2] + there_and_back[3], **near)
    assert found["c lift"] == pytest.approx(there_and_back[1:2], abs=1e-12)


@pytest.mark.parametrize("static", [None, 0.5], ids=["one coefficient", "two"])
@NORMALS
def test_points_slip_where_the_block_does(normal, static):
    """Pulled in the plane of the feet all slip at mu m g = 10 t; the pull goes on."""
    result = pulled(normal, 0.0, mu=0.4, static=static).simulate((0.0, 1.2), rtol=1e-8, events="feet slip of *")
    begins = (static or 0.4) * MASS * G / 10.0
    # dampers of four anchors, 2 sqrt(1e6 N/m 2 kg) each, times 1e-8 m/s of the tolerance, over the 10 N/s of the pull
    for what in ("", *(f" of point {i}" for i in range(4))):
        assert result.events[f"feet slip{what}"] == pytest.approx(begins, abs=1.2e-5)
        assert len(result.events[f"feet slip{what}"]) == 1 or not what  # with two coefficients told of each that slips
    # how four rigid points share their load is decided in steps, in which some are let go and held again
    assert all(not len(result.events[f"feet {what} of point {i}"]) for what in ("lift", "touch") for i in range(4))


def shaken(normal: object, amplitude: float = 0.02, frequency: float = 3.0) -> kf.System:
    """Return a block on a plate that is shaken along x."""
    w = 2.0 * math.pi * frequency
    scene = kf.System(gravity=(0, 0, -G))
    motion = kf.Motion(
        lambda t: amplitude * math.sin(w * t),
        lambda t: amplitude * w * math.cos(w * t),
        lambda t: -amplitude * w**2 * math.sin(w * t),
    )
    plate = scene.add_rigid_body("plate", 10.0, 1.0, joint=kf.Prismatic("x", motion=motion))
    top = scene.add_surface("top", plate, kf.shapes.Plane("z"))
    block_on(scene, top, normal, mu=0.3)
    return scene


@NORMALS
def test_slip_has_the_sign_of_the_motion_past_the_plate(normal):
    result = shaken(normal).simulate((0.0, 0.4), output_step=1e-3)
    points = result.contact_points("feet")
    past = (result.velocity("block") - result.velocity("plate"))[:, None, :2]
    slip = points.slip_velocity
    assert slip[:, :, 0].min() < -0.2
    assert slip[:, :, 0].max() > 0.2
    # the block tilts, and anchors stretch where the slip turns: 0.02 m/s for a few milliseconds
    assert np.median(np.abs(slip[:, :, :2] - past)) < (1e-9 if isinstance(normal, kf.Rigid) else 1e-4)
    assert np.all(slip[:, :, 2] == 0.0)
    slips = points.status == "slips"
    drag = np.linalg.norm(points.friction, axis=2)
    assert drag[slips] == pytest.approx(0.3 * points.normal[slips], rel=1e-9)
    assert np.einsum("tpi,tpi->tp", points.friction, slip).max() <= 0.0
    # the path is the integral of its size: by the trapezium, with corners where it turns
    speed = np.linalg.norm(slip, axis=2).mean(axis=1)
    path = np.sum(0.5 * (speed[1:] + speed[:-1]) * np.diff(result.times))
    assert path == pytest.approx(result.contact("feet").slip[-1], rel=1e-3)


def test_an_anchor_is_stretched_by_what_it_holds():
    """T / k down a slope of 0.2, and nothing slips."""
    scene = kf.System(gravity=(0, 0, -G))
    e = kf.rotation_about("y", 0.2)
    slope = rotation_matrix(e)
    top = scene.add_surface("slope", scene.ground, kf.shapes.Plane("z"), orientation=slope)
    block = scene.add_rigid_body("block", MASS, 0.02, joint=kf.Free(position=slope @ (0, 0, 0.1), orientation=slope))
    feet = [block.frame(at=(x, y, -0.1)) for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
    scene.add_contact("feet", feet, top, normal=LAW, friction=kf.Coulomb(0.6, stiffness=4e5))
    points = kf.equilibrium(scene).contact_points("feet")
    pull = MASS * G * math.sin(0.2)
    assert points.friction[:, 0].sum() == pytest.approx(-pull, rel=1e-9)
    assert points.normal.sum() == pytest.approx(MASS * G * math.cos(0.2), rel=1e-9)
    assert points.stretch[:, 0] == pytest.approx(pull / 4e5, rel=1e-6)  # each of a quarter of k
    assert points.stretch[:, 0] == pytest.approx(-points.friction[:, 0] / 1e5, rel=1e-9)
    assert np.all(points.slip_velocity == 0.0)
    assert np.all(points.status == "sticks")


def test_a_contact_without_friction_slides():
    scene = kf.System(gravity=(0, 0, -G))
    table = scene.add_surface("table", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_rigid_body("ball", 1.0, 0.1, joint=kf.Free(position=(0, 0, 0.1), velocity=(-0.5, 0.25, 0)))
    skin = scene.add_surface("skin", ball, kf.shapes.Sphere(0.1))
    scene.add_contact("c", skin, table, normal=kf.KelvinVoigt(1e5, damping=500.0))
    points = scene.simulate((0.0, 0.2)).contact_points("c")
    assert points.slip_velocity[-1, 0] == pytest.approx((-0.5, 0.25, 0.0), abs=1e-9)
    assert points.status[-1, 0] == "slips"


def test_what_is_not_asked_for_is_not_looked_at():
    """Four functions of the contact, and four more of each point where one of them is asked for."""
    model = pulled(LAW, 0.1, mu=0.8).freeze()
    assert model.route.watching.columns == {0: slice(0, 4)}
    assert model.loads[0].in_detail().told[4:8] == (
        "touch of point 0",
        "lift of point 0",
        "slip of point 0",
        "stick of point 0",
    )
    runs = [pulled(LAW, 0.1, mu=0.8).simulate((0.0, 0.5), events=names) for names in ((), "feet * of point *")]
    assert [len(run.events) for run in runs] == [4, 20]
    assert runs[0].statistics["evaluations"] == runs[1].statistics["evaluations"]


def test_points_of_a_result_come_back_from_its_file(tmp_path):
    result = shaken(LAW).simulate((0.0, 0.1))
    result.save(tmp_path / "run.h5")
    read = kf.load_result(tmp_path / "run.h5")
    for one, other in zip(read.contact_points("feet"), result.contact_points("feet"), strict=True):
        assert np.array_equal(one, other)
    with pytest.raises(kf.ModelError, match=r"no contact called 'plate'\. It has: feet"):
        read.contact_points("plate")
    assert result.at(result.times[3]).contact_points("feet").slip_velocity.shape == (4, 3)


def test_points_are_outputs_of_a_scene_that_is_stepped():
    scene = shaken(LAW)
    names = "contact_points feet point_0_slip_velocity_x", "contact_points feet point_3_stretch_x"
    sim = scene.start(outputs=names)
    sim.step(0.1)
    told = sim.state.contact_points("feet")
    assert sim.outputs == pytest.approx({names[0]: told.slip_velocity[0, 0], names[1]: told.stretch[3, 0]})
    assert sim.units == {names[0]: "m/s", names[1]: "m"}


@pytest.mark.parametrize(
    "friction",
    [None, kf.Coulomb(0.3), kf.Coulomb(0.3, static=0.5), kf.LuGre(1e5, 300.0, 0.4, 0.3, 0.4, 1e-3)],
    ids=["none", "one coefficient", "two", "bristles"],
)
def test_what_events_look_at_is_the_same_compiled_and_in_python(friction: object) -> None:
    """Twenty points, more than a contact has ends and states for; in states in which some touch, and some slip."""
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    body = scene.add_rigid_body("body", MASS, 0.02, joint=kf.Free(position=(0, 0, 0.1)))
    places = [(0.1 * math.cos(i), 0.1 * math.sin(i), -0.1) for i in range(20)]
    skin = scene.add_surface("skin", body, kf.shapes.Points(places))
    scene.add_contact("c", skin, floor, normal=LAW, friction=friction)
    model = scene.freeze()
    model = replace(model, loads=(model.loads[0].in_detail(),))
    rng = np.random.default_rng(3)
    size, looked = len(model.initial_state), 0
    spread = np.concatenate(([1e-5] * 3, [1e-3] * 4, [1e-2] * 6, [1e-5] * (size - 13)))
    for _ in range(20):
        y = model.initial_state + spread * rng.standard_normal(size)
        if friction is not None and friction.has_memory:
            first = size - len(model.initial_states) + 2
            y[first + 3 :: 4] = rng.integers(0, 2, 20)
        compiled = model.route.watching.values(np.zeros(1), np.append(y, (0.0, 0.0))[None])[0]
        state = model.literal.state(0.0, y)
        plain = [event.value(0.0, state) for event in events_of_loads(model, keeps_steps=False)]
        assert len(plain) == (2 if friction is None or isinstance(friction, kf.LuGre) else 4) * 21
        assert compiled == pytest.approx(plain, rel=1e-9, abs=1e-12)
        looked += len(set(np.sign(compiled[::2])))
    assert looked > 30  # of both signs in most states
