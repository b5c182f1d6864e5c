"""The cache of bodies: what is in it, and that it stands concurrent writers, kills and damage."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from kanefe.bodies import cache
from kanefe.cli import main
from kanefe.storage.digest import Unhashable, code_stamp, digest, installed_versions
from kanefe.storage.files import cache_folder
from repository import surroundings
from scenes import lattice_body, lattice_model

KEY = "0123456789abcdef0123456789abcdef"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("KANEFE_CACHE", "1")
    monkeypatch.setenv("KANEFE_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache" / "bodies"


def python(code: str, **popen: Any) -> subprocess.Popen[str]:
    """Start a process that has the tests' helpers; the surroundings of this one, with its folder, are passed on."""
    environment = surroundings(KANEFE_JIT="0")
    return subprocess.Popen([sys.executable, "-c", textwrap.dedent(code)], text=True, env=environment, **popen)


class TestStore:
    def test_a_body_comes_back(self, folder: Path) -> None:
        body = lattice_body(0)
        assert cache.find(KEY) is None
        cache.keep(KEY, body)
        found = cache.find(KEY)
        assert found is not None
        np.testing.assert_array_equal(found.stiffness, body.stiffness)
        assert os.listdir(folder) == [f"{KEY}.npz"]

    def test_damage_is_warned_of_and_thrown_away(self, folder: Path) -> None:
        cache.keep(KEY, lattice_body(0))
        path = folder / f"{KEY}.npz"
        os.truncate(path, path.stat().st_size // 2)
        with pytest.warns(cache.CacheWarning, match="is removed and made again: .*truncated"):
            assert cache.find(KEY) is None
        assert not path.exists()

    @pytest.mark.parametrize("factor", [1.0, 2.0])  # the mass is that of the mass field, or another one
    def test_a_model_comes_back_whole(self, factor: float) -> None:
        model = lattice_model(0)
        model = replace(model, mass=factor * model.mass)
        assert cache.find_model(KEY) is None
        cache.keep_model(KEY, replace(model, stress_stiffness=lambda *state: model.stiffness))
        found = cache.find_model(KEY)
        assert found is not None
        assert found.stress_stiffness is None
        assert digest(model=found) == digest(model=model)  # every field, bit for bit

    @pytest.mark.parametrize("size", [0.5, 0.99])
    def test_a_damaged_model_is_refused(self, folder: Path, size: float) -> None:
        cache.keep_model(KEY, lattice_model(0))
        path = folder / f"{KEY}.npz"
        os.truncate(path, int(size * path.stat().st_size))
        with pytest.warns(cache.CacheWarning, match="a cached model is removed and made again: .*truncated"):
            assert cache.find_model(KEY) is None
        assert not path.exists()

    def test_a_body_is_no_model(self) -> None:
        cache.keep(KEY, lattice_body(0))
        with pytest.warns(cache.CacheWarning, match="not a saved model"):
            assert cache.find_model(KEY) is None

    def test_a_folder_that_cannot_be_written_is_warned_of(self, folder: Path) -> None:
        folder.parent.write_text("a file where the folder should be")
        with pytest.warns(cache.CacheWarning, match=r"is not cached: .*KANEFE_CACHE_DIR"):
            cache.keep(KEY, lattice_body(0))
        assert cache.find(KEY) is None

    def test_what_was_not_used_for_longest_goes_first(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        names = [f"{i}" * 32 for i in range(4)]
        cache.keep(names[0], lattice_body(0))
        size = (folder / f"{names[0]}.npz").stat().st_size
        monkeypatch.setenv("KANEFE_CACHE_GB", str(3.5e-9 * size))
        for i, name in enumerate(names):
            cache.keep(name, lattice_body(0))
            os.utime(folder / f"{name}.npz", (i, i))
        assert cache.find(names[1]) is not None  # used now, and so the last to go
        cache.keep("f" * 32, lattice_body(0))
        assert {entry.key for entry in cache.entries()} == {names[1], names[3], "f" * 32}

    def test_the_newest_stays_whatever_its_size(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("KANEFE_CACHE_GB", "0")
        cache.keep(KEY, lattice_body(0))
        cache.keep_model(KEY[::-1], lattice_model(0))
        assert [entry.key for entry in cache.entries()] == [KEY[::-1]]

    def test_a_limit_that_is_no_number_is_refused(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("KANEFE_CACHE_GB", "plenty")
        with pytest.raises(kf.ModelError, match=r"KANEFE_CACHE_GB='plenty' is not a number of gigabytes\. Remedy"):
            cache.limit()

    def test_left_overs_go_when_they_are_old(self, folder: Path) -> None:
        folder.mkdir(parents=True)
        old, new = folder / f".{KEY}.npz.abc", folder / f".{KEY}.npz.def"
        for path in (old, new):
            path.write_bytes(b"half of a body")
        os.utime(old, (0, 0))
        cache.keep(KEY, lattice_body(0))
        assert not old.exists()
        assert new.exists()  # of a process that may be writing it

    def test_the_folder_can_be_chosen(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        assert cache_folder() == folder.parent
        monkeypatch.delenv("KANEFE_CACHE_DIR")
        monkeypatch.setenv("XDG_CACHE_HOME", str(folder))
        assert cache_folder() == folder / "kanefe"


WRITER = """
import sys
from kanefe.bodies import cache
from scenes import lattice_body
body = lattice_body(0)
print("ready", flush=True)
for _ in range({rounds}):
    cache.keep({key!r}, body)
"""


class TestProcesses:
    def test_many_may_write_and_read_at_once(self, folder: Path) -> None:
        writers = [python(WRITER.format(key=KEY, rounds=30), stdout=subprocess.PIPE) for _ in range(3)]
        for writer in writers:
            assert writer.stdout is not None
            writer.stdout.readline()
        reads = 0
        expected = lattice_body(0).stiffness
        with warnings.catch_warnings():
            warnings.simplefilter("error", cache.CacheWarning)
            while any(writer.poll() is None for writer in writers) or not reads:
                found = cache.find(KEY)
                if found is not None:
                    np.testing.assert_array_equal(found.stiffness, expected)
                    reads += 1
        for writer in writers:
            writer.communicate()
            assert writer.returncode == 0
        assert os.listdir(folder) == [f"{KEY}.npz"]

    def test_a_kill_in_the_middle_leaves_no_half_of_a_body(self, folder: Path) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("error", cache.CacheWarning)
            for delay in (0.0, 0.003, 0.01, 0.03):
                writer = python(WRITER.format(key=KEY, rounds=100_000), stdout=subprocess.PIPE)
                assert writer.stdout is not None
                writer.stdout.readline()
                time.sleep(delay)
                writer.send_signal(signal.SIGKILL)
                writer.communicate()
                found = cache.find(KEY)
                assert found is None or found.free_count == lattice_body(0).free_count
            cache.keep(KEY, lattice_body(0))
            assert cache.find(KEY) is not None

    def test_a_kill_between_writing_and_renaming(self, folder: Path) -> None:
        writer = python(
            """
            import os, signal
            from kanefe.bodies import cache
            from scenes import lattice_body
            os.replace = lambda *names: os.kill(os.getpid(), signal.SIGKILL)
            cache.keep("k" * 32, lattice_body(0))
            """
        )
        assert writer.wait() == -signal.SIGKILL
        assert cache.find("k" * 32) is None
        assert [name for name in os.listdir(folder) if name.endswith(".npz")] == []
        assert cache.clear()[0] == 1  # what it left


class TestCommands:
    def run(self, monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
        monkeypatch.setattr(sys, "argv", ["kanefe", *words])
        with pytest.raises(SystemExit) as end:
            main()
        return int(end.value.code or 0)

    def test_list_and_clear(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        about = {"source": "arm.msh", "element": "tetra10", "dofs": 1234}
        cache.keep(KEY, replace(lattice_body(0), provenance=about))
        cache.keep_model("d" * 32, replace(lattice_model(0), provenance={"source": "leg.msh", "dofs": 567}))
        (folder / f"{'e' * 32}.npz").write_bytes(b"no body")
        assert self.run(monkeypatch, "cache", "list") == 0
        shown = capsys.readouterr().out
        assert KEY[:8] in shown
        (of_body,) = (line for line in shown.splitlines() if "arm.msh, tetra10, 1234 dofs" in line)
        (of_model,) = (line for line in shown.splitlines() if "leg.msh, 567 dofs" in line)
        assert "  body " in of_body
        assert "  model " in of_model
        assert "cannot be read" in shown
        assert str(folder) in shown
        assert self.run(monkeypatch, "cache", "clear") == 0
        assert "3 files" in capsys.readouterr().out
        assert cache.entries() == []
        assert self.run(monkeypatch, "cache", "list") == 0
        assert "is empty" in capsys.readouterr().out

    def test_clear_takes_the_kernels_too_when_asked(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        kernels = folder.parent / "kernels" / "abc"
        kernels.mkdir(parents=True)
        (kernels / "code.nbi").write_bytes(b"machine code")
        self.run(monkeypatch, "cache", "clear")
        assert kernels.exists()
        self.run(monkeypatch, "cache", "clear", "--kernels")
        assert not kernels.exists()


@dataclass(frozen=True)
class Thing:
    name: str
    value: Any


def scaled(factor: float) -> Any:
    return lambda x: factor * x


FACTOR = 2.0


def of_module(x: float) -> float:
    return FACTOR * np.sqrt(x)


class TestDigest:
    @pytest.mark.parametrize(
        ("a", "b"),
        [
            (1.0, 1.0 + 2e-16),
            (1, True),
            ("a", b"a"),
            (("a", "b"), ("ab",)),
            ([[1], [2]], [[1, 2]]),
            ({"a": 1, "b": 2}, {"b": 2, "a": 1}),  # the order of interfaces is the order of coordinates
            (np.zeros(2), np.zeros(3)),
            (np.zeros(2), np.zeros(2, dtype=int)),
            (np.zeros((2, 3)), np.zeros((3, 2))),
            (sp.identity(3), sp.identity(4)),
            (Thing("a", 1), Thing("a", 2)),
            (kf.CraigBampton(modes=3), kf.CraigBampton(modes=4)),
            (scaled(2.0), scaled(3.0)),
            (lambda x: x + 1, lambda x: x + 2),
            (lambda x: x.real, lambda x: x.imag),
            (None, 0),
        ],
    )
    def test_what_differs_has_another_digest(self, a: Any, b: Any) -> None:
        assert digest(part=a) != digest(part=b)
        assert digest(part=a) == digest(part=a)

    def test_what_is_equal_has_the_same_digest(self) -> None:
        assert digest(a=np.arange(6.0).reshape(2, 3)) == digest(a=np.asfortranarray(np.arange(6.0).reshape(2, 3)))
        assert digest(a=[1, 2]) == digest(a=(1, 2))
        assert digest(a=np.float64(0.1)) == digest(a=0.1)
        assert digest(a=scaled(2.0)) == digest(a=scaled(2.0))
        twice = sp.csr_matrix((np.ones(2), ([0, 0], [1, 1])), (2, 2))
        assert digest(a=twice) == digest(a=sp.csr_matrix((np.full(1, 2.0), ([0], [1])), (2, 2)))

    def test_a_function_counts_by_what_it_uses(self, monkeypatch: pytest.MonkeyPatch) -> None:
        before = digest(a=of_module)
        assert digest(a=of_module) == before
        monkeypatch.setitem(of_module.__globals__, "FACTOR", 3.0)
        assert digest(a=of_module) != before

    def test_a_file_counts_by_its_content(self, tmp_path: Path) -> None:
        for name in ("a", "b"):
            (tmp_path / name).write_bytes(b"mesh")
        assert digest(a=tmp_path / "a") == digest(a=tmp_path / "b")
        (tmp_path / "b").write_bytes(b"mess")
        assert digest(a=tmp_path / "a") != digest(a=tmp_path / "b")

    def test_the_same_in_every_process(self) -> None:
        code = "from kanefe.storage.digest import digest; print(digest(a={'x', 'y', 'z'}, b=lambda x: x in {1, 2}))"
        first, second = (python(code, stdout=subprocess.PIPE).communicate()[0] for _ in range(2))
        assert first == second != ""

    def test_what_cannot_be_told_is_named(self) -> None:
        with pytest.raises(Unhashable, match=r"things\[1\]\.value is an object of _thread\.lock"):
            digest(things=[Thing("a", 1), Thing("b", threading.Lock())])

    def test_the_code_counts(self, tmp_path: Path) -> None:
        (tmp_path / "a.py").write_text("x = 1\n")
        before = code_stamp(tmp_path)
        (tmp_path / "a.py").write_text("x = 2\n")
        assert code_stamp(tmp_path) != before

    def test_versions_without_importing(self) -> None:
        assert installed_versions("numpy", "no-such-package") == {"numpy": np.__version__}
