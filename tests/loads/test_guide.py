"""Guides: the law against virtual power, a moving load against its closed form, routes, ends of the line."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline
from scipy.optimize import minimize_scalar

import kanefe as kf
from kanefe.checks.verification.references import load_references
from kanefe.kernels.force_elements.guide import GuideNumbers, place_in
from kanefe.loads.action import End
from kanefe_fem import Material, Rectangle, beam_body, exact_beam, segmented, straight_beam
from kanefe_fem.verification import moving_force

LENGTH, SPEED, MASS, STIFFNESS, ELEMENTS = 12.0, 6.0, 200.0, 1e6, 24
NONE = np.zeros(0)


@pytest.fixture(scope="module")
def girder() -> kf.FlexibleBody:
    steel = Material(E=210e9, nu=0.3, rho=7850.0)
    model = straight_beam(
        LENGTH, Rectangle(0.1, 0.2), steel, elements=ELEMENTS, theory="euler-bernoulli", rotary_inertia=False
    )
    held = {"root": kf.Interface(fixed=("x", "y", "z", "rx")), "tip": kf.Interface(fixed=("y", "z"))}
    return beam_body(model, held, kf.CraigBampton(modes=40))


def crossing(girder: kf.FlexibleBody, at: float = 0.0, is_driven: bool = False) -> kf.System:
    """A trolley that slides along a girder under its weight, freely or driven."""
    scene = kf.System(gravity=(0, 0, -9.81))
    body = scene.add_flexible_body("girder", girder, gravity=False)
    start = kf.Translation(position=(at, 0, 0), velocity=(SPEED, 0, 0))
    if is_driven:
        start = kf.Translation(motion=(kf.Motion.steady(SPEED), None, None))
    trolley = scene.add_point("trolley", MASS, joint=start)
    line = [body.node(i) for i in range(ELEMENTS + 1)]
    scene.add(kf.Guide("rail", (trolley, *line), stiffness=STIFFNESS))
    return scene


def test_forces_are_the_gradient_of_the_energy_over_the_nearest_distance() -> None:
    rng = np.random.default_rng(2)
    count, k = 9, 50.0
    p = np.column_stack((np.arange(count), 0.2 * rng.normal(size=(count, 2))))
    at = np.array((3.3, 0.2, -0.1))
    guide = kf.Guide("g", tuple("abcdefghij"), stiffness=k, stations=np.arange(count))

    def ends(x: np.ndarray) -> list[End]:
        return [End(place, np.eye(3), np.zeros(3), np.zeros(3)) for place in x.reshape(-1, 3)]

    def stored(x: np.ndarray) -> float:
        line, place = make_interp_spline(np.arange(count), x[3:].reshape(-1, 3), k=5), x[:3]
        gap = lambda s: float(np.sum((line(s) - place) ** 2))  # noqa: E731
        found = minimize_scalar(gap, bounds=(2.0, 4.5), method="bounded", options={"xatol": 1e-10})
        return 0.5 * k * found.fun

    x = np.concatenate((at, p.ravel()))
    done = guide.action(0.0, ends(x), NONE)
    assert done.potential == pytest.approx(stored(x), rel=1e-10)
    step = 1e-5
    slope = [(stored(x + step * e) - stored(x - step * e)) / (2 * step) for e in np.eye(len(x))]
    # differences of second order: 1e-10 of the third derivative, and round-off 1e-15 / 1e-5
    np.testing.assert_allclose(done.wrenches[:, :3].ravel(), -np.array(slope), atol=1e-7)
    np.testing.assert_allclose(done.wrenches[:, :3].sum(axis=0), 0.0, atol=1e-12)


def test_a_trolley_that_crosses_a_girder_keeps_the_energy_and_its_force_does_not_jump(
    girder: kf.FlexibleBody,
) -> None:
    end = 0.95 * LENGTH / SPEED
    result = crossing(girder).simulate((0.0, end), rtol=1e-9, output_step=end / 400)
    energy = result.energy.total
    assert np.ptp(energy) < 1e-7 * energy[0]  # rtol, and interpolation between steps
    assert abs(result.load("rail", "arc length")[-1] - 0.95 * LENGTH) < 0.05
    # without jumps over 24 gaps: the largest third difference over 400 times is that of its bouncing at 70 rad/s,
    # m g (70 h)^3 with h = 4.75e-3 s
    assert np.abs(np.diff(result.load("rail", "force"), 3)).max() < 3.0 * MASS * 9.81 * (70.0 * end / 400) ** 3


def test_both_routes_agree(girder: kf.FlexibleBody) -> None:
    model = crossing(girder, at=3.0).freeze()
    rng = np.random.default_rng(1)
    for _ in range(5):
        y = 1e-3 * rng.normal(size=model.coordinate_count + model.free_count)
        np.testing.assert_allclose(
            model.route.evaluate(0.0, y).rates, model.literal.evaluate(0.0, y).rates, rtol=1e-10, atol=1e-8
        )


def test_a_trolley_moves_as_by_the_modal_equations_of_a_moving_mass(girder: kf.FlexibleBody) -> None:
    """The modal equations of a simply supported beam under a sprung mass at constant speed, by scipy."""
    end, n = 0.9 * LENGTH / SPEED, np.arange(1, 25)
    EI, rho_A = 210e9 * 0.1 * 0.2**3 / 12, 7850.0 * 0.02
    omega = (n * np.pi / LENGTH) ** 2 * np.sqrt(EI / rho_A)

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        shape = np.sin(n * np.pi * SPEED * t / LENGTH)
        press = STIFFNESS * (shape @ y[:24] - y[48])
        ddw = -(omega**2) * y[:24] - shape * press / (0.5 * rho_A * LENGTH)
        return np.concatenate((y[24:48], ddw, (y[49], press / MASS - 9.81)))

    own = solve_ivp(rates, (0.0, end), np.zeros(50), method="DOP853", rtol=1e-7, atol=1e-10, t_eval=(end / 2, end))
    result = crossing(girder, is_driven=True).simulate((0.0, end), rtol=1e-7, output_step=end / 2)
    sag = result.position("trolley")[1:, 2]
    # some 13 modes across of 24 elements against 24 sines, and what slopes of 1e-3 change
    np.testing.assert_allclose(sag, own.y[48], atol=2e-3 * np.abs(own.y[48]).max())


def test_a_stiffer_guide_comes_to_the_rigid_one_as_one_over_its_stiffness_in_few_more_steps() -> None:
    """Against the series of a force that crosses the beam: see case C07, whose runner leaves the beam by P / k."""
    values = load_references()["C07"].values
    beam, times = moving_force.simply_supported(values), np.linspace(0.0, 0.95 * LENGTH / 12.0, 51)
    under = moving_force.sags(values, times, 12.0 * times)
    found = [moving_force.crossing(beam, values, stiffness) for stiffness in (1e5, 1e7, 1e9)]
    gaps = [np.abs(result.position("runner")[:, 1] - under).max() for result in found]
    # to 1e-6 m of the time steps
    np.testing.assert_allclose(gaps, values["force"] / np.array((1e5, 1e7, 1e9)), atol=1e-6)
    steps = [result.statistics["steps"] for result in found]
    assert steps[-1] < 3.0 * steps[0]


def test_a_run_fails_where_the_line_ends(girder: kf.FlexibleBody) -> None:
    scene = crossing(girder, at=11.0)
    with pytest.warns(kf.SimulationWarning, match=r"guide 'rail' ends under its runner.*end, at .* 12 m, at t = 0\.16"):
        scene.simulate((0.0, 1.0))


@pytest.mark.parametrize(("at", "message"), [((13.0, 0, 0), "from 0 to 12 m"), ((6.0, 0, 2.0), "2 m off its line")])
def test_a_start_off_the_line_is_refused(girder: kf.FlexibleBody, at: tuple[float, ...], message: str) -> None:
    scene = kf.System()
    body = scene.add_flexible_body("girder", girder)
    trolley = scene.add_point("trolley", MASS, joint=kf.Translation(position=at))
    scene.add(kf.Guide("rail", (trolley, *(body.node(i) for i in range(ELEMENTS + 1))), stiffness=STIFFNESS))
    with pytest.raises(kf.ModelError, match=message):
        scene.simulate((0.0, 0.1))


def test_a_trolley_crosses_from_segment_to_segment_and_an_exact_beam_bends_alike() -> None:
    model = straight_beam(4.0, Rectangle(0.1, 0.1), Material(E=210e9, nu=0.3, rho=7850.0), elements=12)
    exact = exact_beam(4.0, Rectangle(0.1, 0.1), Material(E=210e9, nu=0.3, rho=7850.0), basis=4)
    sag = []
    for body in (segmented(model, {"root": "clamped", "tip": "rigid"}, segments=4), exact):
        scene = kf.System(gravity=(0, 0, -9.81))
        add = scene.add_flexible_body if body is exact else scene.add_segmented_body
        jib = add("jib", body, gravity=False)
        trolley = scene.add_point("trolley", MASS, joint=kf.Translation(velocity=(4.0, 0, 0)))
        nodes = range(0, len(body.nodes), 2 if body is exact else 1)
        scene.add(kf.Guide("rail", (trolley, *(jib.node(i) for i in nodes)), stiffness=1e6))
        result = scene.simulate((0.0, 0.9), rtol=1e-8, output_step=0.3)
        assert np.ptp(result.energy.total) < 1e-6 * np.ptp(result.energy.kinetic)
        sag.append(result.position("trolley")[-1, 2])
    assert sag[0] == pytest.approx(sag[1], rel=2e-2)  # 4 segments: (1/4)^2 of a tip that turns by 1e-2, and bouncing


def bead_near(posts: np.ndarray, place: np.ndarray, **options: float) -> kf.System:
    scene = kf.System()
    bead = scene.add_point("bead", 1.0, joint=kf.Translation(position=tuple(place)))
    line = [scene.ground.frame(at=tuple(p)) for p in posts]
    scene.add(kf.Guide("wire", (bead, *line), stiffness=100.0, **options))
    return scene


def test_the_foot_is_the_nearest_of_all_points_of_a_line_that_is_strongly_bent() -> None:
    """Of drawn lines and places the distance is that of a fine search along the same polynomial."""
    rng, found = np.random.default_rng(4), []
    while len(found) < 60:
        count = int(rng.integers(3, 6))
        posts = np.cumsum(rng.uniform((0.2, -0.8, -0.3), (0.7, 0.8, 0.3), (count, 3)), axis=0)
        gaps = np.linalg.norm(np.diff(posts, axis=0), axis=1)
        stations = np.append(0.0, np.cumsum(gaps))
        s = np.linspace(0.0, stations[-1], 20001)
        line = np.vander(s, count) @ np.linalg.solve(np.vander(stations), posts)
        place = line[rng.integers(len(line))] + rng.uniform(-0.5, 0.5, 3) * gaps.min() / np.sqrt(3.0)
        distances = np.linalg.norm(line - place, axis=1)
        if not 0 < distances.argmin() < len(s) - 1 or distances.min() > 0.45 * gaps.min():
            continue
        guide = kf.Guide("wire", tuple(range(count + 1)), stiffness=100.0, stations=stations)
        ends = [End(p, np.eye(3), np.zeros(3), np.zeros(3)) for p in (place, *posts)]
        found.append(float(guide.tell(0.0, ends, NONE)[1] - distances.min()))
    assert np.abs(found).max() < 1e-6


def test_beside_the_centre_of_curvature_the_search_ends_and_forces_are_derivatives() -> None:
    """The places of 50 steps round in a circle; the run keeps the energy over the nearest distance."""
    posts = np.array([(0.0, 0.0, 0.0), (0.7, -0.7, 0.0), (0.9, -0.3, 0.0)])
    result = bead_near(posts, np.array((0.59, -0.56, 0.0))).simulate((0.0, 0.1), rtol=1e-9)
    assert np.linalg.norm(result.acceleration("bead")[0]) == pytest.approx(17.1147, abs=1e-3)
    assert abs(result.energy.balance_error).max() < 1e-7


def test_states_that_overflow_end_the_run_with_a_message() -> None:
    scene = kf.System(gravity=(0, 0, -9.81))
    bead = scene.add_point("bead", 1.0, joint=kf.Translation(position=(0.3, 0, 0), velocity=(0.1, 0, 0)))
    posts = [scene.ground.frame(at=(x, 0, 0)) for x in (0.0, 0.5, 1.0)]
    scene.add(kf.Guide("wire", (bead, *posts), stiffness=1e4, drag=1e308))
    with pytest.warns(kf.SimulationWarning, match="the run failed at t = "):
        scene.simulate((0.0, 0.05), method="dop853")


@pytest.mark.parametrize("s", [np.nan, np.inf, -np.inf, 1e300])
def test_no_arc_length_leads_out_of_the_table(s: float) -> None:
    guide = kf.Guide("g", tuple("abcdefg"), stiffness=1.0, stations=np.arange(6.0))
    line = GuideNumbers(guide.kernel.numbers).line
    first = place_in(line, s)[0]
    assert 0 <= first
    assert first + 6 * 6 <= len(line.table)  # six powers of six weights
