"""Scripts of gmsh that do more than make a geometry: refused by the line that does it, unless they are trusted."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pytest

from kanefe.errors import FileError
from kanefe_fem import read_mesh
from kanefe_fem.mesh.geo_commands import first_refused, without_comments

BOX = 'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 1, 1};\nPhysical Volume("v") = {1};\n'
ONE_TETRAHEDRON = (
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
    "$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n"
)


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
        ('System "touch owned";', "System"),
        ('System/**/"touch owned";', "System"),
        ('MergeWithBoundingBox "other.geo";', "MergeWithBoundingBox"),
        ('NewCommand "touch owned";', "NewCommand"),
        ('If(1) NewCommand StrCat("touch", " owned"); EndIf', "NewCommand"),
        ('Solver.Executable0 = "ls";', "Solver"),
        ('General.LogFileName = "log";', "LogFileName"),
        ("Exit;", "Exit"),
        ("Abort;", "Abort"),
        ("For i In {0:1}", "For"),
        ("EndFor", "EndFor"),
        ("For i In {0:1} " + " " * 8000 + "EndFor", "For"),
        ("ElseIf1System = 2;", "ElseIf1System"),
    ],
)
def test_what_a_script_may_not_do_is_found_in_its_line(line: str, word: str) -> None:
    found = first_refused(BOX + line)
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
        "Mesh.SaveAll = 1; MergeTolerance = 1; SaveMe = 2; Mesh.MshFileVersion = 2.2; Print.Width = 3;",
        'DefineConstant[ a = {1, Name "Size", Choices {1="small", 2="large"}, Highlight "Blue"} ];',
        'Call "f"; Physical Surface(Str("a")) = {1}; x() = Surface "*"; SetName "part"; View "v" { };',
        'Field[1] = MathEval; Field[1].F = "x + 1"; name = StrPrefix(General.FileName);',
    ],
)
def test_comments_texts_and_comparisons_do_nothing(line: str) -> None:
    assert first_refused(BOX + line) is None


LED_ASTRAY = {
    "behind a loop": 'For i In {0:1} /*\nSystem "touch owned"; // */\nEndFor\n',
    "behind a call": 'Macro f\nReturn\nCall f; /*\nSystem "touch owned"; */\n',
    "an end in a comment": 'If (0)\nE/* EndIf System "touch owned"; */\nEndIf\n',
    "an end in a text": "If (0)\nE = \"EndIf System 'touch owned'; \";\nEndIf\n",
    "a long text": 's = "' + "a" * 1023 + "; System 'touch owned'; //\";\n",
    "a text of several lines": "For i In {0:1} s = \"\n; System 'touch owned'; \";\nEndFor\n",
    "a zero byte": '// \0 System "touch owned";\n',
    "the last line": "If (0)\n/* ; System 'touch owned'; */",
}
"""Scripts with a command in a comment or a text that gmsh 4.8 leaves, most of them so that it is run."""


@pytest.mark.gmsh
@pytest.mark.parametrize("script", LED_ASTRAY.values(), ids=LED_ASTRAY)
def test_gmsh_is_not_led_out_of_comments_and_texts(
    script: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("part.geo").write_text(BOX + "Mesh.MeshSizeMin = 1;\n" + script)
    with contextlib.suppress(FileError):  # what could not hide anything is read
        read_mesh("part.geo")
    assert [path.name for path in tmp_path.iterdir()] == ["part.geo"]


def test_comments_are_left_out_and_all_else_keeps_its_line() -> None:
    script = 'a = "//"; // one\r\n/* two\n */ b = 1;'
    assert without_comments(script).split("\n") == ['a = "//";        ', "      ", "    b = 1;", ""]


@pytest.mark.gmsh
def test_a_script_runs_nothing_unless_it_is_trusted(tmp_path: Path) -> None:
    owned, path = tmp_path / "owned", tmp_path / "part.geo"
    path.write_text(f'{BOX}SystemCall "touch {owned}";\nMesh.MeshSizeMax = 1;\n')
    with pytest.raises(FileError, match=r"part\.geo, line 4: SystemCall runs a program: .*Remedy: .*trusted=True"):
        read_mesh(path)
    assert not owned.exists()
    read_mesh(path, trusted=True)
    assert owned.exists()


@pytest.mark.gmsh
@pytest.mark.parametrize("head", ["\n", " ", "\t\n"])
def test_a_mesh_that_gmsh_takes_for_a_script_is_refused(tmp_path: Path, head: str) -> None:
    owned, path = tmp_path / "owned", tmp_path / "part.msh"
    sections = "".join(f"${name}\n$End{name}\n" for name in ("Nodes", "Elements"))
    path.write_text(f'{head}$MeshFormat\n4.1 0 8\n$EndMeshFormat\n{sections};\nSystem "touch {owned}";\n$EndElements\n')
    with pytest.raises(FileError, match="does not begin with"):
        read_mesh(path)
    assert not owned.exists()


@pytest.mark.gmsh
@pytest.mark.parametrize("name", ["part.geo", "part.msh"])
def test_options_beside_a_mesh_are_a_script_too(tmp_path: Path, name: str) -> None:
    owned, path = tmp_path / "owned", tmp_path / name
    path.write_text(BOX if name.endswith(".geo") else ONE_TETRAHEDRON)
    read_mesh(path)
    path.with_name(f"{name}.opt").write_text(f'System "touch {owned}";\n')
    with pytest.raises(FileError, match=rf"beside {name} lies {name}\.opt, .*Remedy: .*trusted=True"):
        read_mesh(path)
    assert not owned.exists()
    read_mesh(path, trusted=True)
    assert owned.exists()


@pytest.mark.gmsh
def test_a_mesh_named_as_a_script_is_refused(tmp_path: Path) -> None:
    (tmp_path / "part.geo").write_text(ONE_TETRAHEDRON)
    with pytest.raises(FileError, match=r"Remedy: name it \.msh"):
        read_mesh(tmp_path / "part.geo")
