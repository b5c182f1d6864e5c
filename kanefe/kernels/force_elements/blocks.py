"""Numbers of a load under names: one declaration says where the kernel finds them, and what Python has to give."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np

Block = TypeVar("Block", bound=tuple[Any, ...])


def places(block: type[Block], **widths: int) -> Block:
    """Return where each of the names of a block begins; the last may be as long as it likes.

    Parameters
    ----------
    block : type
        A named tuple.
    **widths : int
        How many numbers those have that have more than one.
    """
    named: Any = block
    at, found = 0, []
    for name in named._fields:
        found.append(at)
        at += widths.get(name, 1)
    places_of_names: Block = named(*found)
    return places_of_names


def flat(block: tuple[Any, ...]) -> np.ndarray:
    """Return the numbers of a block one after the other, arrays row by row."""
    return np.concatenate([np.ravel(part) for part in block]).astype(float)
