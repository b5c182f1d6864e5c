"""What ``kanefe bench`` was asked for, handed to the process that measures."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields
from pathlib import Path


@dataclass(frozen=True)
class Options:
    """Options of the command; see there.

    Attributes
    ----------
    scenes, methods : tuple of str
    quick, peer, figures, skips, bodies : bool
    json, csv, png, env, tests : str or None
        Files and folders.
    core : int or None
    """

    scenes: tuple[str, ...] = ()
    methods: tuple[str, ...] = ()
    quick: bool = False
    peer: bool = False
    figures: bool = False
    skips: bool = False
    bodies: bool = False
    json: str | None = None
    csv: str | None = None
    png: str | None = None
    env: str | None = None
    tests: str | None = None
    core: int | None = None

    def text(self) -> str:
        """Return the options as one argument of a command line."""
        return json.dumps(asdict(self))

    @classmethod
    def read(cls, text: str) -> Options:
        """Return the options of such an argument."""
        given = json.loads(text)
        for f in fields(cls):
            if isinstance(given[f.name], list):
                given[f.name] = tuple(given[f.name])
        return cls(**given)

    @property
    def environment(self) -> Path:
        """Folder of the peer's environment: the user's choice, or one in kanefe's cache."""
        from kanefe.storage.files import cache_folder

        return Path(self.env) if self.env else cache_folder() / "benchmarks" / "peers"
