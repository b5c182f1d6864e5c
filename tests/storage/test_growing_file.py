"""Files of tables that grow: what is sealed is read, what is not is refused before HDF5 sees it."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from kanefe.errors import FileError
from kanefe.storage import hdf5
from kanefe.storage.growing_file import GrowingFile, Layout, read_head, read_part
from kanefe.storage.hdf5 import put_digest
from kanefe.storage.sealed_parts import MARK, PartWriter, parts_of

TIMES, VALUES = np.linspace(0.0, 1.0, 12), np.arange(24.0).reshape(12, 2)
EXTREMES = np.array(((0.1, 0.2, 0.3), (0.4, 0.5, 0.6)))


def written(path: Path, shift: float = 0.0, rows: int = 12) -> GrowingFile:
    """Return an open file of a table of two columns, in three parts, and of the extremes of three columns."""
    file = GrowingFile(path, {"format": "test", "tables": [1, 2]}, [Layout(2, True), Layout(3, False), Layout(1, True)])
    for first in range(0, rows, 4):
        file.write(0, TIMES[first : first + 4], VALUES[first : first + 4] + shift)
        file.write(1, EXTREMES, EXTREMES + first)
    return file


def closed(path: Path, shift: float = 0.0, rows: int = 12) -> bytes:
    written(path, shift, rows).close({"status": "done"})
    return path.read_bytes()


def left(path: Path, shift: float = 0.0) -> bytes:
    written(path, shift).leave()
    return path.read_bytes()


def test_a_file_is_the_same_while_it_grows_and_when_it_is_closed(tmp_path: Path) -> None:
    path = tmp_path / "r.h5"
    file = written(path)
    for status in ({}, {"status": "done"}):
        assert read_head(path).items() >= {"format": "test", "tables": "[1, 2]", **status}.items()
        for column in (0, 1):
            times, values = read_part(path, 0, column)
            np.testing.assert_array_equal(times, TIMES)
            np.testing.assert_array_equal(values, VALUES[:, column])
        times, values = read_part(path, 1, 2)
        np.testing.assert_array_equal(times, EXTREMES[:, 2])
        np.testing.assert_array_equal(values, EXTREMES[:, 2] + 8)
        assert [len(numbers) for numbers in read_part(path, 2, 0)] == [0, 0]
        if not status:
            file.close({"status": "done"})
    with h5py.File(path) as other:  # as any program reads it
        np.testing.assert_array_equal(other["records/0/values"][...], VALUES)
        assert other["records/0/times"].attrs["unit"] == "s"


def test_a_file_that_was_cut_is_read_up_to_its_last_sealed_part(tmp_path: Path) -> None:
    path = tmp_path / "r.h5"
    whole = left(path)
    first = len(MARK) + 16 + int.from_bytes(whole[len(MARK) + 4 : len(MARK) + 8], "little")
    path.write_bytes(whole[: first - 1])
    with pytest.raises(FileError, match="its first part is not whole"):
        read_head(path)
    counts = []
    for size in range(first, len(whole) + 1, 5):
        path.write_bytes(whole[:size])
        assert read_head(path)["format"] == "test"
        counts.append(len(read_part(path, 0, 0)[0]))
    assert sorted(set(counts)) == [0, 4, 8, 12]
    assert counts == sorted(counts)


@pytest.mark.parametrize("made", [left, closed])
def test_flipped_bits_are_refused(
    made: Callable[[Path], bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, rng = tmp_path / "r.h5", np.random.default_rng(5)
    whole = made(path)
    monkeypatch.setattr(h5py, "File", None)  # HDF5 does not see them
    for place in rng.integers(0, len(whole), 100):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << rng.integers(8)
        path.write_bytes(damaged)
        for read in (read_head, lambda path: read_part(path, 0, 1)):
            with pytest.raises(FileError, match="Remedy: record the run again"):
                read(path)


def test_parts_of_other_files_and_places_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "parts"
    pieces = []
    for name in (b"one", b"two"):
        writer = PartWriter(path)
        ends = [len(MARK)]
        for i in range(3):
            writer.add(i, name * 4)
            ends.append(path.stat().st_size)
        writer.close()
        data = path.read_bytes()
        pieces.append([data[start:end] for start, end in pairwise(ends)])
    one, two = pieces
    for wrong in ([one[0], one[2]], [one[0], one[2], one[1]], [one[0], two[1], one[2]], [one[0], one[1], two[2]]):
        path.write_bytes(MARK + b"".join(wrong))
        with pytest.raises(ValueError, match="is not the one that was written"):
            list(parts_of(path) or ())


def test_a_file_that_takes_the_place_of_another_is_not_read_for_it(tmp_path: Path) -> None:
    path = tmp_path / "r.h5"
    file = written(path)
    parts = parts_of(path)
    assert parts is not None
    file.close({})
    assert len(list(parts)) == 8  # two heads, and three parts of two tables
    assert parts_of(path) is None


def test_seals_that_are_missing_old_or_of_another_file_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "r.h5"
    whole, other, shorter = closed(path), closed(path, 1.0), closed(path, rows=8)
    head = hdf5.HEAD
    path.write_bytes(whole)
    assert read_part(path, 0, 0)[1][-1] == VALUES[-1, 0]
    for content in (
        b" " * head + whole[head:],
        whole[head:],
        other[:head] + whole[head:],
        shorter[:head] + whole[head:],
        whole[:-1],
        whole + b" ",
    ):
        path.write_bytes(content)
        with pytest.raises(FileError, match=r"its content does not match its digest|it has no digest"):
            read_part(path, 0, 0)


def _external(file: Any, folder: Path) -> None:
    file["records/0"].create_dataset("values", shape=(12, 2), dtype=float, external=[(folder / "private.bin", 0, 192)])


def _external_link(file: Any, folder: Path) -> None:
    file["records/0/values"] = h5py.ExternalLink(folder / "private.h5", "private")


def _soft_link(file: Any, folder: Path) -> None:
    file["records/0/values"] = h5py.SoftLink("/records/1/values")


def _virtual(file: Any, folder: Path) -> None:
    layout = h5py.VirtualLayout(shape=(12, 2), dtype=float)
    layout[:] = h5py.VirtualSource(folder / "private.h5", "private", shape=(12, 2))
    file["records/0"].create_virtual_dataset("values", layout)


@pytest.mark.parametrize("lead", [_external, _external_link, _soft_link, _virtual])
def test_what_leads_to_other_files_is_refused(lead: Callable[[Any, Path], None], tmp_path: Path) -> None:
    path = tmp_path / "r.h5"
    closed(path)
    (tmp_path / "private.bin").write_bytes(VALUES.tobytes())
    with h5py.File(tmp_path / "private.h5", "w") as file:
        file["private"] = VALUES
    with h5py.File(path, "r+") as file:
        del file["records/0/values"]
        lead(file, tmp_path)
    with path.open("r+b") as file:
        put_digest(file)
    with pytest.raises(FileError, match=r"records/0/values (is a link|lies in another file)"):
        read_part(path, 0, 0)


def test_what_cannot_be_written_is_told(tmp_path: Path) -> None:
    file = written(tmp_path / "r.h5")
    with pytest.raises(FileError, match="another run writes it"):
        written(tmp_path / "r.h5")
    file.close({})
    with pytest.raises(FileError, match="it is no file"):
        written(Path("/dev/null"))
    with pytest.raises(FileError, match="cannot write"):
        written(tmp_path)
