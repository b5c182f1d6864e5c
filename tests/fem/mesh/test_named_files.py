"""Files that a mesh or an input file names: read only where they lie below its folder, unless it is trusted."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path

import pytest

import kanefe as kf
from kanefe.errors import FileError, MeshError
from kanefe.imports.abaqus_job import job_of
from kanefe_fem import read_mesh


def tetrahedron(first: int) -> str:
    """Return an input file of one tetrahedron, its nodes numbered from some label on."""
    nodes = "".join(f"{first + i}, {x}, {first}.\n" for i, x in enumerate(("0., 0.", "1., 0.", "0., 1.")))
    labels = ", ".join(str(first + i) for i in range(4))
    return f"*NODE\n{nodes}{first + 3}, 0., 0., {first + 1}.\n*ELEMENT, TYPE=C3D4, ELSET=V\n{first}, {labels}\n"


def mesh_of(path: Path, trusted: bool) -> None:
    """Read a mesh, whose tetrahedra are several bodies."""
    with contextlib.suppress(MeshError):
        read_mesh(path, trusted=trusted)


READERS: dict[str, Callable[[Path, bool], object]] = {
    "read_mesh": mesh_of,
    "read_abaqus": job_of,
}


@pytest.fixture
def job(tmp_path: Path) -> Path:
    """Return an input file in a folder, beside which lie the nodes of another job."""
    (tmp_path / "secret.inp").write_text(tetrahedron(11))
    (tmp_path / "job" / "parts").mkdir(parents=True)
    return tmp_path / "job" / "main.inp"


@pytest.mark.parametrize("read", READERS.values(), ids=READERS)
@pytest.mark.parametrize("how", ["absolute", "up", "link", "in an included file"])
def test_files_outside_the_folder_are_read_only_if_trusted(
    job: Path, how: str, read: Callable[[Path, bool], object]
) -> None:
    outside = job.parent.parent / "secret.inp"
    (job.parent / "link.inp").symlink_to(outside)
    (job.parent / "parts" / "a.inp").write_text(tetrahedron(21) + "*INCLUDE, INPUT=../../secret.inp\n")
    named = {"absolute": str(outside), "up": "../secret.inp", "link": "link.inp", "in an included file": "parts/a.inp"}
    job.write_text(f"{tetrahedron(1)}*INCLUDE, INPUT={named[how]}\n")
    with pytest.raises(FileError, match=r"which does not lie below .*job\. Remedy: put it there; or.* trusted=True\)"):
        read(job, False)
    read(job, True)


@pytest.mark.parametrize("read", READERS.values(), ids=READERS)
def test_files_below_the_folder_are_read(job: Path, read: Callable[[Path, bool], object]) -> None:
    (job.parent / "nodes.inp").write_text(tetrahedron(11))
    (job.parent / "parts" / "a.inp").write_text(tetrahedron(21) + "*INCLUDE, INPUT=../nodes.inp\n")
    job.write_text(f"{tetrahedron(1)}*INCLUDE, INPUT=parts/a.inp\n")
    read(job, False)


def test_an_include_may_be_written_in_many_ways(job: Path) -> None:
    job.write_text(tetrahedron(1) + "  *include,INPUT = ../secret.inp\r*END\n", newline="")
    with pytest.raises(FileError, match="does not lie below"):
        read_mesh(job)


@pytest.mark.parametrize(
    "item",
    [
        '<DataItem Format="HDF" Dimensions="4 3">../data.h5:/x</DataItem>',
        '<DataItem\nDimensions="4 3" Format="HDF">&#46;&#46;/data.h5:/x</DataItem>',
        '<DataItem Dimensions="4 3" Format="Binary">{outside}</DataItem>',
    ],
)
def test_data_of_xdmf_outside_the_folder_are_refused(job: Path, item: str) -> None:
    outside = job.parent.parent / "data.h5"
    outside.write_bytes(b"data")
    path = job.with_suffix(".xdmf")
    path.write_text(f'<Xdmf Version="3.0"><Domain><Grid>{item.format(outside=outside)}</Grid></Domain></Xdmf>')
    with pytest.raises(FileError, match=r"data\.h5, which does not lie below"):
        read_mesh(path)


def test_read_abaqus_takes_the_word(job: Path) -> None:
    job.write_text("*INCLUDE, INPUT=../secret.inp\n")
    with pytest.raises(FileError, match=r"read_abaqus\(\.\.\., trusted=True\)"):
        kf.read_abaqus(job, "k.mtx", "m.mtx")
    with pytest.raises(FileError, match=r"no file k\.mtx"):
        kf.read_abaqus(job, "k.mtx", "m.mtx", trusted=True)
