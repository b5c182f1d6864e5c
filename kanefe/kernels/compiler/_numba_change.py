"""What takes the place of functions inside numba while libraries are built."""

from collections.abc import Callable
from typing import Any, NamedTuple


class Change(NamedTuple):
    """What takes the place of a function inside numba.

    Attributes
    ----------
    owner : object
        Module or class.
    name : str
    instead : function (original) -> function
    uses : str
        Names that the original refers to and what takes its place relies on.
    """

    owner: Any
    name: str
    instead: Callable[[Any], Any]
    uses: str = ""

    def fits(self) -> bool:
        """Return whether this version of numba has it, and works as it is known to."""
        original = getattr(self.owner, self.name, None)
        names = getattr(getattr(original, "__code__", None), "co_names", ())
        return original is not None and {*self.uses.split()} <= {*names}

    def make(self) -> None:
        """Put it into its place."""
        setattr(self.owner, self.name, self.instead(getattr(self.owner, self.name)))
