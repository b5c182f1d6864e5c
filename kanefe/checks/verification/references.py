"""The references of the package."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import files

from kanefe.checks.verification.case import Reference


@lru_cache(maxsize=1)
def load_references() -> Mapping[str, Reference]:
    """Return the references of ``references.json`` by their ids, in the order of the file."""
    content = json.loads(files("kanefe.checks.verification").joinpath("references.json").read_text(encoding="utf-8"))
    names = ("id", "title", "definition", "quantity", "tolerance", "source")
    return {
        entry["id"]: Reference(**{name: entry[name] for name in names}, values=entry["reference"])
        for entry in content["cases"]
    }
