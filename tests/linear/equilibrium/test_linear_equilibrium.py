"""Equilibrium: at rest and in steady motion, against closed forms; what cannot balance is named."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import ModelError, SimulationError
from kanefe.literal import loop_closure
from kanefe.literal.loop_closure import project_positions
from linear_scenes import GRAVITY, cart_and_rod, governor
from loop_scenes import four_bar, four_bars
from scenes import lattice_body
from steel_beams import steel_bar

EXACT = 1e-9
"""Newton's method ends at round-off: what is left is that of the forces over the stiffness."""


def test_a_spring_sags_by_its_load():
    scene = kf.System(gravity=GRAVITY)
    scene.add_rigid_body("ball", 2.0, joint=kf.Prismatic("z", forces=kf.CoordinateForce(stiffness=100.0)))
    found = kf.equilibrium(scene)
    assert found.joint_coordinates("ball")[0] == pytest.approx(-2.0 * 9.81 / 100.0, abs=1e-14)
    assert found.coordinates == {"ball: distance [m]": pytest.approx(-0.1962)}
    assert found.joint_reaction("ball") == pytest.approx(np.array((0, 0, 19.62, 0, 0, 0)), abs=1e-12)


def test_chains_settle_from_far_away_and_not_upright():
    """Two rods on ball joints, let go along x, hang; Newton's method by itself finds them upright as often."""
    scene = kf.System(gravity=GRAVITY)
    first = scene.add_rigid_body("first", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Spherical())
    scene.add_rigid_body("second", 1.0, 0.1, com=(0.5, 0, 0), at=(1, 0, 0), parent=first, joint=kf.Spherical())
    found = kf.equilibrium(scene)
    assert found.position("second") == pytest.approx((0, 0, -1), abs=EXACT)
    assert found.linearise().modes().is_stable


def test_a_start_in_balance_stays_though_it_is_unstable():
    scene = kf.System(gravity=GRAVITY)
    scene.add_rigid_body("rod", 1.0, 1 / 12, com=(0, 0, 0.5), joint=kf.Revolute("y"))
    found = kf.equilibrium(scene)
    assert found.state == pytest.approx(0.0)
    modes = found.linearise().modes()
    growth = np.sqrt(1.5 * 9.81)
    assert modes.eigenvalues == pytest.approx([growth, -growth])
    assert modes.grows.tolist() == [True, False]
    assert "unstable" in str(modes)


def test_a_loop_settles_where_its_energy_is_least():
    model = four_bar(speed=0.0).freeze()
    found = kf.equilibrium(model)
    lowest = model.energy(0.0, found.state).gravity
    for angle in np.linspace(-0.5, 0.5, 11):
        q = project_positions(model, 0.0, found.state[:3] + np.array((angle, 0.0, 0.0)))
        assert model.energy(0.0, np.concatenate((q, np.zeros(3)))).gravity >= lowest - 1e-12
    assert lowest < 0.5 * model.energy(0.0, model.initial_state).gravity
    assert found.linearise().modes().is_stable


@pytest.mark.parametrize(("speed", "lean"), [(3.0, 0.0), (6.0, np.arccos(9.81 / 0.5 / 36.0))])
def test_an_arm_on_a_driven_shaft(speed, lean):
    """Below sqrt(g / l) it hangs; above it stands off: cos = g / l W^2. Its frequency has a closed form."""
    found = kf.equilibrium(governor(speed))
    assert abs(found.joint_coordinates("arm")[0]) == pytest.approx(lean, abs=EXACT)
    square = 9.81 / 0.5 - speed**2 if lean == 0.0 else (speed * np.sin(lean)) ** 2
    assert found.linearise().modes().frequencies == pytest.approx([np.sqrt(square) / 2 / np.pi], rel=1e-9)


def test_an_arm_on_a_free_shaft_keeps_its_momentum():
    """As the arm rises the shaft slows down: the frequency has 4 cos^2 m l^2 / J more of its square."""
    speed, inertia = 6.0, 0.01
    found = kf.equilibrium(governor(None), speeds={"shaft": speed})
    cosine = 9.81 / 0.5 / speed**2
    lean = np.arccos(cosine)
    assert abs(found.joint_coordinates("arm")[0]) == pytest.approx(lean, abs=EXACT)
    arm = 0.25
    total = inertia + arm * np.sin(lean) ** 2
    expected = speed * np.sin(lean) * np.sqrt(1 + 4 * cosine**2 * arm / total)
    assert found.linearise().change < 1e-10  # nothing resists the shaft, and it turns: no other scene for that
    modes = found.linearise().modes()
    assert modes.is_rigid.tolist() == [True, False]
    assert modes.frequencies[1] == pytest.approx(expected / 2 / np.pi, rel=1e-8)
    assert kf.equilibrium(governor(None), speeds={"shaft": [speed]}).state == pytest.approx(found.state)


@pytest.mark.parametrize(("guess", "which"), [(1.0, 0), (30.0, 1)])
def test_a_top_precesses_slowly_or_fast(guess, which):
    """Trim: C n P - A P^2 cos = m g l, with n the total spin about its axis; two precessions at one lean."""
    spin, lean, A, C, load = 150.0, 0.4, 0.02 + 0.09, 0.01, 9.81 * 0.3
    scene = kf.System(gravity=GRAVITY)
    turn = scene.add_frame("turn", joint=kf.Revolute("z"))
    tilt = scene.add_frame("tilt", parent=turn, joint=kf.Revolute("x", position=lean))
    scene.add_rigid_body("top", 1.0, (0.02, 0.02, 0.01), com=(0, 0, 0.3), parent=tilt, joint=kf.Revolute("z"))
    speeds = {"top": spin, "tilt": 0.0, "turn": guess}
    found = kf.equilibrium(scene, speeds=speeds, find=["turn"])
    # (C - A) P^2 cos + C spin P - load = 0
    a, b = (C - A) * np.cos(lean), C * spin
    roots = np.sort(np.roots((a, b, -load)))
    precession = found.state[found.model.state_names.index("turn: rate [rad/s]")]
    assert precession == pytest.approx(roots[which], rel=1e-8)
    assert found.joint_coordinates("tilt")[0] == lean


def test_a_flexible_body_that_floats_is_in_balance_anywhere():
    """Nothing holds it, and nothing moves it: six rigid motions are neutral."""
    scene = kf.System()
    body = lattice_body(2, {}, reduction=kf.CraigBampton(modes=6))
    scene.add_flexible_body("body", body, joint=kf.Free(position=-body.center_of_mass))
    still = kf.equilibrium(scene)
    assert still.state[7:13] == pytest.approx(0.0, abs=1e-15)
    assert kf.linearise(still.model).modes().is_rigid.sum() == 6


def test_loads_that_change_are_balanced_at_one_time_only_if_asked():
    scene = kf.System()
    body = scene.add_rigid_body("body", 1.0, joint=kf.Prismatic("x", forces=kf.CoordinateForce(stiffness=10.0)))
    scene.add_force(body, lambda t: (1.0 + t, 0.0, 0.0))
    model = scene.freeze()
    with pytest.raises(SimulationError, match=r"not 0.37 s later.*body: distance.*steady=False"):
        kf.equilibrium(model)
    assert kf.equilibrium(model, t=1.0, steady=False).joint_coordinates("body") == pytest.approx([0.2])


def test_a_drive_that_turns_against_gravity_is_no_steady_state():
    scene = kf.System(gravity=(0, -9.81, 0))
    shaft = scene.add_frame("shaft", joint=kf.Revolute("z", motion=kf.Motion.steady(2.0)))
    spring = kf.CoordinateForce(stiffness=100.0)
    scene.add_rigid_body("flap", 1.0, 0.1, com=(0.3, 0, 0), parent=shaft, joint=kf.Revolute("z", forces=spring))
    with pytest.raises(SimulationError, match="flap: angle"):
        kf.equilibrium(scene)


def falling():
    scene = kf.System(gravity=GRAVITY)
    scene.add_rigid_body("ball", 0.1, 1.0, joint=kf.Free())
    return scene


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: kf.equilibrium(falling()), SimulationError, "0.981 N along ball: z .*nothing holds it.*Remedy"),
        (lambda: kf.equilibrium("scene"), ModelError, "needs a System or a Model"),
        (lambda: kf.equilibrium(governor(2.0), speeds={"shaft": 1.0}), ModelError, "'shaft' has no free speed"),
        (lambda: kf.equilibrium(governor(None), speeds={"shaft": (1, 2)}), ModelError, "must be 1 finite numbers"),
        (lambda: kf.equilibrium(governor(None), speeds={"wheel": 1.0}), ModelError, "no body called 'wheel'"),
        (lambda: kf.equilibrium(governor(None), start=[1.0]), ModelError, "has 4 entries"),
        (lambda: kf.equilibrium(governor(None), start=[0, np.nan, 0, 0]), ModelError, r"arm: angle \[rad\] is nan"),
        (lambda: kf.equilibrium(four_bar(speed=0.0), find=["crank"]), ModelError, "loops at once"),
        (lambda: kf.equilibrium(governor(1.0), t=np.inf), ModelError, "finite"),
    ],
)
def test_what_is_wrong_is_named(call, error, words):
    with pytest.raises(error, match=words):
        call()


def test_what_is_printed_fits_a_screen() -> None:
    """Modal coordinates by their number and their largest, and no arrays of a linearisation."""
    found = kf.equilibrium(steel_bar(0.02, 0.01, gravity=9.81, reduction=kf.CraigBampton(modes=10)))
    lines = str(found).splitlines()
    eta = found.q[found.model.bodies[-1].flexible.eta]
    assert len(lines) == 4
    assert lines[2].startswith(f"  bar: {len(eta)} modal coordinates, the largest eta {np.argmax(abs(eta))}: ")
    assert lines[3].startswith("  bending inside bodies: 'bar' by ")
    small = kf.linearise(cart_and_rod(), outputs=("joint_coordinates rod",))
    shown = "small motions about t = 0 s: 4 states; A, B, C, D are arrays\n  inputs   none named\n  outputs  joint_"
    assert str(small).startswith(shown)


def test_a_search_steps_over_positions_at_which_loops_are_singular():
    """The first step, of 0.3 rad, ends where all bars are in one line; the parallelogram hangs in the end."""
    aside = np.pi / 2 - 0.3
    found = kf.equilibrium(four_bars(1, "one on the other"), start=[aside, -aside, aside, 0.0, 0.0, 0.0])
    assert np.cos(found.q) == pytest.approx(-np.ones(3), abs=1e-9)


@pytest.mark.parametrize("seed", [8, 11, 13, 15, 52])
def test_a_level_bar_on_a_hinge_turns_down(seed: int) -> None:
    """Nothing resists its turn there to first order, and its modes are stiff beyond round-off of that."""
    rng = np.random.default_rng(seed)
    width, height = rng.uniform(0.002, 0.04, 2)
    modes = kf.CraigBampton(modes=int(rng.integers(1, 12)))
    found = kf.equilibrium(steel_bar(width, height, gravity=float(rng.uniform(0.1, 50.0)), reduction=modes))
    assert found.q[0] == pytest.approx(0.5 * np.pi, abs=1e-9)


def test_loops_are_closed_by_compiled_code(monkeypatch: pytest.MonkeyPatch) -> None:
    model, calls = four_bar(speed=0.0).freeze(), list[object]()
    newton = loop_closure.closed
    monkeypatch.setattr(loop_closure, "closed", lambda *given: calls.append(given) or newton(*given))
    found = kf.equilibrium(model)
    assert len(calls) == 1  # of the start; none of the search
    assert project_positions(model, 0.0, found.state[:3]) == pytest.approx(found.state[:3], abs=1e-14)
