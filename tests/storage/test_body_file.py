"""The file of a flexible body: nothing lost, nothing half-written."""

from __future__ import annotations

import errno
import json
import os
import re
import tempfile
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from body_makers import BODIES
from disk_faults import full_disk
from kanefe.errors import FileError
from kanefe.kane.assemble import assemble
from kanefe.states.state import State
from kanefe.storage import array_file
from kanefe.storage.array_file import ALIGNMENT, MAPPED
from kanefe.storage.object_file import DAMAGE
from kanefe.storage.serialise import encoded
from scenes import flexible_scene, lattice_body, random_state


def same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    if sp.issparse(a):
        return a.shape == b.shape and (a != b).nnz == 0
    if isinstance(a, tuple) and a and hasattr(a[0], "__dataclass_fields__"):
        return len(a) == len(b) and all(same_object(x, y) for x, y in zip(a, b, strict=True))
    return same_object(a, b) if hasattr(a, "__dataclass_fields__") else a == b


def same_object(a: Any, b: Any) -> bool:
    return type(a) is type(b) and all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))


@pytest.mark.parametrize("make", BODIES.values(), ids=BODIES)
def test_a_body_comes_back_bit_for_bit(make: Any, tmp_path: Path) -> None:
    body = make()
    path = tmp_path / "body.npz"
    body.save(str(path))
    back = kf.FlexibleBody.load(str(path))
    for f in fields(body):
        assert same(getattr(body, f.name), getattr(back, f.name)), f.name
    assert os.listdir(tmp_path) == ["body.npz"]


def test_a_loaded_body_is_as_frozen_as_the_first(tmp_path: Path) -> None:
    lattice_body(0).save(str(tmp_path / "body.npz"))
    with pytest.raises(ValueError, match="read-only"):
        kf.FlexibleBody.load(str(tmp_path / "body.npz")).stiffness[0, 0] = 1.0


def test_a_scene_with_a_loaded_body_has_the_same_equations(tmp_path: Path) -> None:
    scene = flexible_scene(0)
    entry = scene._entries[1]
    model = scene.freeze()
    entry.flexible.save(str(tmp_path / "body.npz"))
    entry.flexible = kf.FlexibleBody.load(str(tmp_path / "body.npz"))
    q, u = random_state(model, 0)
    for ours, theirs in zip(assemble(State(model, 0.0, q, u)), assemble(State(scene.freeze(), 0.0, q, u)), strict=True):
        assert np.array_equal(ours, theirs)


def test_a_name_without_suffix_is_kept(tmp_path: Path) -> None:
    # numpy would add .npz on its own, and the file would not be where the user looks for it
    lattice_body(0).save(str(tmp_path / "arm.body"))
    assert os.listdir(tmp_path) == ["arm.body"]
    assert kf.FlexibleBody.load(str(tmp_path / "arm.body")).free_count == lattice_body(0).free_count


def large_body(nodes: int = 3000) -> kf.FlexibleBody:
    """Return a body whose basis is large enough to be mapped, and stands for its inertia as well."""
    points = np.random.default_rng(0).standard_normal((nodes, 3))
    basis = np.asfortranarray(np.random.default_rng(1).standard_normal((3 * nodes, 18)))
    assert basis.nbytes > MAPPED
    small = lattice_body(0)
    return replace(
        small,
        nodes=points,
        components=("x", "y", "z"),
        basis=basis,
        inertia_points=points.copy(),
        inertia_basis=basis.copy(order="K"),
        inertia_mass=sp.identity(nodes, format="csr"),
    )


def test_large_arrays_stay_in_the_file_and_come_back_bit_for_bit(tmp_path: Path) -> None:
    body, path = large_body(), tmp_path / "body.npz"
    body.save(str(path))
    back = kf.FlexibleBody.load(str(path))
    for f in fields(body):
        assert same(getattr(body, f.name), getattr(back, f.name)), f.name
    assert back.basis.flags.f_contiguous
    assert back.basis.flags.aligned
    assert back.basis.ctypes.data % ALIGNMENT == 0
    assert not back.basis.flags.writeable
    maps = Path("/proc/self/maps")
    if maps.exists():
        assert str(path) in maps.read_text()
    # a new file in its place, as of another process, does not disturb those who read the old one
    lattice_body(1).save(str(path))
    assert np.array_equal(back.basis, body.basis)


def test_what_a_body_holds_twice_is_written_once(tmp_path: Path) -> None:
    body, path = large_body(), tmp_path / "body.npz"
    body.save(str(path))
    assert path.stat().st_size < 1.2 * (body.basis.nbytes + body.nodes.nbytes + 20 * len(body.nodes))
    back = kf.FlexibleBody.load(str(path))
    assert np.shares_memory(back.basis, back.inertia_basis)
    with np.load(path) as file:
        assert "inertia_basis" not in file.files
        assert np.array_equal(file["basis"], body.basis)


def test_equal_bodies_give_equal_bytes(tmp_path: Path) -> None:
    body = large_body()
    for name in ("a.npz", "b.npz"):
        body.save(str(tmp_path / name))
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_a_bit_that_flips_in_a_large_array_is_seen(tmp_path: Path) -> None:
    path = tmp_path / "body.npz"
    large_body().save(str(path))
    assert kf.FlexibleBody.load(str(path)).basis[0, 0] == large_body().basis[0, 0]
    content = bytearray(path.read_bytes())
    content[content.index(large_body().basis.tobytes(order="F")[:64]) + 6] ^= 1
    path.write_bytes(bytes(content))
    with pytest.raises(FileError, match=r"the checksum of basis.npy is wrong"):
        kf.FlexibleBody.load(str(path))


def test_a_process_compares_the_checksums_of_a_file_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, compared = tmp_path / "body.npz", []
    compare = array_file._compare_checksum
    monkeypatch.setattr(array_file, "_compare_checksum", lambda *given: (compared.append(1), compare(*given)))
    for seed in range(2):
        body = large_body() if seed else replace(large_body(), nodes=np.zeros((3000, 3)))
        body.save(str(path))
        for _ in range(3):
            kf.FlexibleBody.load(str(path))
        assert len(compared) == seed + 1


def test_no_bit_can_flip_unseen(tmp_path: Path) -> None:
    """A body either comes back to the bit, where nothing is said that counts, or is refused."""
    path = tmp_path / "body.npz"
    whole, rng = saved(path), np.random.default_rng(0)
    expected = kf.FlexibleBody.load(str(path))
    refused = 0
    for place in rng.integers(len(whole), size=250):
        content = bytearray(whole)
        content[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(bytes(content))
        try:
            back = kf.FlexibleBody.load(str(path))
        except FileError:
            refused += 1
        else:
            for f in fields(expected):
                assert same(getattr(expected, f.name), getattr(back, f.name)), (place, f.name)
    assert refused > 150


def test_no_bit_of_the_directory_can_flip_and_lose_an_array(tmp_path: Path) -> None:
    """A comment that seems longer hides the array behind it; what may be missing was then taken for not there."""
    path = tmp_path / "arrays.npz"
    arrays = {name: np.arange(3.0) for name in "abc"}
    array_file.write_arrays(path, "header", arrays)
    whole = path.read_bytes()
    lengths = [entry.start() + i for entry in re.finditer(b"PK\1\2", whole) for i in range(28, 34)]
    for place in [*lengths, *range(whole.index(b"PK\5\6"), len(whole))]:
        for bit in range(4):
            content = bytearray(whole)
            content[place] ^= 1 << bit
            path.write_bytes(bytes(content))
            try:
                header, found = array_file.open_arrays(path)
            except DAMAGE:
                continue
            assert header == "header"
            assert {name: array.tolist() for name, array in found.items()} == {key: [0.0, 1.0, 2.0] for key in "abc"}


@pytest.mark.parametrize("share", [0.3, 0.6, 0.99])
def test_a_truncated_large_file_is_named(share: float, tmp_path: Path) -> None:
    path = tmp_path / "arm.npz"
    large_body().save(str(path))
    os.truncate(path, int(share * path.stat().st_size))
    with pytest.raises(FileError, match="truncated"):
        kf.FlexibleBody.load(str(path))


def test_a_file_of_version_2_is_refused_with_the_reason(tmp_path: Path) -> None:
    path = tmp_path / "old.npz"
    header = {"format": "kanefe flexible body", "version": 2, "components": ["x"]}
    np.savez_compressed(path, header=np.array(json.dumps(header)), nodes=np.zeros((3, 3)))
    with pytest.raises(FileError, match=r"has format version 2, this kanefe reads version 4\. Remedy: make the body"):
        kf.FlexibleBody.load(str(path))


def test_a_compressed_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "arm.npz"
    saved(path)
    with np.load(path) as file:
        arrays = dict(file)
    np.savez_compressed(path, **arrays)
    with pytest.raises(FileError, match=r"not a saved body \(.*is compressed\)"):
        kf.FlexibleBody.load(str(path))


def test_a_part_that_cannot_be_saved_is_named() -> None:
    with pytest.raises(TypeError, match=r"provenance\.made_by is a function, which cannot be saved"):
        encoded(replace(lattice_body(0), provenance={"made_by": saved}))


def saved(path: Path) -> bytes:
    lattice_body(0).save(str(path))
    return path.read_bytes()


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "arm.npz"
    with pytest.raises(FileError, match=r"there is no file .*arm\.npz\. Remedy: check the path"):
        kf.FlexibleBody.load(str(path))
    with pytest.raises(FileError, match="there is no file"):
        kf.FlexibleBody.load(str(tmp_path))


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.9, 0.999])
def test_a_truncated_file_is_named(share: float, tmp_path: Path) -> None:
    path = tmp_path / "arm.npz"
    content = saved(path)
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(FileError, match=r"arm\.npz is truncated or not a saved body .* Remedy: save the body again"):
        kf.FlexibleBody.load(str(path))


@pytest.mark.parametrize("position", [0.0, 0.2, 0.5, 0.8, 0.97])
def test_a_damaged_file_is_named(position: float, tmp_path: Path) -> None:
    path = tmp_path / "arm.npz"
    content = bytearray(saved(path))
    start = int(position * len(content))
    content[start : start + 40] = bytes(255 - byte for byte in content[start : start + 40])
    path.write_bytes(bytes(content))
    with pytest.raises(FileError, match=r"arm\.npz .* Remedy: save the body again"):
        kf.FlexibleBody.load(str(path))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"version": 99}, r"has format version 99, this kanefe reads version \d+\. Remedy: make the body again"),
        (
            {"format": "something else"},
            r"is not a saved flexible body\. Remedy: give the file that FlexibleBody\.save wrote",
        ),
        ({"body": None}, "not a saved body .* Remedy: save the body again"),
        ({"body": [1, 2]}, r"not a saved body\. Remedy: save the body again"),
        (
            {"body": {"is": "object", "class": "os:system", "fields": {}}},
            "not a saved body .*'os:system' is not a kind of object .*Remedy: save the body again",
        ),
        (
            {"body": {"is": "object", "class": "flexible body", "fields": {"nodes": None}}},
            r"another version of kanefe \(FlexibleBody has other fields in this version\)\. Remedy: make the body",
        ),
    ],
)
def test_another_version_or_format_is_named(change: dict, message: str, tmp_path: Path) -> None:
    path = tmp_path / "arm.npz"
    saved(path)
    with np.load(path) as file:
        arrays = dict(file)
    header = json.loads(str(arrays["header"])) | change
    header = {name: value for name, value in header.items() if value is not None}
    np.savez(path, **{**arrays, "header": np.array(json.dumps(header))})
    with pytest.raises(FileError, match=message):
        kf.FlexibleBody.load(str(path))


def test_a_file_of_another_kind_is_named(tmp_path: Path) -> None:
    other = tmp_path / "other.npz"
    np.savez(other, a=np.zeros(3))
    text = tmp_path / "text.npz"
    text.write_text("not a zip file")
    pickled = tmp_path / "pickled.npz"
    np.savez(pickled, header=np.array({"format": "kanefe flexible body"}, dtype=object))
    for path in (other, text, pickled):
        with pytest.raises(FileError, match=f"{path.name} is truncated or not a saved body"):
            kf.FlexibleBody.load(str(path))


def test_a_missing_array_is_named(tmp_path: Path) -> None:
    path = tmp_path / "arm.npz"
    saved(path)
    with np.load(path) as file:
        arrays = dict(file)
    for name in ("basis", "moments.first", "interfaces[0].motion"):
        assert name in arrays
        np.savez(path, **{n: a for n, a in arrays.items() if n != name})
        with pytest.raises(FileError, match=r"arm\.npz .*Remedy: save the body again"):
            kf.FlexibleBody.load(str(path))


@pytest.mark.parametrize("where", ["fsync", "write", "replace"])
def test_a_full_disk_leaves_the_old_file(where: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "arm.npz"
    content = saved(path)
    if where == "write":
        monkeypatch.setattr(np.lib.format, "write_array", full_disk)
    else:
        monkeypatch.setattr(os, where, full_disk)
    with pytest.raises(
        FileError, match=r"cannot write .*arm\.npz: No space left .* untouched\. Remedy: free some space"
    ):
        lattice_body(5).save(str(path))
    monkeypatch.undo()
    assert path.read_bytes() == content
    assert os.listdir(tmp_path) == ["arm.npz"]


def test_an_interrupted_save_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "arm.npz"
    content = saved(path)

    def interrupted(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        lattice_body(5).save(str(path))
    assert path.read_bytes() == content
    assert os.listdir(tmp_path) == ["arm.npz"]


def test_a_missing_folder_is_made(tmp_path: Path) -> None:
    path = tmp_path / "out" / "bodies" / "arm.npz"
    assert saved(path)


def test_a_folder_that_is_a_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("a file")
    with pytest.raises(FileError, match=r"cannot write .*arm\.npz: .* Remedy: choose a folder"):
        lattice_body(0).save(str(tmp_path / "out" / "arm.npz"))


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: object, **options: object) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    # root may write anywhere, so the refusal is made up
    monkeypatch.setattr(tempfile, "mkstemp", refuse)
    with pytest.raises(FileError, match=r"cannot write .*: Permission denied\. Remedy: choose a folder"):
        lattice_body(0).save(str(tmp_path / "arm.npz"))


def test_the_file_is_as_readable_as_any_other(tmp_path: Path) -> None:
    old = os.umask(0o022)
    try:
        saved(tmp_path / "arm.npz")
    finally:
        os.umask(old)
    assert (tmp_path / "arm.npz").stat().st_mode & 0o777 == 0o644
