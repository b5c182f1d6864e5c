"""The errors that kanefe raises: each message names the cause and the remedy."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from types import FrameType

INSIDE = {"kanefe", "kanefe_fem", "functools", "scipy"}
"""Packages whose lines no warning points to: our own, and those that call our functions."""

MOST_LETTERS = 2000
"""Largest number of characters of a message that is shown: arguments may be very long texts or lists."""


class KanefeError(Exception):
    """Base of every error that kanefe raises on purpose."""

    def __str__(self) -> str:
        """Return the message; of a very long one, the middle and the middles of its longest words are left out."""
        text, half = super().__str__(), MOST_LETTERS // 2 - 10
        if len(text) > MOST_LETTERS:
            text = re.sub(r"(\S{60})\S{60,}(\S{20})", r"\1[...]\2", text)
        return text if len(text) <= MOST_LETTERS else f"{text[:half]} [...] {text[-half:]}"


class ModelError(KanefeError, ValueError):
    """A scene, body, joint, load or matrix that is not valid."""


class SingularStiffness(ModelError):
    """The stiffness of a body that should be held is singular: a mechanism, a loose part, or too few supports."""


class MeshError(KanefeError, ValueError):
    """A mesh of which no matrices can be assembled."""


class FileError(KanefeError, ValueError):
    """A file that is truncated, of another format or of another version."""


class SimulationError(KanefeError, RuntimeError):
    """A run that could not be finished; the message says when, why and what to try."""


class SimulationWarning(UserWarning):
    """A run that failed before its end: its result ends at the time in the message."""


class AccuracyWarning(UserWarning):
    """A result with the error that the message gives, or that covers less than was requested."""


class UnitWarning(UserWarning):
    """A size, mass, material or frequency so unusual that the units are probably not SI."""


class MissingDependency(KanefeError, ImportError):
    """An optional package that a function needs is not installed.

    Parameters
    ----------
    package : str
        The package that could not be imported.
    needed_by : str
        The function that the user called.
    remedy : str
        The command that installs it.
    """

    def __init__(self, package: str, needed_by: str, remedy: str) -> None:
        super().__init__(f"{needed_by} needs {package}, which is not installed. Remedy: {remedy}")
        self.package = package
        self.needed_by = needed_by
        self.remedy = remedy


def did_you_mean(name: str, known: Iterable[str], least: float = 0.6) -> str:
    """Return the question whether the nearest of the known names was meant, for a message; empty if none is near.

    Parameters
    ----------
    name : str
    known : iterable of str
    least : float
        Least similarity, 0 to 1.
    """
    import difflib

    near = difflib.get_close_matches(name, list(known), 1, least)
    return f"Did you mean {near[0]!r}? " if near else ""


def outside() -> int:
    """Return the `stacklevel` at which a warning points to the line of the user."""
    frame: FrameType | None = sys._getframe(1)
    level = 1
    while frame is not None and str(frame.f_globals.get("__name__")).partition(".")[0] in INSIDE:
        frame, level = frame.f_back, level + 1
    return level
