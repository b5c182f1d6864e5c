"""Files put in place whole; devices, pipes and links stay what they are."""

from __future__ import annotations

import os
import stat
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import kanefe as kf
import kanefe_fem
from kanefe.errors import FileError
from kanefe.new_project.project import new_project
from kanefe.storage import files as storage_files
from kanefe.storage.files import ready_path, regular_file, usable_memory, write_whole
from kanefe.studies.store import Store
from run_scenes import double_pendulum

DATA = b"0123456789" * 20_000
"""More than a pipe holds at once, 64 KiB."""


def write(path: Path) -> None:
    write_whole(path, lambda file: file.write(DATA))


def test_a_pipe_is_given_the_bytes_and_stays(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[bytes] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    write(pipe)
    reader.join(10.0)
    assert read == [DATA]
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_a_device_stays(tmp_path: Path) -> None:
    device = tmp_path / "null"
    try:
        os.mknod(device, stat.S_IFCHR | 0o666, os.makedev(1, 3))
        device.write_bytes(b"")
    except OSError:
        pytest.skip("devices cannot be made or used here")
    write(device)
    assert stat.S_ISCHR(device.stat().st_mode)
    assert [path.name for path in tmp_path.iterdir()] == ["null"]


@pytest.mark.parametrize("is_there", [True, False])
def test_a_link_stays_and_what_it_points_to_is_replaced(tmp_path: Path, is_there: bool) -> None:
    target, link = tmp_path / "folder" / "file", tmp_path / "link"
    target.parent.mkdir()
    if is_there:
        target.write_bytes(b"before")
    link.symlink_to(target)
    write(link)
    assert link.is_symlink()
    assert target.read_bytes() == DATA
    assert [path.name for path in target.parent.iterdir()] == ["file"]


def test_a_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"cannot write .*: Is a directory. Remedy: the name of a file"):
        write(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_name_that_no_file_can_have_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"no file can have the path .*null (byte|character).*\. Remedy: another name"):
        write(tmp_path / "a\0b")


READERS = {
    "stl": kf.shapes.Mesh.from_stl,
    "result": kf.load_result,
    "rao": lambda path: kf.read_rao(path.with_suffix(".csv")),
    "sid": kf.read_sid,
    "body": kf.FlexibleBody.load,
    "matrices": kf.read_matrices,
    "matrix market": lambda path: kf.read_matrix_market([[0, 0, 0], [1, 0, 0]], path, path),
    "mesh": kanefe_fem.read_mesh,
    "urdf": kf.read_urdf,
    "mjcf": kf.read_mjcf,
    "resume": lambda path: double_pendulum().simulate((0.0, 1.0), resume=path),
}


@pytest.mark.parametrize("read", READERS.values(), ids=READERS)
def test_readers_open_files_that_end(read: Any, tmp_path: Path) -> None:
    for name in ("pipe", "pipe.csv"):
        os.mkfifo(tmp_path / name)
    with pytest.raises(FileError, match=r"is a pipe, which may never end. Remedy: write its content to a file"):
        read(tmp_path / "pipe")


@pytest.fixture
def locked(tmp_path: Path) -> Iterator[Path]:
    """Return a folder that may not be entered by the user who the process is meanwhile."""
    if os.name != "posix" or os.geteuid() != 0:
        pytest.skip("only root becomes another user")
    folder = tmp_path / "locked"
    folder.mkdir(mode=0o700)
    (folder / "file").touch()
    (tmp_path / "shut").touch(mode=0o600)
    for above in (tmp_path, *tmp_path.parents[:3]):
        above.chmod(above.stat().st_mode | 0o011)
    os.seteuid(65534)
    yield folder
    os.seteuid(0)


def test_what_may_not_be_read_or_entered_is_told(locked: Path) -> None:
    for path in (locked / "file", locked.parent / "shut"):
        with pytest.raises(FileError, match=r"Permission denied.*Remedy: have it.*made readable for you"):
            regular_file(path)
    with pytest.raises(FileError, match=r"cannot write .*Permission denied.*Remedy: choose a folder"):
        write_whole(locked / "page.html", lambda file: file.write(b"page"))
    with pytest.raises(FileError, match=r"cannot make .*Permission denied. Remedy: another place"):
        new_project(str(locked / "arm"))
    with pytest.raises(FileError, match=r"cannot read .*locked: Permission denied. Remedy: another folder"):
        Store(locked).begin({})


def test_devices_links_to_themselves_and_files_beyond_memory_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="/dev/zero is a device, which may never end"):
        regular_file("/dev/zero")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    with pytest.raises(FileError, match=r"cannot read the file .*loop.*Remedy"):
        regular_file(tmp_path / "loop")
    with (tmp_path / "large").open("wb") as file:
        file.truncate(int(usable_memory()))
    with pytest.raises(FileError, match=r"large has .* GiB, of which .* can be read here. Remedy"):
        regular_file(tmp_path / "large")
    assert regular_file(tmp_path / "large", whole=False) == tmp_path / "large"


@pytest.mark.parametrize(
    ("text", "message"),
    [("/dev/zero", "/dev/zero that arm.inp reads is a device"), ("arm.inp", "arm.inp includes itself")],
)
def test_a_mesh_that_names_what_never_ends_is_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "arm.inp").write_text(f"*NODE\n1, 0., 0., 0.\n*Include, input={text}\n")
    with pytest.raises(FileError, match=message):
        kanefe_fem.read_mesh(tmp_path / "arm.inp")


@pytest.mark.parametrize("path", ["a\0b", "\ud800", "a" * 100_000, 3, None, b"a"])
def test_what_no_file_can_be_called_is_named(path: Any) -> None:
    for use in (regular_file, ready_path, lambda path: write_whole(path, lambda file: file.write(b""))):
        with pytest.raises(FileError, match=r"no file can have the path .*Remedy"):
            use(path)


def test_a_pipe_that_nobody_reads_is_no_wait_without_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(storage_files, "MOST_WAITING", 0.0)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(FileError, match=r"cannot write .*pipe"):
        write(tmp_path / "pipe")
