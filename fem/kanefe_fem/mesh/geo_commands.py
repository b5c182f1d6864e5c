"""What a gmsh script (.geo) asks for beyond a geometry: programs to be run, and files to be read or written."""

from __future__ import annotations

import re
from typing import NamedTuple

from kanefe.errors import FileError

RUNS = frozenset({"SystemCall", "NonBlockingSystemCall", "OnelabRun", "ExternalProcess"})
"""Words that run a program: commands, and the mesh size field that asks one. Refused wherever they stand, also in texts
and comments, so that nothing depends on where gmsh takes a text to end."""

OPENS = frozenset({"Include", "Merge", "ShapeFromFile", "ListFromFile", "Print", "Save", "CreateDir", "Plugin"})
"""Words that read or write files of the script's choice."""

NAMES = frozenset({"StringToName", "S2N"})
"""Words that make a name out of a text, so that the script does not show what it calls."""

PRINTS = frozenset({"Printf", "Error", "Warning"})
"""Words that print a line, and write it to a file where ``>`` follows."""

FILE_OPTION = re.compile(r"\w*File(Name)?\w*")
"""Names of options that name files, such as the file of a mesh size field."""

TOKEN = re.compile(
    r"""//[^\n]* | /\*.*?(?:\*/|\Z) | "[^"]*(?:"|\Z) | '[^']*(?:'|\Z) | [A-Za-z_]\w* | >>? | ; | \. | \n""",
    re.VERBOSE | re.DOTALL,
)
"""Comments, texts, words, and the signs that tell what a word does."""


class Command(NamedTuple):
    """A word of a script, and what is wrong with it.

    Attributes
    ----------
    word : str
    what : str
    line : int
        From 1.
    """

    word: str
    what: str
    line: int


def check_script(script: str, name: str) -> None:
    """Refuse a script that does more than make a geometry and mesh it.

    Parameters
    ----------
    script : str
        Text of a .geo file.
    name : str
        Of the file.

    Raises
    ------
    FileError
        Names the line, and the remedy.
    """
    found = first_command(script)
    if found is not None:
        text = script.splitlines()[found.line - 1].strip()
        raise FileError(
            f"{name}, line {found.line}: {found.word} {found.what}: {text[:120]!r}. Remedy: a script that makes its "
            "geometry by itself; or, if you know what this one does, read_mesh(..., trusted=True)"
        )


def first_command(script: str) -> Command | None:
    r"""Return the first word that runs a program, or reads or writes a file; None where there is none.

    Examples
    --------
    >>> first_command('Point(1) = {0, 0, 0};\nSystemCall "ls";')
    Command(word='SystemCall', what='runs a program', line=2)
    """
    for match in re.finditer(r"[A-Za-z_]\w*", script):
        if match[0] in RUNS | NAMES:
            what = "runs a program" if match[0] in RUNS else "hides what it calls"
            return Command(match[0], what, 1 + script.count("\n", 0, match.start()))
    line, printing, after_dot = 1, "", False
    for match in TOKEN.finditer(script):
        token = match[0]
        if token in OPENS and not after_dot:
            return Command(token, "reads or writes files of its choice", line)
        if token in PRINTS:
            printing = token
        elif token.startswith(">") and printing:
            return Command(printing, "writes a file", line)
        elif token == ";":
            printing = ""
        elif after_dot and FILE_OPTION.fullmatch(token):
            return Command(token, "is the name of a file of its choice", line)
        after_dot = token == "."
        line += token.count("\n")
    return None
