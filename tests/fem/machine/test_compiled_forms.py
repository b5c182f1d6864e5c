"""Compiled forms of dolfinx: damaged ones, those that others can write, and what the compiler is told."""

from __future__ import annotations

import os
from collections.abc import Callable
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import pytest

from kanefe.errors import FileError
from kanefe.storage import kept_code
from kanefe_fem import Material, box_mesh, solid_model
from kanefe_fem.machine import compiled_forms
from kanefe_fem.machine.compiled_forms import OPTIONS, VARIABLE, being_compiled, check_forms, forms_folder, keep_digests

ON_POSIX = pytest.mark.skipif(os.name != "posix", reason="modes tell nothing there")
AS_ROOT = pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="only root gives files to others")
NOBODY = 65534


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a library as FFCx leaves it, in a folder of the user's; it is new to this process."""
    monkeypatch.setattr(compiled_forms, "_sound", set())
    folder = tmp_path / "forms"
    folder.mkdir(mode=0o700)
    for suffix in (".c", ".c.cached", ".o", EXTENSION_SUFFIXES[0]):
        (folder / f"form{suffix}").write_bytes(b"content" * 1000)
    (folder / "other.c").write_text("being compiled by another process")
    return folder / f"form{EXTENSION_SUFFIXES[0]}"


def one_bit(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[123] ^= 4
    path.write_bytes(content)


@pytest.mark.parametrize(
    "damage", [one_bit, Path.unlink, lambda path: os.truncate(path, 100)], ids=["bit", "gone", "cut"]
)
def test_what_is_damaged_is_removed_and_so_compiled_anew(
    library: Path,
    damage: Callable[[Path], None],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    keep_digests(library.parent)
    monkeypatch.setattr(compiled_forms, "_sound", set())
    check_forms(library.parent)
    assert library.exists()
    damage(library)
    monkeypatch.setattr(compiled_forms, "_sound", set())
    check_forms(library.parent)
    assert [path.name for path in library.parent.iterdir() if path.suffix] == ["other.c"]
    assert "form is damaged: it is compiled again" in capsys.readouterr().err


@ON_POSIX
def test_what_a_process_left_that_was_ended_while_it_compiled_is_removed(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """For each such form dolfinx waited 10 s, and then raised a TimeoutError, for ever."""
    monkeypatch.setattr(compiled_forms, "forms_folder", lambda: library.parent)
    with being_compiled(library.parent):  # here or in another process
        check_forms(library.parent)
        assert library.with_name("other.c").exists()
    assert not library.with_name("other.c").exists()
    assert library.exists()


@ON_POSIX
def test_what_others_compile_under_an_open_umask_in_a_shut_folder_is_no_foreign_code(library: Path) -> None:
    library.with_name("other.c").chmod(0o666)
    check_forms(library.parent)
    assert library.with_name("other.c").stat().st_mode & 0o777 == 0o644


@ON_POSIX
def test_what_is_removed_while_it_is_looked_at_is_no_error(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def check(path: Path, variable: str) -> None:
        path.unlink(missing_ok=True)
        path.lstat()

    monkeypatch.setattr(compiled_forms, "check_entry", check)
    check_forms(library.parent)


@ON_POSIX
def test_what_others_may_write_is_refused(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library.parent.chmod(0o711)
    library.chmod(0o666)
    with pytest.raises(FileError, match=rf"form.* others may write it .*Remedy: chmod go-w .*{VARIABLE}="):
        check_forms(library.parent)
    library.chmod(0o644)
    library.parent.chmod(0o777)
    monkeypatch.setattr(kept_code, "_checked", set())
    with pytest.raises(FileError, match=r"forms: others may write it"):
        check_forms(library.parent)


@AS_ROOT
@pytest.mark.parametrize("by_link", [False, True])
def test_what_belongs_to_others_is_refused(library: Path, by_link: bool, tmp_path: Path) -> None:
    if by_link:
        library.rename(tmp_path / "theirs")
        library.symlink_to(tmp_path / "theirs")
    os.chown(library, NOBODY, NOBODY)
    with pytest.raises(FileError, match=r"belongs to user 65534, who could run code here. Remedy: "):
        check_forms(library.parent)


@ON_POSIX
def test_the_folder_and_its_libraries_are_the_users_alone_whatever_the_umask(
    tmp_path: Path, library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "caches"))
    before = os.umask(0)
    try:
        folder = forms_folder.__wrapped__()
        library.chmod(0o777)
        keep_digests(library.parent)
    finally:
        os.umask(before)
    assert {place.stat().st_mode & 0o777 for place in (folder, *folder.parents[:4])} == {0o700}
    assert library.stat().st_mode & 0o777 == 0o755
    assert library.with_name("form.digest").stat().st_mode & 0o022 == 0
    check_forms(library.parent)


@pytest.mark.fenicsx
@pytest.mark.parametrize("name", OPTIONS)
def test_options_of_the_compiler_in_the_working_directory_are_refused(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path(name).write_text('{"cffi_extra_compile_args": ["-B./"]}')  # gcc would run ./cc1
    mesh, steel = box_mesh((1.0, 0.1, 0.1), (2, 1, 1)), Material(E=210e9, nu=0.3, rho=7850.0)
    with pytest.raises(FileError, match=rf"would take options from .*{name}, .*Remedy: start in another folder"):
        solid_model(mesh, steel)
    Path(name).unlink()
    assert solid_model(mesh, steel).size == 135  # 5 x 3 x 3 nodes
