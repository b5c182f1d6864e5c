"""Run the snippets of a page one after another in one namespace; write what each printed and drew.

Called as `run_page.py SNIPPETS FOLDER`, SNIPPETS being a JSON list of ``{"code", "kind"}``; kind "raises NAME" wants
that error, whose message is then what the snippet shows.
"""

import contextlib
import io
import json
import shutil
import sys
import textwrap
import traceback
import warnings
from pathlib import Path


def shown(message, category, filename, lineno, file=None, line=None):
    """Show a warning as its category and text: where it came from says nothing to a reader."""
    print(prose(f"{category.__name__}: {message}"))


def prose(text):
    """Return a message in lines that a page shows whole."""
    return textwrap.fill(text, 98, break_long_words=False, break_on_hyphens=False)


snippets = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
folder = Path(sys.argv[2])
warnings.showwarning = shown
names = {"__name__": "__main__"}
outcomes = []
seen: dict[Path, float] = {}
for number, snippet in enumerate(snippets):
    printed = io.StringIO()
    wanted = snippet["kind"].removeprefix("raises ") if snippet["kind"].startswith("raises ") else ""
    try:
        with contextlib.redirect_stdout(printed):
            exec(compile(snippet["code"], f"<snippet {number + 1}>", "exec"), names)
    except Exception as error:  # noqa: BLE001  # whatever a snippet raises is told
        if type(error).__name__ != wanted:
            traceback.print_exc()
            sys.exit(f"snippet {number + 1} failed:\n{snippet['code']}")
        printed.write(prose(f"{wanted}: {error}") + "\n")
    else:
        if wanted:
            sys.exit(f"snippet {number + 1} raises no {wanted}:\n{snippet['code']}")
    pictures = []
    for path in sorted(Path().rglob("*.png")):
        if path.is_symlink() or path.parts[0] in ("meshes", "examples") or seen.get(path) == path.stat().st_mtime:
            continue
        seen[path] = path.stat().st_mtime
        pictures.append(f"{number}-{path.name}")
        shutil.copy(path, folder / pictures[-1])
    outcomes.append({"printed": printed.getvalue(), "pictures": pictures})
(folder / "done.json").write_text(json.dumps(outcomes), encoding="utf-8")
