"""What the build runs, and its outcomes: kept until the code or kanefe itself changes."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
STORE = ROOT / "build" / "docs" / "runs"


@lru_cache
def _sources() -> bytes:
    files = sorted(p for folder in ("kanefe", "fem/kanefe_fem", "meshes") for p in (ROOT / folder).rglob("*.*"))
    files += sorted((ROOT / "docs" / "_ext").glob("run_*.py"))
    digest = hashlib.sha256()
    for path in files:
        if path.suffix in (".py", ".json", ".csv", ".msh", ".geo"):
            digest.update(str(path.relative_to(ROOT)).encode() + path.read_bytes())
    return digest.digest()


def run(program: str, text: str, *arguments: str) -> Path:
    """Run a program of this folder in an empty folder; return the folder of its outcomes.

    Parameters
    ----------
    program : str
        A file of this folder; called with a file that holds `text`, a folder for what it finds, and `arguments`.
    text : str
        What it works on; the outcome is kept under its digest and that of kanefe's sources.
    """
    key = hashlib.sha256(_sources() + program.encode() + text.encode() + "\0".join(arguments).encode()).hexdigest()[:24]
    kept = STORE / key
    if (kept / "done.json").exists():
        return kept
    STORE.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        work, found = Path(folder) / "work", Path(folder) / "found"
        work.mkdir()
        found.mkdir()
        for name in ("meshes", "examples"):
            (work / name).symlink_to(ROOT / name)
        (found / "text").write_text(text, encoding="utf-8")
        # warnings are part of what a reader would see; a picture needs no screen
        environment = os.environ | {"MPLBACKEND": "Agg", "COLUMNS": "100", "PYTHONHASHSEED": "0"}
        command = [sys.executable, str(Path(__file__).with_name(program)), str(found / "text"), str(found), *arguments]
        told = subprocess.run(command, cwd=work, env=environment, capture_output=True, text=True, check=False)
        if told.returncode:
            raise RuntimeError(f"{told.stdout[-1500:]}\n{told.stderr[-3000:]}")
        if not (found / "done.json").exists():
            (found / "done.json").write_text(json.dumps({}), encoding="utf-8")
        partial = STORE / f"{key}.{os.getpid()}"
        shutil.rmtree(partial, ignore_errors=True)
        shutil.copytree(found, partial)
        shutil.rmtree(kept, ignore_errors=True)
        partial.rename(kept)
    return kept
