"""The file of a flexible body: nothing lost, nothing half-written."""

from __future__ import annotations

import errno
import json
import os
import tempfile
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import FileError
from kanefe.finite_element_model import Cells
from kanefe.kane.assemble import assemble
from kanefe.load_pattern import LoadPattern
from scenes import flexible_scene, lattice_body, random_state

BODIES = {
    "reduced": lambda: lattice_body(0, reduction=kf.CraigBampton(modes=3), damping=kf.ModalDamping(0.02)),
    "unreduced": lambda: lattice_body(1),
    "nodal form": lambda: lattice_body(2, rotations=True),
    "floating, planar": lambda: lattice_body(3, {}, planar=True, reduction=kf.CraigBampton(modes=2)),
    "with load patterns": lambda: replace(
        lattice_body(5),
        load_patterns=(
            LoadPattern("top", "surface", True, 0.5, *(np.arange(n) + 0.1 for n in (3, 3, 3, 3, 4))),
            LoadPattern("span", "line", False, 2.0, *(np.zeros(n) for n in (3, 3, 3, 3, 4))),
        ),
    ),
    "with cells": lambda: replace(
        lattice_body(4), cells=(Cells("line", np.array([[0, 1], [1, 2]])), Cells("vertex", np.array([[3]])))
    ),
}


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
    for ours, theirs in zip(assemble(model, 0.0, q, u), assemble(scene.freeze(), 0.0, q, u), strict=True):
        assert np.array_equal(ours, theirs)


def test_a_name_without_suffix_is_kept(tmp_path: Path) -> None:
    # numpy would add .npz on its own, and the file would not be where the user looks for it
    lattice_body(0).save(str(tmp_path / "arm.body"))
    assert os.listdir(tmp_path) == ["arm.body"]
    assert kf.FlexibleBody.load(str(tmp_path / "arm.body")).free_count == lattice_body(0).free_count


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
    with pytest.raises(FileError, match=r"arm\.npz is truncated or is no saved body .* Remedy: save the body again"):
        kf.FlexibleBody.load(str(path))


@pytest.mark.parametrize("position", [0.2, 0.5, 0.8])
def test_a_damaged_file_is_named(position: float, tmp_path: Path) -> None:
    path = tmp_path / "arm.npz"
    content = bytearray(saved(path))
    start = int(position * len(content))
    content[start : start + 40] = bytes(40)
    path.write_bytes(bytes(content))
    with pytest.raises(FileError, match=r"arm\.npz .* Remedy: save the body again"):
        kf.FlexibleBody.load(str(path))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"version": 99}, r"has format version 99, this kanefe reads version \d+\. Remedy: make the body again"),
        (
            {"format": "something else"},
            r"is no saved flexible body\. Remedy: give the file that FlexibleBody\.save wrote",
        ),
        ({"moments": "Other"}, "is no saved body .* Remedy: save the body again"),
        ({"free_count": None}, "is no saved body .* Remedy: save the body again"),
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
        with pytest.raises(FileError, match=f"{path.name} is truncated or is no saved body"):
            kf.FlexibleBody.load(str(path))


def test_a_missing_array_is_named(tmp_path: Path) -> None:
    path = tmp_path / "arm.npz"
    saved(path)
    with np.load(path) as file:
        arrays = dict(file)
    for name in ("basis", "moments_first", "interface_0_motion"):
        np.savez(path, **{n: a for n, a in arrays.items() if n != name})
        with pytest.raises(FileError, match=r"arm\.npz .*Remedy: save the body again"):
            kf.FlexibleBody.load(str(path))


def full_disk(*arguments: object, **options: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize("where", ["fsync", "write", "replace"])
def test_a_full_disk_leaves_the_old_file(where: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "arm.npz"
    content = saved(path)
    if where == "write":
        monkeypatch.setattr(np, "savez_compressed", full_disk)
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
