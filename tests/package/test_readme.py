"""The README's scripts run as printed."""

import re

import numpy as np
import pytest

import kanefe as kf
from kanefe.checks.verification.rotors import point_on_springs
from repository import ROOT

SCRIPTS = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL)


@pytest.mark.fenicsx
def test_the_first_script_runs(tmp_path, monkeypatch, capsys):
    script = SCRIPTS[0]
    (tmp_path / "meshes").symlink_to(ROOT / "meshes")
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(compile(script, "README.md", "exec"), names)
    assert {path.name for path in tmp_path.iterdir()} >= {"energy.png", "arm.pvd", "run.h5"}
    printed = [float(x) for x in re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", capsys.readouterr().out)]
    # the arm has all but stopped shaking: its root carries the weight of arm and tip mass
    assert printed[2] == pytest.approx((6.5233 + 0.5) * 9.81, rel=0.1)


def test_the_loop_closes(capsys):
    names: dict = {}
    exec(compile("import kanefe as kf\n" + SCRIPTS[1], "README.md", "exec"), names)
    report = names["model"].constraint_report()
    assert "pin" in capsys.readouterr().out
    # five rows in space hold what two do in the plane
    assert (report.rows, report.rank) == (5, 2)


def test_a_ball_lands_and_rolls():
    scene = kf.System(gravity=(0, 0, -9.81))
    ball = scene.add_rigid_body("ball", 1.0, 4e-3, joint=kf.Free(position=(0, 0, 0.2), velocity=(1, 0, 0)))
    names = {"kf": kf, "scene": scene, "ball": ball}
    names["height_of_ball"] = lambda t, state: state.position("ball")[2] - 0.1
    exec(compile(SCRIPTS[2], "README.md", "exec"), names)
    result = scene.simulate((0.0, 0.5), events=[names["lands"]])
    assert result.velocity("ball")[-1, 0] == pytest.approx(5.0 / 7.0, abs=1e-6)


def test_a_hoist_and_a_car_on_a_track():
    scene = kf.System(gravity=(0, 0, -9.81))
    hook = scene.add_point("hook", 300.0, joint=kf.Prismatic("z"))
    ends = {name: scene.ground.frame(at=at) for name, at in (("winch", (-3, 0, 0)), ("sheave", (0, 0, 5)))}
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    track = 20.0 * np.column_stack((np.cos(angle), np.sin(angle), np.zeros(40)))
    exec(compile(SCRIPTS[3], "README.md", "exec"), {"kf": kf, "scene": scene, "hook": hook, "track": track, **ends})
    result = scene.simulate((0.0, 0.5))
    assert result.status.is_finished
    assert result.joint_coordinates("car")[-1, 0] == pytest.approx(6.0, rel=1e-6)
    assert result.load("hoist")[0, 2] == pytest.approx(5e3, rel=1e-6)


def test_a_ball_bounces(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    scene = kf.System(gravity=(0, 0, -9.81))
    scene.add_point("ball", 0.1, joint=kf.Prismatic("z", position=1.0))
    names = {"kf": kf, "scene": scene}
    exec(compile(SCRIPTS[4], "README.md", "exec"), names)
    # it falls for sqrt(2 h / g) and flies for 0.8, 0.64, ... of twice that
    fall = np.sqrt(2.0 / 9.81)
    flights = fall * np.cumsum(np.concatenate(([1.0], 2.0 * 0.8 ** np.arange(1, 9))))
    assert names["result"].events["floor"] == pytest.approx(flights[flights < 3.0], abs=1e-6)
    assert "floor" in capsys.readouterr().out
    assert (tmp_path / "run.npz").exists()


def test_small_motions_of_a_scene(tmp_path, monkeypatch, capsys):
    pytest.importorskip("control")
    monkeypatch.chdir(tmp_path)
    scene = kf.System(gravity=(0, 0, -9.81))
    scene.add_rigid_body("tip", 2.0, joint=kf.Prismatic("y", forces=kf.CoordinateForce(stiffness=50.0, damping=1.0)))
    names = {"np": np, "kf": kf, "scene": scene, "rotor": point_on_springs}
    exec(compile(SCRIPTS[5], "README.md", "exec"), names)
    assert {path.name for path in tmp_path.iterdir()} == {"response.png", "campbell.png"}
    assert "frequency [Hz]" in capsys.readouterr().out
    assert len(SCRIPTS) == 7


def test_a_crane_is_studied(tmp_path, monkeypatch, capsys):
    def crane(speed, wind_deg, seed):
        scene = kf.System(gravity=(0, 0, -9.81))
        load = scene.add_rigid_body("load", 300.0, 1.0, com=(0, 0, -4.0), joint=kf.Revolute("y", position=0.1 * speed))
        scene.add_spring("hoist", scene.ground.frame(at=(0, 0, 5)), load, stiffness=1.0, damping=seed)
        return scene

    monkeypatch.chdir(tmp_path)
    # what is printed is a script, whose functions workers would import
    monkeypatch.setattr(kf.Study.run, "__defaults__", ("serial", None))
    script = SCRIPTS[6]
    for printed, fewer in (
        ("range(0, 360, 30)", "(0, 90)"),
        ("range(10)", "range(5)"),
        ("duration=20.0", "duration=1.0"),
    ):
        assert printed in script
        script = script.replace(printed, fewer)
    exec(compile(script, "README.md", "exec"), {"kf": kf, "crane": crane, "__name__": "__main__"})
    assert "20 cases, 20 finished" in capsys.readouterr().out
    assert {path.name for path in tmp_path.iterdir()} == {"study", "study.html"}
