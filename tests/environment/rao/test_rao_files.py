"""Motions in waves from files: every format and convention gives the same ship; what contradicts itself is not read."""

from __future__ import annotations

import importlib
import itertools
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.environment.rao.rao_checks import surface_motion
from kanefe.errors import AccuracyWarning, FileError, MissingDependency, ModelError
from ship_motions import (
    FREQUENCIES,
    HEADINGS,
    OURS,
    ROLL,
    ROLL_RATIO,
    capytaine_dataset,
    motions,
    table,
    write_table,
    write_veres,
    write_wamit,
)

CONVENTIONS = [
    dict(zip(OURS, (*choice, "cg"), strict=True))
    for choice in itertools.product(
        ("exp(+iwt)", "exp(-iwt)"),
        ("head", "following"),
        ("port", "starboard"),
        ("forward", "aft"),
        ("port", "starboard"),
        ("up", "down"),
        ("rad/m", "deg/slope"),
    )
    if sum(ours != other for ours, other in zip(("forward", "port", "up"), choice[3:6], strict=True)) % 2 == 0
]


def assert_same_ship(rao: kf.MotionRao) -> None:
    """Compare with the formula, on both sides; files have twelve digits."""
    for heading in (0.0, 60.0, 90.0, 150.0, 180.0, 210.0, 270.0, 330.0, -30.0, 390.0):
        found = rao.at(FREQUENCIES, heading, 0.0)
        np.testing.assert_allclose(found, motions(FREQUENCIES, heading), rtol=0, atol=1e-11)
    assert rao.is_symmetric


def test_veres(tmp_path: Path) -> None:
    rao = kf.read_rao(write_veres(tmp_path / "ship.re1"))
    assert_same_ship(rao)
    assert rao.speeds.tolist() == [0.0, 5.0, 10.0]
    assert "1.5 m from Lpp/2" in rao.reference
    np.testing.assert_allclose(rao.at(FREQUENCIES, 60.0, 5.0), motions(FREQUENCIES, 60.0, 5.0), rtol=0, atol=1e-11)


def test_wamit(tmp_path: Path) -> None:
    path = write_wamit(tmp_path / "ship.4")
    assert_same_ship(kf.read_rao(path, length=50.0))
    path.write_text("PER BETA I MOD PHA RE IM\n" + path.read_text())
    assert_same_ship(kf.read_rao(path, length=50.0))
    with pytest.raises(ModelError, match="ULEN, which the file does not give"):
        kf.read_rao(path)
    with pytest.raises(ModelError, match=r"0.02 times the slope.*unit slope, not height"):
        kf.read_rao(path, length=2500.0)


def test_generalised_modes_of_wamit_are_left_out_and_told(tmp_path: Path) -> None:
    """As barge.4 of WEC-Sim's applications has them."""
    path, rows = write_wamit(tmp_path / "barge.4"), []
    for row in path.read_text().splitlines():
        rows.append(row)
        fields = row.split()
        if fields[2] == "6":
            rows += [" ".join((*fields[:2], str(mode), *fields[3:])) for mode in (7, 8)]
    path.write_text("\n".join(rows) + "\n")
    with pytest.warns(AccuracyWarning, match=r"barge\.4: motions 7 to 8, generalised modes .* are left out"):
        assert_same_ship(kf.read_rao(path, length=50.0))


def test_capytaine(tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    dataset = capytaine_dataset()
    assert_same_ship(kf.read_rao(dataset))
    joined = dataset["RAO"].sel(complex="re") + 1j * dataset["RAO"].sel(complex="im")
    assert_same_ship(kf.read_rao(joined.drop_vars("complex", errors="ignore").to_dataset(name="RAO")))
    assert_same_ship(kf.read_rao(dataset.expand_dims(forward_speed=[0.0])))
    pytest.importorskip("h5netcdf")
    dataset.to_netcdf(tmp_path / "ship.nc", engine="h5netcdf")
    assert_same_ship(kf.read_rao(tmp_path / "ship.nc"))
    more = dataset["RAO"].isel(radiating_dof=[0]).assign_coords(radiating_dof=["bending"])
    whole = importlib.import_module("xarray").concat((dataset["RAO"], more), "radiating_dof")
    with pytest.warns(AccuracyWarning, match="motions bending, generalised modes, are left out"):
        assert_same_ship(kf.read_rao(whole.to_dataset(name="RAO")))
    with pytest.raises(FileError, match=r'has no RAO. Remedy: dataset\["RAO"\]'):
        kf.read_rao(dataset.drop_vars("RAO"))
    with pytest.raises(FileError, match="motions yaw are missing"):
        kf.read_rao(dataset.isel(radiating_dof=slice(5)))
    with pytest.raises(ModelError, match="several water_depth"):
        kf.read_rao(dataset.drop_vars("water_depth").expand_dims(water_depth=[10.0, 20.0]))
    (tmp_path / "bad.nc").write_bytes(b"no netcdf")
    with pytest.raises(FileError, match="truncated or not a netCDF-4"):
        kf.read_rao(tmp_path / "bad.nc")


def test_netcdf_needs_xarray(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(FileError, match="there is no file"):
        kf.read_rao(tmp_path / "none.nc")
    monkeypatch.setitem(sys.modules, "xarray", None)
    (tmp_path / "ship.nc").write_bytes(b"")
    with pytest.raises(MissingDependency, match=r"pip install 'kanefe\[sea\]'"):
        kf.read_rao(tmp_path / "ship.nc")


@pytest.mark.parametrize("said", CONVENTIONS, ids=lambda said: " ".join(said.values()))
def test_tables_in_all_conventions(tmp_path: Path, said: dict[str, str]) -> None:
    assert_same_ship(kf.read_rao(write_table(tmp_path / "ship.csv", said, polar=said["time"] == "exp(-iwt)")))


@pytest.mark.parametrize(
    ("wrong", "cause"),
    [
        ({"time": "exp(-iwt)"}, "time goes as exp"),
        ({"heading_zero": "following"}, "x points the other way, or heading 0 is following"),
        ({"heading_90": "starboard"}, "y points the other way, or heading 90 is from the other side"),
        ({"x": "aft", "y": "starboard"}, "time goes as exp"),
        ({"x": "aft", "z": "down"}, "z points the other way"),
        ({"rotations": "deg/m"}, "0.0179 times the slope|0.0175 times the slope"),
        ({"rotations": "rad/slope"}, "unit slope, not height"),
        # turned over, of whatever size: what the sign says is told first
        ({"rotations": "deg/m", "time": "exp(-iwt)"}, "roll in long waves is opposed.*time goes as exp"),
    ],
    ids=lambda wrong: " ".join(wrong.values()) if isinstance(wrong, dict) else "",
)
def test_a_convention_that_is_declared_wrong_is_found(tmp_path: Path, wrong: dict[str, str], cause: str) -> None:
    path = write_table(tmp_path / "ship.csv", declared={**OURS, **wrong})
    with pytest.raises(ModelError, match=f"long waves.*({cause})"):
        kf.read_rao(path)


def test_degrees_that_are_said_to_be_radians_are_found(tmp_path: Path) -> None:
    path = write_table(tmp_path / "ship.csv", {**OURS, "rotations": "deg/m"}, declared=OURS)
    with pytest.raises(ModelError, match="rotations are in degrees"):
        kf.read_rao(path)


def test_columns_of_a_table_that_are_not_used_are_told(tmp_path: Path) -> None:
    path = write_table(tmp_path / "ship.csv")
    rows = path.read_text().splitlines()
    head = next(i for i, row in enumerate(rows) if not row.startswith("#"))
    more = [f"{row},encounter" if i == head else f"{row},0.5" if i > head else row for i, row in enumerate(rows)]
    path.write_text("\n".join(more) + "\n")
    with pytest.warns(AccuracyWarning, match=r"ship\.csv: columns encounter, .* are left out"):
        assert_same_ship(kf.read_rao(path))
    path.write_text("\n".join(more).replace("encounter", "heave_re") + "\n")
    with pytest.raises(FileError, match="has two columns 'heave_re'"):
        kf.read_rao(path)


def test_a_convention_must_be_declared(tmp_path: Path) -> None:
    declared = {name: value for name, value in OURS.items() if name not in ("time", "reference")}
    path = write_table(tmp_path / "ship.csv", declared=declared)
    with pytest.raises(ModelError, match="time, reference of the convention are not declared"):
        kf.read_rao(path)
    assert_same_ship(kf.read_rao(path, convention={"time": "exp(+iwt)", "reference": "cg"}))
    assert_same_ship(kf.read_rao(path, convention=kf.RaoConvention(**OURS)))
    with pytest.raises(ModelError, match="left-handed"):
        kf.RaoConvention(**{**OURS, "x": "aft"})
    with pytest.raises(ModelError, match="z of an RAO's convention is one of up, down"):
        kf.RaoConvention(**{**OURS, "z": "high"})
    with pytest.raises(ModelError, match="the point whose motions"):
        kf.RaoConvention(**{**OURS, "reference": " "})


def test_short_waves_cannot_tell_and_it_is_said(tmp_path: Path) -> None:
    path = tmp_path / "ship.csv"
    lines = write_table(path).read_text().splitlines()
    head = len(OURS) + 1
    kept = [line for line in lines[head:] if float(line.split(",")[1]) > 0.9]
    path.write_text("\n".join([*lines[:head], *kept]))
    with pytest.warns(AccuracyWarning, match="too short to check axes"):
        kf.read_rao(path)


def test_a_wave_that_is_told_elsewhere() -> None:
    rao = kf.MotionRao(FREQUENCIES, HEADINGS, np.zeros(1), table())
    there = (12.0, -5.0)
    # seen from the bow-ward point, a head sea's wave is told earlier by k x
    moved = rao.with_wave_at(*there)
    k = FREQUENCIES**2 / 9.81
    np.testing.assert_allclose(moved.values[0, 0], rao.values[0, 0] * np.exp(12j * k)[:, None], atol=1e-14)
    np.testing.assert_allclose(moved.values[0, 3], rao.values[0, 3] * np.exp(-5j * k)[:, None], atol=1e-14)
    with pytest.raises(ModelError, match=r"wave_at .* must be finite numbers"):
        kf.read_rao("none.re1", wave_at=(1.0, 2.0, 3.0))


@pytest.mark.parametrize("heading", [0.0, 35.0, 90.0, 180.0, 250.0])
def test_a_raft_stays_normal_to_the_surface_of_long_waves(heading: float) -> None:
    # what a deck feels across it, of its accelerations and of gravity, vanishes
    k = 0.001
    x = surface_motion(heading, k)
    omega_squared = 9.81 * k
    assert abs(-omega_squared * x[1] + 9.81 * x[3]) < 1e-15
    assert abs(-omega_squared * x[0] - 9.81 * x[4]) < 1e-15


def test_interpolation_is_of_real_and_imaginary_parts() -> None:
    rao = kf.MotionRao(FREQUENCIES, HEADINGS, np.array((0.0, 4.0)), table((0.0, 4.0)))
    omega = 0.5 * (FREQUENCIES[3] + FREQUENCIES[4])
    wanted = np.mean(
        [
            motions(FREQUENCIES[i], heading, speed)[0]
            for i in (3, 4)
            for heading in (30.0, 60.0)
            for speed in (0.0, 4.0)
        ],
        axis=0,
    )
    np.testing.assert_allclose(rao.at(np.array([omega]), 45.0, 2.0)[0], wanted, rtol=1e-13)


def test_nothing_is_extrapolated() -> None:
    rao = kf.MotionRao(FREQUENCIES, HEADINGS, np.array((2.0, 4.0)), table((2.0, 4.0)), "ship")
    one = np.ones(1)
    for wrong, said in (
        ((3.2 * one, 0.0, 3.0), "known for wave frequency 0.08 to 3 rad/s and was asked for 3.2"),
        ((0.05 * one, 0.0, 3.0), "was asked for 0.05 rad/s"),
        ((one, 0.0, 5.0), "known for speed 2 to 4 m/s and was asked for 5 m/s"),
        ((one, 0.0, 0.0), "was asked for 0 m/s"),
    ):
        with pytest.raises(ModelError, match=said):
            rao.at(*wrong)
    still = kf.MotionRao(FREQUENCIES, HEADINGS, np.zeros(1), table(), "ship")
    with pytest.raises(ModelError, match="of 0 m/s alone, not of 3 m/s"):
        still.at(one, 0.0, 3.0)
    bow = kf.MotionRao(FREQUENCIES, HEADINGS[1:4], np.zeros(1), table(headings=HEADINGS[1:4]), "ship", symmetric=True)
    np.testing.assert_allclose(bow.at(FREQUENCIES, 285.0, 0.0), bow.at(FREQUENCIES, 75.0, 0.0) * (1, -1, 1, -1, 1, -1))
    for heading in (0.0, 10.0, 100.0, 180.0, 340.0):
        with pytest.raises(ModelError, match="has headings of 30 to 90 degrees and was asked for"):
            bow.at(one, heading, 0.0)
    assert not kf.MotionRao(FREQUENCIES, HEADINGS[1:4], np.zeros(1), table(headings=HEADINGS[1:4])).is_symmetric


def test_asymmetric_ships_are_not_mirrored() -> None:
    values = table()
    values[0, 0, :, 3] = 0.2 * values[0, 3, :, 3]  # it rolls in head seas
    rao = kf.MotionRao(FREQUENCIES, HEADINGS, np.zeros(1), values, "ferry")
    assert not rao.is_symmetric
    rao.at(FREQUENCIES, 90.0, 0.0)
    with pytest.raises(
        ModelError, match="ferry has headings of 0 to 180 degrees and was asked for 270: the ship is not symmetric"
    ):
        rao.at(FREQUENCIES, 270.0, 0.0)
    round_ = np.arange(0.0, 360.0, 30.0)
    values = table(headings=round_)
    values[0, 3, :, 3] *= 2.0
    values[0, 0, :, 3] = values[0, 3, :, 3]
    whole = kf.MotionRao(FREQUENCIES, round_, np.zeros(1), values)
    assert not whole.is_symmetric
    np.testing.assert_allclose(
        whole.at(FREQUENCIES, 345.0, 0.0), 0.5 * (values[0, -1] + values[0, 0]), rtol=1e-12, atol=1e-15
    )


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"frequencies": FREQUENCIES[::-1]}, "frequencies of an RAO must be finite numbers that increase"),
        ({"frequencies": FREQUENCIES - 0.08}, "two frequencies above zero"),
        ({"headings_deg": HEADINGS - 30.0}, "headings 0 to 360"),
        ({"speeds": np.array([-1.0])}, "speeds of an RAO are zero or above"),
        ({"values": table()[:, :2]}, "must be of shape"),
        ({"values": np.where(np.arange(6) == 3, np.nan, table())}, "roll at 0.08 rad/s and heading 0 is not a finite"),
    ],
)
def test_arrays_that_are_no_rao_are_refused(change: dict[str, Any], said: str) -> None:
    given = {"frequencies": FREQUENCIES, "headings_deg": HEADINGS, "speeds": np.zeros(1), "values": table()}
    with pytest.raises(ModelError, match=said):
        kf.MotionRao(**{**given, **change})


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("ship.re1", lambda text: text[: len(text) // 2], "ends in line|numbers were expected"),
        ("ship.re1", lambda text: text.replace("1025.0", "much"), "numbers were expected"),
        ("ship.re1", lambda text: text.replace(" 16 6\n", " 16 3\n"), "3 motions: no file"),
        ("ship.re1", lambda text: text.replace("\n2 ", "\n4 ", 1), "motion 2 was expected"),
        ("ship.re1", lambda text: "", "is empty or not text"),
        ("ship.4", lambda text: "\n".join(text.splitlines()[:-2]), "motions 1 to 6 of each"),
        ("ship.4", lambda text: "\n".join(text.splitlines()[:-6]), "are missing. Remedy: one row for each"),
        ("ship.4", lambda text: text + "\n".join(text.splitlines()[-6:]), "are given twice"),
        ("ship.csv", lambda text: text.replace("yaw_re", "yo_re"), "has no columns yaw_re and yaw_im"),
        ("ship.csv", lambda text: text.replace("heading,", "course,"), "Remedy: heading, and one of omega"),
        ("ship.csv", lambda text: text.replace("0.08", "zero", 1), "row 1 is no 14 numbers"),
        ("ship.csv", lambda text: text.replace(",0.08,", ",-0.08,"), "omega must be above zero"),
        ("ship.csv", lambda text: "# depth: deep\n" + text, "the depth must be a number"),
        ("ship.csv", lambda text: text[: text.index("heading,")] + "heading,omega", "no rows"),
    ],
)
def test_files_that_are_not_whole_are_refused(tmp_path: Path, name: str, change: Any, said: str) -> None:
    path = tmp_path / name
    write = {".re1": write_veres, ".4": write_wamit, ".csv": write_table}[path.suffix]
    path.write_text(change(write(path).read_text()))
    with pytest.raises(FileError, match=said):
        kf.read_rao(path, **({"length": 50.0} if path.suffix == ".4" else {}))


def test_what_is_no_file_of_motions_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="there is no file"):
        kf.read_rao(tmp_path / "none.re1")
    with pytest.raises(FileError, match="end in "):
        kf.read_rao(tmp_path / "ship.doc")
    with pytest.raises(ModelError, match=r"length cannot be given for .* states its convention itself"):
        kf.read_rao(write_veres(tmp_path / "ship.re1"), length=3.0)


def test_roll_is_damped_as_one_degree_of_freedom_is() -> None:
    from kanefe.environment.rao.roll_damping import roll_resonance
    from kanefe.environment.ship import damped

    fine = np.linspace(0.1, 1.2, 111)
    rao = kf.MotionRao(fine, HEADINGS, np.zeros(1), motions(fine, HEADINGS[:, None])[None])
    assert roll_resonance(rao) == pytest.approx((ROLL, ROLL_RATIO), rel=1e-9)
    found = damped(rao, kf.RollDamping(0.15), 9.81)
    wanted = ROLL**2 / (ROLL**2 - fine**2 + 2j * 0.15 * ROLL * fine) * 1j * fine**2 / 9.81
    np.testing.assert_allclose(found.values[0, 3, :, 3], wanted, rtol=1e-8)
    np.testing.assert_array_equal(found.values[..., :3], rao.values[..., :3])
    given = kf.RollDamping(0.15, frequency=ROLL, ratio_of_rao=ROLL_RATIO)
    np.testing.assert_allclose(damped(rao, given, 9.81).values, found.values, rtol=1e-8)
    above = kf.MotionRao(fine[60:], HEADINGS, np.zeros(1), rao.values[:, :, 60:])
    with pytest.raises(ModelError, match="no peak within its frequencies"):
        roll_resonance(above)
    with pytest.raises(ModelError, match="ratio of a RollDamping"):
        kf.RollDamping(0.0)
