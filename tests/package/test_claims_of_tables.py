"""What tables of the documents say of calls: each is bound to its signature, and made where its arguments are known."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import kanefe as kf
import kanefe_fem
from kanefe.scene.scene import FlexibleMember
from repository import ROOT

HOLDERS = (kf.System, kf.Result, kf.Instant, kf.Linearisation, kf.Frame, FlexibleMember, kf.Model, kf.SceneDamping)
"""Classes whose methods tables name by an object: `scene.simulate`, `result.load`, `body.frame`."""

OTHERS = {
    *("f", "mbs", "step", "loadVectorUserFunction", "DoStepDynamics"),
    *("stress", "stresses", "stiffness", "mass", "damping", "stress_stiffness", "geometric_stiffness", "added_mass"),
    *("stress_in_layer", "shell_forces", "section_forces", "fibre_stress", "gauge"),  # methods of what `recover` gives
}
"""What functions of users, and of other programs, are called in these tables."""

KNOWN: dict[str, Any] = {
    "points": np.column_stack((np.linspace(0, 1, 5), np.zeros(5), np.zeros(5))),
    "depths": (0.0, 0.01),
    "forces": (0.0, 10.0),
    "hysteresis": 0.1,
    "turning": 0.001,
    "k": 1e5,
    "c": 10.0,
    "e": 0.5,
    "mu": 0.3,
    "diameter": 0.02,
    "outer_diameter": 0.02,
    "width": 0.02,
    "height": 0.04,
    "thickness": 0.002,
    **dict.fromkeys(("A", "I_y", "I_z", "J"), 1e-6),
}
"""Values of the names that tables use as arguments."""


def calls() -> Iterator[tuple[str, ast.Call]]:
    """Yield place and syntax of each call that stands in backquotes in a table."""
    for path in sorted((ROOT / "docs").rglob("*.md")):
        is_code = False
        for number, line in enumerate(path.read_text().splitlines(), 1):
            is_code ^= line.startswith("```")
            if is_code or not line.startswith("|"):
                continue
            for code in re.findall(r"`([^`]+)`", line):
                # a keyword without a value, `damping=`, and what is left out at the end
                text = re.sub(r"=(?=[,)])", "=...", code.strip().removesuffix("..."))
                try:
                    tree = ast.parse(text, mode="eval")
                except SyntaxError:
                    continue
                place = f"{path.relative_to(ROOT).as_posix()}:{number} {code}"
                yield from ((place, node) for node in ast.walk(tree) if isinstance(node, ast.Call))


def called(function: ast.expr) -> list[Callable[..., Any]]:
    """Return what a name may stand for; none for functions of users and of other programs."""
    if isinstance(function, ast.Name):
        found = [getattr(home, function.id, None) for home in (kf, kanefe_fem, *HOLDERS)]
        return [one for one in found if callable(one)]
    if not isinstance(function, ast.Attribute):
        return []
    root = function
    while isinstance(root, ast.Attribute):
        root = root.value
    if isinstance(root, ast.Name) and root.id in {"kf", "kanefe", "kanefe_fem"}:
        text = ast.unparse(function).replace("kanefe.", "kf.")
        return [eval(text, {"kf": kf, "kanefe_fem": kanefe_fem})]
    return [found for holder in HOLDERS if callable(found := getattr(holder, function.attr, None))]


def fits(one: Callable[..., Any], call: ast.Call) -> bool:
    signature = inspect.signature(one)
    is_method = "self" in signature.parameters
    given = [argument for argument in call.args if not _is_left_out(argument)]
    try:
        signature.bind_partial(*([None] * (len(given) + is_method)), **{str(k.arg): None for k in call.keywords})
    except TypeError:
        return False
    return True


def _is_left_out(argument: ast.expr) -> bool:
    return isinstance(argument, ast.Constant) and argument.value is ...


def test_each_call_of_a_table_fits_the_signature():
    wrong, seen = [], 0
    for place, call in calls():
        name = ast.unparse(call.func)
        if name.partition(".")[0] in OTHERS or name in OTHERS:
            continue
        found = called(call.func)
        if not found and isinstance(call.func, ast.Attribute):
            continue  # a method of what another call returns
        seen += 1
        if not any(fits(one, call) for one in found):
            wrong.append(place)
    assert not wrong
    assert seen > 60


def made() -> dict[str, str]:
    """Return the calls of classes with known arguments, with their places."""
    found = {}
    for place, call in calls():
        text = ast.unparse(call)
        if re.match(r"(kf|kanefe_fem)\.[A-Z]\w*\(", text) and "..." not in text:
            names = {node.id for node in ast.walk(call) if isinstance(node, ast.Name)} - {"kf", "kanefe_fem"}
            if names <= set(KNOWN):
                found[text] = place
    return found


@pytest.mark.parametrize("text", made())
def test_each_call_with_known_arguments_can_be_made(text):
    eval(text, {"kf": kf, "kanefe_fem": kanefe_fem, **KNOWN})


def test_tables_of_sections_have_the_sides_of_their_classes():
    """Of width and height which is along y, as the docstrings say: by the second moments that bend about y and z."""
    page = (ROOT / "docs" / "howto" / "materials.md").read_text()
    for section in (kanefe_fem.Rectangle(0.02, 0.04), kanefe_fem.Box(0.02, 0.04, 0.002)):
        row = next(line for line in page.splitlines() if f"kanefe_fem.{type(section).__name__}(" in line)
        assert section.I_y > section.I_z, "height is along z"
        assert "along y" in row
        assert row.index("along y") < row.index("z", row.index("along y"))


def test_pages_for_those_who_come_from_others_say_signs_axes_and_points():
    """Of `force=` of a spring, a bushing, a motor, a gear, and speeds of a free body: exact but for round-off."""
    scene = kf.System()
    ball = scene.add_point("ball", 1.0, at=(2, 0, 0), joint=kf.Prismatic("x"))
    scene.add_spring("pulls", scene.ground, ball, force=lambda length, rate: 10.0)
    held = scene.add_rigid_body("held", 2.0, 1.0, at=(2, 0, 0), joint=kf.Free())
    turned = scene.ground.frame(at=(0, 0.5, 0), orientation=kf.rotation_about("z", np.pi / 2))
    scene.add_bushing("in axes of a", turned, held, stiffness=(1.0, 10.0, 100.0))
    spun = kf.Free(orientation=kf.rotation_about("x", np.pi / 2), angular_velocity=(0, 0, 1.0))
    scene.add_rigid_body("spun", 1.0, 1.0, com=(1, 0, 0), joint=spun)
    driven = scene.add_rigid_body("driven", 1.0, 1.0, joint=kf.Revolute("z", speed=1.0))
    scene.add_motor(driven, 3.0)
    other = scene.add_rigid_body("other", 1.0, 1.0, joint=kf.Revolute("z", speed=None))
    scene.add_gear("against each other", {driven: 1, other: 2})
    start = scene.simulate((0.0, 1e-3))
    assert start.acceleration("ball")[0, 0] == pytest.approx(-10.0), "positive forces pull"
    assert start.load_force("pulls", end=0)[0, 0] == pytest.approx(10.0), "on end a"
    assert start.acceleration("held")[0] == pytest.approx((-10.0, 0.25, 0.0)), "in axes of a"
    assert start.angular_acceleration("held")[0] == pytest.approx(np.zeros(3), abs=1e-12), "at b"
    assert start.velocity("spun")[0] == pytest.approx(np.zeros(3), abs=1e-12), "of the origin"
    assert start.angular_velocity("spun")[0] == pytest.approx((0.0, 0.0, 1.0)), "in axes of the body"
    assert start.joint_speeds("other")[0, 0] == pytest.approx(-0.5)
    # 1.25 kg m2: the inertia of the other counts by the square of the ratio
    assert start.angular_acceleration("driven")[0, 2] == pytest.approx(3.0 / 1.25)
    assert start.joint_reaction("other")[0, 5] == pytest.approx(-0.5 * 3.0 / 1.25), "what a gear does is part of it"
