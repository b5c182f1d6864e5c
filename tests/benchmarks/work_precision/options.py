"""What `bench.py` was asked for, and what of it cannot be done."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Options:
    """Options of the command line; see there.

    Attributes
    ----------
    scenes, methods : tuple of str
    quick, peer, figures, skips, certified, bodies : bool
    only : str
        Only the groups of figures with this in the name.
    json, csv, png, env, tests : Path or None
        Files and folders.
    core : int or None
    """

    scenes: tuple[str, ...] = ()
    methods: tuple[str, ...] = ()
    quick: bool = False
    peer: bool = False
    figures: bool = False
    skips: bool = False
    certified: bool = False
    bodies: bool = False
    only: str = ""
    json: Path | None = None
    csv: Path | None = None
    png: Path | None = None
    env: Path | None = None
    tests: Path | None = None
    core: int | None = None

    @property
    def environment(self) -> Path:
        """Folder of the peer's environment: the user's choice, or one in kanefe's cache."""
        from kanefe.storage.files import cache_folder

        return self.env or cache_folder() / "benchmarks" / "peers"


def check(options: Options) -> None:
    """Refuse what cannot be done.

    Raises
    ------
    ModelError
        If a scene, a method or a combination of options does not exist.
    FileError
        If a file cannot be written.
    """
    from benchmarks.work_precision.bodies import TRIALS
    from benchmarks.work_precision.catalogue import chosen_scenes
    from benchmarks.work_precision.settings import chosen_methods
    from kanefe.errors import ModelError
    from kanefe.storage.files import ready_path

    kinds = [name for name in ("bodies", "skips", "figures") if getattr(options, name)]
    if len(kinds) > 1:
        raise ModelError(f"--{kinds[0]} and --{kinds[1]} are benchmarks of their own. Remedy: one after the other")
    chosen = chosen_scenes(options.scenes)
    chosen_methods(options.methods)
    without = {
        "bodies": ("methods", "peer", "csv", "tests", "only"),
        "skips": ("scenes", "methods", "peer", "csv", "png", "tests", "only"),
        "figures": ("scenes", "methods", "peer", "csv", "png"),
        "": ("tests", "only"),
    }[kinds[0] if kinds else ""]
    for name in without:
        if getattr(options, name):
            with_what = f"with --{kinds[0]}" if kinds else "without --figures"
            raise ModelError(f"--{name} has no meaning {with_what}. Remedy: leave it out")
    if options.bodies and options.scenes and not set(chosen) <= set(TRIALS):
        raise ModelError(f"--bodies is for {', '.join(TRIALS)}, not {', '.join(options.scenes)}")
    if options.tests is not None and not (options.tests / "tests").is_dir():
        raise ModelError(f"--tests {options.tests} is no repository with a folder of tests")
    for path in (options.json, options.csv, options.png):
        if path is not None:
            ready_path(path)
