"""Arguments of public functions are held to their type hints, and what is no number is none."""

from __future__ import annotations

import decimal
import inspect
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack

import numpy as np
import pytest

import kanefe as kf
import kanefe_fem as fem
from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.integrate.options import RunKeywords, RunOptions

if TYPE_CHECKING:
    from decimal import Decimal

NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    "given", ["1", ["1", "2"], True, [True], 1j, np.array([1j]), 10**400, None, [[1.0], [1.0, 2.0]]]
)
def test_what_is_no_number_becomes_none(given: Any) -> None:
    assert np.isnan(numbers(given)).all()
    assert numbers(given).shape == ()


@pytest.mark.parametrize("given", [2, np.int64(2), np.float32(2), Fraction(4, 2), np.array(2)])
def test_numbers_of_all_kinds_are_read(given: Any) -> None:
    assert numbers(given) == 2.0


def test_hints_of_all_public_functions_are_understood() -> None:
    """Also those of names that are imported for type checkers only."""
    things = [getattr(module, name) for module in (kf, kf.shapes, kf.studies, fem) for name in module.__all__]
    bases = {base for thing in things if isinstance(thing, type) for base in thing.__mro__}
    things += [getattr(method, "__func__", method) for base in bases for method in vars(base).values()]
    asked = [thing.asked for thing in things if hasattr(thing, "asked")]
    assert len(asked) > 100
    for kinds in asked:
        kinds()


@checked
def door(
    size: float = 1.0,
    sizes: Sequence[float] = (),
    name: str | None = None,
    span: tuple[float, float] = (-INF, INF),
    groups: Mapping[str, int] | None = None,
    kind: Literal["soft", "hard"] = "soft",
    law: float | Callable[[float], float] = 0.0,
    path: str | Path = "x",
    flag: bool = False,
    field: np.ndarray | None = None,
    names: Sequence[str] = (),
    other: Decimal | None = None,
) -> str:
    return "open"


@pytest.mark.parametrize(
    ("argument", "fine", "wrong"),
    [
        (
            "size",
            [1, 2.5, np.float64(1), np.float32(1), np.int64(1), np.array(1.0), Fraction(1, 2)],
            ["1", True, None, NAN, INF, 1j, [1.0], 10**400],
        ),
        ("sizes", [(), [1, 2], np.ones(3)], ["12", [1, NAN], [[1.0]], [None], 3, itertools.count(), [1j], {1: 2}]),
        ("name", ["a", None, np.str_("a")], [1, b"a", ["a"]]),
        ("span", [(0, 1), (-INF, INF), [0, 1], np.array([0, 1])], [(0,), 1, (0, NAN), (0, "1"), (0, 1, 2), None]),
        (
            "groups",
            [{"a": 1}, None, {}, {"a": np.int64(1)}, {"a": np.array(1)}, MappingProxyType({"a": 1})],
            [{1: 1}, {"a": "b"}, ["a"], "a"],
        ),
        ("kind", ["hard", np.str_("hard")], ["harder", None, 1]),
        ("law", [2.0, abs], ["abs", None, NAN, [abs]]),
        ("path", ["a", Path("a")], [1, None, b"a"]),
        ("flag", [True, np.True_], [1, "yes", None]),
        ("field", [np.ones((2, 2)), [[1.0, 2.0]], np.array([True])], [np.array([NAN]), np.array(["a"]), "a", object()]),
        ("names", [["a"], ("a", "b")], ["ab", [1], iter(["a"]), 1]),
        ("other", [decimal.Decimal(1), None], [decimal.Decimal, object(), 1]),
    ],
)
def test_arguments_are_held_to_their_hints(argument: str, fine: list[Any], wrong: list[Any]) -> None:
    for value in fine:
        assert door(**{argument: value}) == "open"
    for value in wrong:
        with pytest.raises(ModelError, match=f"^{argument}= of door must be .*, not "):
            door(**{argument: value})


def test_places_are_held_as_names_are() -> None:
    assert door(1.0, [2.0], "a") == "open"
    with pytest.raises(ModelError, match="name= of door must be a text or None, not 3"):
        door(1.0, [2.0], 3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="unexpected keyword argument 'colour'"):
        door(colour=3)  # type: ignore[call-arg]


def test_what_follows_places_without_number_is_not_by_place() -> None:
    @checked
    def told(first: str, *names: str, level: float | None = None) -> tuple[str, ...]:
        return names

    assert told("a", "b", "c", level=1.0) == ("b", "c")
    with pytest.raises(ModelError, match="level= of told must be a finite number or None, not 'c'"):
        told("a", "b", level="c")  # type: ignore[arg-type]


def test_some_arguments_may_be_left_to_the_function() -> None:
    @checked("second")
    def two(first: float, second: float) -> object:
        return first

    assert two("1", 2.0) == "1"  # type: ignore[arg-type]
    with pytest.raises(ModelError, match="second= of two must be a finite number, not '2'"):
        two(1.0, "2")  # type: ignore[arg-type]


class Levels(TypedDict, total=False):
    level: float
    label: str | None


def test_keywords_of_a_group_are_held_and_others_refused() -> None:
    @checked
    def grouped(first: float, **levels: Unpack[Levels]) -> Levels:
        return levels

    assert grouped(1.0, level=2, label=None) == {"level": 2, "label": None}
    with pytest.raises(ModelError, match=r"level= of grouped must be a finite number, not '2'"):
        grouped(1.0, level="2")  # type: ignore[typeddict-item]
    with pytest.raises(ModelError, match=r"^grouped takes no levle=. Remedy: one of first, level, label$"):
        grouped(1.0, levle=2.0)  # type: ignore[call-arg]

    @checked("label")
    def partly(**levels: Unpack[Levels]) -> Levels:
        return levels

    assert partly(level="2") == {"level": "2"}  # type: ignore[typeddict-item]
    with pytest.raises(ModelError, match="label= of partly must be"):
        partly(label=2)  # type: ignore[typeddict-item]
    with pytest.raises(ModelError, match="partly takes no levle="):
        partly(levle=2.0)  # type: ignore[call-arg]

    @checked()
    def own_words(first: float, **levels: Unpack[Levels]) -> Levels:
        return levels

    assert own_words("1", level="2") == {"level": "2"}  # type: ignore[arg-type, typeddict-item]
    with pytest.raises(ModelError, match="own_words takes no levle="):
        own_words(1.0, levle=2.0)  # type: ignore[call-arg]


def test_the_keywords_of_runs_are_the_options_of_a_run() -> None:
    assert {*RunKeywords.__annotations__, "t_span"} == {*inspect.signature(RunOptions).parameters}


def test_constructors_are_held_too() -> None:
    @checked
    @dataclass(frozen=True)
    class Beam:
        length: float
        label: str = "beam"

    assert Beam(2.0).length == 2.0
    with pytest.raises(ModelError, match="length= of Beam must be a finite number, not '2'"):
        Beam("2")  # type: ignore[arg-type]


def test_long_values_are_cut() -> None:
    with pytest.raises(ModelError) as told:
        door(name=list(range(10_000)))  # type: ignore[arg-type]
    assert len(str(told.value)) < 200


def test_long_messages_keep_their_ends() -> None:
    text = str(ModelError(f"name of a body must be short, not {'a' * 10**6}. Remedy: one word"))
    assert len(text) < 2001
    assert text.startswith("name of a body")
    assert text.endswith("Remedy: one word")


@pytest.mark.parametrize(
    "given", [Fraction(1, 2), np.float16(0.5), np.array(0.5), np.array(Fraction(1, 2)), np.longdouble(0.5)]
)
def test_one_number_of_any_type_is_a_float_within(given: Any) -> None:
    @checked
    def taken(length: float, count: int | None = None) -> Any:
        return length, count

    assert [type(one) for one in taken(given, np.uint8(200))] == [float, int]  # an uint8 would overflow at 256
    assert [type(one) for one in taken(count=np.array(3), length=given)] == [float, int]
    law, spring = kf.KelvinVoigt(given, given), kf.CoordinateForce(stiffness=given)
    friction, run = kf.JointFriction(given, stiffness=given), RunOptions(t_span=(0.0, 1.0), rtol=given)
    section, damping = fem.Rectangle(given, given), kf.RayleighDamping(given, given)
    fields = (
        law.stiffness,
        spring.stiffness,
        friction.mu,
        run.rtol,
        section.width,
        damping.mass,
        kf.Screw("z", lead=given).lead,
    )
    assert [type(one) for one in fields] == [float] * len(fields)


def test_a_whole_number_is_a_time_of_a_start_report() -> None:
    scene = kf.System()
    scene.add_rigid_body("a", 1.0, 0.1, joint=kf.Revolute("z", speed=2.0))
    assert scene.start_report(1).kinetic_energy == scene.start_report(1.0).kinetic_energy
