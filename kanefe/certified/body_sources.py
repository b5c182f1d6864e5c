"""Sources of error of flexible bodies: modes, stiffening, mesh and order of each, from what it was made from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from kanefe.certified.choice import Choice, Kept, Source
from kanefe.reduction import CraigBampton, FreeInterface, Krylov
from kanefe.scene.scene import BodyEntry

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody
    from kanefe.scene.segments import SegmentMethods

DOUBLINGS = 4
"""Number of times that the modes of a body may be doubled."""

COARSER = (4, 2)
"""Factors by which the numbers of modes are smaller that a search begins with."""

SPLITS = 6
"""Number of times that cells may be split."""

MOST_CELLS = 200_000
"""Number of cells that no split exceeds: solids of so many take some GB and minutes."""

TOGETHER = 3
"""Number of bodies above which all of them are raised as one."""

PLANE = ("line", "triangle", "quad")
"""First letters of the shapes of cells that have less than three dimensions."""


class Owned(NamedTuple):
    """A body, with the names under which it is in the scene.

    Attributes
    ----------
    names : list of str
    body : FlexibleBody or SegmentedBody
    part : FlexibleBody
        The body itself, or its first segment.
    has_gravity, is_loaded : bool
        Whether gravity acts on it in one of these places, and whether it carries anything.
    """

    names: list[str]
    body: Any
    part: FlexibleBody
    has_gravity: bool
    is_loaded: bool


def body_sources(scene: SegmentMethods) -> tuple[list[Source], list[Kept]]:
    """Return what of the flexible bodies of a scene can be varied, and what cannot."""
    sources: list[Source] = []
    kept: list[Kept] = []
    owned = _owned(scene)
    for one in owned:
        for found in _of_body(one):
            if isinstance(found, Source):
                sources.append(found)
            else:
                kept.append(found)
    return _together(sources, len(owned)), kept


def _owned(scene: Any) -> list[Owned]:
    """Return each flexible body of a scene once."""
    chains = {f"{name} {i}" for name, chain in scene._segmented.items() for i in range(1, len(chain.segments) + 1)}
    found: dict[int, Owned] = {}
    for name, chain in scene._segmented.items():
        found[id(chain)] = Owned([name], chain, chain.segments[0].body, bool(scene.gravity.any()), True)
    for entry in scene._entries:
        body = entry.flexible
        if body is None or entry.name in chains:
            continue
        before = found.get(id(body), Owned([], body, body, False, False))
        has_gravity = before.has_gravity or (bool(scene.gravity.any()) and entry.has_gravity)
        is_loaded = before.is_loaded or _is_loaded(scene, entry)
        found[id(body)] = Owned([*before.names, entry.name], body, body, has_gravity, is_loaded)
    return list(found.values())


def _together(sources: list[Source], count: int) -> list[Source]:
    """Return sources of the same kind of many bodies as one."""
    if count <= TOGETHER:
        return sources
    kinds: dict[str, list[Source]] = {}
    for source in sources:
        kinds.setdefault(source.name.partition(" of ")[0], []).append(source)
    return [_joined(f"{kind} of {len(group)} bodies", group) for kind, group in kinds.items()]


def _joined(name: str, group: list[Source]) -> Source:
    """Return sources as one whose levels count from that of the user."""
    below = max(source.given for source in group)
    above = max(len(source.choices) - 1 - source.given for source in group)
    choices = []
    for level in range(-below, above + 1):
        each = [s.choices[min(max(s.given + level, 0), len(s.choices) - 1)] for s in group]
        bodies = {body: changes for one in each for body, changes in one.bodies.items()}
        codes = "\n".join(one.code for one in each if one.code)
        choices.append(Choice("; ".join(dict.fromkeys(one.text for one in each)), codes, bodies=bodies))
    return Source(
        name,
        tuple(choices),
        below,
        below + max(source.first - source.given for source in group),
        all(source.is_exact for source in group),
        memory=max(source.memory for source in group),
    )


def _of_body(one: Owned) -> Iterator[Source | Kept]:
    about, title = one.body.rebuildable, ", ".join(one.names)
    if about.reduction:
        yield _modes(one, about.reduction.now)
    else:
        yield Kept(f"modes of {title}", about.reduction.why_not)
    if not about.stiffening:
        yield Kept(f"stiffening of {title}", about.stiffening.why_not)
    elif about.stiffening.now in LEVELS:
        yield _stiffening(one.names, about.stiffening.now, one.is_loaded)
    if about.mesh or about.order:
        yield _mesh(one.names, about, _pieces(one.part))
    else:
        yield Kept(f"mesh of {title}", about.mesh.why_not)


def _choice(names: Sequence[str], text: str, changes: Mapping[str, Any]) -> Choice:
    """Return a level of bodies that are rebuilt with changes; without any it has no code."""
    given = ", ".join(f"{name}={value!r}" for name, value in changes.items())
    code = "\n".join(f"{name}: body.rebuilt({given})" for name in names) if changes else ""
    return Choice(text, code, bodies=dict.fromkeys(names, changes) if changes else {})


def _modes(one: Owned, now: Any) -> Source | Kept:
    """Return fewer modes, those of the user, and twice the modes with the static shapes of what acts."""
    names, title = one.names, f"modes of {', '.join(one.names)}"
    if isinstance(now, Krylov):
        orders = [int(now.order) * 2**n for n in range(DOUBLINGS)]
        changed = [(f"order {order}", replace(now, order=order)) for order in orders]
        return Source(title, tuple(_choice(names, text, {"reduction": other}) for text, other in changed))
    if not isinstance(now, (CraigBampton, FreeInterface)):
        return Kept(title, "it keeps all of its coordinates" if now is None else f"{now!r} has no levels")
    count = _count(now, one.part)
    own: Any = replace(now, error_up_to=None, modes=count, up_to_frequency=None)
    acting = tuple(dict.fromkeys((*own.loads, *_acting(one))))
    fewer = list(dict.fromkeys(count // part for part in COARSER if 0 < count // part < count))
    choices = [_choice(names, f"{n} modes", {"reduction": replace(own, modes=n)}) for n in fewer]
    choices.append(_choice(names, f"{count} modes", {}))
    for doubled in range(1, DOUBLINGS + 1):
        more = max(count, 1) * 2**doubled
        rich = replace(own, modes=more, loads=acting)
        choices.append(_choice(names, f"{more} modes and statics", {"reduction": rich}))
    return Source(title, tuple(choices), given=len(fewer))


def _count(reduction: CraigBampton | FreeInterface, body: FlexibleBody) -> int:
    """Return the number of normal modes of a body."""
    if isinstance(reduction.modes, int):
        return reduction.modes
    record = body.provenance["reduction"].get("modes", [])
    return sum(1 for mode in record if mode.get("kept", True))


def _acting(one: Owned) -> tuple[str, ...]:
    """Return the loads whose static shapes are kept: inertia, gravity, and those on surfaces of the body."""
    inertia = ("angular acceleration", "centrifugal")
    return (*(("gravity",) if one.has_gravity else ()), *inertia, *(p.name for p in one.part.load_patterns))


LEVELS = ("none", "inertial", "full")


def _is_loaded(scene: Any, entry: BodyEntry) -> bool:
    """Return whether a body carries anything: bodies, loads on interfaces and surfaces, ends of springs and loops."""
    number = scene._entries.index(entry)
    ends = [end for one in (*scene._loads, *scene._constraints) for end in one.ends]
    carries = any(other.parent == number for other in scene._entries) or any(end.body == number for end in ends)
    return carries or bool(entry.loads or entry.field_loads)


def _stiffening(names: Sequence[str], now: str, is_loaded: bool) -> Source:
    """Return no stiffening, that of the user, and all that acts, beyond which there is none."""
    levels = list(dict.fromkeys(("none", now, "full" if is_loaded else "inertial")))
    choices = tuple(_choice(names, f"stiffening {one}", {} if one == now else {"stiffening": one}) for one in levels)
    return Source(f"stiffening of {', '.join(names)}", choices, given=levels.index(now), is_exact=True)


def _pieces(body: FlexibleBody) -> int:
    """Return into how many a cell is split, of the most dimensions that its cells have."""
    kinds = [block.kind for block in body.cells]
    if any(not kind.startswith(PLANE) for kind in kinds):
        return 8
    return 4 if any(not kind.startswith("line") for kind in kinds) else 2


def _mesh(names: Sequence[str], about: Any, pieces: int) -> Source:
    """Return the first order, the second one, and cells that are split."""
    now = about.order.now
    choices, given = [], 0
    if about.order and now == 2:
        choices, given = [_choice(names, "order 1", {"order": 1})], 1
    choices.append(_choice(names, f"{about.mesh.now} cells" + (f" of order {now}" if now else ""), {}))
    more: dict[str, Any] = {}
    if about.order and now == 1:
        more = {"order": 2}
        choices.append(_choice(names, f"{about.mesh.now} cells of order 2", more))
    if about.mesh:
        splits = [n for n in range(1, SPLITS + 1) if n == 1 or about.mesh.now * pieces**n <= MOST_CELLS]
        choices += [_choice(names, f"cells split {n} times", more | {"refined": n}) for n in splits]
    return Source(f"mesh of {', '.join(names)}", tuple(choices), given, memory=float(pieces))
