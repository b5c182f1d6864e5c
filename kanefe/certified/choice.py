"""Sources of error: what of a scene and its run can be made finer, level by level."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, eq=False)
class Choice:
    """One level of a source.

    Attributes
    ----------
    text : str
        What it is, for tables: "12 modes".
    code : str
        The same as code to paste.
    options : mapping
        Keywords of the run.
    bodies : mapping of str to mapping
        Keywords of `FlexibleBody.rebuilt`, by name of body.
    anchors : mapping of str to float
        Factors on the stiffness of friction anchors, by name of contact.
    """

    text: str
    code: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)
    bodies: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    anchors: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Source:
    """Something that makes an error, with its levels from coarse to fine.

    Attributes
    ----------
    name : str
    choices : tuple of Choice
    given : int
        The level that the user gave.
    first : int
        The level to begin with.
    is_exact : bool
        Whether the last level leaves no error of this source.
    is_inner : bool
        Whether one evaluation has both levels of a pair in it.
    is_noise : bool
        Whether its error is in the pairs of all other sources.
    memory : float
        Factor by which a level more may enlarge the memory of the process.
    """

    name: str
    choices: tuple[Choice, ...]
    given: int = 0
    first: int = 0
    is_exact: bool = False
    is_inner: bool = False
    is_noise: bool = False
    memory: float = 1.0


@dataclass(frozen=True)
class Kept:
    """What is not varied, and why.

    Attributes
    ----------
    name, reason : str
    """

    name: str
    reason: str


Levels = tuple[int, ...]
"""The level of each source, in their order."""


def settings(sources: tuple[Source, ...], levels: Levels) -> Choice:
    """Return the choices of some levels as one."""
    options: dict[str, Any] = {}
    bodies: dict[str, dict[str, Any]] = {}
    anchors: dict[str, float] = {}
    codes = []
    for source, level in zip(sources, levels, strict=True):
        chosen = source.choices[level]
        options |= chosen.options
        anchors |= chosen.anchors
        for name, changes in chosen.bodies.items():
            bodies.setdefault(name, {}).update(changes)
        codes += [chosen.code] if chosen.code else []
    text = ", ".join(source.choices[level].text for source, level in zip(sources, levels, strict=True))
    return Choice(text, "\n".join(codes), options, bodies, anchors)
