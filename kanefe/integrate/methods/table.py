"""The table of methods: a line for each."""

from __future__ import annotations

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.integrate.methods import (
    _sundials,
    dop853,
    dopri5,
    energy_momentum,
    external,
    extrapolation,
    generalised_alpha,
    generalised_alpha_unreduced,
    hht,
    moreau_jean,
    radau5,
    rk4,
    vern9,
)
from kanefe.integrate.methods.method import Method

ROWS: tuple[Method, ...] = (
    dopri5.METHOD,
    dop853.METHOD,
    vern9.METHOD,
    rk4.METHOD,
    extrapolation.METHOD,
    radau5.METHOD,
    energy_momentum.METHOD,
    generalised_alpha.METHOD,
    generalised_alpha_unreduced.METHOD,
    hht.METHOD,
    hht.UNREDUCED,
    moreau_jean.METHOD,
    *external.METHODS,
    _sundials.METHOD,
)
"""Methods in order of precedence: of those with the same name, the first that can integrate the scene is taken."""

METHODS: dict[str, Method] = {}
"""First method of each name."""

for _row in ROWS:
    METHODS.setdefault(_row.name, _row)


def own_methods() -> tuple[str, ...]:
    """Return the names of the methods for all kinds of motion that are not solvers of other packages."""
    return tuple(name for name, row in METHODS.items() if not (row.is_plugged or row.steps_over_impacts))


def row_for(model: Model, name: str) -> Method:
    """Return the row of a method that serves a model.

    Raises
    ------
    ModelError
        If there is none: it says why, and the remedy.
    """
    rows = [row for row in ROWS if row.name == name]
    for row in rows:
        if not row.refuses(model):
            return row
    raise ModelError(f"method {name!r} {rows[0].refuses(model)}")


def serving(model: Model, *names: str) -> list[str]:
    """Return those of some methods, in their order, that serve a model."""
    return [name for name in names if any(row.name == name and not row.refuses(model) for row in ROWS)]


def methods() -> str:
    """Return a text with a line on each method of integration: its options, its order, and what it is for.

    Examples
    --------
    >>> import kanefe as kf
    >>> print(kf.methods().splitlines()[0])
    auto               rtol, atol or step  chooses by the scene; result.statistics tell the choice and why
    """
    lines = [("auto", "rtol, atol or step", "chooses by the scene; result.statistics tell the choice and why")]
    lines += [(row.name, _options(row), f"{row.about} (order {row.order})") for row in ROWS]
    return "\n".join(f"{name:18} {options:19} {about}" for name, options, about in lines)


def _options(row: Method) -> str:
    controlled = ["rtol, atol" if row.takes_atol else "rtol"] if row.has_error_control else []
    return " or ".join((*controlled, *(["step"] if row.has_fixed_steps else [])))
