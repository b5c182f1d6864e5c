"""Scenes of loose bodies with many rigid contacts as arrays of the kernel that steps over their impacts."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.contact import granular_contacts as kernel
from kanefe.kernels.contact import granular_impulses as sweeping
from kanefe.kernels.contact.contact_shapes import PLANE
from kanefe.tree.model_data import QUADRATURES, ModelData

ENOUGH = 1e-5
"""Change of speeds in a sweep over the contacts, relative to the largest, at which the sweeps end: below the error of a
step."""

MOST_SWEEPS = 200

ROOM = 4
"""Initial number of contacts per ball for which there is memory; it grows."""


FREE_SPEEDS = 6
"""Number of speeds of a joint without constraints."""


def lacking(model: ModelData) -> str:
    """Return the features of a scene that granular steps do not support, as the end of a sentence, or ""."""
    if len(model.loads) > 1:
        return "other loads between frames"
    for what, is_there in (
        ("loops", bool(model.constraints)),
        ("controllers", bool(model.controllers)),
        ("driven joints", model.driven_count > 0),
    ):
        if is_there:
            return what
    for body in model.bodies:
        is_loose = body.parent < 0 and len(body.joint.speed_names) == FREE_SPEEDS and body.rigid is not None
        if not is_loose or np.any(body.p_PoFo_P) or np.any(body.A_PF != np.eye(3)):
            return f"body {body.name!r}, which does not move freely from the ground's origin"
        if body.rigid is not None and (np.any(body.rigid.com) or np.any(body.rigid.rotor)):
            return f"body {body.name!r}, whose centre of mass is not its origin"
        if body.loads or body.joint_loads or not body.has_gravity:
            return f"forces on body {body.name!r}"
    return ""


class GranularSteps:
    """Steps of a scene of loose bodies.

    Parameters
    ----------
    model : ModelData
        Without what `lacking` tells.
    """

    def __init__(self, model: ModelData) -> None:
        granular = model.granular
        if granular is None:
            raise TypeError("steps are of a scene with granular contacts")
        count = len(model.bodies)
        self.bodies = np.zeros((count, kernel.BODY_SIZE))
        for row, body in zip(self.bodies, model.bodies, strict=True):
            if body.rigid is None:
                raise TypeError("loose bodies are rigid")
            inertia = np.asarray(body.rigid.inertia, dtype=float)
            row[0], row[1:10], row[10:] = body.rigid.mass, inertia.ravel(), np.linalg.inv(inertia).ravel()
        self.balls = np.zeros((len(granular.balls), kernel.BALL_SIZE))
        for row, ball in zip(self.balls, granular.balls, strict=True):
            end = granular.ends[ball.end]
            row[:] = end.body, *(end.point + end.axes @ ball.centre), ball.radius
        self.walls, shapes = np.zeros((len(granular.walls), kernel.WALL_SIZE)), [np.zeros(0)]
        for row, (number, shape) in zip(self.walls, granular.walls, strict=True):
            end = granular.ends[number]
            if shape.kind == PLANE:
                normal = end.axes @ shape.numbers
                row[:] = 1.0, *normal, normal @ end.point
            else:
                row[kernel.OFFSET] = sum(map(len, shapes))
                shapes.append(np.concatenate((end.point, end.axes.ravel(), (float(shape.kind),), shape.numbers)))
        self.shapes = np.concatenate(shapes)
        self._out = granular.left_out
        self._counts, self._control = np.zeros(sweeping.COUNTS, dtype=np.int64), np.zeros(sweeping.CONTROL_SIZE)
        self._control[sweeping.GRAVITY : sweeping.GRAVITY + 3] = model.gravity
        self._control[sweeping.RESTITUTION], self._control[sweeping.FRICTION] = (
            granular.law.restitution,
            granular.friction,
        )
        self._control[sweeping.ENOUGH] = ENOUGH
        self._counts[sweeping.MOST_SWEEPS] = MOST_SWEEPS
        self._order = np.argsort(self.balls[:, kernel.CENTRE]).astype(np.int64)
        self._places = np.zeros((len(self.balls), 3))
        self._groups, self._sums = np.zeros((count, 2), dtype=np.int64), np.zeros((count, sweeping.SUMS))
        self._make_room(ROOM * len(self.balls) + 16)

    def _make_room(self, most: int) -> None:
        kept = getattr(self, "_kept", np.zeros((0, 3)))
        keys = getattr(self, "_keys", np.zeros(1, dtype=np.int64))
        self._contacts = np.zeros((most, sweeping.CONTACT_SIZE))
        self._pairs = np.zeros((most, sweeping.PAIR_SIZE), dtype=np.int64)
        self._slots = np.full(1 << int(2 * most).bit_length(), -1, dtype=np.int64)
        self._kept, self._keys = np.zeros((most, 3)), np.zeros(most + 1, dtype=np.int64)
        self._kept[: len(kept)] = kept
        self._keys[: len(keys) - 1], self._keys[-1] = keys[:-1], keys[-1]

    @property
    def sweeps(self) -> int:
        """Over the contacts, of all steps."""
        return int(self._counts[sweeping.SWEEPS])

    @property
    def contacts(self) -> int:
        """Contacts of all steps together."""
        return int(self._counts[sweeping.TOUCHED])

    @property
    def lowered(self) -> int:
        """How many groups of bodies have had their restitution lowered, of all steps together."""
        return int(self._counts[sweeping.LOWERED])

    @property
    def friction(self) -> float:
        """Its coefficient."""
        return float(self._control[sweeping.FRICTION])

    @property
    def impulses(self) -> np.ndarray:
        """Impulses of the last step, along the normal and in two directions along the surface, (contacts, 3), N s."""
        return self._kept[: int(self._keys[-1])]

    @property
    def smallest(self) -> float:
        """Radius of the smallest ball, m; infinite where points are among them, which are never within."""
        least = float(self.balls[:, kernel.RADIUS].min())
        return least if least > 0.0 else np.inf

    @property
    def deepest(self) -> float:
        """Deepest contact so far, m."""
        return float(self._control[sweeping.DEEPEST])

    @property
    def residual(self) -> float:
        """Largest change of speeds at which sweeps ended, of the largest speed."""
        return float(self._control[sweeping.RESIDUAL])

    def forget(self) -> None:
        """Begin without impulses of a step before."""
        self._keys[-1] = 0

    def memory(self) -> dict[str, np.ndarray]:
        """Return copies of what the next step depends on."""
        n = int(self._keys[-1])
        return {
            "control": self._control.copy(),
            "counts": self._counts.copy(),
            "order": self._order.copy(),
            "kept": self._kept[:n].copy(),
            "keys": self._keys[:n].copy(),
        }

    def recall(self, memory: dict[str, np.ndarray]) -> None:
        """Continue from such copies."""
        n = len(memory["keys"])
        if n > len(self._kept):
            self._make_room(n)
        self._control[:], self._counts[:], self._order[:] = memory["control"], memory["counts"], memory["order"]
        self._kept[:n], self._keys[:n], self._keys[-1] = memory["kept"], memory["keys"], n

    def go_on(self, y: np.ndarray, h: float, steps: int) -> np.ndarray:
        """Return the state (q, u, z, energy dissipated, work) after some steps of h (s)."""
        after, count = y.copy(), len(self.bodies)
        q, u = after[: 7 * count].reshape(-1, 7).copy(), after[7 * count : 13 * count].reshape(-1, 6).copy()
        self._control[sweeping.STEP], self._control[sweeping.TAKEN] = h, 0.0
        self._counts[sweeping.STEPS] = steps
        while (
            kernel.march_granular(
                self._counts,
                self._control,
                self.bodies,
                self.balls,
                self.walls,
                self.shapes,
                self._out,
                q,
                u,
                self._order,
                self._places,
                self._contacts,
                self._pairs,
                self._slots,
                self._kept,
                self._keys,
                self._groups,
                self._sums,
            )
            == kernel.TOO_MANY
        ):
            self._make_room(2 * len(self._kept))
        after[: 7 * count], after[7 * count : 13 * count] = q.ravel(), u.ravel()
        after[13 * count : 13 * count + 3] = self._counts[sweeping.TOUCHING], self.residual, self.deepest
        after[-QUADRATURES] += self._control[sweeping.TAKEN]
        return after
