"""Ships in seas: statistics against closed forms and records, deck motions by both routes, and what is refused."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import trapezoid

import kanefe as kf
from joint_scenes import assert_routes_agree
from kanefe.environment.deck_motion import turned
from kanefe.environment.harmonics import Ramp
from kanefe.environment.rao.rao_checks import surface_motion
from kanefe.environment.rao.roll_damping import roll_resonance
from kanefe.errors import AccuracyWarning, ModelError
from kanefe.frames import rotation_matrix
from kanefe.kernels.links.deck_motion import deck_motion
from ship_motions import FREQUENCIES, HEADINGS, motions, table, write_veres

SEA = kf.Sea.bretschneider(3.0, 9.0, seed=7, duration=300.0, frequency_range=(0.3, 2.0))
SPREADING = kf.Sea.bretschneider(3.0, 9.0, spreading=2, seed=7, duration=300.0, frequency_range=(0.3, 2.0))
FINE = np.linspace(0.1, 2.2, 211)
RAO = kf.MotionRao(
    FINE, HEADINGS, np.array((0.0, 8.0)), motions(FINE, HEADINGS[:, None], np.array((0.0, 8.0))[:, None, None])
)


BOW = kf.MotionRao(FREQUENCIES, HEADINGS[:4], np.zeros(1), table(headings=HEADINGS[:4]))


def ship(sea: kf.Sea = SEA, speed: float = 0.0, heading: float = 90.0, **more: Any) -> kf.Ship:
    return kf.Ship(RAO, sea, speed, heading, slowest_hz=more.pop("slowest_hz", 0.0), **more)


def test_a_raft_on_the_surface_has_its_variance() -> None:
    values = np.array([[surface_motion(heading, 1.0) for _ in FINE] for heading in HEADINGS])[None]
    values[..., 3:] *= (FINE**2 / 9.81)[:, None]
    raft = kf.Ship(kf.MotionRao(FINE, HEADINGS, np.zeros(1), values), SEA, 0.0, 60.0, 0.0)
    found = raft.motions_std()
    spectrum = SEA.spectrum
    heave = np.sqrt(spectrum.moment(0, FINE[0], FINE[-1]))
    assert found["heave"] == pytest.approx(heave, rel=1e-9)
    assert found["sway"] == pytest.approx(heave * np.sin(np.pi / 3.0), rel=1e-9)
    # the slope k is a parabola, straight between points a hundredth apart
    slope = np.sqrt(spectrum.moment(4, FINE[0], FINE[-1])) / 9.81
    assert found["roll"] == pytest.approx(slope * np.sin(np.pi / 3.0), rel=1e-4)
    spread = kf.Ship(raft.rao, SPREADING, 0.0, 0.0, 0.0).motions_std()
    # of cos^2, the mean of sin^2 is a quarter; headings are 30 degrees apart, straight between: chords of 2 %
    assert spread["sway"] == pytest.approx(0.5 * heave, rel=0.03)
    assert spread["heave"] == pytest.approx(heave, rel=1e-9)


@pytest.mark.parametrize("heading", [0.0, 60.0, 90.0, 135.0, 240.0])
@pytest.mark.parametrize("speed", [0.0, 6.0])
def test_a_record_has_the_variance_of_the_integral(speed: float, heading: float) -> None:
    one = ship(speed=speed, heading=heading)
    # cut as the record is, which has steps of frequency in place of the integral
    omega = np.linspace(*SEA.range, 4001)
    wanted = np.sqrt(trapezoid(one.response_spectra(omega), omega, axis=0))
    amplitudes = np.sqrt(0.5 * np.sum(abs(one.harmonics.amplitudes) ** 2, axis=0))
    np.testing.assert_allclose(amplitudes, wanted, rtol=0.02, atol=1e-6)
    found = one.motions(np.arange(0.0, 3000.0, 0.5))
    # over many periods of all differences of encounter but the least
    np.testing.assert_allclose(found[:, 0].std(axis=0), wanted, rtol=0.15, atol=1e-6)
    whole = one.motions_std()
    assert all(whole[name] >= 0.99 * value for name, value in zip(whole, wanted, strict=True))


def test_rates_are_those_of_the_motions() -> None:
    one = ship(SPREADING, 5.0, 140.0)
    times, h = np.linspace(3.0, 200.0, 31), 1e-4
    here, back, ahead = (one.motions(times + d) for d in (0.0, -h, h))
    for k in (0, 1):
        # differences of the second order
        np.testing.assert_allclose((ahead[:, k] - back[:, k]) / (2 * h), here[:, k + 1], rtol=0, atol=1e-7)


def test_the_wave_below_the_ship_is_that_of_the_sea() -> None:
    values = np.zeros((1, len(HEADINGS), len(FINE), 6), dtype=complex)
    values[..., 2] = 1.0
    cork = kf.MotionRao(FINE, HEADINGS, np.zeros(1), values, symmetric=True)
    times = np.linspace(0.0, 100.0, 51)
    for heading in (0.0, 70.0):
        found = kf.Ship(cork, SPREADING, 0.0, heading).motions(times)[:, 0, 2]
        np.testing.assert_allclose(found, SPREADING.elevation(times), rtol=0, atol=1e-12)
    # in head seas a moving one meets the waves where it is
    ahead = kf.Ship(kf.MotionRao(FINE, HEADINGS, np.array((5.0,)), values, symmetric=True), SPREADING, 5.0, 0.0)
    wanted = [SPREADING.elevation([t], -5.0 * t)[0] for t in times]
    np.testing.assert_allclose(ahead.motions(times)[:, 0, 2], wanted, rtol=0, atol=1e-12)
    aside = kf.Ship(kf.MotionRao(FINE, HEADINGS, np.array((5.0,)), values, symmetric=True), SPREADING, 5.0, 90.0)
    # with waves from port, the bow points to the left of where they go
    wanted = [SPREADING.elevation([t], 0.0, 5.0 * t)[0] for t in times]
    np.testing.assert_allclose(aside.motions(times)[:, 0, 2], wanted, rtol=0, atol=1e-12)


def test_turns_have_the_rates_of_matrices() -> None:
    a, h = np.array((0.4, -0.3, 0.9)), 1e-5
    d, dd = np.array((0.5, -0.8, 0.3)), np.array((-0.2, 0.7, 0.4))

    def at(t: float) -> Any:
        return turned(a + d * t + 0.5 * dd * t * t, d + dd * t, dd)

    axes, w, dw = at(0.0)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    rate = (at(h)[0] - at(-h)[0]) / (2 * h)
    spin = axes.T @ rate
    # differences of the second order
    np.testing.assert_allclose((spin[2, 1], spin[0, 2], spin[1, 0]), w, atol=1e-9)
    np.testing.assert_allclose((at(h)[1] - at(-h)[1]) / (2 * h), dw, atol=1e-9)
    yawed, pitched, rolled = (
        rotation_matrix(kf.rotation_about(axis, a[k])) for axis, k in (("z", 2), ("y", 1), ("x", 0))
    )
    np.testing.assert_allclose(axes, yawed @ pitched @ rolled, atol=1e-15)


@pytest.mark.parametrize("rotations", ["exact", "small"])
@pytest.mark.parametrize(
    ("sea", "speed", "heading"), [(SEA, 0.0, 90.0), (SPREADING, 8.0, 20.0), (SPREADING, 6.0, 170.0)]
)
def test_compiled_pieces_are_the_sums_of_cosines(sea: kf.Sea, speed: float, heading: float, rotations: str) -> None:
    deck = ship(sea, speed, heading).at((-45.0, 3.0, 6.0), ramp=20.0, start=2.0, rotations=rotations)
    numbers = deck.kernel().numbers
    for t in (0.0, 2.0, 7.3, 22.0, 22.1, 100.0, 299.99, 321.9, 322.0):
        out, wanted = np.zeros(24), deck.at(t)
        deck_motion(numbers, np.array([t]), out)
        axes = wanted.axes
        pairs = (
            (out[:3], wanted.position),
            (out[3:12], axes.ravel()),
            (out[12:15], wanted.velocity),
            (out[15:18], axes @ wanted.angular_velocity),
            (out[18:21], wanted.acceleration),
            (out[21:], axes @ wanted.angular_acceleration),
        )
        for found, same in pairs:
            # m and rad; what the polynomials leave out is 1e-13 of the amplitudes, and 45 m have an ulp of 7e-15
            np.testing.assert_allclose(found, same, rtol=0, atol=1e-12)


def test_a_deck_point_has_the_spectrum_of_its_own_rao() -> None:
    point = np.array((-45.0, 3.0, 6.0))
    one = ship(SEA, 8.0, 60.0)
    response = RAO.at(SEA.waves.frequency, 60.0, 8.0)
    x, y, z, roll, pitch, yaw = response.T
    rao = np.column_stack((x + pitch * 6.0 - yaw * 3.0, y + yaw * -45.0 - roll * 6.0, z + roll * 3.0 - pitch * -45.0))
    waves = SEA.waves.amplitude * np.exp(1j * SEA.waves.phase)
    deck, exact = (one.at(point, ramp=0.0, rotations=how) for how in ("small", "exact"))
    for t in (1.0, 50.0):
        turning = waves * np.exp(1j * one.harmonics.frequencies * t)
        wanted = (rao * turning[:, None]).real.sum(axis=0)
        np.testing.assert_allclose(deck.at(t).position - point, wanted, rtol=0, atol=1e-12)
        np.testing.assert_allclose(exact.at(t).position - point, wanted, rtol=0, atol=0.1)  # 45 m times angles squared
        np.testing.assert_allclose(exact.at(t).axes, deck.at(t).axes, rtol=0, atol=0)
    omega = np.linspace(FINE[0], FINE[-1], 20001)
    x, y, z, roll, pitch, yaw = RAO.at(omega, 60.0, 8.0).T
    density = SEA.spectrum.density(omega)
    variance = trapezoid(abs(z + roll * 3.0 + pitch * 45.0) ** 2 * density, omega)
    assert one.motions_std(point)["heave"] == pytest.approx(np.sqrt(variance), rel=1e-4)
    assert one.motions_std(point)["heave"] != pytest.approx(one.motions_std()["heave"], rel=0.1)


def scene_on(deck: Any) -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    frame = scene.add_frame("deck", joint=kf.Free(motion=deck))
    scene.add_rigid_body(
        "arm", 2.0, (0.1, 0.2, 0.3), com=(0.3, 0.1, 0), parent=frame, joint=kf.Revolute("y", position=0.4)
    )
    return scene


@pytest.mark.parametrize("rotations", ["exact", "small"])
def test_both_routes_know_the_same_deck(rotations: str) -> None:
    deck = ship(SPREADING, 6.0, 60.0).at((-45.0, 3.0, 6.0), rotations=rotations)
    for t in (0.0, 17.0, 123.4):
        assert_routes_agree(scene_on(deck).freeze(), t)


def test_a_deck_carries_a_scene_and_its_power_is_in_the_balance() -> None:
    deck = ship(SPREADING, 6.0, 60.0).at((-45.0, 3.0, 6.0))
    result = scene_on(deck).simulate((0.0, 60.0), rtol=1e-9, output_step=0.5)
    assert result.statistics["route"] == "order n"
    energy = result.energy
    # some hundred steps, each to the tolerance
    assert abs(energy.balance_error).max() < 1e-6 * abs(energy.work).max()
    assert abs(energy.work).max() > 1.0
    np.testing.assert_allclose(result.position("deck")[0], (-45.0, 3.0, 6.0), atol=1e-12)  # at rest, before the ramp


def test_beyond_its_duration_a_deck_is_not_known() -> None:
    deck = ship().at((-45.0, 3.0, 6.0), duration=20.5)
    named = r"is given from 0 to 20.5 s and was asked for at t = 2[0-9.]* s.*duration=\.\.\. of Ship.at"
    # before it begins: the run would have come to 20.5 s
    for run in (kf.System.simulate, kf.screen):
        with pytest.raises(kf.ModelError, match="motion of body 'deck' " + named):
            run(scene_on(deck), (0.0, 20.8))
    with pytest.raises(kf.ModelError, match="motion of a deck " + named):
        deck.at(25.0)
    assert scene_on(deck).simulate((0.0, 20.5)).times[-1] == 20.5
    late = kf.Event("late", lambda t, state: t - 3.0, terminal=True)
    assert scene_on(deck).simulate((0.0, 100.0), events=[late]).times[-1] == pytest.approx(3.0)


def test_a_ship_is_no_motion_but_its_points_have_one() -> None:
    with pytest.raises(kf.ModelError, match=r"not of type Ship\. Remedy: .*ship\.at\(point\)") as told:
        kf.Free(motion=ship())  # type: ignore[arg-type]
    assert len(str(told.value)) < 300


def test_decks_are_data(tmp_path: Path) -> None:
    deck = ship().at((1.0, 2.0, 3.0))
    same = pickle.loads(pickle.dumps(deck))
    assert all(np.array_equal(a, b) for a, b in zip(same.at(40.0), deck.at(40.0), strict=True))


def test_pieces_are_made_once_and_only_as_short_as_needed() -> None:
    slow = kf.Sea.bretschneider(3.0, 14.0, duration=100.0, frequency_range=(0.3, 1.2))
    deck = ship(slow).at((0.0, 0.0, 6.0))
    assert "pieces" not in vars(deck)
    assert deck.kernel() is deck.kernel()
    assert np.diff(deck.edges)[0] == 1.0
    assert np.diff(ship(SEA, 8.0, 0.0).at((0.0, 0.0, 6.0)).edges)[0] < 1.0


def test_the_ramp_leads_in_smoothly() -> None:
    ramp, h = Ramp(2.0, 10.0), 1e-5
    for t in (3.0, 7.0, 11.5):
        _, dr, ddr = ramp.at(t)
        assert (ramp.at(t + h)[0] - ramp.at(t - h)[0]) / (2 * h) == pytest.approx(dr, abs=1e-9)
        assert (ramp.at(t + h)[1] - ramp.at(t - h)[1]) / (2 * h) == pytest.approx(ddr, abs=1e-9)
    assert ramp.at(7.0)[0] == pytest.approx(0.5)
    for t, wanted in ((1.0, (0.0, 0.0, 0.0)), (2.0, (0.0, 0.0, 0.0)), (12.0, (1.0, 0.0, 0.0))):
        assert ramp.at(t) == wanted
    assert Ramp(0.0, 0.0).at(0.0) == (1.0, 0.0, 0.0)


def test_a_record_of_twenty_hertz_takes_the_place_of_a_ship() -> None:
    one = ship(SPREADING, 6.0, 60.0)
    times = np.arange(0.0, 40.0, 0.05)
    record = one.motions(times)[:, 0]
    table = kf.PoseTable(times, record[:, :3], [kf.euler_angles("ZYX", angles[::-1]) for angles in record[:, 3:]])
    deck = one.at((0.0, 0.0, 0.0), ramp=0.0)
    for t in (5.02, 21.137):
        found, wanted = table.at(t), deck.at(t)
        # a cubic spline: the fourth power of 3 rad/s times 0.05 s, accelerations the second
        np.testing.assert_allclose(found.position, wanted.position, rtol=0, atol=1e-5)
        np.testing.assert_allclose(found.axes, wanted.axes, rtol=0, atol=1e-5)
        np.testing.assert_allclose(found.acceleration, wanted.acceleration, rtol=0, atol=0.02)


def test_another_depth_is_told() -> None:
    shallow = kf.Sea.bretschneider(3.0, 9.0, depth=12.0, duration=100.0, frequency_range=(0.3, 2.0))
    with pytest.warns(AccuracyWarning, match="is for water of inf m depth, the sea is 12 m deep"):
        kf.Ship(RAO, shallow, 0.0, 90.0, 0.0)


def test_slow_motions_in_the_plane_are_left_out_and_told() -> None:
    with pytest.warns(AccuracyWarning, match=r"slower than 0.03 Hz are left out, with this share .*: surge \d"):
        following = kf.Ship(RAO, SEA, 8.0, 180.0)
    whole = ship(speed=8.0, heading=180.0)
    slow = abs(whole.harmonics.frequencies) < 2.0 * np.pi * 0.03
    assert 0 < slow.sum() < len(slow)
    assert not np.any(following.harmonics.amplitudes[np.ix_(slow, (0, 1, 5))])
    np.testing.assert_array_equal(following.harmonics.amplitudes[:, 2:5], whole.harmonics.amplitudes[:, 2:5])
    np.testing.assert_array_equal(following.harmonics.amplitudes[~slow], whole.harmonics.amplitudes[~slow])
    share = 1.0 - (following.motions_std()["surge"] / whole.motions_std()["surge"]) ** 2
    assert following.left_out["surge"] == pytest.approx(share, rel=1e-9)
    assert following.left_out["surge"] > 0.01


def test_roll_damping_is_a_parameter() -> None:
    calm = kf.Ship.from_rao(RAO, sea=SEA, heading_deg=90.0, roll_damping=0.3, slowest_hz=0.0)
    assert calm.motions_std()["roll"] < 0.7 * ship().motions_std()["roll"]
    same = kf.Ship.from_rao(RAO, sea=SEA, heading_deg=90.0, roll_damping=kf.RollDamping(0.3, 0.5, 0.06), slowest_hz=0.0)
    assert same.motions_std() == pytest.approx(calm.motions_std(), rel=1e-6)


def test_a_ship_of_a_file(tmp_path: Path) -> None:
    path = write_veres(tmp_path / "ship.re1")
    found = kf.Ship.from_rao(str(path), sea=SEA, speed=5.0, heading_deg=300.0)
    wanted = motions(FREQUENCIES[9], 300.0, 5.0)[0]
    np.testing.assert_allclose(found.rao.at(FREQUENCIES[9:10], 300.0, 5.0)[0], wanted, rtol=0, atol=1e-11)
    assert "ship.re1 at 5 m/s, heading 300" in str(found)
    with pytest.raises(ModelError, match="symmetric are options for a file"):
        kf.Ship.from_rao(found.rao, sea=SEA, symmetric=True)


def test_the_example_ship_is_what_its_file_says() -> None:
    rao = kf.example_rao()
    assert rao.is_symmetric
    assert "amidships" in rao.reference
    assert roll_resonance(rao) == pytest.approx((0.56, 0.08), rel=0.02)
    for number in (3, 4, 5, 6, 7):  # its frequencies reach as far as all sea states do
        assert kf.Ship(rao, kf.Sea.state(number, spreading=2), 0.0, 60.0, 0.0).motions_std()["roll"] > 0.0


def test_the_picture_shows_amplitudes_and_phases(tmp_path: Path) -> None:
    figure = ship().plot_rao(tmp_path / "rao.svg")
    assert (tmp_path / "rao.svg").stat().st_size > 1000
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles[:3] == ["surge: amplitude", "surge: phase before the crest", "sway: amplitude"]
    # the roll of beam seas, told per slope
    (line,) = [line for line in figure.axes[6].get_lines() if line.get_label() == "90"]
    np.testing.assert_allclose(line.get_ydata(), abs(motions(FINE, 90.0)[:, 3]) / (FINE**2 / 9.81), rtol=1e-9)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: ship(kf.Sea.bretschneider(0.1, 2.0)), r"even its peak, Tp = 2 s, is outside.*keeps \S+ %"),
        (lambda: ship(kf.Sea.bretschneider(1.0, 6.0)), r"is known from 0.1 to 2.2. Remedy:.*frequency_range=\(0.314"),
        (lambda: ship(speed=9.0), "known for speed 0 to 8 m/s and was asked for 9"),
        (lambda: ship(speed=-1.0), "speed of a ship must be a finite number, 0 or above, not -1"),
        (lambda: ship(heading=np.nan), "heading_deg of a ship must be a finite number"),
        (lambda: ship(speed="5"), "speed of a ship must be a finite number"),
        (lambda: ship().at((0, 0, 0), start="now"), "start of a ship's motion"),
        (lambda: ship().at((0, 0, 0), duration=True), "duration of a ship's motion must be a finite number"),
        (lambda: kf.RollDamping("much"), "ratio of a RollDamping must be a finite number above 0"),
        (lambda: kf.Ship(RAO, "sea"), "sea of a ship must be a Sea"),
        (lambda: kf.Ship("s175.re1", SEA), "rao of a ship must be a MotionRao"),
        (lambda: ship().at((1.0, 2.0)), "a point of a ship"),
        (lambda: ship().at((0, 0, 0), duration=-1.0), "duration of a ship's motion must be after 0 s"),
        (lambda: ship().at((0, 0, 0), ramp=-1.0), "the ramp of a ship's motion must be a finite number, 0 or above"),
        (lambda: ship().at((0, 0, 0), rotations="linear"), 'are "exact" or "small"'),
        (lambda: kf.Ship(BOW, SPREADING, 0.0, 60.0), "has headings of 0 to 90 degrees"),
    ],
)
def test_what_a_ship_does_not_know_is_refused(make: Any, said: str) -> None:
    with pytest.raises(ModelError, match=said):
        make()
