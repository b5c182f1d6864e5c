"""An assembly: parts, proposed joints, what does not fit, and the scene of the joints that are taken."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from kanefe.arguments import checked
from kanefe.errors import ModelError, did_you_mean
from kanefe.joints.base import Joint
from kanefe.joints.fixed import Fixed
from kanefe.system import System
from kanefe_fem.assemblies.building import Builder
from kanefe_fem.assemblies.parts import Part
from kanefe_fem.assemblies.proposals import ProposedJoint


class Overlap(NamedTuple):
    """Two parts that overlap by a volume in m^3; None where OpenCASCADE cannot tell."""

    parts: tuple[str, str]
    volume: float | None


@dataclass(frozen=True, eq=False)
class Assembly:
    """What `kanefe_fem.read_step` found in a file.

    Attributes
    ----------
    source, unit : str
        The file, and the unit in which it was read.
    parts : dict of str to Part
    joints : dict of str to ProposedJoint
        None is taken unless `scene` is told to.
    overlaps : tuple of Overlap
    alone : tuple of (str, str, float)
        Parts of which no plane or cylinder meets another part, with the nearest part and a bound of the distance, m.
    """

    source: str
    unit: str
    parts: dict[str, Part]
    joints: dict[str, ProposedJoint]
    overlaps: tuple[Overlap, ...] = ()
    alone: tuple[tuple[str, str, float], ...] = field(default=())

    def __str__(self) -> str:
        """Return what was found, and what was not."""
        lines = [f"assembly {self.source}: {len(self.parts)} parts, lengths of the file in {self.unit}"]
        lines += [f"  {part}" for part in self.parts.values()]
        lines.append("joints that may be (none is taken by itself):" if self.joints else "no joints were found")
        lines += [f"  {joint}" for joint in self.joints.values()]
        for (one, other), volume in self.overlaps:
            by = "whether they overlap cannot be told" if volume is None else f"overlap by {1e9 * volume:.4g} mm3"
            lines.append(f"{one} and {other}: {by}")
        for name, nearest, distance in self.alone:
            lines.append(f"{name}: no plane or cylinder of it meets a part; {nearest} is at most {distance:.3g} m away")
        return "\n".join(lines)

    @checked
    def scene(
        self,
        ground: str,
        joints: Mapping[str, str | Joint | None] | Sequence[str],
        *,
        without: Sequence[str] = (),
        gravity: Sequence[float] = (0.0, 0.0, -9.81),
        reduction: Any = "auto",
        damping: Any = None,
    ) -> System:
        """Return the scene of the parts with the joints that are taken, as drawn; it can be added to.

        Parameters
        ----------
        ground : str
            The part that stands still.
        joints : sequence of str, or dict of str to str, Joint or None
            Names of proposed joints; with another kind ("fixed", "revolute", "cylindrical", "prismatic") or a joint of
            your own in the axes of the assembly instead of what is proposed. Those beyond a tree close loops.
        without : sequence of str
            Parts to leave out.
        gravity : array_like, shape (3,)
            m/s2.
        reduction, damping : optional
            Of flexible parts, as of `kanefe_fem.solid_body`.

        Raises
        ------
        ModelError
            If a name is not known, or a part is left that no joint reaches.
        """
        taken = dict.fromkeys(joints) if not isinstance(joints, Mapping) else dict(joints)
        self._check(ground, taken, without)
        left = {name: self.joints[name] for name in taken if not set(without) & set(self.joints[name].parts)}
        builder = Builder(self.parts, System(gravity=gravity), taken, reduction, damping)
        builder.add(ground, None, Fixed(), tuple(left.values()))
        while new := next((one for one in left.values() if len(builder.bodies.keys() & set(one.parts)) == 1), None):
            builder.follow(left.pop(new.name), tuple(self.joints[name] for name in taken))
        for loop in [one for one in left.values() if builder.bodies.keys() >= set(one.parts)]:
            builder.close(left.pop(loop.name))
        lost = [name for name in self.parts if name not in builder.bodies and name not in without]
        if lost:
            proposed = [joint.name for joint in self.joints.values() if lost[0] in joint.parts]
            raise ModelError(
                f"{self.source}: no joint that is taken reaches {', '.join(map(repr, lost))} from {ground!r}. Remedy: "
                f"take {' or '.join(map(repr, proposed)) or 'a joint'}, or without={lost!r}"
            )
        return builder.scene

    @checked
    def unreached(self, ground: str, joints: Mapping[str, str | Joint | None] | Sequence[str]) -> list[str]:
        """Return the parts that the joints that are taken do not reach from the part that stands still."""
        self._check(ground, dict.fromkeys(joints), ())
        reached, before = {ground}, 0
        while len(reached) > before:
            before = len(reached)
            reached |= {
                part for name in joints for part in self.joints[name].parts if reached & set(self.joints[name].parts)
            }
        return [name for name in self.parts if name not in reached]

    def _check(self, ground: str, taken: Mapping[str, str | Joint | None], without: Sequence[str]) -> None:
        for name in (ground, *without):
            if name not in self.parts:
                raise ModelError(
                    f"{self.source} has no part called {name!r}. {did_you_mean(name, self.parts)}Remedy: one of "
                    f"{', '.join(map(repr, self.parts))}"
                )
        for name, kind in taken.items():
            if name not in self.joints:
                raise ModelError(
                    f"{self.source}: no joint {name!r} is proposed. {did_you_mean(name, self.joints)}Remedy: one of "
                    f"{', '.join(map(repr, self.joints)) or 'none'}; other joints are added to the scene"
                )
            if not isinstance(kind, Joint):
                self.joints[name].joint(kind)
