"""Functions of the user that numba compiles, so that runs do not return to Python for them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.kernels.compiler._numba_functions import checked as with_bounds
from kanefe.kernels.compiler._numba_functions import controller_function, offered
from kanefe.kernels.compiler.foreign import address_of

FORMS = {
    1: "f(t)",
    2: "f(t, reads) with reads=, or f(t, y) with the state y",
    3: "f(t, reads, memory) of a sampled controller",
}


@dataclass(frozen=True, eq=False)
class CompiledByNumba:
    """A function of the user in machine code, with what it reads or keeps: see `compiled`.

    Attributes
    ----------
    function : callable
        As numba has compiled it.
    reads : str, sequence or mapping of str
        Of a load: what it reads.
    memory : int
        Of a sampled controller: how many numbers it keeps.
    """

    function: Callable[..., Any]
    reads: Sequence[str] | Mapping[str, str] | str = ()
    memory: int = 0

    @property
    def is_controller(self) -> bool:
        """Whether it takes a memory."""
        return len(_parameters(self.function)) == max(FORMS)

    def __call__(self, *given: Any) -> Any:
        """Call it from Python; arrays are checked for their bounds."""
        return with_bounds(self.function)(*given) if hasattr(self.function, "py_func") else self.function(*given)

    def address(self, reads: int, drives: int, label: str = "a controller") -> int:
        """Return the address of ``void f(double t, const double *reads, double *memory, double *drives)``."""
        made = controller_function(self.function, (reads, self.memory, drives), label)
        return made if isinstance(made, int) else address_of(made, label)


@checked("reads", "memory")
def compiled(
    function: Callable[..., Any], *, reads: Sequence[str] | Mapping[str, str] | str = (), memory: int = 0
) -> Any:
    """Return a function compiled by numba: a run that calls it stays in compiled code.

    It may use numbers, arrays, `math` and numpy as far as numba supports them, and the values that variables outside of
    it have now, or that arguments have as a default: ``lambda t, k=k: k * t`` in a loop over k. Loads, motors, motions
    and sampled controllers take it where they take a function in Python.

    Parameters
    ----------
    function : callable
        ``f(t)`` or ``f(t, reads)`` of a force, torque, motor, traction or pressure -> a number or three; ``f(t)`` of a
        `Motion`; ``f(t, reads, memory)`` of a sampled controller -> a number for each drive. t in s; reads and memory
        are arrays, the first not to be written to.
    reads : str, sequence or mapping of str
        What a load reads, in the order of the array: ``"joint_coordinates hub"``, ``"joint_speeds hub"``,
        ``"modal_coordinates arm"``, ``"modal_speeds arm 0"``, ``"deflection arm/tip y"``. Without them f(t, y) is given
        the state y = (q, u, z) in the order of `Model.state_names`. What a controller reads is said where it is added.
    memory : int
        How many numbers a controller keeps from sample to sample, zeros at the start of each run.

    Raises
    ------
    ModelError
        If numba cannot compile it, or it takes other arguments; the message names it.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System()
    >>> hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z", speed=1.0))
    >>> brake = kf.compiled(lambda t, reads: -0.2 * reads[0] ** 3, reads="joint_speeds hub")
    >>> scene.add_motor(hub, brake)
    >>> result = scene.simulate((0.0, 1.0))
    """
    name = getattr(function, "__name__", repr(function))
    if not callable(function):
        raise ModelError(f"kanefe.compiled takes a function, not {function!r}")
    plain = getattr(function, "py_func", function)
    if not inspect.isfunction(plain):
        raise ModelError(f"kanefe.compiled takes a function that is written in Python, not {function!r}")
    count = len(_parameters(plain))
    if count not in FORMS:
        raise ModelError(
            f"{name!r} given to kanefe.compiled must be one of {'; '.join(FORMS.values())}; it takes {count} arguments"
        )
    size = numbers(memory)
    if size.shape != () or int(size) != memory or memory < 0 or (memory and count != max(FORMS)):
        raise ModelError(
            f"memory of {name!r} must be a whole number, zero or more, of a controller f(t, reads, memory), not "
            f"{memory!r}"
        )
    if len(reads) and count != 2:
        raise ModelError(
            f"{name!r} given to kanefe.compiled takes {count} arguments, and reads= belongs to f(t, reads). Remedy: "
            "add_controller(..., reads=...) says what a controller reads"
        )
    made = offered(function, name, count)
    return CompiledByNumba(made, reads, memory) if len(reads) or count == max(FORMS) else made


def _parameters(function: Callable[..., Any]) -> list[str]:
    """Return the names of the parameters of a function that have to be given."""
    parameters = inspect.signature(getattr(function, "py_func", function)).parameters.values()
    places = inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD
    return [p.name for p in parameters if p.kind in places and p.default is p.empty]
