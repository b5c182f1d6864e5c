"""Scripts of gmsh that do more than make a geometry: refused by the line that does it, unless they are trusted."""

from __future__ import annotations

from pathlib import Path

import pytest

from kanefe.errors import FileError
from kanefe_fem import read_mesh
from kanefe_fem.mesh.geo_commands import first_command

BOX = 'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 1, 1};\nPhysical Volume("v") = {1};\n'


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ('SystemCall "touch owned";', "SystemCall"),
        ('SystemCall\n\n"touch owned";', "SystemCall"),
        ('x = 1; /* a\ncomment */ NonBlockingSystemCall "ls";', "NonBlockingSystemCall"),
        ('s = "SystemCall"; t = "//"; SystemCall s;', "SystemCall"),
        ("s = '\"'; SystemCall 'ls';", "SystemCall"),
        ('OnelabRun("a", "ls");', "OnelabRun"),
        ('Field[1] = ExternalProcess;\nField[1].CommandLine = "ls";', "ExternalProcess"),
        ('Field[1] = StringToName[StrCat("External", "Process")];', "StringToName"),
        ('Field[1].FileName = "/etc/passwd";', "FileName"),
        ('Merge "/etc/passwd";', "Merge"),
        ('Include "other.geo";', "Include"),
        ('ShapeFromFile("part.step");', "ShapeFromFile"),
        ('Print "picture.png";', "Print"),
        ('Save "mesh.msh";', "Save"),
        ('CreateDir "folder";', "CreateDir"),
        ("Plugin(MathEval).Run;", "Plugin"),
        ('Printf("a > b %g", 1) >> "log.txt";', "Printf"),
    ],
)
def test_what_a_script_may_not_do_is_found_in_its_line(line: str, word: str) -> None:
    found = first_command(BOX + line)
    assert found is not None
    assert found.word == word
    assert word in line.splitlines()[found.line - 4]


@pytest.mark.parametrize(
    "line",
    [
        "// Merge",
        "/* Merge\nSave */",
        's = "Save";',
        'Printf("%g > %g", 1, 2);',
        "If(x > 1) Box(2) = {2, 0, 0, 1, 1, 1}; EndIf",
        'Printf("a"); If(x > 1) EndIf',
        "Mesh.SaveAll = 1; MergeTolerance = 1; SaveMe = 2;",
    ],
)
def test_comments_texts_and_comparisons_do_nothing(line: str) -> None:
    assert first_command(BOX + line) is None


@pytest.mark.gmsh
def test_a_script_runs_nothing_unless_it_is_trusted(tmp_path: Path) -> None:
    owned, path = tmp_path / "owned", tmp_path / "part.geo"
    path.write_text(f'{BOX}SystemCall "touch {owned}";\nMesh.MeshSizeMax = 1;\n')
    with pytest.raises(FileError, match=r"part\.geo, line 4: SystemCall runs a program: .*Remedy: .*trusted=True"):
        read_mesh(path)
    assert not owned.exists()
    read_mesh(path, trusted=True)
    assert owned.exists()
