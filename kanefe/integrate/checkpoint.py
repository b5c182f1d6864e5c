"""Checkpoint files from which a run continues: its full state, and its identity."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kanefe._version import __version__
from kanefe.equations.model import Model
from kanefe.errors import FileError, ModelError
from kanefe.integrate.auto.choice import Choice
from kanefe.integrate.events.event import Event
from kanefe.storage.array_file import open_arrays, write_arrays
from kanefe.storage.digest import Unhashable, digest_of_scene
from kanefe.storage.files import regular_file
from kanefe.storage.object_file import DAMAGE

FORMAT = "kanefe checkpoint"
VERSION = 5
"""Version of the file. In version 1 the source files of classes were part of the identity of the scene; in version 2 it
was not told which values of events are estimates, nor anything of outputs that are settled; in version 3 not how deep
steps over impacts may be in a surface; until version 4 the memory of methods was laid out in another order."""

LEAST_SHARE = 20.0
"""Time to the next file in multiples of the time to write one: writing takes at most a twentieth of a run."""


@dataclass(frozen=True)
class Identity:
    """Identity of a run: only the same run may continue from its checkpoint.

    Attributes
    ----------
    scene : str
        Digest of the frozen model.
    options : dict
        Those of the call that the results depend on, in numbers and texts.
    """

    scene: str
    options: dict[str, Any]


@dataclass(frozen=True, eq=False)
class Progress:
    """How far a run has come.

    Attributes
    ----------
    states : ndarray, shape (stored, state)
    accelerations : ndarray, shape (stored, free), or None
    stepper, watch : mapping of str to ndarray
        Snapshots.
    statistics : dict
    seconds : dict of str to float
        By part.
    """

    states: np.ndarray
    accelerations: np.ndarray | None
    stepper: Mapping[str, np.ndarray]
    watch: Mapping[str, np.ndarray]
    statistics: dict[str, int | float]
    seconds: dict[str, float]


def identity(
    model: Model, choice: Choice, span: tuple[float, float], outputs: np.ndarray, events: Sequence[Event]
) -> Identity:
    """Return what a run is of.

    Raises
    ------
    ModelError
        If a function in the scene holds something whose content cannot be identified.
    """
    try:
        scene = digest_of_scene(model=model)
        options = {
            "method": choice.name,
            **choice.control,
            "t_span": list(span),
            "output times": digest_of_scene(times=outputs),
            "events": {event.name: digest_of_scene(event=event) for event in events},
        }
    except Unhashable as problem:
        raise ModelError(
            f"a checkpoint of this scene cannot be distinguished from that of another scene: {problem}. Remedy: "
            "functions of plain values and arrays, or a run without checkpoint= and resume="
        ) from problem
    return Identity(scene, options)


class CheckpointFile:
    """A file that is written again and again, and always whole.

    Parameters
    ----------
    path : path
    of : Identity
    every : float
        Seconds between writings, at least.
    """

    def __init__(self, path: str | Path, of: Identity, every: float) -> None:
        self.path, self._of, self._every = Path(path), of, every
        self._next = 0.0

    @property
    def is_due(self) -> bool:
        """Whether it is time to write."""
        return time.monotonic() >= self._next

    def write(self, progress: Progress) -> None:
        """Write how far the run has come; the file then holds either this or what it held before.

        Raises
        ------
        FileError
            If it cannot be written.
        """
        began = time.monotonic()
        header = {
            "format": FORMAT,
            "version": VERSION,
            "kanefe": __version__,
            **asdict(self._of),
            "statistics": progress.statistics,
            "seconds": progress.seconds,
        }
        arrays = {"states": progress.states}
        if progress.accelerations is not None:
            arrays["accelerations"] = progress.accelerations
        arrays |= {f"stepper/{name}": array for name, array in progress.stepper.items()}
        arrays |= {f"watch/{name}": array for name, array in progress.watch.items()}
        write_arrays(self.path, json.dumps(header), arrays)
        now = time.monotonic()
        self._next = now + max(self._every, LEAST_SHARE * (now - began))


def read_checkpoint(path: str | Path, of: Identity) -> Progress:
    """Read a checkpoint of the same run.

    Raises
    ------
    FileError
        If the file is not there, damaged, or of another scene, other options or another version; the message says
        which options.
    """
    path = regular_file(
        path, kind="checkpoint", remedy="check the path, or leave resume= out to start again", whole=False
    )
    try:
        text, arrays = open_arrays(path)
        header = json.loads(text)
        if header["format"] != FORMAT:
            raise ValueError(f"its format is {header['format']!r}")
        _check_same(path, header, of)
        return Progress(
            states=arrays["states"],
            accelerations=arrays.get("accelerations"),
            stepper=_folder(arrays, "stepper/"),
            watch=_folder(arrays, "watch/"),
            statistics=header["statistics"],
            seconds=header["seconds"],
        )
    except DAMAGE as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"{path} is damaged or not a checkpoint ({error}). Remedy: start the run again") from error


def _check_same(path: Path, header: dict[str, Any], of: Identity) -> None:
    versions = (header["version"], header["kanefe"])
    if versions != (VERSION, __version__):
        raise FileError(
            f"the checkpoint {path} was written by kanefe {versions[1]} (format {versions[0]}), this is {__version__} "
            f"(format {VERSION}). Remedy: go on with that version, or start the run again"
        )
    if header["scene"] != of.scene:
        raise FileError(
            f"the checkpoint {path} is of another scene: bodies, joints, loads, functions or starts differ. "
            "Remedy: the scene for which it was written, or start the run again"
        )
    there, here = header["options"], json.loads(json.dumps(of.options))
    # what else is chosen may follow from the span: a default of the outputs, the method, its tolerance
    for name in dict.fromkeys(("t_span", *there, *here)):
        if there.get(name) == here.get(name):
            continue
        is_short = not isinstance(there.get(name), dict) and name != "output times"
        detail = f": {there.get(name)!r} there, {here.get(name)!r} here" if is_short else ""
        raise FileError(
            f"the checkpoint {path} is of a run with another option, {name}{detail}. "
            "Remedy: the options that it was written with, or start the run again"
        )


def _folder(arrays: Mapping[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
