"""Which runs make a curve of error against time: methods, and the tolerances or steps of each."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.work_precision.scene import BenchScene, Setting
from kanefe.errors import ModelError
from kanefe.integrate.methods.table import METHODS, own_methods

AUTO = "auto"

TOLERANCES = tuple(10.0 ** (-0.5 * i) for i in range(3, 21))
"""Tolerances of 1.5 to 10 digits."""

HALVINGS = 16


def method_names() -> tuple[str, ...]:
    """Return "auto" and the names of kanefe's own methods."""
    return (AUTO, *own_methods())


def chosen_methods(names: Sequence[str]) -> list[str]:
    """Return the methods asked for, also solvers of other packages; all of kanefe's own if there are none.

    Raises
    ------
    ModelError
        If there is no such method.
    """
    known = (AUTO, *METHODS)
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ModelError(f"there is no method {', '.join(unknown)}. There are: {', '.join(known)}")
    return list(names) or list(method_names())


def settings_of(scene: BenchScene, method: str, quick: bool = False) -> list[Setting]:
    """Return the runs of a method, the coarsest first: over steps where it has no error control, else tolerances."""
    if method != AUTO and not METHODS[method].has_error_control:
        return steps_of(scene, method, quick)
    least = 0.0 if method == AUTO else METHODS[method].least_rtol
    found = [Setting(method, rtol=rtol) for rtol in TOLERANCES if rtol >= 0.999 * least]
    return found[::2] if quick else found


def steps_of(scene: BenchScene, method: str, quick: bool = False) -> list[Setting]:
    """Return the runs of a method with fixed steps, the coarsest first."""
    found = [Setting(method, step=scene.largest_step / 2**i) for i in range(HALVINGS)]
    return found[::2] if quick else found
