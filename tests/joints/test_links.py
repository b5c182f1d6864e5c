"""What a joint says of itself: nobody outside of its room asks of which kind it is."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from kanefe import joints
from repository import ROOT

KINDS = {name: kind for name in joints.__all__ if issubclass(kind := getattr(joints, name), kf.Joint)}
MADE = [kind() for kind in KINDS.values() if kind not in (kf.Joint, kf.PointOnCurve)]
ON_CURVE = kf.PointOnCurve(((0, 0, 0), (1, 0, 0)))  # nowhere at home: it is where its first point is
NAMES = set(KINDS) | {"ScalarJoint", "AxisJoint", "SeveralCoordinatesJoint"}


def asks_for_a_kind(node: ast.AST) -> bool:
    """Tell whether a call asks of what kind a joint is; that it is a joint at all may be asked."""
    if not (isinstance(node, ast.Call) and ast.unparse(node.func) in ("isinstance", "issubclass")):
        return False
    asked = {name.id for name in ast.walk(node.args[1]) if isinstance(name, ast.Name)}
    return bool(asked & NAMES - {"Joint"})


def places_that_ask(folder: Path) -> list[str]:
    """Return file and line of each question for the kind of a joint outside of the room of joints."""
    found = []
    for path in sorted(folder.rglob("*.py")):
        text, name = path.read_text(encoding="utf-8"), path.relative_to(folder).as_posix()
        if name.startswith("joints/") or not any(kind in text for kind in NAMES - {"Joint"}):
            continue
        found += [f"{name}:{node.lineno}" for node in ast.walk(ast.parse(text)) if asks_for_a_kind(node)]
    return found


def test_nobody_asks_for_the_kind_of_a_joint(tmp_path: Path) -> None:
    (tmp_path / "asks.py").write_text("def f(joint):\n    return isinstance(joint, Revolute)\n", encoding="utf-8")
    assert places_that_ask(tmp_path) == ["asks.py:2"]
    assert places_that_ask(ROOT / "kanefe") == []


def test_a_question_for_the_kind_is_seen() -> None:
    asked = ast.parse("if isinstance(body.joint, (Fixed, Translation)): pass")
    assert any(map(asks_for_a_kind, ast.walk(asked)))


@pytest.mark.parametrize("joint", [*MADE, ON_CURVE], ids=lambda joint: joint.kind)
def test_links_have_the_coordinates_and_speeds_of_the_joint(joint: kf.Joint) -> None:
    links = joint.links()
    assert links is not None
    assert sum(link.coordinate_count for link in links) == len(joint.coordinate_names)
    assert sum(link.speed_count for link in links) == len(joint.speed_names)
    assert len(joint.units) == len(joint.speed_names)


@pytest.mark.parametrize("joint", MADE, ids=lambda joint: joint.kind)
def test_a_joint_that_has_not_moved_is_at_home(joint: kf.Joint) -> None:
    assert joint.initial_coordinates() == pytest.approx(joint.home(), abs=0.0)
    p, A = joint.pose(joint.home())
    assert np.array_equal(p, np.zeros(3))
    assert np.array_equal(A, np.eye(3))


def test_one_joint_is_fixed_and_one_is_free() -> None:
    assert [joint.kind for joint in MADE if joint.is_fixed] == ["fixed"]
    assert [joint.kind for joint in MADE if joint.is_free] == ["free"]
    assert [joint.kind for joint in MADE if joint.holds_floating] == ["free", "planar"]
    assert [joint.kind for joint in MADE if joint.held() is None] == ["free"]


def test_a_loop_joint_has_no_start_of_its_own() -> None:
    scene = kf.System()
    body = scene.add_rigid_body("body", 1.0, 0.1, joint=kf.Free())
    given = (kf.Spherical(orientation=(0, 1, 0, 0)), kf.Revolute("z", position=0.1), kf.Revolute("z", position=0.0))
    for joint in (*given, kf.Spherical(orientation=(-1, 0, 0, 0)), kf.Planar(position=kf.Guess((1, 0)))):
        with pytest.raises(kf.errors.ModelError, match="has a start or forces of its own"):
            scene.add_loop_joint("pin", joint, scene.ground, body)
    scene.add_loop_joint("pin", kf.Spherical(), scene.ground, body)
