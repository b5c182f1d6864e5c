"""Tables and files of what a benchmark found."""

from __future__ import annotations

import csv
import io
import json
import platform
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from kanefe import __version__
from kanefe.content_hash import installed_versions
from kanefe.whole_file import write_whole
from kanefe_fem.bench.runs import COUNTS, Point

COLUMNS = ("scene", "side", "method", "chosen", "rtol", "step", "error", "seconds", *COUNTS, "remark")


def surroundings() -> dict[str, Any]:
    """Return machine, versions and date: a time means little without them."""
    return {
        "kanefe": __version__,
        "python": platform.python_version(),
        "machine": _processor(),
        "system": platform.platform(terse=True),
        "date": time.strftime("%Y-%m-%d"),
        **installed_versions("numpy", "scipy", "numba"),
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def points_table(points: Sequence[Point]) -> str:
    """Return the runs of one scene as a table for a terminal."""
    rows: list[tuple[str, ...]] = [("side", "method", "", "error", "CPU ms", "steps", "rejected", "evaluations", "")]
    for p in points:
        chosen = f"{p.method} ({p.chosen})" if p.chosen != p.method else p.method
        numbers = [f"{p.error:.2e}", f"{1e3 * p.seconds:.3g}"] if p.is_good else ["failed", ""]
        counts = [str(p.counts.get(name, "")) for name in ("steps", "rejected", "evaluations")]
        rows.append((p.side, chosen, p.setting, *numbers, *counts, p.remark[:80]))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "\n".join("  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in rows)


def write_points(points: Sequence[Point], scenes: Sequence[dict[str, Any]], path: Path) -> None:
    """Write the runs with their scenes, references and surroundings as JSON."""
    rows = [{key: _finite(value) for key, value in asdict(p).items()} for p in points]
    _write_text(path, json.dumps({"about": surroundings(), "scenes": list(scenes), "runs": rows}, indent=1) + "\n")


def write_rows(rows: Sequence[dict[str, Any]], path: Path) -> None:
    """Write rows with their surroundings as JSON."""
    kept = [{key: _finite(value) for key, value in row.items()} for row in rows]
    _write_text(path, json.dumps({"about": surroundings(), "rows": kept}, indent=1) + "\n")


def write_csv(points: Sequence[Point], path: Path) -> None:
    """Write the runs as a table with a comma between columns; what is not known is empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for p in points:
        known = {**asdict(p), **p.counts}
        writer.writerow(["" if _finite(known.get(name)) is None else known[name] for name in COLUMNS])
    _write_text(path, text.getvalue())


def _finite(value: Any) -> Any:
    """Return a value as JSON can have it: no NaN."""
    return None if isinstance(value, float) and not abs(value) < float("inf") else value


def _write_text(path: Path, text: str) -> None:
    write_whole(path, lambda file: file.write(text.encode("utf-8")))
