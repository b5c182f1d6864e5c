"""Where joints start: positions of joints with several coordinates, and couplings, which move what depends only."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kanefe as kf

INERTIAL = '<inertial pos=".1 .2 .3" mass="1" diaginertia=".1 .1 .1"/>'
LINK = """<link name="{}"><inertial><origin xyz=".1 0 .2"/><mass value="1"/>
<inertia ixx=".1" iyy=".2" izz=".25" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = (
    '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/>{}</joint>'
)
TURNED = (0.6, 0.0, 0.8, 0.0)
PLACES = {
    "free": (0.1, 0.2, 0.3, *TURNED),
    "ball": TURNED,
    "floating": (0.1, 0.2, 0.3, *TURNED),
    "planar": (0.1, 0.2, 0.3),
}


def one_joint(folder: Path, kind: str, positions: dict[str, object]) -> kf.RobotScene:
    path = folder / "robot.xml"
    if kind in ("free", "ball"):
        joint = f'<joint name="j" type="{kind}"/>'
        path.write_text(f'<mujoco><worldbody><body name="a">{joint}{INERTIAL}</body></worldbody></mujoco>')
        return kf.read_mjcf(path, positions=positions)
    parts = [LINK.format("a"), JOINT.format("j", kind, "base", "a", "")]
    path.write_text(f'<robot name="r"><link name="base"/>{"".join(parts)}</robot>')
    return kf.read_urdf(path, positions=positions)


BOTH = [pytest.param(kind, marks=pytest.mark.mjcf if kind in ("free", "ball") else pytest.mark.urdf) for kind in PLACES]


@pytest.mark.parametrize("kind", BOTH)
def test_joints_with_several_coordinates_start_where_they_are_put(kind: str, tmp_path: Path) -> None:
    at = PLACES[kind]
    model = one_joint(tmp_path, kind, {"j": at}).freeze()
    # Euler parameters are normalised
    assert model.initial_state[: len(at)] == pytest.approx(at, abs=1e-15)


@pytest.mark.parametrize("kind", BOTH)
def test_positions_of_another_number_are_refused(kind: str, tmp_path: Path) -> None:
    number = {3: "three", 4: "four", 7: "seven"}[len(PLACES[kind])]
    for wrong in (0.3, PLACES[kind][:2]):
        with pytest.raises(kf.ModelError, match=f"positions: joint 'j' takes {number} numbers: "):
            one_joint(tmp_path, kind, {"j": wrong})


@pytest.mark.urdf
def test_positions_of_fixed_and_single_joints_are_refused(tmp_path: Path) -> None:
    with pytest.raises(kf.ModelError, match="joint 'j' takes none, because it is fixed"):
        one_joint(tmp_path, "fixed", {"j": 0.3})
    with pytest.raises(kf.ModelError, match="joint 'j' takes one number"):
        one_joint(tmp_path, "continuous", {"j": (0.3, 0.4)})
    with pytest.raises(kf.ModelError, match="'j' must be a finite number"):
        one_joint(tmp_path, "planar", {"j": (0.3, np.nan, 0.0)})
    with pytest.raises(kf.ModelError, match="Euler parameters of joint 'j' are all zero"):
        one_joint(tmp_path, "floating", {"j": (0.0,) * 7})


@pytest.mark.urdf
@pytest.mark.parametrize(
    ("factor", "given", "start"),
    [
        (2, {}, (0.0, 0.0, 0.3)),
        (0, {}, (0.0, 0.0, 0.3)),
        (2, {"driver": 0.1}, (0.0, 0.1, 0.5)),
        (2, {"follower": 0.5}, (0.0, 0.1, 0.5)),
    ],
)
def test_only_what_is_coupled_moves(
    factor: int, given: dict[str, float], start: tuple[float, ...], tmp_path: Path
) -> None:
    mimic = f'<mimic joint="driver" multiplier="{factor}" offset="0.3"/>'
    joints = ("shoulder", "base", "a", ""), ("driver", "a", "b", ""), ("follower", "b", "c", mimic)
    parts = [LINK.format(name) for name in "abc"] + [JOINT.format(j[0], "continuous", *j[1:]) for j in joints]
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="r"><link name="base"/>{"".join(parts)}</robot>')
    # round-off of the solver's residual of the coupling
    assert kf.read_urdf(path, positions=given).freeze().initial_state[:3] == pytest.approx(start, abs=1e-15)


@pytest.mark.mjcf
@pytest.mark.parametrize(
    ("equalities", "start"),
    [
        ('<joint joint1="z" polycoef=".3 0 0 0 0"/>', (0.0, 0.0, 0.3)),
        ('<joint joint1="y" joint2="z" polycoef=".2 2 0 0 0"/><joint joint1="z" polycoef=".3"/>', (0.0, 0.8, 0.3)),
        ('<joint joint1="y" joint2="x" polycoef=".2"/><joint joint1="z" joint2="y"/>', (0.0, 0.2, 0.2)),
    ],
)
def test_what_is_held_starts_there_and_nothing_else_moves(
    equalities: str, start: tuple[float, ...], tmp_path: Path
) -> None:
    path = tmp_path / "robot.xml"
    bodies = "".join(f'<body pos=".5 0 0"><joint name="{name}" axis="0 1 0"/>{INERTIAL}' for name in "xyz")
    path.write_text(f"<mujoco><worldbody>{bodies}{'</body>' * 3}</worldbody><equality>{equalities}</equality></mujoco>")
    # round-off of the solver's residual of the couplings
    assert kf.read_mjcf(path).freeze().initial_state[:3] == pytest.approx(start, abs=1e-15)
