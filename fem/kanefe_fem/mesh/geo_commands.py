"""Refusal of gmsh scripts (.geo) that run programs, or read or write files.

If a script is not trusted, gmsh gets a copy without comments, in which strings are short and on one line. Otherwise a
script could hide commands in comments and strings, because gmsh does not skip them reliably: after a `For` or `Call` it
jumps back to the start of the next line, it searches for the end of a skipped `If` as plain text, it truncates long
strings, and it keeps the rest of a last line without a line end.
"""

from __future__ import annotations

import os
import re
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from kanefe.errors import FileError

RUNS = "runs a program"
OPENS = "reads or writes files of its choice"

COMMANDS = {
    **dict.fromkeys(("System", "SystemCall", "NonBlockingSystemCall", "OnelabRun", "ExternalProcess"), RUNS),
    **dict.fromkeys(("Include", "Merge", "MergeWithBoundingBox", "ShapeFromFile", "ListFromFile"), OPENS),
    **dict.fromkeys(("Print", "Save", "CreateDir", "Plugin"), OPENS),
    **dict.fromkeys(("StringToName", "S2N"), "makes a name of a text, and so hides what it calls"),
    "SetString": "sets a parameter of other programs",
    "SendToServer": "opens a connection",
    "Exit": "ends Python",
    "Abort": "leaves gmsh in the middle of a script",
}
"""Words that are refused: commands, functions, and the mesh size field that calls a program."""

PRINTS = ("Printf", "Error", "Warning")
"""Words that print a line, or write it to a file if ``>`` follows."""

TAKES_TEXT = frozenset(
    ["SetName", "OptimizeMesh", "View", "Macro", "Function", "Call", "Point", "Line", "Curve", "Surface", "Volume"]
)
"""Words that may precede a text and run nothing. Other words that precede a text are unknown commands."""

TEXT_FUNCTION = re.compile(
    r"Str(Cat|Prefix|Relative|Replace|Choice|Sub)?|Sprintf|N2S|NameToString|NameStruct|DefineString|Today|CodeName"
    r"|Get(Env|String|StringValue|ForcedStr)|UpperCase|LowerCase(In)?|OnelabAction|GmshExecutableName"
    r"|Current(Dir|Directory|FileName)|DirName|FixRelativePath|AbsolutePath"
)
"""Functions that return a text."""

OPTION = re.compile(r"\w*(FileName|FilePattern|FileToLoad|RecentFile|Command|Executable|Interpreter|SocketName)\w*")
"""Names of options that are files or programs, such as the file of a mesh size field."""

JUMPS = ("For", "EndFor", "Macro", "Function", "Call", "Return")
"""Words after which gmsh continues in another line."""

ENDS = re.compile(r"EndIf|EndFor|Else(?:If)?|Return")
"""Words where gmsh ends a skipped part: it also finds them within texts and before a digit."""

LONGEST_TEXT = 1000
"""Largest length of a text in characters; gmsh ends a text after 1,023."""

LONGEST_LINE = 8000
"""Largest length of a line in characters; gmsh reads 8,192 at once and then continues from there."""

TOKEN = re.compile(
    r"""(?P<comment>//[^\n]*|/\*.*?(?:\*/|\Z)) | (?P<text>"[^"]*(?:"|\Z)|'[^']*(?:'|\Z))
    | (?P<number>\d+(?:\.\d*)?(?:[eE][-+]?\d+)?|\.\d+(?:[eE][-+]?\d+)?) | (?P<word>[A-Za-z_]\w*) | (?P<sign>\S)""",
    re.VERBOSE | re.DOTALL | re.ASCII,
)


class Token(NamedTuple):
    """A text, number, word or sign of a script, and the place of its first character."""

    kind: str
    text: str
    place: int


class Refused(NamedTuple):
    """A refused word of a script, the reason, and its line.

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


def harmless_script(path: Path) -> bytes:
    """Return a script without its comments if all it does is to make a geometry and mesh it.

    Raises
    ------
    FileError
        If the script does anything else; the message names the line and the remedy.
    """
    refuse_options(path)
    script = path.read_bytes().decode("latin-1")  # one character a byte, as gmsh reads it
    if script.startswith("$"):
        raise FileError(f"{path.name} is not a script, but begins as a mesh. Remedy: name it .msh")
    found = first_refused(script)
    if found is not None:
        line = script.split("\n")[found.line - 1].encode("latin-1").decode("utf-8", errors="replace")
        raise FileError(
            f"{path.name}, line {found.line}: {found.word} {found.what}: {line.strip()[:120]!r}. Remedy: a script that "
            "makes its geometry by itself; or, if you know what this one does, read_mesh(..., trusted=True)"
        )
    return without_comments(script).encode("latin-1")


def refuse_options(path: Path) -> None:
    """Refuse a script or mesh with an options file beside it, which gmsh runs as a script.

    Raises
    ------
    FileError
        If there is such a file; the message names both files.
    """
    options = f"{path.name}.opt"
    if os.path.lexists(path.with_name(options)):
        raise FileError(
            f"beside {path.name} lies {options}, which gmsh would run as a script. Remedy: remove or rename it; or, if "
            "you know what it does, read_mesh(..., trusted=True)"
        )


def without_comments(script: str) -> str:
    """Return a script with its comments replaced by blanks, the same lines, and a line end after the last one."""

    def blank(found: re.Match[str]) -> str:
        return re.sub(r"[^\n]", " ", found[0]) if found.lastgroup == "comment" else found[0]

    return TOKEN.sub(blank, script).replace("\r", " ") + "\n"


def first_refused(script: str) -> Refused | None:
    r"""Return the first word of a script that runs a program, reads or writes a file, or could hide such a command.

    Examples
    --------
    >>> first_refused('Point(1) = {0, 0, 0};\nSystemCall "ls";')
    Refused(word='SystemCall', what='runs a program', line=2)
    """
    tokens = [Token(str(found.lastgroup), found[0], found.start()) for found in TOKEN.finditer(script)]
    tokens = [token for token in tokens if token.kind != "comment" or _is_open(token.text)]
    printing, depth, previous, loops = "", 0, ";", []
    for token, after in pairwise([*tokens, Token("sign", ";", len(script))]):
        what = _fault(script, token, previous, after)
        if token.text == "For":
            loops.append(token)
        elif token.text == "EndFor" and not (loops and loops.pop()):
            what = "ends no loop"
        if what:
            return _refused(script, token.text, what, token.place)
        if token.text in PRINTS:
            printing, depth = token.text, 0
        elif token.text == ">" and printing and depth == 0:
            return _refused(script, printing, "writes a file", token.place)
        elif token.text == ";":
            printing = ""
        depth += (token.text in ("(", "[", "{")) - (token.text in (")", "]", "}"))
        previous = token.text
    return _refused(script, "For", "has no EndFor", loops[-1].place) if loops else None


def _refused(script: str, word: str, what: str, place: int) -> Refused:
    return Refused(word[:40], what, 1 + script.count("\n", 0, place))


def _fault(script: str, token: Token, previous: str, after: Token) -> str:
    """Return why a token is refused, or an empty text."""
    word = token.text
    if token.kind in ("text", "comment"):
        return _fault_of_text(word)
    if word == "\0":
        return "is a zero byte, which is not text"
    if token.kind != "word":
        return ""
    if word in COMMANDS and not (word == "Print" and after.text == "."):
        return COMMANDS[word]
    if word == "Solver" and after.text == ".":
        return "names programs"
    if previous == "." and after.text == "=" and OPTION.fullmatch(word):
        return "is a file or a program of its choice"
    if _gives_text(after) and previous not in (",", "{", "[", "(", ".") and not _may_precede_text(word):
        return "is a command that is not known to be harmless"
    if re.search(rf"({ENDS.pattern})\d", word):
        return "may be read as two words by gmsh"
    if word in JUMPS and _line_length(script, token.place) > LONGEST_LINE:
        return f"stands in a line of more than {LONGEST_LINE} characters, of which gmsh could repeat a part"
    return ""


def _fault_of_text(text: str) -> str:
    if _is_open(text):
        return "has no end"
    if "\0" in text or "\n" in text or "\r" in text:
        return "is a text of several lines, within which gmsh could go on"
    if len(text) > LONGEST_TEXT:
        return f"is a text of more than {LONGEST_TEXT} characters, which gmsh ends early"
    return "is a text in which gmsh could end what an If leaves out" if ENDS.search(text) else ""


def _is_open(text: str) -> bool:
    """Return whether a text or comment has no end."""
    end = "" if text.startswith("//") else "*/" if text.startswith("/*") else text[0]
    return not text[len(end) :].endswith(end)


def _gives_text(token: Token) -> bool:
    return token.kind == "text" or (token.kind == "word" and TEXT_FUNCTION.fullmatch(token.text) is not None)


def _may_precede_text(word: str) -> bool:
    return word in TAKES_TEXT or TEXT_FUNCTION.fullmatch(word) is not None


def _line_length(script: str, place: int) -> int:
    end = script.find("\n", place)
    return (len(script) if end < 0 else end) - script.rfind("\n", 0, place) - 1
