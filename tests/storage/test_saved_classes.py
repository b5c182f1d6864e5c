"""What files and digests name classes by: words that stay when the files of the code move."""

from __future__ import annotations

import ast
import inspect
import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, is_dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import kanefe as kf
import kanefe_fem
from body_makers import BODIES
from kanefe.fe_model.file import load_model, save_model
from kanefe.storage import saved_classes
from kanefe.storage.array_file import read_header
from kanefe.storage.digest import digest, digest_of_scene
from kanefe.storage.saved_classes import SAVED_CLASSES, word_of
from kanefe.storage.serialise import decoded, encoded
from kanefe_fem import body_cache
from kanefe_fem.body_cache import WARNINGS
from scenes import lattice_model

# These words are in files that users have: more may come, but none may change.
WORDS = {
    "beam inertia",
    "beam line",
    "cells",
    "elasticity",
    "exact beam",
    "facet block",
    "finite element model",
    "flexible body",
    "inertia field",
    "interface frame",
    "load pattern",
    "loaded face",
    "mass field",
    "mass moments",
    "model record",
    "nodal moments",
    "nodal pattern",
    "pressure change",
    "node group",
    "node shares",
    "relaxation",
    "ribs",
    "section frame",
    "unreduced body",
    "viscoelastic part",
    "wet moments",
    "shell stack",
}
WORDS_OF_WARNINGS = {
    "accuracy",
    "deck",
    "error",
    "imported body",
    "mesh",
    "modes",
    "nodal form",
    "simulation",
    "tie",
    "units",
}

# Classes of the same name in two files of a package. A digest does not tell them apart, and need not: they are parts of
# tables that are printed, of verification runs, studies and searches, and of what is read or meshed on the way to a
# body, never of a scene or of the options of a body.
SHARED_NAMES = {"Assembly", "Case", "Held", "Output", "Row", "Samples", "Surface", "Table", "Tangent", "_Part"} | {
    "Changes",
    "Choice",
    "Limits",
    "Piece",
    "Quantity",
    "Search",
    "Source",
    "Trial",
}

PLACES = {**SAVED_CLASSES, **{f"{word} warning": place for word, place in WARNINGS.items()}}


def class_at(place: str) -> Any:
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


@cache
def classes() -> list[tuple[str, str, ast.ClassDef]]:
    """Return package, qualified name and node of every class of the code."""
    found = []
    for package in (kf, kanefe_fem):
        for path in sorted(Path(str(package.__file__)).parent.rglob("*.py")):
            text = path.read_text(encoding="utf-8")
            if "class " in text:
                found += [(package.__name__, *one) for one in classes_below(ast.parse(text))]
    return found


def classes_of(folder: Path) -> list[str]:
    """Return the qualified names of the classes in the files of a folder."""
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in sorted(folder.rglob("*.py")))
    return [name for tree in trees for name, _ in classes_below(tree)]


def is_saved(name: str) -> bool:
    """Return whether a class of kernels, a law, is in files."""
    return any(place.startswith("kanefe.kernels") and place.endswith(f":{name}") for place in PLACES.values())


def classes_below(node: ast.AST, outer: str = "") -> Iterator[tuple[str, ast.ClassDef]]:
    """Yield the qualified names and nodes of all classes below a node: statements within statements."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.expr):
            continue
        inner = outer
        if isinstance(child, ast.ClassDef):
            yield outer + child.name, child
            inner = f"{outer}{child.name}."
        elif isinstance(child, ast.FunctionDef):
            inner = f"{outer}{child.name}.<locals>."
        yield from classes_below(child, inner)


def classes_in(header: str) -> set[str]:
    return set(re.findall(r'"class": "([^"]*)"', header))


def test_the_words_are_those_that_files_have() -> None:
    assert set(SAVED_CLASSES) == WORDS
    assert set(WARNINGS) == WORDS_OF_WARNINGS


@pytest.mark.parametrize("module", [saved_classes, body_cache])
def test_no_word_is_given_twice(module: Any) -> None:
    tables = [node for node in ast.walk(ast.parse(inspect.getsource(module))) if isinstance(node, ast.Dict)]
    words = [key.value for table in tables for key in table.keys if isinstance(key, ast.Constant)]
    assert {"flexible body", "accuracy"} & set(words)
    assert [word for word, count in Counter(words).items() if count > 1 and word in WORDS | WORDS_OF_WARNINGS] == []


@pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)
def test_every_class_is_where_the_table_says(place: str) -> None:
    found = class_at(place)
    assert f"{found.__module__}:{found.__qualname__}" == place  # not a name that another file passes on
    assert is_dataclass(found) or issubclass(found, Warning)


def test_no_class_has_two_words() -> None:
    assert len(set(PLACES.values())) == len(PLACES)


def test_every_warning_has_a_word() -> None:
    # these are of a machine or of a scene, and not kept with a body
    of_machine = {"CacheWarning", "MemoryWarning", "OtherRestWarning"}
    of_scene = {"StartWarning", "StiffeningWarning", "UnsettledWarning"}
    of_robots = {"LinkMassWarning", "NotTakenWarning", "OddInertiaWarning"}
    nodes = [node for _, _, node in classes()]
    ours = {node.name for node in nodes if any(ast.unparse(base).endswith("Warning") for base in node.bases)}
    assert ours - of_machine - of_scene - of_robots == {place.partition(":")[2] for place in WARNINGS.values()}


@pytest.mark.parametrize("make", BODIES.values(), ids=BODIES)
def test_a_saved_body_names_no_file_of_the_code(make: Callable[[], kf.FlexibleBody], tmp_path: Path) -> None:
    make().save(str(tmp_path / "body.npz"))
    header = read_header(tmp_path / "body.npz")
    assert "flexible body" in classes_in(header)
    assert classes_in(header) <= WORDS
    assert "kanefe." not in header


def test_a_saved_model_names_no_file_of_the_code(tmp_path: Path) -> None:
    save_model(lattice_model(0), tmp_path / "model.npz")
    header = read_header(tmp_path / "model.npz")
    assert {"model record", "finite element model"} <= classes_in(header) <= WORDS
    assert "kanefe." not in header
    assert load_model(tmp_path / "model.npz").size == lattice_model(0).size


@dataclass(frozen=True)
class Thing:
    value: float


def test_a_class_without_a_word_is_refused() -> None:
    with pytest.raises(TypeError, match=r"^made_by is a Thing, which has no word in kanefe\.storage\.saved_classes$"):
        encoded({"made_by": Thing(1.0)})
    with pytest.raises(TypeError, match=r"is a CraigBampton, which has no word"):
        encoded(kf.CraigBampton(modes=3))


@pytest.mark.parametrize("word", ["arm", "kanefe.bodies.flexible:FlexibleBody", "os:system"])
def test_an_unknown_word_is_refused(word: str) -> None:
    with pytest.raises(ValueError, match=f"'{word}' is not a kind of object that this version knows"):
        decoded(f'{{"is": "object", "class": "{word}", "fields": {{}}}}', {})


def pendulum() -> Any:
    scene = kf.System()
    scene.add_rigid_body("arm", 1.0, 0.5, joint=kf.Revolute("z", motion=kf.Motion.steady(1.0)))
    return scene.freeze()


class TestDigest:
    def test_the_file_of_our_classes_does_not_count(self, monkeypatch: pytest.MonkeyPatch) -> None:
        of_options, of_scene = digest(reduction=kf.CraigBampton(modes=3)), digest_of_scene(model=pendulum())
        for cls in (kf.CraigBampton, kf.Revolute, kf.Motion, type(pendulum())):
            monkeypatch.setattr(cls, "__module__", "kanefe.elsewhere.methods")
        assert digest(reduction=kf.CraigBampton(modes=3)) == of_options
        assert digest_of_scene(model=pendulum()) == of_scene

    def test_methods_of_a_class_that_was_typed_in_count(self) -> None:
        """By python -c their file has the name that dataclasses give to the functions they write."""

        def of(value: float) -> str:
            names: dict[str, Any] = {"__name__": "typed_in"}
            exec(f"def f(): return {value}\nclass Build:\n    def __call__(self): return f()", names)
            return digest(build=names["Build"])

        assert of(1.0) == of(1.0)
        assert of(1.0) != of(2.0)

    def test_a_saved_class_counts_by_its_word(self, monkeypatch: pytest.MonkeyPatch) -> None:
        body = BODIES["reduced"]()
        before = digest(body=body)
        monkeypatch.setitem(saved_classes._WORDS, "kanefe.bodies:FlexibleBody", "flexible body")
        monkeypatch.setattr(kf.FlexibleBody, "__module__", "kanefe.bodies")
        assert word_of(kf.FlexibleBody) == "flexible body"
        assert digest(body=body) == before

    def test_the_file_of_the_users_classes_counts(self, monkeypatch: pytest.MonkeyPatch) -> None:
        before = digest(thing=Thing(1.0))
        monkeypatch.setattr(Thing, "__module__", "elsewhere")
        assert digest(thing=Thing(1.0)) != before

    def test_both_packages_may_use_a_name(self, monkeypatch: pytest.MonkeyPatch) -> None:
        before = digest(reduction=kf.CraigBampton(modes=3))
        monkeypatch.setattr(kf.CraigBampton, "__module__", "kanefe_fem.methods")
        assert digest(reduction=kf.CraigBampton(modes=3)) != before

    def test_distinct_classes_have_distinct_names(self) -> None:
        in_kernels = Counter(classes_of(Path(str(kf.__file__)).parent / "kernels"))  # none of these is in a file
        count = Counter((package, name) for package, name, _ in classes())
        count.subtract({("kanefe", name): times for name, times in in_kernels.items() if not is_saved(name)})
        assert count["kanefe", "FlexibleBody"] == 1
        assert {name for (_, name), times in count.items() if times > 1} == SHARED_NAMES
