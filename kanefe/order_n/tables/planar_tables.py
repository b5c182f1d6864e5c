"""From the frozen model to the tables of the planar kernels, where everything moves in one plane."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Matrix, Vector, cross, turn_to
from kanefe.joints import Joint, Link
from kanefe.kernels.planar.layout import ROW, ROW_INTEGERS, ROW_NUMBERS, SHAPE, PlanarTables, PlanarWork, RowKind
from kanefe.kernels.scene import Sizes
from kanefe.kernels.tables import Tables
from kanefe.kernels.values.filled import laid_out
from kanefe.order_n.tables.frame_offsets import FrameOffset
from kanefe.tree.body_terms import BodyTerms
from kanefe.tree.model_data import ModelData

# Axes this far from parallel are round-off of what the user has composed; the plane then turns by as much.
ROUND_OFF = 1e-12


def planar_tables(model: ModelData, tables: Tables) -> PlanarTables | None:
    """Return the tables of a scene in which everything moves in one plane, or None if it is not one.

    All bodies are rigid and hang on joints whose links are fixed, turn or slide, such as revolute, prismatic and planar
    ones. Links turn about axes parallel to one normal and slide at right angles to it. Gravity and loads may point
    anywhere: what of them is out of the plane does no work, nor do products of inertia or rotors. Springs and bushings
    between frames and closed loops are left to the kernels in space.

    Parameters
    ----------
    model : ModelData
    tables : Tables
        Of the model in space: the forces along joints are the same, and so is where the values of loads are.

    Returns
    -------
    PlanarTables or None
        For `kanefe.kernels.planar.evaluation.evaluate_planar`.

    Examples
    --------
    >>> import kanefe as kf
    >>> from kanefe.order_n.tables.scene_tables import TableBuilder
    >>> scene = kf.System()
    >>> arm = scene.add_rigid_body("arm", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("y"))
    >>> model = scene.freeze()
    >>> in_space, _ = TableBuilder(model).tables()
    >>> planar_tables(model, in_space).sizes
    array([1, 1, 0])
    """
    if model.constraints or model.loads or model.free_count == 0:
        return None
    for body in model.bodies:
        links = body.joint.links()
        if body.rigid is None or links is None:
            return None
        if not all(link.is_fixed or link.is_turn or link.is_slide for link in links):
            return None
    axes = _axes_at_zero(model)
    basis = _plane(model, axes)
    return None if basis is None else _Builder(model, axes, basis).tables(tables)


def floats_in_plane(joint: Joint) -> bool:
    """Return whether the links of a joint slide along x and then y and turn about z: one row takes all three."""
    links = joint.links() or ()
    if [link.is_turn for link in links] != [False, False, True] or not all(link.is_slide for link in links[:2]):
        return False
    x, y, z = (link.axis for link in links)
    return float(y @ cross(z, x)) > 1.0 - ROUND_OFF


def _axes_at_zero(model: ModelData) -> list[Matrix]:
    """Return A_NR of every body when all coordinates are zero."""
    axes: list[Matrix] = []
    for body in model.bodies:
        axes.append(body.A_PF if body.parent < 0 else axes[body.parent] @ body.A_PF)
    return axes


def _plane(model: ModelData, axes: list[Matrix]) -> Matrix | None:
    """Return the plane in which everything moves: two axes and the normal, in rows; None if there is none."""
    normals: list[Vector] = []
    directions: list[Vector] = []
    for body, A in zip(model.bodies, axes, strict=True):
        for link in body.joint.links() or ():
            if not link.is_fixed:
                (normals if link.is_turn else directions).append(A @ link.axis)
    normal = normals[0] if normals else _across(np.array(directions))
    up = normal * np.sign(normal[int(np.argmax(abs(normal)))])
    basis = turn_to(up).T
    if normals and abs(basis[:2] @ np.array(normals).T).max() > ROUND_OFF:
        return None
    if directions and abs(np.array(directions) @ basis[2]).max() > ROUND_OFF:
        return None
    return basis


def _across(directions: Matrix) -> Vector:
    """Return a unit vector across the first direction and the one that differs most from it."""
    first = directions[0]
    crosses = np.cross(first, np.vstack((directions, np.eye(3))))
    sizes = np.linalg.norm(crosses, axis=1)
    chosen = int(np.argmax(sizes[: len(directions)]))
    if sizes[chosen] < 1e-6:  # all parallel: any plane along them will do
        chosen = int(np.argmax(sizes))
    return crosses[chosen] / sizes[chosen]


class _Builder:
    """Writes the rows of a planar scene and remembers where its bodies went."""

    def __init__(self, model: ModelData, axes: list[Matrix], basis: Matrix) -> None:
        self.model = model
        self.basis = basis
        self.frame_offsets: list[FrameOffset] = []
        self._integers: list[list[int]] = []
        self._numbers: list[list[float]] = []
        self._add_row(RowKind.TURN, 0, np.zeros(3))
        for body, A in zip(model.bodies, axes, strict=True):
            self._add_body(body, basis @ A)

    def tables(self, in_space: Tables) -> PlanarTables:
        """Return the tables; what is the same in space is taken from there."""
        loads = in_space.loads.copy()
        loads[:, 0] = [
            frame_offset.row
            for body, frame_offset in zip(self.model.bodies, self.frame_offsets, strict=True)
            for _ in body.loads
        ]
        sizes = Sizes(in_space.sizes)
        return PlanarTables(
            rows=np.array(self._integers, dtype=np.int64),
            geometry=np.array(self._numbers),
            gravity=self.basis[:2] @ self.model.gravity,
            loads=loads,
            points=self._points(),
            joint_forces=in_space.joint_forces,
            laws=in_space.laws,
            sizes=in_space.sizes,
            work=laid_out(PlanarWork, row_count=len(self._integers), speed_count=sizes.free_count + sizes.driven_count),
        )

    def _add_row(self, kind: int, parent: int, place: Vector, axis: Vector | None = None, sign: float = 1.0) -> int:
        integers, numbers = [-1] * ROW_INTEGERS, [0.0] * ROW_NUMBERS
        integers[ROW.parent], integers[ROW.kind], integers[ROW.is_lifted] = parent, kind, 0
        numbers[SHAPE.place : SHAPE.place + 2] = place[:2].tolist()
        numbers[SHAPE.sign] = sign
        if axis is not None:
            numbers[SHAPE.axis : SHAPE.axis + 2] = axis[:2].tolist()
        self._integers.append(integers)
        self._numbers.append(numbers)
        return len(self._integers) - 1

    def _add_body(self, body: BodyTerms, axes: Matrix) -> None:
        parent = self.frame_offsets[body.parent] if body.parent >= 0 else FrameOffset(0, self.basis, np.zeros(3))
        row, place, joint = parent.row, parent.place + parent.axes @ body.p_PoFo_P, body.joint
        moving: list[Link] = [link for link in joint.links() or () if not link.is_fixed]
        has_rotors = bool(self.model.armatures[body.speeds].any())
        if floats_in_plane(joint) and not (body.is_driven or has_rotors):
            x, _, z = (link.axis for link in moving)
            row = self._add_row(RowKind.FLOAT, row, place, axes @ x, float(np.sign(axes[2] @ z)))
            self._number(row, body, 0)
            place = np.zeros(3)
        else:
            for i, link in enumerate(moving):
                if link.is_turn:
                    row = self._add_row(RowKind.TURN, row, place, sign=float(np.sign(axes[2] @ link.axis)))
                else:
                    row = self._add_row(RowKind.SLIDE, row, place, axes @ link.axis)
                self._number(row, body, i)
                place = np.zeros(3)
        frame_offset = FrameOffset(row, axes, place)
        self._add_mass(body, frame_offset)
        self.frame_offsets.append(frame_offset)

    def _number(self, row: int, body: BodyTerms, i: int) -> None:
        """Write where coordinate i of a body's joint is in the state, or among the driven ones."""
        integers, speed = self._integers[row], int(body.speeds[i])
        integers[ROW.speed] = speed
        self._numbers[row][SHAPE.armature] = self.model.armatures[speed]
        if speed >= self.model.free_count:
            integers[ROW.drive] = speed - self.model.free_count
        else:
            integers[ROW.coordinate] = int(body.coordinates[i])

    def _add_mass(self, body: BodyTerms, frame_offset: FrameOffset) -> None:
        rigid, numbers = body.rigid, self._numbers[frame_offset.row]
        if rigid is None or rigid.mass == 0.0:
            return
        x, y, _ = (frame_offset.place + frame_offset.axes @ rigid.com).tolist()
        normal = frame_offset.axes[2]
        numbers[SHAPE.mass] += rigid.mass
        numbers[SHAPE.first] += rigid.mass * x
        numbers[SHAPE.first + 1] += rigid.mass * y
        numbers[SHAPE.second] += float(normal @ rigid.inertia @ normal) + rigid.mass * (x * x + y * y)
        if not body.has_gravity:
            self._integers[frame_offset.row][ROW.is_lifted] = 1
            numbers[SHAPE.lifted] += rigid.mass
            numbers[SHAPE.lifted + 1] += rigid.mass * x
            numbers[SHAPE.lifted + 2] += rigid.mass * y

    def _points(self) -> np.ndarray:
        """Return where loads act, and what takes their values into the plane."""
        points = []
        for body, frame_offset in zip(self.model.bodies, self.frame_offsets, strict=True):
            for load, _ in body.loads:
                into_plane = frame_offset.axes if load.follows else self.basis
                if load.is_torque:
                    points.append((0.0, 0.0, *into_plane[2], 0.0, 0.0, 0.0))
                else:
                    place = frame_offset.place + frame_offset.axes @ load.point
                    points.append((*place[:2], *into_plane[0], *into_plane[1]))
        return np.array(points, dtype=float).reshape(-1, 8)
