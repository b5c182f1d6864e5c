"""The cache of kernels runs nothing foreign: planted, damaged and open files, folders of others."""

from __future__ import annotations

import grp
import os
import pwd
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from kanefe.errors import FileError
from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.storage import kept_code

pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="modes tell nothing there"),
    pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python"),
]

AS_ROOT = pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="only root gives files to others")
NOBODY = 65534

CODE = """
import sys
import numpy as np
from kanefe.errors import FileError
from kanefe.kernels.compiler.addresses import NUMBER, NUMBERS, call_in_python, house_address
from kanefe.kernels.force_elements.given import given
out = np.zeros(2)
try:
    address = house_address(given, NUMBER, *[NUMBERS] * 5)
    call_in_python(address, (0.0, np.array((2.0,)), np.array((3.0, 4.0)), np.zeros(0), np.zeros(0), out))
    print(out.tolist())
except FileError as error:
    print("refused:", error)
"""
"""Runs the smallest kernel there is."""

PLANTED = """
#include <stdio.h>
__attribute__((constructor)) static void owned(void) { fclose(fopen("OWNED", "w")); }
void kanefe_unit(void) {}
"""


@pytest.fixture(scope="module")
def full(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a cache with the one kernel."""
    cache = tmp_path_factory.mktemp("full") / "cache"
    assert run(cache)[0] == "[3.0, 4.0]"
    return cache


@pytest.fixture
def cache(full: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(full, tmp_path / "cache"))


def run(cache: Path, umask: int = -1) -> tuple[str, str]:
    """Return what a new process prints, and its errors."""
    variables = {"KANEFE_CACHE_DIR": str(cache), "KANEFE_JIT": "1"}
    command = [sys.executable, "-c", CODE]
    done = subprocess.run(
        command, env=os.environ | variables, cwd=cache.parent, capture_output=True, text=True, umask=umask, check=True
    )
    assert not (cache.parent / "OWNED").exists()
    return done.stdout.strip(), done.stderr


def file_in(cache: Path) -> Path:
    (found,) = cache.rglob("*.so")
    return found


def planted(path: Path) -> None:
    source = path.parent / "planted.c"
    source.write_text(PLANTED)
    subprocess.run(["cc", "-shared", "-fPIC", "-o", str(path), str(source)], check=True)
    source.unlink()


def one_bit(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(content)


DAMAGE: dict[str, Callable[[Path], object]] = {
    "planted": planted,
    "one bit": one_bit,
    "half": lambda path: os.truncate(path, path.stat().st_size // 2),
    "empty": lambda path: os.truncate(path, 0),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_what_is_not_what_was_built_is_not_loaded(cache: Path, damage: str) -> None:
    whole = file_in(cache).read_bytes()
    DAMAGE[damage](file_in(cache))
    assert file_in(cache).read_bytes() != whole
    with pytest.raises(kept_code.Damaged), kept_code.opened(file_in(cache)):
        pass
    assert not list(cache.rglob("*.so"))  # so that it is built again


def test_a_damaged_file_is_built_anew_and_told(cache: Path) -> None:
    planted(file_in(cache))
    printed, said = run(cache)
    assert printed == "[3.0, 4.0]"
    assert "is damaged: it is built again" in said
    assert run(cache) == ("[3.0, 4.0]", "")


def test_a_file_of_another_name_is_not_taken(cache: Path) -> None:
    path = file_in(cache)
    other = path.with_name(path.name.replace("given-", "taken-"))
    path.rename(other)
    with pytest.raises(kept_code.Damaged), kept_code.opened(other):
        pass


def test_folders_and_files_are_the_owners_whatever_the_umask(tmp_path: Path) -> None:
    cache = tmp_path / "new" / "cache"
    (tmp_path / "new").mkdir()
    assert run(cache, umask=0)[0] == "[3.0, 4.0]"
    assert [path for path in (cache, *cache.rglob("*")) if path.stat().st_mode & 0o077] == []


def test_folders_of_the_cache_that_others_may_write_are_shut(cache: Path) -> None:
    folder = file_in(cache).parent
    folder.chmod(0o777)
    folder.parent.chmod(0o1777)
    assert run(cache) == ("[3.0, 4.0]", "")
    assert [path.stat().st_mode & 0o077 for path in (folder, folder.parent)] == [0, 0]


def test_a_group_that_a_user_has_alone_is_no_other(cache: Path) -> None:
    cache.parent.chmod(0o770)
    group = grp.getgrgid(cache.parent.stat().st_gid)
    if group.gr_name != pwd.getpwuid(os.geteuid()).pw_name or group.gr_mem:
        pytest.skip("the folder's group is no private one")
    assert run(cache)[0] == "[3.0, 4.0]"


@pytest.mark.parametrize("mode", [0o777, pytest.param(0o770, marks=AS_ROOT)])
def test_a_parent_that_others_may_write_is_refused_with_the_remedy(cache: Path, mode: int) -> None:
    if mode == 0o770:
        os.chown(cache.parent, -1, NOBODY)
    cache.parent.chmod(mode)
    assert f"others may write it (mode {mode:o})" in run(cache)[0]
    assert f"Remedy: chmod go-w {cache.parent}" in run(cache)[0]
    cache.parent.chmod(0o1777)  # as /tmp: each removes only what is his
    assert run(cache)[0] == "[3.0, 4.0]"


def test_a_file_that_others_may_write_is_refused(cache: Path) -> None:
    file_in(cache).chmod(0o666)
    assert f"Remedy: rm -r {file_in(cache).parent}" in run(cache)[0]


@AS_ROOT
@pytest.mark.parametrize("what", ["file", "folder", "cache"])
def test_what_belongs_to_another_is_refused(cache: Path, what: str) -> None:
    path = {"file": file_in(cache), "folder": file_in(cache).parent, "cache": cache}[what]
    os.chown(path, NOBODY, NOBODY)
    printed, _ = run(cache)
    assert printed.startswith("refused:")
    assert f"{path}: it belongs to user {NOBODY}" in printed


@AS_ROOT
def test_a_link_to_a_folder_of_another_is_refused(cache: Path, tmp_path: Path) -> None:
    theirs = tmp_path / "theirs"
    shutil.move(cache / "kernels", theirs)
    os.chown(theirs, NOBODY, NOBODY)
    (cache / "kernels").symlink_to(theirs)
    assert run(cache)[0].startswith("refused:")


def test_what_is_checked_is_what_is_loaded(cache: Path) -> None:
    path = file_in(cache)
    whole = path.read_bytes()
    with kept_code.opened(path) as (descriptor, content):
        spare = path.with_name("spare")
        planted(spare)
        spare.replace(path)
        assert content == whole
        assert Path(f"/proc/self/fd/{descriptor}").read_bytes() == whole


def test_two_files_of_one_name_are_both_sound(tmp_path: Path) -> None:
    """Two processes that build at once need not make the same bytes."""
    made = [kept_code.keep(tmp_path, "unit-stamp", content) for content in (b"one", b"other")]
    assert all(kept_code.is_sound(path) for path in made)
    assert kept_code.kept(tmp_path, "unit-stamp") in made


def test_a_folder_is_checked_before_it_is_listed(tmp_path: Path) -> None:
    folder = tmp_path / "open"
    folder.mkdir()
    folder.chmod(0o777)
    with pytest.raises(FileError, match="others may write it"):
        kept_code.kept(folder, "unit-stamp")


SCENE = """
import kanefe as kf
scene = kf.System(gravity=(0, -9.81, 0))
scene.add_rigid_body("p", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z", position=0.1))
for method in ("auto", "dop853", "rk4", "radau5"):
    try:
        scene.simulate((0.0, 1.0), method=method, **({"step": 0.01} if method == "rk4" else {}))
    except kf.FileError as error:
        print("refused:", error)
"""


def test_a_run_whose_kernels_are_refused_ends_at_once(cache: Path) -> None:
    """It took the refusal for a state without an answer, and tried for ever."""
    cache.parent.chmod(0o777)
    variables = os.environ | {"KANEFE_CACHE_DIR": str(cache), "KANEFE_JIT": "1"}
    done = subprocess.run([sys.executable, "-c", SCENE], env=variables, capture_output=True, text=True, timeout=60)
    assert done.stdout.count("refused: compiled code is not loaded from") == 4, done


def test_a_shared_folder_as_cache_stays_shared(cache: Path) -> None:
    cache.chmod(0o1777)
    assert run(cache) == ("[3.0, 4.0]", "")
    assert cache.stat().st_mode & 0o7777 == 0o1777
