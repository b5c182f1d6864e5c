"""Scenes of loose bodies with many rigid contacts as arrays of the kernel that steps over their impacts."""

from __future__ import annotations

import numpy as np

from kanefe.kernels.contact import granular_scene as scene
from kanefe.kernels.contact.granular_contacts import DONE, march_granular
from kanefe.kernels.values.filled import allocate, filled
from kanefe.kernels.values.records import Record, column
from kanefe.kernels.values.tensors import Vector
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
        ("armatures of joints", bool(model.armatures.any())),
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


def _rows_of(record: type[Record], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return arrays of zeros for so many records, of integers and of numbers."""
    return np.zeros((count, record.integer_count), dtype=np.int64), np.zeros((count, record.number_count))


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
        bodies = []
        for body in model.bodies:
            if body.rigid is None:
                raise TypeError("loose bodies are rigid")
            inertia = np.asarray(body.rigid.inertia, dtype=float)
            own = {"mass": body.rigid.mass, "inertia": inertia, "inverse": np.linalg.inv(inertia)}
            bodies.append(filled(scene.LooseBody, **own))
        balls, walls = [], []
        for ball in granular.balls:
            end = granular.ends[ball.end]
            centre = end.point + end.axes @ ball.centre
            balls.append(filled(scene.Ball, body=end.body, centre=centre, radius=ball.radius))
        for number, shape in granular.walls:
            end = granular.ends[number]
            walls.append(filled(scene.Wall, p=end.point, A=end.axes, shape=shape.listed))
        starts = np.cumsum([0, *map(len, walls)])[:-1].astype(np.int64)
        shapes = np.concatenate(walls or [np.zeros(0)])
        self.balls = np.array(balls)
        self._given = scene.Loose(np.array(bodies), self.balls, starts, shapes, granular.left_out)
        self._memory = allocate(scene.Control)
        self._control = scene.Control(*self._memory)
        self._control.gravity, self._control.enough = Vector(*model.gravity), ENOUGH
        self._control.restitution, self._control.friction = granular.law.restitution, granular.friction
        self._control.most_sweeps = MOST_SWEEPS
        self._order = np.argsort(self.balls[:, column(scene.Ball, "centre")]).astype(np.int64)
        self._kept, self._keys = np.zeros((0, 3)), np.zeros(1, dtype=np.int64)
        self._groups = _rows_of(scene.Group, len(bodies))
        self._make_room(ROOM * len(balls) + 16)

    def _make_room(self, most: int) -> None:
        kept, keys = self._kept, self._keys
        self._contacts = _rows_of(scene.Contact, most)
        self._slots = np.full(1 << int(2 * most).bit_length(), -1, dtype=np.int64)
        self._kept, self._keys = np.zeros((most, 3)), np.zeros(most + 1, dtype=np.int64)
        self._kept[: len(kept)] = kept
        self._keys[: len(keys) - 1], self._keys[-1] = keys[:-1], keys[-1]

    @property
    def sweeps(self) -> int:
        """Over the contacts, of all steps."""
        return self._control.sweeps

    @property
    def contacts(self) -> int:
        """Contacts of all steps together."""
        return self._control.touched

    @property
    def lowered(self) -> int:
        """How many groups of bodies have had their restitution lowered, of all steps together."""
        return self._control.lowered

    @property
    def friction(self) -> float:
        """Its coefficient."""
        return float(self._control.friction)

    @property
    def impulses(self) -> np.ndarray:
        """Impulses of the last step, along the normal and in two directions along the surface, (contacts, 3), N s."""
        return self._kept[: int(self._keys[-1])]

    @property
    def smallest(self) -> float:
        """Radius of the smallest ball, m; infinite where points are among them, which are never within."""
        least = float(self.balls[:, column(scene.Ball, "radius")].min())
        return least if least > 0.0 else np.inf

    @property
    def deepest(self) -> float:
        """Deepest contact so far, m."""
        return float(self._control.deepest)

    @property
    def residual(self) -> float:
        """Largest change of speeds at which sweeps ended, of the largest speed."""
        return float(self._control.residual)

    def forget(self) -> None:
        """Begin without impulses of a step before."""
        self._keys[-1] = 0

    def memory(self) -> dict[str, np.ndarray]:
        """Return copies of what the next step depends on."""
        n = int(self._keys[-1])
        return {
            "control": self._memory[1].copy(),
            "counts": self._memory[0].copy(),
            "order": self._order.copy(),
            "kept": self._kept[:n].copy(),
            "keys": self._keys[:n].copy(),
        }

    def recall(self, memory: dict[str, np.ndarray]) -> None:
        """Continue from such copies."""
        n = len(memory["keys"])
        if n > len(self._kept):
            self._make_room(n)
        self._memory[0][:], self._memory[1][:], self._order[:] = memory["counts"], memory["control"], memory["order"]
        self._kept[:n], self._keys[:n], self._keys[-1] = memory["kept"], memory["keys"], n

    def go_on(self, y: np.ndarray, h: float, steps: int) -> np.ndarray:
        """Return the state (q, u, z, energy dissipated, work) after some steps of h (s)."""
        after, count = y.copy(), len(self._given.bodies)
        q, u = after[: 7 * count].reshape(-1, 7).copy(), after[7 * count : 13 * count].reshape(-1, 6).copy()
        control, balls = self._control, len(self.balls)
        control.step, control.taken, control.steps = h, 0.0, steps
        room = np.zeros(balls), np.zeros((balls, 3))
        while True:
            kept = self._slots, self._keys, self._kept
            memory = scene.Steps._make((*self._memory, q, u, self._order, *room, *self._contacts, *kept, *self._groups))
            if march_granular(self._given, memory) == DONE:
                break
            self._make_room(2 * len(self._kept))
        after[: 7 * count], after[7 * count : 13 * count] = q.ravel(), u.ravel()
        after[13 * count : 13 * count + 3] = control.touching, self.residual, self.deepest
        after[-QUADRATURES] += control.taken
        return after
