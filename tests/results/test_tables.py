"""Channels of a run by text: DataFrames, data sets, comma-separated text and MAT files hold the numbers of `Result`."""

import csv
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

import kanefe as kf
from kanefe.errors import FileError, MissingDependency, ModelError
from result_scenes import four_bar, pendulum, robot

HUB = ("joint_reaction hub", "kinetic_energy", "velocity hub z")
ASKED = ["position arm/tip", "coupling_force arm/root moment_y", *HUB]


def expected(result: kf.Result) -> np.ndarray:
    """Return the columns of `ASKED`, by the methods of `Result`."""
    return np.column_stack(
        (
            result.position("arm", "tip"),
            result.coupling_force("arm", "root")[:, 4],
            result.joint_reaction("hub"),
            result.energy.kinetic,
            result.velocity("hub")[:, 2],
        )
    )


def test_a_frame_has_the_numbers_names_and_units_of_its_channels():
    pytest.importorskip("pandas")
    frame = robot().to_dataframe(ASKED)
    np.testing.assert_array_equal(frame.to_numpy(), expected(robot()))
    np.testing.assert_array_equal(frame.index.to_numpy(), robot().times)
    wrench = [f"joint_reaction hub {name}_{axis}" for name in ("force", "moment") for axis in "xyz"]
    assert list(frame.columns) == [
        *(f"position arm/tip {axis}" for axis in "xyz"),
        "coupling_force arm/root moment_y",
        *wrench,
        "kinetic_energy",
        "velocity hub z",
    ]
    assert frame.index.name == "time"
    assert list(frame.attrs["units"].values()) == ["m"] * 3 + ["N m"] + ["N"] * 3 + ["N m"] * 3 + ["J", "m/s"]


def test_names_of_ones_own():
    pytest.importorskip("pandas")
    frame = robot().to_dataframe({"tip": "position arm/tip", "height": "position arm/tip z"})
    assert list(frame.columns) == ["tip x", "tip y", "tip z", "height"]


def test_without_channels_coordinates_and_speeds_are_given():
    pytest.importorskip("pandas")
    result = robot()
    frame = result.to_dataframe()
    assert set(frame.columns) >= {"joint_coordinates hub", "joint_speeds hub", "modal_coordinates arm 0"}
    assert frame.shape[1] == sum(result.read(q, body).shape[1] for q, body in _coordinates(result))
    assert list(pendulum().to_dataframe().columns) == ["joint_coordinates rod", "joint_speeds rod"]


def _coordinates(result: kf.Result) -> list[tuple[str, str]]:
    joints = [(q, body) for q in ("joint_coordinates", "joint_speeds") for body in result.bodies]
    flexible = [body for body in result.bodies if result.body(body).basis.shape[1]]
    return joints + [(q, body) for q in ("modal_coordinates", "modal_speeds") for body in flexible]


def test_a_data_set_has_units_as_attributes():
    pytest.importorskip("xarray")
    found = robot().to_xarray(ASKED)
    for name, column in zip(found.data_vars, expected(robot()).T, strict=True):
        np.testing.assert_array_equal(found[name].to_numpy(), column)
    assert found["kinetic_energy"].attrs == {"units": "J"}
    assert found["time"].attrs == {"units": "s"}
    assert found["kinetic_energy"].dims == ("time",)


def test_a_data_set_is_saved_and_read_by_xarray(tmp_path: Path):
    """There a "/" in names is refused by netCDF, a folder in zarr that is not read (xarray 2026.9, zarr 3.1.6)."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    asked = {"tip": "position arm/tip", "arm/tip": "velocity arm/tip x", "[load]": "coupling_force arm/root force_x"}
    found = robot().to_xarray(asked)
    assert list(found.data_vars) == ["tip x", "tip y", "tip z", "arm.tip", "v[load]"]
    assert found["arm.tip"].attrs == {"units": "m/s", "long_name": "arm/tip"}
    assert found["v[load]"].attrs["long_name"] == "[load]"
    assert "long_name" not in found["tip x"].attrs
    for name in ("position arm.tip x", "kinetic_energy"):
        assert name in robot().to_xarray(ASKED)
    found.to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as read:
        xarray.testing.assert_identical(read.load(), found)
    with pytest.raises(ModelError, match=r"'a/b' and 'a.b' have the same name in netCDF, 'a.b'"):
        robot().to_xarray({"a/b": "kinetic_energy", "a.b": "elastic_energy"})


def test_text_keeps_all_digits(tmp_path: Path):
    path = robot().to_csv(tmp_path / "new" / "run.csv", ASKED)
    rows = list(csv.reader(path.read_text().splitlines()))
    assert rows[0][:2] == ["time [s]", "position arm/tip x [m]"]
    values = np.array(rows[1:], dtype=float)
    np.testing.assert_array_equal(values[:, 0], robot().times)
    np.testing.assert_array_equal(values[:, 1:], expected(robot()))


def test_a_mat_file_has_a_matrix_for_each_channel(tmp_path: Path):
    path = robot().to_matlab(tmp_path / "run.mat", {"tip": "position arm/tip", "hub_load": "joint_reaction hub"})
    found = loadmat(path, simplify_cells=True)
    np.testing.assert_array_equal(found["time"], robot().times)
    np.testing.assert_array_equal(found["tip"], robot().position("arm", "tip"))
    np.testing.assert_array_equal(found["hub_load"], robot().joint_reaction("hub"))
    assert list(found["columns"]["tip"]) == ["tip x", "tip y", "tip z"]
    assert list(found["units"]["hub_load"]) == ["N"] * 3 + ["N m"] * 3


def test_tables_of_a_file_equal_those_of_its_run(tmp_path: Path):
    pytest.importorskip("pandas")
    robot().save(tmp_path / "run.h5")
    loaded = kf.load_result(tmp_path / "run.h5")
    np.testing.assert_array_equal(loaded.to_dataframe(ASKED).to_numpy(), robot().to_dataframe(ASKED).to_numpy())


def test_loops_are_channels():
    pytest.importorskip("pandas")
    frame = four_bar().to_dataframe("loop_force pin force_x")
    np.testing.assert_array_equal(frame["loop_force pin force_x"], four_bar().loop_force("pin")[:, 0])


@pytest.mark.parametrize(
    ("channels", "message"),
    [
        ("positon hub", "there is no 'positon'. Did you mean 'position'"),
        ("position hob", "no body called 'hob'. It has: hub, arm"),
        ("position arm/end", "has no interface called 'end'|no interface 'end'"),
        ("position hub w", "there is no component 'w'. There are: x, y, z"),
        ("kinetic_energy hub", "'hub'"),
        ("coupling_force arm", "interface"),
        (["position hub", "position hub x"], "'position hub x' is given twice"),
        ([3], "must be"),
    ],
)
def test_a_channel_that_is_not_there_is_named(channels, message):
    with pytest.raises(ModelError, match=message):
        robot().to_csv("never.csv", channels)
    assert not Path("never.csv").exists()


def test_files_that_cannot_be(tmp_path: Path):
    with pytest.raises(ModelError, match=r"ends in \.csv"):
        pendulum().to_csv(tmp_path / "run.txt")
    with pytest.raises(ModelError, match=r"ends in \.mat"):
        pendulum().to_matlab(tmp_path / "run")
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError):
        pendulum().to_csv(tmp_path / "file" / "run.csv")
    with pytest.raises(ModelError, match="'2nd' would be '2nd' in MATLAB"):
        pendulum().to_matlab(tmp_path / "run.mat", {"2nd": "position rod"})
    for word in ("end", "for", "until"):  # GNU Octave 7.3 loads them without a word, and each use is a parse error
        with pytest.raises(ModelError, match="a keyword or no name"):
            pendulum().to_matlab(tmp_path / "run.mat", {word: "position rod"})
    with pytest.raises(ModelError, match="is taken, too long"):
        pendulum().to_matlab(tmp_path / "run.mat", {"a b": "position rod", "a-b": "velocity rod"})
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_pandas_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    monkeypatch.delitem(sys.modules, "kanefe.storage._pandas", raising=False)
    with pytest.raises(MissingDependency, match=r"pip install 'kanefe\[study\]'"):
        pendulum().to_dataframe()
