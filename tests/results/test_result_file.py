"""Results in files: a round trip is exact, and no failure leaves half a file."""

import builtins
import contextlib
import dataclasses
import errno
import hashlib
import json
import math
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ClassVar

import h5py
import numpy as np
import pytest

import kanefe as kf
from disk_faults import full_disk
from kanefe.results.channel_tables import saved_keys
from kanefe.storage import hdf5
from kanefe.tree.neighbours import Neighbours
from result_scenes import pendulum, robot, turntable


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    path = tmp_path / "run.h5"
    robot().save(path)
    return path


@contextlib.contextmanager
def changed(path: Path) -> Iterator[h5py.File]:
    """Have a file to change, with a digest of what it is afterwards: as a writer that means to deceive would."""
    with h5py.File(path, "r+") as file:
        yield file
    content = path.read_bytes()[hdf5.HEAD :]
    path.write_bytes(hdf5._head(hashlib.sha256(content).hexdigest()) + content)


@pytest.mark.parametrize("run", [pendulum, turntable, robot])
def test_a_loaded_result_tells_the_same(run, tmp_path):
    result = run()
    result.save(tmp_path / "out" / "run.h5")
    loaded = kf.load_result(tmp_path / "out" / "run.h5")
    assert loaded.bodies == result.bodies
    assert loaded.statistics == result.statistics
    np.testing.assert_array_equal(loaded.times, result.times)
    shapes = [result.body(name) for name in result.bodies]
    keys = saved_keys(shapes, result, forces=True)
    assert len(keys) > 10
    for quantity, body, interface, part in keys:
        ours, theirs = (r.read(quantity, body, interface or None, part or None) for r in (result, loaded))
        np.testing.assert_array_equal(theirs, ours, err_msg=f"{quantity} {body} {interface} {part}")
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
    assert units["channels/coupling_force"] == "N, N m"
    assert units["channels/joint_coordinates"] == "by column"  # the hub turns, the arm and the tip have none
    assert all(isinstance(unit, str) and unit for unit in units.values())


def test_other_programs_find_a_channel_by_the_columns_of_its_table(saved):
    result = robot()
    with h5py.File(saved) as file:
        columns, first = json.loads(file.attrs["channels"])["coupling_force"], 0
        for column in columns:
            end = first + math.prod(column["shape"])
            if (column["name"], column["interface"], column["part"]) == ("arm", "tip", ""):
                found = file["channels/coupling_force"][:, first:end]
                assert column["unit"] == "N, N m"
            first = end
        assert first == file["channels/coupling_force"].shape[1]
    np.testing.assert_array_equal(found, result.coupling_force("arm", "tip"))


def test_a_file_has_as_many_arrays_of_many_bodies_as_of_few(tmp_path):
    def arrays(count: int) -> int:
        scene = kf.System(gravity=(0, 0, -9.81))
        for i in range(count):
            scene.add_point(f"ball {i}", 1.0, joint=kf.Prismatic("z"))
        scene.simulate((0.0, 0.1)).save(tmp_path / "run.h5")
        with h5py.File(tmp_path / "run.h5") as file:
            names: list[str] = []
            file.visit(names.append)
        return len(names)

    assert arrays(8) == arrays(1)


def test_names_of_any_group_and_a_long_provenance_survive(tmp_path):
    result = robot()
    shape = dataclasses.replace(
        result.body("arm"), provenance={"log": "x" * 100_000, "count": np.int64(3), "sizes": np.arange(2)}
    )

    class Renamed:
        times, statistics, has_forces, loops, loads, surfaces = result.times, result.statistics, True, (), {}, ()
        gears: ClassVar[dict[str, tuple[str, ...]]] = {}
        points: ClassVar[dict[str, int]] = {}
        records: ClassVar[dict[str, object]] = {}
        status, events = result.status, {"floor": np.array([0.5])}
        controllers: ClassVar[dict[str, object]] = {}
        neighbours: ClassVar[dict[str, Neighbours]] = {"a/b": Neighbours((".",), ("c/d",)), "..": Neighbours((), ())}
        bodies = (dataclasses.replace(shape, name="50 % öl & <b>", interfaces=("a/b", ".."), neighbours=neighbours),)

        def load_lines(self, rows: np.ndarray) -> tuple[()]:
            return ()

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
        with pytest.raises(kf.FileError, match=r"cut.h5 is truncated or not an HDF5 file"):
            kf.load_result(tmp_path / "cut.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["a"] = 1.0
    with pytest.raises(kf.FileError, match=r"other.h5 is .*not an HDF5 file of this kanefe: it has no digest"):
        kf.load_result(tmp_path / "other.h5")
    with changed(saved) as file:
        file.attrs["version"] = 99
    with pytest.raises(kf.FileError, match=r"version 99.*reads version 14"):
        kf.load_result(saved)


def test_a_name_of_another_format_is_refused(tmp_path):
    with pytest.raises(kf.ModelError, match=r"save writes HDF5, and 'run.xyz' ends otherwise. Remedy: .*\.h5"):
        pendulum().save(tmp_path / "run.xyz")
    assert list(tmp_path.iterdir()) == []


def test_rows_that_do_not_match_the_times_are_named(saved):
    with changed(saved) as file:
        times = file["times"][:-2]
        del file["times"]
        file["times"] = times
    with pytest.raises(kf.FileError, match=r"run.h5 lacks parts .* should have .* for each of 39 times"):
        kf.load_result(saved)


def test_a_line_without_a_point_for_each_time_is_named(tmp_path):
    scene = kf.System()
    scene.add_spring("string", scene.ground, scene.add_point("ball", 1.0, at=(1, 0, 0)), stiffness=1.0)
    scene.simulate((0.0, 0.1)).save(tmp_path / "run.h5")
    with changed(tmp_path / "run.h5") as file:
        points = file["lines/0/points"][:-2]
        del file["lines/0/points"]
        file["lines/0/points"] = points
    with pytest.raises(kf.FileError, match=r"run.h5 lacks parts .*line of 'string' has not a row"):
        kf.load_result(tmp_path / "run.h5")


def test_an_array_that_the_file_does_not_hold_is_not_made(saved):
    with changed(saved) as file:
        file.create_dataset("bodies/huge", shape=(10**12,), chunks=(10**4,), dtype=float)
    with pytest.raises(kf.FileError, match=r"bodies/huge claims 8e\+12 bytes, which the file does not hold"):
        kf.load_result(saved)


def test_a_file_that_lacks_a_mesh_is_named(saved):
    with changed(saved) as file:
        del file["bodies/arm/mesh/cells_0"]
    with pytest.raises(kf.FileError, match=r"run.h5 lacks parts"):
        kf.load_result(saved)


def test_no_bit_can_flip_unseen(saved: Path, tmp_path: Path) -> None:
    """Wherever it is: in numbers, in names, in what HDF5 keeps of itself, in the digest."""
    whole, rng = saved.read_bytes(), np.random.default_rng(0)
    damaged = tmp_path / "damaged.h5"
    places = [*rng.integers(len(whole), size=250), *range(0, hdf5.HEAD, 37), len(whole) - 1]
    for place in places:
        content = bytearray(whole)
        content[place] ^= 1 << int(rng.integers(8))
        damaged.write_bytes(content)
        with pytest.raises(kf.FileError, match=r"damaged.h5 is truncated or .*Remedy"):
            kf.load_result(damaged)


def test_other_programs_see_damage_by_the_checksums_of_hdf5(saved: Path) -> None:
    with h5py.File(saved) as file:
        assert file["times"].fletcher32
        kept = file["bodies/arm/mesh/nodes"].id.read_direct_chunk((0, 0))[1]  # its offset is told in two ways
    content = bytearray(saved.read_bytes())
    content[content.index(kept) + 3] ^= 1
    saved.write_bytes(content)
    with h5py.File(saved) as file, pytest.raises(OSError, match=r"checksum|filter"):
        file["bodies/arm/mesh/nodes"][()]


POSITION = "channels/position"


def put(make: Callable[[h5py.File, Any], Any]) -> Callable[[h5py.File], None]:
    """Return what replaces the positions of a body by something that is made of them."""

    def change(file: h5py.File) -> None:
        array = file[POSITION][()]
        del file[POSITION]
        file[POSITION] = make(file, array)

    return change


def elsewhere(file: h5py.File) -> None:
    count = len(file["times"])
    del file[POSITION]
    file.create_dataset(POSITION, (count, 3), "f8", external=[("other.bin", 0, h5py.h5f.UNLIMITED)])


def virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout((len(file["times"]), 3), "f8")
    layout[:] = h5py.VirtualSource("other.h5", "x", shape=layout.shape)
    del file[POSITION]
    file.create_virtual_dataset(POSITION, layout)


def times(make: Callable[[np.ndarray], np.ndarray]) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        file["times"][...] = make(file["times"][()])

    return change


def attribute(name: str, text: str) -> Callable[[h5py.File], None]:
    return lambda file: file.attrs.__setitem__(name, text)


def regrouped(file: h5py.File) -> None:
    """Let a column of one body pass to the next."""
    channels = json.loads(file.attrs["channels"])
    columns = channels["position"]
    place = [column["name"] for column in columns].index("arm")
    columns[place]["shape"], columns[place + 1]["shape"] = [2], [4]
    file.attrs["channels"] = json.dumps(channels)


ODD: dict[str, tuple[Callable[[h5py.File], None], str]] = {
    "external storage": (elsewhere, "position lies in another file"),
    "virtual": (virtual, "position lies in another file"),
    "external link": (put(lambda _, __: h5py.ExternalLink("other.h5", "x")), "position is a link"),
    "soft link": (put(lambda _, __: h5py.SoftLink("/times")), "position is a link"),
    "group in itself": (lambda file: file.__setitem__("bodies/again", file["/"]), "a group in more than 32 others"),
    "complex": (put(lambda _, a: a * 1j), "position is not of numbers, but of complex128"),
    "whole numbers": (put(lambda _, a: a.astype(int)), "position is int64 .* should have 15 numbers for each"),
    "two columns": (put(lambda _, a: a[:, :2]), "position is float64 .* should have 15 numbers for each"),
    "no columns": (put(lambda _, a: a[:, 0]), "position is float64 .* should have 15 numbers for each"),
    "a number": (put(lambda _, __: 3.0), "position is float64"),
    "texts": (put(lambda _, __: np.array(["a"], object)), "position is not of numbers"),
    "missing": (lambda file: file.__delitem__(POSITION), "position"),
    "times that fall": (times(lambda t: t[::-1]), "times do not rise"),
    "times that are not there": (times(lambda t: t * np.nan), "times are not finite"),
    "deep json": (attribute("events", "[" * 20000 + "]" * 20000), "recursion"),
    "no mapping": (attribute("events", "[]"), "events is no dict"),
    "nothing": (attribute("statistics", "{}"), "lacks parts"),
    "no tables": (attribute("channels", "{}"), "lacks parts"),
    "columns of another shape": (regrouped, "position arm .* should have 3 numbers a time"),
    "no list": (attribute("loops", "{}"), "loops is no list"),
    "a number for a list": (attribute("bodies", "[3]"), "lacks parts"),
}


@pytest.mark.parametrize(("change", "message"), ODD.values(), ids=ODD)
def test_what_no_run_writes_is_refused_by_name(saved: Path, change: Any, message: str) -> None:
    other = np.full((len(robot().times), 3), 42.0)
    (saved.parent / "other.bin").write_bytes(other.tobytes())
    with h5py.File(saved.parent / "other.h5", "w") as file:
        file["x"] = other
    with changed(saved) as file:
        change(file)
    with pytest.raises(kf.FileError, match=rf"run.h5 .*{message}.*Remedy"):
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
