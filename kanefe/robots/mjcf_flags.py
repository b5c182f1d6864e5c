"""Flags of MJCF's <option> that switch parts of the physics off, in the arrays of a compiled model."""

from __future__ import annotations

from typing import Any

CONSTRAINT, EQUALITY, FRICTION, LIMIT, CONTACT, SPRING, DAMPER, GRAVITY = (1 << i for i in range(8))  # mjtDisableBit
ACTUATION = 1 << 11  # mjtDisableBit
SLEEP = 1 << 4  # mjtEnableBit

OFF: dict[int, tuple[str, ...]] = {
    SPRING: ("jnt_stiffness", "jnt_stiffnesspoly", "jnt_springyield"),
    DAMPER: ("dof_damping", "dof_dampingpoly"),
    FRICTION: ("dof_frictionloss",),
    LIMIT: ("jnt_limited",),
    EQUALITY: ("eq_active0",),
}
"""Flag -> arrays that are zero without what it switches off."""

HELD = FRICTION | LIMIT | EQUALITY | CONTACT
"""Flags that the one of all constraints stands for."""

PASSIVE = SPRING | DAMPER
"""Without both there are no passive forces at all: no compensation of gravity and no fluid either."""


def switched_off(model: Any) -> int:
    """Return the flags of what is off, each with those that follow from it."""
    flags = int(model.opt.disableflags)
    return flags | HELD if flags & CONSTRAINT else flags


def apply_flags(model: Any) -> None:
    """Set what is switched off to zero in a compiled model, as MuJoCo leaves it out at each step."""
    flags = switched_off(model)
    for flag, arrays in OFF.items():
        if flags & flag:
            for name in arrays:
                getattr(model, name)[...] = 0
    if flags & PASSIVE == PASSIVE:
        model.body_gravcomp[...] = 0.0
        model.opt.density = model.opt.viscosity = 0.0
    if flags & GRAVITY:
        model.opt.gravity[...] = 0.0
