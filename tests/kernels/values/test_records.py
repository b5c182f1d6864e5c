"""Records: views of arrays by name, in Python and compiled."""

import enum
from typing import Annotated, Any

import numpy as np
import pytest

from kanefe.kernels.compiler._numba import IS_COMPILED, dispatcher
from kanefe.kernels.compiler.arrays import IntegerRows, Integers, RealRows, Reals, ValueRows, Values
from kanefe.kernels.compiler.entries import entry
from kanefe.kernels.compiler.signatures import COMPLEX, REAL
from kanefe.kernels.values.filled import allocate, filled, room
from kanefe.kernels.values.records import Array, Behind, Columns, Many, One, Record, Rows, Start, Table, column
from kanefe.kernels.values.tensors import (
    ZERO,
    Matrix,
    Symmetric,
    Vector,
    congruent,
    cross,
    diagonal,
    dot,
    outer,
    rotation,
    skew,
    square,
    turned_about_z,
)

compiled_only = pytest.mark.skipif(not IS_COMPILED, reason="nothing is compiled")


class Shape(enum.IntEnum):
    BALL = 1
    BOX = 2


class Joint(Record):
    number: int
    axis: Vector


class Body(Record):
    k: int
    shape: Shape
    is_heavy: bool
    joint: Joint
    start: Annotated[int, Start("pool")]
    mass: float
    c: Vector
    J: Symmetric
    R: Matrix
    few: Annotated[np.ndarray, Columns(2)]
    stiffness: Annotated[np.ndarray, Array("k", "2k")]
    shapes: Annotated[Any, Many(Symmetric, "k")]
    moment: Annotated[Any, One(Vector)]
    age: Annotated[Any, One(float)]


class Wheel(Body):
    spin: float


class Bodies(Rows[Body]):
    """Bodies."""


class Wheels(Rows[Wheel]):
    """Wheels."""


class Joints(Rows[Joint]):
    """Joints."""


def test_room_of_parts_follows_from_lengths() -> None:
    assert room(Body, "start", k=3) == 3 * 6 + 6 * 3 + 3 + 1


def arrays(kind: type = float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return room for two wheels of 2 and 3 modes."""
    rng = np.random.default_rng(2)
    integers = np.array([[2, Shape.BALL, 1, 7, 3], [3, Shape.BOX, 0, 8, 30]])

    def numbers(*shape: int) -> np.ndarray:
        found = rng.standard_normal(shape)
        return found + 1j * rng.standard_normal(shape) if kind is complex else found

    return integers, numbers(2, Wheel.number_count), numbers(80)


def test_places_follow_from_the_fields() -> None:
    assert [column(Body, name) for name in ("k", "shape", "is_heavy", "joint", "start")] == [0, 1, 2, 0, 4]
    assert [column(Body, name) for name in ("mass", "c", "J", "R", "few")] == [3, 4, 7, 13, 22]
    assert (Body.integer_count, Body.number_count) == (5, 24)
    assert Body.memories == ("integers", "numbers", "pool")
    assert column(Wheel, "spin") == Body.number_count  # what a record adds comes behind


def test_a_record_is_a_view() -> None:
    integers, numbers, pool = arrays()
    bodies = Bodies(integers, numbers, pool)
    body = bodies[1]
    assert (len(bodies), body.k, body.shape, body.is_heavy, body.joint.number) == (2, 3, Shape.BOX, False, 8)
    body.c, body.mass, body.joint.axis, body.is_heavy = Vector(1.0, 2.0, 3.0), 4.0, Vector(5.0, 6.0, 7.0), True
    assert numbers[1, 4:7].tolist() == [1.0, 2.0, 3.0]
    assert numbers[1, :4].tolist() == [5.0, 6.0, 7.0, 4.0]
    assert integers[1, 2] == 1
    assert body.stiffness.shape == (3, 6)
    body.stiffness[2, 5] = 9.0
    assert pool[30 + 17] == 9.0
    body.shapes[2] = Symmetric(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    assert pool[30 + 18 : 30 + 36].reshape(6, 3)[:, 2].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert bodies[-1].mass == 4.0
    pool[66:70] = [1.0, 2.0, 3.0, 4.0]  # behind stiffness and shapes, from 30 on
    assert (body.moment.y, body.age) == (2.0, 4.0)
    body.moment, body.age = 2.0 * body.moment, 5.0
    assert pool[66:70].tolist() == [2.0, 4.0, 6.0, 5.0]
    assert "mass = 4.0" in repr(body)


def test_a_record_of_another_kind_has_the_same_memory() -> None:
    wheel = Wheels(*arrays())[0]
    Body(wheel).mass = 3.0
    assert wheel.mass == 3.0
    with pytest.raises(TypeError, match="a Joint has no pool, which a Body wants"):
        Body(Joints(*arrays()[:2])[0])


@pytest.mark.parametrize(
    ("mistake", "error", "told"),
    [
        (
            lambda body: body.radius,
            AttributeError,
            "a Body has no 'radius'; it has k, shape, is_heavy, joint, start, mass",
        ),
        (lambda body: setattr(body, "radius", 1.0), AttributeError, "a Body has no 'radius'; it has k, shape"),
        (lambda body: setattr(body, "c", body.J), TypeError, "Body.c is a Vector, not a Symmetric"),
        (lambda body: setattr(body, "joint", body.joint), AttributeError, "Body.joint has parts: write these"),
        (lambda body: body.shapes.__setitem__(0, body.c), TypeError, "a Symmetric is wanted, not a Vector"),
    ],
)
def test_mistakes_are_told(mistake: Any, error: type[Exception], told: str) -> None:
    with pytest.raises(error, match=told):
        mistake(Bodies(*arrays())[0])


Row = Annotated[np.ndarray, Array("length")]
"""One hint for several fields."""


class Method(Record):
    """A record that is no row, with parts behind its fields."""

    length: int
    rows: int
    moves: int
    t: float
    behind: Annotated[int, Start("integers")]
    map: Annotated[np.ndarray, Array("moves", 2)]
    first: Annotated[int, Start("vectors")]
    at: Row
    slopes: Annotated[np.ndarray, Array("rows", "length")]


class Keeping(Method):
    h: float
    kept: Row
    times: Annotated[int, Start("numbers")]
    knots: Annotated[np.ndarray, Array("rows")]


@entry()
def step(integers: Integers, numbers: Reals, vectors: RealRows) -> None:
    """Write to parts of all kinds."""
    one = Keeping(integers, numbers, vectors)
    for i in range(one.length):
        one.kept[i] = one.at[i] + one.slopes[1, i] + one.knots[1] * one.h
    one.map[1, 0] += 1
    one.t += one.h


def test_a_record_is_made_of_arrays_of_its_own() -> None:
    memory = allocate(Keeping, length=3, rows=2, moves=2)
    assert [len(array) for array in memory] == [Keeping.integer_count + 4, Keeping.number_count + 2, 3 * (1 + 2 + 1)]
    one = Keeping(*memory)
    one.at[:], one.slopes[1], one.knots[:], one.map[:], one.h = 1.0, 2.0, (3.0, 4.0), 5, 0.5
    assert memory[2].tolist() == [1.0] * 3 + [0.0] * 3 + [2.0] * 3 + [0.0] * 3  # what is added lies behind
    step.bound(memory[0], memory[1], memory[2].reshape(4, 3))()
    assert (one.kept.tolist(), one.map.tolist(), one.t) == ([5.0] * 3, [[5, 5], [6, 5]], 0.5)
    assert Method(one).at is not None


def test_mistakes_in_declarations_are_told() -> None:
    with pytest.raises(TypeError, match=r"Odd\.text: str can be no field of a record"):
        type("Odd", (Record,), {"__annotations__": {"text": str}})
    with pytest.raises(TypeError, match=r"Odd\.x: no Start before it says where it begins"):
        type("Odd", (Record,), {"__annotations__": {"x": Annotated[np.ndarray, Array(3)]}})
    with pytest.raises(TypeError, match=r"Odd\.fields: records themselves have something of this name"):
        type("Odd", (Record,), {"__annotations__": {"fields": int}})
    with pytest.raises(TypeError, match="'2 k' is no length"):
        Array("2 k")
    with pytest.raises(TypeError, match="Bodies are made of integers, numbers, pool, not of 1 arrays"):
        Bodies(np.zeros((2, 5), dtype=np.int64))


@entry(REAL, COMPLEX)
def work(integers: IntegerRows, numbers: ValueRows, pool: Values) -> None:
    """Do everything that there is with records and values."""
    wheels = Wheels(integers, numbers, pool)
    for i in range(len(wheels)):
        wheel, body, other = wheels[i], Body(wheels[i]), wheels[i - 1]
        b = ZERO
        if wheel.shape == Shape.BOX:
            b = wheel.c
        x = body.R @ body.c + skew(b) @ other.c + 2.0 * (body.J @ b) - (body.R @ skew(b)) @ other.c
        x += (body.J.inverse @ body.R) @ b - body.R.T @ b
        body.c = x
        body.J += square(x, x) + congruent(body.R, body.J) - diagonal(body.mass)
        body.R = turned_about_z(body.R, 0.6, 0.8) + outer(x, b) + rotation(1.0, x.x, x.y, 0.1)
        wheel.mass = dot(x, b) / (2.0 + wheel.mass) + body.J.trace
        wheel.joint.axis = cross(x, -wheel.joint.axis)
        wheel.joint.number += len(wheel.shapes)
        for j in range(wheel.k):
            wheel.stiffness[j, 2 * j] += wheel.few[1]
            wheel.shapes[j] = wheel.shapes[j] + body.J
        wheel.shapes.numbers[0] += wheel.age * wheel.moment.z
        wheel.moment += b
        wheel.age = 2.0 * wheel.age
        wheel.is_heavy = not wheel.is_heavy


@compiled_only
@pytest.mark.parametrize("kind", [float, complex])
def test_compiled_records_are_those_of_python(kind: type) -> None:
    plain, compiled = arrays(kind), arrays(kind)
    work.function(*plain)
    work.bound(*compiled, is_complex=kind is complex)()
    assert (compiled[0] == plain[0]).all()
    for found, wanted in zip(compiled[1:], plain[1:], strict=True):
        # products and sums of some ten numbers, one upon the other, contracted or not
        np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-12)


class Law(Record):
    stiffness: float
    axis: Vector


class Spring(Record):
    ends: Vector
    nested: Law
    rest: Annotated[Any, Behind()]


class Laws(Rows[Law]):
    """Laws."""


def test_records_lie_in_lists_of_numbers() -> None:
    numbers = [0.0, *filled(Spring, ends=(1.0, 2.0, 3.0), nested=range(4, 8), rest=range(8, 16)).tolist()]
    for kind in (list, np.array):
        spring = Spring(kind(numbers), 1)
        assert (spring.ends.y, spring.nested.axis.x, spring.nested.stiffness) == (2.0, 5.0, 4.0)
        law = Laws(spring.rest)[1]
        law.stiffness, law.axis = 0.5, law.axis + Vector(0.0, 0.0, 1.0)
        spring.nested.stiffness += 1.0
        assert (spring.rest[4], spring.rest[7], Laws(spring.rest)[1].axis.z) == (0.5, 16.0, 16.0)
        assert spring.nested.stiffness == 5.0
    with pytest.raises(TypeError, match=r"Law\.axis has 3 numbers, not 2"):
        filled(Law, stiffness=1.0, axis=(1.0, 2.0))
    with pytest.raises(TypeError, match="a Law is filled by stiffness, axis: axis"):
        filled(Law, stiffness=1.0)


@entry(REAL, COMPLEX)
def in_lists(numbers: Values, out: Values) -> None:
    """Work on records in lists."""
    spring = Spring(numbers, 1)
    law = Laws(spring.rest)[1]
    law.axis += spring.nested.stiffness * spring.ends
    Law(out).stiffness = law.axis.x
    Law(out).axis = law.axis


@compiled_only
@pytest.mark.parametrize("kind", [float, complex])
def test_compiled_records_in_lists_are_those_of_python(kind: type) -> None:
    given = [np.arange(16.0).astype(kind), np.zeros(4, dtype=kind)]
    told = [one.copy() for one in given]
    in_lists.function(*given)
    in_lists.bound(*told, is_complex=kind is complex)()
    assert (given[0] == told[0]).all()
    assert (given[1] == told[1]).all()


@compiled_only
@pytest.mark.parametrize(
    ("mistake", "told"),
    [
        (
            lambda i, n, p: Bodies(i, n, p)[0].radius,
            "a Body has no 'radius'; it has k, shape, is_heavy, joint, start, m",
        ),
        (lambda i, n, p: Bodies(i, n, p)[0].c + Bodies(i, n, p)[0].J, r"there is no Vector \+ Symmetric"),
        (lambda i, n, p: cross(Bodies(i, n, p)[0].c, 1.0), r"there is no cross\(Vector, float64\): a Vector is wanted"),
        (lambda i, n, p: Bodies(i, n, p)[0].c.w, "a Vector has no 'w'; it has x, y, z"),
        (lambda i, n, p: Bodies(i, n, p).mass, "one of the Body records has fields, not all"),
        (lambda i, n, p: Bodies(i, n)[0].mass, "Bodies are made of arrays of integers, numbers, pool, not of array"),
        (lambda i, n, p: Body(Joints(i, n)[0]).mass, "a Joint has no pool, which a Body wants"),
    ],
)
def test_mistakes_in_compiled_code_are_told(mistake: Any, told: str) -> None:
    with pytest.raises(Exception, match=told):  # of numba's own classes
        dispatcher(mistake)(*arrays())


class Ends(Rows[Joint]):
    pass


class Point(Record):
    place: Vector
    weight: float


class Points(Rows[Point]):
    pass


class Room(Record, is_frozen=True):
    count: int
    begins: Annotated[int, Start("memory")]
    first: Annotated[np.ndarray, Array("count")]
    points: Annotated[Points, Table(Points, "count", 6)]
    last: Annotated[np.ndarray, Array(2)]


@entry(REAL, COMPLEX)
def sum_of_points(integers: Integers, memory: Values, found: Values) -> int:
    own = Room(integers, memory)
    for i in range(len(own.points)):
        point = own.points[i]
        point.place += point.weight * point.place
        own.first[i] = point.place.z
        own.points.numbers[i, 5] = 1.0 + i
    own.last[0] = own.points.numbers.sum()
    found[0] = own.last[0]
    return len(own.points)


@pytest.mark.parametrize("kind", [float, complex])
def test_a_table_of_records_lies_in_a_memory(kind: type) -> None:
    integers, room_for = allocate(Room, count=3)
    assert len(room_for) == 3 + 3 * 6 + 2
    memory = np.arange(len(room_for)).astype(kind)
    rows = memory[3:21].reshape(3, 6).copy()
    rows[:, :3] *= 1.0 + rows[:, 3:4]
    rows[:, 5] = 1.0, 2.0, 3.0
    found = np.zeros(1, dtype=kind)
    assert sum_of_points.bound(integers, memory, found, is_complex=kind is complex)() == 3
    assert np.array_equal(memory[3:21].reshape(3, 6), rows)
    assert np.array_equal(memory[:3], rows[:, 2])
    assert memory[21] == found[0] == rows.sum()


@compiled_only
def test_compiled_code_does_not_write_what_is_frozen() -> None:
    def write(integers: Any, memory: Any) -> None:
        Room(integers, memory).count = 2

    with pytest.raises(Exception, match="whole numbers of a Room, 'count' as others, are not written"):
        dispatcher(write)(np.zeros(2, dtype=np.int64), np.zeros(9))
