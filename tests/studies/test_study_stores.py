"""The store of a study: kills, resumption, other studies, a full disk, files of tables."""

from __future__ import annotations

import errno
import os
import shutil
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.storage.hdf5 import decode
from kanefe.storage.sealed import sealed, unsealed
from kanefe.studies import store as stores
from repository import surroundings
from study_scenes import GRID, bits, deadly_study, lowest, pendulum


def files(store: Path) -> list[list[dict[str, Any]]]:
    """Return the rows of each file of a store: one file for each time that the study was run."""
    paths = sorted((store / "rows").glob("*.jsonl"))
    return [[unsealed(line) for line in path.read_bytes().splitlines()] for path in paths]


def study(**options: Any) -> kf.Study:
    return kf.Study(pendulum, lowest, **{"duration": 0.1, **GRID, **options})


def test_what_is_done_is_not_run_again(tmp_path: Path) -> None:
    table = study().run("serial", store=tmp_path)
    assert [len(rows) for rows in files(tmp_path)] == [12]
    assert bits(study().run("serial", store=tmp_path)) == bits(table)
    assert [len(rows) for rows in files(tmp_path)] == [12]


def test_more_cases_are_added(tmp_path: Path) -> None:
    study(seed=range(2)).run("serial", store=tmp_path)
    table = study().run("serial", store=tmp_path)
    assert [len(rows) for rows in files(tmp_path)] == [8, 4]
    assert bits(table) == bits(study().run("serial"))
    assert len(kf.StudyTable(tmp_path)) == 12


def test_a_killed_study_goes_on(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "study_scenes", str(tmp_path), "serial"]
    done = subprocess.run(command, env=surroundings(KANEFE_TEST_KILL="1"), capture_output=True, check=False)
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert [row["case"] for row in files(tmp_path)[0]] == [0, 1]
    before = deadly_study().table(tmp_path)  # as one looks at a study that runs
    assert before.counts["not run"] == 2
    assert lowest(before.case(3))
    table = deadly_study().run("serial", store=tmp_path)
    assert [row["case"] for row in files(tmp_path)[1]] == [2, 3]
    assert bits(table) == bits(deadly_study().run("serial"))


def test_a_line_that_is_cut_is_left_out(tmp_path: Path) -> None:
    table = study().run("serial", store=tmp_path)
    path = tmp_path / "rows" / "00001.jsonl"
    data = path.read_bytes()
    path.write_bytes(data[:-7])
    assert study().table(tmp_path).counts["not run"] == 1
    assert bits(study().run("serial", store=tmp_path)) == bits(table)
    assert len((tmp_path / "rows" / "00002.jsonl").read_text().splitlines()) == 1


def test_no_bit_can_flip_unseen(tmp_path: Path) -> None:
    """A row comes back as it was written, or is told and left out; so does the header, or it is refused."""
    table = study().run("serial", store=tmp_path)
    expected, rng = table.lists(), np.random.default_rng(0)
    for path in (tmp_path / "rows" / "00001.jsonl", tmp_path / "study.json"):
        whole = path.read_bytes()
        for place in [*rng.integers(len(whole), size=150), len(whole) - 1]:
            content = bytearray(whole)
            content[place] ^= 1 << int(rng.integers(8))
            path.write_bytes(content)
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                try:
                    found = kf.StudyTable(tmp_path).lists()
                except kf.FileError:
                    assert path.name == "study.json"
                    continue
            lost = len(expected["key"]) - len(found["key"])
            assert lost in (1, 2)  # a line's end that goes makes one line of two
            assert len(told) == 1 or place == len(whole) - 1
            kept = [expected["key"].index(key) for key in found["key"]]
            assert found == {name: [values[i] for i in kept] for name, values in expected.items()}
        path.write_bytes(whole)


@pytest.mark.parametrize(
    "line", [b"[1,2]", b"3", b'{"hello": 1}', sealed({"hello": 1}).encode(), b"[" * 20000, b"\xff"]
)
def test_a_line_that_is_no_row_is_told_and_left_out(tmp_path: Path, line: bytes) -> None:
    table = study().run("serial", store=tmp_path)
    with (tmp_path / "rows" / "00001.jsonl").open("ab") as file:
        file.write(line + b"\n")
    with pytest.warns(
        kf.SimulationWarning, match=r"line 13 of .*00001.jsonl is left out: .*Remedy: run the study again"
    ):
        assert bits(study().table(tmp_path)) == bits(table)


def test_a_damaged_row_is_run_again(tmp_path: Path) -> None:
    table = study().run("serial", store=tmp_path)
    path = tmp_path / "rows" / "00001.jsonl"
    path.write_bytes(path.read_bytes().replace(b'"lowest": -', b'"lowest": +', 1))
    with pytest.warns(kf.SimulationWarning, match=r"line 1 .*its checksum is wrong"):
        again = study().run("serial", store=tmp_path)
    with pytest.warns(kf.SimulationWarning, match="line 1"):
        assert bits(again) == bits(table)
    assert len((tmp_path / "rows" / "00002.jsonl").read_text().splitlines()) == 1


def test_rows_that_are_no_folder_are_told(tmp_path: Path) -> None:
    study().run("serial", store=tmp_path)
    shutil.rmtree(tmp_path / "rows")
    (tmp_path / "rows").touch()
    with pytest.raises(kf.FileError, match=r"cannot create the folder .*rows: File exists. Remedy"):
        study().run("serial", store=tmp_path)


def test_failed_cases_are_run_again_if_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def build(seed: int) -> kf.System:
        if seed == 1 and "KANEFE_TEST_FAIL" in os.environ:
            raise MemoryError("no room")
        return pendulum(1.0, 0.0, seed)

    monkeypatch.setenv("KANEFE_TEST_FAIL", "1")
    made = kf.Study(build, lowest, duration=0.1, seed=range(3))
    assert made.run("serial", store=tmp_path).counts["failed"] == 1
    monkeypatch.delenv("KANEFE_TEST_FAIL")
    assert made.run("serial", store=tmp_path).counts["failed"] == 1
    assert made.run("serial", store=tmp_path, retry_failed=True).counts["finished"] == 3
    assert [len(rows) for rows in files(tmp_path)] == [3, 1]


def test_a_build_that_fails_for_a_case_stops_no_study_that_has_begun(tmp_path: Path) -> None:
    def build(seed: int) -> kf.System:
        if seed == 1:
            raise MemoryError("no room")
        return pendulum(1.0, 0.0, seed)

    def counts(seeds: int, **options: bool) -> dict[str, int]:
        made = kf.Study(build, lowest, duration=0.1, seed=range(seeds))
        return made.run("serial", store=tmp_path, **options).counts

    assert counts(1)["finished"] == 1
    assert counts(3) == {"finished": 2, "stopped": 0, "failed": 1, "not run": 0}
    assert counts(3, retry_failed=True)["failed"] == 1


CONSTANT = 0.0


def with_constant(length: float, angle: float, seed: int) -> kf.System:
    return pendulum(length, angle + CONSTANT, seed)


def other_pendulum(length: float, angle: float, seed: int) -> kf.System:
    return pendulum(2.0 * length, angle, seed)


def highest(result: kf.Result) -> dict[str, Any]:
    return {"highest": result.joint_coordinates("rod").max()}


OTHERS = {
    "build": (lambda: kf.Study(other_pendulum, lowest, duration=0.1, **GRID), "pendulum there, other_pendulum here"),
    "outputs": (lambda: kf.Study(pendulum, highest, duration=0.1, **GRID), "outputs .lowest there, highest here"),
    "options": (lambda: study(rtol=1e-3), "options .*rtol"),
}


@pytest.mark.parametrize(("other", "message"), OTHERS.values(), ids=OTHERS)
def test_a_store_of_another_study_is_refused(tmp_path: Path, other: Any, message: str) -> None:
    study(seed=0).run("serial", store=tmp_path)
    for use in (lambda: other().run("serial", store=tmp_path), lambda: other().table(tmp_path)):
        with pytest.raises(kf.FileError, match=f"contains another study: it differs in .*{message}"):
            use()
    assert len(files(tmp_path)) == 1


def test_a_constant_that_build_uses_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kf.Study(with_constant, lowest, duration=0.1, **GRID).run("serial", store=tmp_path)
    monkeypatch.setitem(globals(), "CONSTANT", 0.1)
    with pytest.raises(kf.FileError, match="the functions, constants or data that build or outputs use"):
        kf.Study(with_constant, lowest, duration=0.1, **GRID).run("serial", store=tmp_path)


def test_a_store_of_another_version_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    study().run("serial", store=tmp_path)
    monkeypatch.setattr("kanefe.studies.study.stamp", lambda: "9.9")
    with pytest.raises(kf.FileError, match=r"kanefe \(0.*there, 9.9 here\)"):
        study().run("serial", store=tmp_path)


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("dear")
    with pytest.raises(kf.FileError, match="contains other files than a study"):
        study().run("serial", store=tmp_path)
    with pytest.raises(kf.FileError, match="holds no study"):
        kf.StudyTable(tmp_path)
    (tmp_path / "study.json").write_text("{")
    with pytest.raises(kf.FileError, match="cannot be read"):
        kf.StudyTable(tmp_path)
    (tmp_path / "study.json").write_text(sealed({"format": "kanefe study", "version": 0}))
    with pytest.raises(kf.FileError, match="is not of a study that this kanefe reads"):
        kf.StudyTable(tmp_path)


def test_the_store_says_what_it_is(tmp_path: Path) -> None:
    study().run("serial", store=tmp_path)
    header = kf.StudyTable(tmp_path).header
    assert header["kanefe"].startswith(kf.__version__)
    assert header["packages"]["numpy"] == np.__version__
    assert "Revolute" in header["build"]["source"] or "hinged" in header["build"]["source"]
    assert header["cases"]["grid"]["seed"] == [0, 1, 2]
    assert header["options"] == {"t_span": "(0.0, 0.1)"}


class SmallDisk:
    """A file on a disk with so much room, that of the spare file too once it is gone."""

    def __init__(self, file: Any, room: int) -> None:
        self._file, self._room = file, room
        self.spare = Path(file.name).parents[1] / "spare"

    def write(self, data: Any) -> int:
        room = self._room + (0 if self.spare.exists() else 1 << 20) - self._file.tell()
        if room <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return int(self._file.write(data[:room]))  # a part of a line, as disks do

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


@pytest.mark.parametrize("has_spare", [True, False])
def test_a_full_disk_loses_nothing_that_is_finished(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, has_spare: bool
) -> None:
    expected = bits(study().run("serial"))
    new_file = stores._new_file

    def small(folder: Path) -> SmallDisk:
        if has_spare:
            return SmallDisk(new_file(folder), 1000)
        (folder.parent / "spare").unlink()
        return SmallDisk(new_file(folder), 1000 - (1 << 20))

    monkeypatch.setattr(stores, "_new_file", small)
    kept = "All finished cases are" if has_spare else "All cases before are"
    with pytest.raises(kf.FileError, match=rf"No space left on device. {kept} in the store. Remedy: free"):
        study().run("serial", store=tmp_path)
    (rows,) = files(tmp_path)  # whole lines, of which none is a part
    assert 1 < len(rows) < 12
    # the one that did not fit is there, in the room that was kept aside
    assert (sum(len(sealed(row)) + 1 for row in rows) > 1000) == has_spare
    monkeypatch.undo()
    assert bits(study().run("serial", store=tmp_path)) == expected
    assert len(files(tmp_path)[1]) == 12 - len(rows)


def test_a_store_without_rows_is_anybodys(tmp_path: Path) -> None:
    def build(length: float) -> kf.System:
        raise ValueError("not yet")

    with pytest.raises(kf.ModelError, match="not yet"):
        kf.Study(build, lowest, duration=0.1, length=1.0).run("serial", store=tmp_path)
    assert study().run("serial", store=tmp_path).counts["finished"] == 12


def test_a_table_of_other_cases_runs_its_own_again(tmp_path: Path) -> None:
    table = study(seed=(2, 1)).run("serial", store=tmp_path)
    other = study(seed=(0, 1, 2)).table(tmp_path)  # not run yet: the store knows two seeds
    assert len(other) == 8
    assert lowest(other.case(0))["lowest"] == table.column("lowest")[0]


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(kf.FileError, match="cannot write"):
        study().run("serial", store=tmp_path / "file" / "store")


def test_a_table_goes_to_files(tmp_path: Path) -> None:
    table = study().run("serial")
    table.save(tmp_path / "new" / "table.csv")
    lines = (tmp_path / "new" / "table.csv").read_text().splitlines()
    assert lines[0].startswith("case,length,angle,seed,lowest,status")
    assert float(lines[3].split(",")[4]) == table.column("lowest")[2]
    table.save(tmp_path / "table.h5")
    header, arrays = decode(tmp_path / "table.h5")
    assert arrays["lowest"].tobytes() == table.column("lowest").tobytes()
    assert arrays["status"][0] == b"finished"
    assert header["format"] == "kanefe study"
    with pytest.raises(kf.ModelError, match=r"Remedy: one of the suffixes .csv, .h5, .parquet"):
        table.save(tmp_path / "table.xls")
    with pytest.raises(kf.ModelError, match=r"the table has no column 'speed'. It has: case, length"):
        table.column("speed")


def test_a_temporary_store_goes_with_its_table() -> None:
    table = study().run("serial")
    folder = table.store
    assert folder.is_dir()
    del table
    deadline = time.monotonic() + 5.0
    while folder.exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    assert not folder.exists()
