"""Results in files: a round trip is exact, and no failure leaves half a file."""

import builtins
import dataclasses
import errno
import os
import tempfile
from pathlib import Path
from typing import ClassVar

import h5py
import numpy as np
import pytest

import kanefe as kf
from disk_faults import full_disk
from kanefe.results import file as result_file
from kanefe.tree.neighbours import Neighbours
from result_scenes import pendulum, robot, turntable


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    path = tmp_path / "run.h5"
    robot().save(path)
    return path


@pytest.mark.parametrize("run", [pendulum, turntable, robot])
def test_a_loaded_result_tells_the_same(run, tmp_path):
    result = run()
    result.save(tmp_path / "out" / "run.h5")
    loaded = kf.load_result(tmp_path / "out" / "run.h5")
    assert loaded.bodies == result.bodies
    assert loaded.statistics == result.statistics
    np.testing.assert_array_equal(loaded.times, result.times)
    shapes = [result.body(name) for name in result.bodies]
    keys = result_file._saved(shapes, result, forces=True)
    assert len(keys) > 10
    for quantity, body, interface in keys:
        ours, theirs = (r.read(quantity, body, interface or None) for r in (result, loaded))
        np.testing.assert_array_equal(theirs, ours, err_msg=f"{quantity} {body} {interface}")
        if body:
            assert loaded.units(quantity, body) == result.units(quantity, body)
    np.testing.assert_array_equal(loaded.energy.balance_error, result.energy.balance_error)


def test_a_loaded_result_has_mesh_and_views(saved, tmp_path):
    loaded, result = kf.load_result(saved), robot()
    np.testing.assert_array_equal(loaded.nodal_positions("arm"), result.nodal_positions("arm"))
    cells = [(block.kind, block.nodes.tolist()) for block in result.body("arm").cells]
    assert [(block.kind, block.nodes.tolist()) for block in loaded.body("arm").cells] == cells
    assert loaded.body("arm").provenance["reduction"]["method"] == "CraigBampton(modes=1)"
    loaded.plot(path=tmp_path / "overview.png")
    loaded.to_vtk(tmp_path / "run.pvd", every=20)
    with pytest.raises(kf.ModelError, match=r"'leg'.*hub, arm, tip"):
        loaded.position("leg")


def test_a_loaded_result_can_be_saved_again(saved, tmp_path):
    kf.load_result(saved).save(tmp_path / "again.h5")
    np.testing.assert_array_equal(
        kf.load_result(tmp_path / "again.h5").coupling_force("arm", "root"), robot().coupling_force("arm", "root")
    )


def test_without_forces_they_are_missed_by_name(tmp_path):
    robot().save(tmp_path / "small.h5", forces=False)
    loaded = kf.load_result(tmp_path / "small.h5")
    np.testing.assert_array_equal(loaded.position("tip"), robot().position("tip"))
    with pytest.raises(kf.ModelError, match=r"coupling_force of 'arm' at 'root' was not saved in .*forces=True"):
        loaded.coupling_force("arm", "root")
    loaded.plot(path=tmp_path / "overview.png")  # says so in the diagram
    loaded.save(tmp_path / "again.h5")
    assert not kf.load_result(tmp_path / "again.h5").has_forces


def test_every_dataset_carries_its_unit(saved):
    units = {}

    def collect(name: str, item: h5py.HLObject) -> None:
        if isinstance(item, h5py.Dataset):
            units[name] = item.attrs["unit"]

    with h5py.File(saved, "r") as file:
        file.visititems(collect)
        assert file.attrs["format"] == "kanefe result"
    assert units["times"] == "s"
    assert units["bodies/arm/interfaces/root/coupling_force"] == "N, N m"
    assert units["bodies/hub/joint_coordinates"] == "rad"
    assert all(isinstance(unit, str) and unit for unit in units.values())


def test_names_of_any_group_and_a_long_provenance_survive(tmp_path):
    result = robot()
    shape = dataclasses.replace(
        result.body("arm"), provenance={"log": "x" * 100_000, "count": np.int64(3), "sizes": np.arange(2)}
    )

    class Renamed:
        times, statistics, has_forces, loops, loads, surfaces = result.times, result.statistics, True, (), {}, ()
        status, events = result.status, {"floor": np.array([0.5])}
        controllers: ClassVar[dict[str, object]] = {}
        neighbours: ClassVar[dict[str, Neighbours]] = {"a/b": Neighbours((".",), ("c/d",)), "..": Neighbours((), ())}
        bodies = (dataclasses.replace(shape, name="50 % öl & <b>", interfaces=("a/b", ".."), neighbours=neighbours),)

        def read(self, quantity: str, body: str = "", interface: str = "", of: str = "") -> np.ndarray:
            name = {"a/b": "root", "..": "tip"}.get(interface, "")
            values = result._channels.read(quantity, "arm" if body else "", name)
            return {"": 1.0, ".": 3.0, "c/d": -2.0}[of] * values

    renamed = kf.Result.from_channels(Renamed())
    renamed.save(tmp_path / "run.h5")
    loaded = kf.load_result(tmp_path / "run.h5")
    (name,) = loaded.bodies
    assert loaded.interfaces(name) == ("a/b", "..")
    np.testing.assert_array_equal(loaded.coupling_force(name, "a/b"), result.coupling_force("arm", "root"))
    assert loaded.neighbours(name, "a/b") == renamed.neighbours(name, "a/b")
    for of, share in ((".", 3.0), ("c/d", -2.0), ("F_u", 3.0), ("F_k", -2.0)):
        force = loaded.coupling_force(name, "a/b", of)
        np.testing.assert_array_equal(force, share * result.coupling_force("arm", "root"))
    np.testing.assert_array_equal(loaded.position(name, ".."), result.position("arm", "tip"))
    assert loaded.body(name).provenance == {"log": "x" * 100_000, "count": 3, "sizes": [0, 1]}


def test_a_full_disk_leaves_the_old_file(saved, monkeypatch):
    before = saved.read_bytes()

    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(kf.FileError, match=r"run.h5: No space left.*untouched.*Remedy"):
        pendulum().save(saved)
    assert saved.read_bytes() == before
    assert [p.name for p in saved.parent.iterdir()] == ["run.h5"]


def test_a_folder_that_cannot_be_written_is_named(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(kf.FileError, match=r"cannot write .*run.h5.*Remedy"):
        pendulum().save(tmp_path / "file" / "run.h5")

    def denied(**_: object) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(tempfile, "mkstemp", denied)
    with pytest.raises(kf.FileError, match=r"run.h5: Permission denied.*Remedy"):
        pendulum().save(tmp_path / "run.h5")


def test_bad_files_are_named(saved, tmp_path):
    with pytest.raises(kf.FileError, match=r"no file .*none.h5"):
        kf.load_result(tmp_path / "none.h5")
    with pytest.raises(kf.FileError, match=r"is a folder\. Remedy: the file in it"):
        kf.load_result(tmp_path)
    whole = saved.read_bytes()
    for share in (0.0, 0.01, 0.5, 0.99):
        (tmp_path / "cut.h5").write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(kf.FileError, match=r"cut.h5 is truncated or is no HDF5 file"):
            kf.load_result(tmp_path / "cut.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["a"] = 1.0
    with pytest.raises(kf.FileError, match=r"other.h5 is no saved result"):
        kf.load_result(tmp_path / "other.h5")
    with h5py.File(saved, "r+") as file:
        file.attrs["version"] = 99
    with pytest.raises(kf.FileError, match=r"version 99.*reads version 7"):
        kf.load_result(saved)


def test_a_name_of_another_format_is_refused(tmp_path):
    with pytest.raises(kf.ModelError, match=r"save writes HDF5, and 'run.xyz' ends otherwise. Remedy: .*\.h5"):
        pendulum().save(tmp_path / "run.xyz")
    assert list(tmp_path.iterdir()) == []


def test_rows_that_do_not_match_the_times_are_named(saved):
    with h5py.File(saved, "r+") as file:
        times = file["times"][:-2]
        del file["times"]
        file["times"] = times
    with pytest.raises(kf.FileError, match=r"run.h5 lacks parts .* rows for"):
        kf.load_result(saved)


def test_an_array_that_the_file_does_not_hold_is_not_made(saved):
    with h5py.File(saved, "r+") as file:
        file.create_dataset("bodies/huge", shape=(10**12,), chunks=(10**4,), dtype=float)
    with pytest.raises(kf.FileError, match=r"bodies/huge claims 8e\+12 bytes, which the file does not hold"):
        kf.load_result(saved)


def test_a_file_that_lacks_a_mesh_is_named(saved):
    with h5py.File(saved, "r+") as file:
        del file["bodies/arm/mesh/cells_0"]
    with pytest.raises(kf.FileError, match=r"run.h5 lacks parts"):
        kf.load_result(saved)


@pytest.mark.parametrize(
    ("problem", "error", "message"),
    [
        (ImportError("h5py"), kf.MissingDependency, r"Result.save needs h5py.*pip install"),
        (ValueError("Not a datatype"), kf.FileError, r"Result.save: h5py does not start.*import h5py at its head"),
    ],
)
def test_without_h5py_the_remedy_is_named(monkeypatch, tmp_path, problem, error, message):
    real = builtins.__import__

    def missing(name: str, *rest: object, **named: object) -> object:
        if name == "h5py":
            raise problem
        return real(name, *rest, **named)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(error, match=message):
        pendulum().save(tmp_path / "run.h5")
    assert list(tmp_path.iterdir()) == []
