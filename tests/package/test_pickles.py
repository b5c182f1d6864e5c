"""Scenes, models and results are pickled: what comes back gives the same bits, in another process too."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

import kanefe as kf
from kanefe.bodies.unreduced import UnreducedBody
from kanefe.storage.digest import digest_of_scene
from pickled_scenes import SCENES, fingerprint
from repository import surroundings
from scenes import lattice_body


def again(value: Any) -> Any:
    return pickle.loads(pickle.dumps(value))


@pytest.mark.parametrize("make", SCENES.values(), ids=SCENES)
def test_a_scene_that_comes_back_runs_to_the_same_bits(make: Any) -> None:
    scene = make()
    before = again(scene)
    expected = fingerprint(scene)
    assert fingerprint(before) == expected
    assert fingerprint(again(scene)) == expected  # one that was frozen
    # a checkpoint of the one goes on with the other
    assert digest_of_scene(model=before.freeze()) == digest_of_scene(model=scene.freeze())


@pytest.mark.parametrize("make", SCENES.values(), ids=SCENES)
def test_a_model_comes_back_without_what_it_keeps(make: Any) -> None:
    model = make().freeze()
    t, y = 0.1, model.initial_state
    expected = model.rhs(t, y)
    model.energy(t, y)
    assert model.literal is not None
    for found in (again(model), copy.deepcopy(model)):
        assert set(vars(found)) == {f.name for f in fields(model)}
        assert found.rhs(t, y).tobytes() == expected.tobytes()
        assert not found.gravity.flags.writeable
        assert found.route.name == model.route.name


@pytest.mark.parametrize("make", SCENES.values(), ids=SCENES)
def test_a_result_comes_back(make: Any) -> None:
    result = make().simulate((0.0, 0.02), rtol=1e-5, output_step=0.01)
    before = again(result)
    name = result.run.model.bodies[-1].name
    for found in (before, again(result)):
        assert found.times.tobytes() == result.times.tobytes()
        assert found.position(name).tobytes() == result.position(name).tobytes()
        assert found.energy.total.tobytes() == result.energy.total.tobytes()
        assert str(found) == str(result)


def test_scenes_run_to_the_same_bits_in_another_process(tmp_path: Path) -> None:
    scenes = {name: make() for name, make in SCENES.items()}
    (tmp_path / "scenes").write_bytes(pickle.dumps(scenes))
    code = (
        "import pickle, sys\n"
        "from pickled_scenes import fingerprint\n"
        "for name, scene in pickle.load(open(sys.argv[1], 'rb')).items(): print(f'{name}: {fingerprint(scene)}')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "scenes")],
        capture_output=True,
        text=True,
        env=surroundings(),
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [f"{name}: {fingerprint(scene)}" for name, scene in scenes.items()]


def test_a_result_that_was_asked_answers_in_another_process(tmp_path: Path) -> None:
    result = SCENES["springs"]().simulate((0.0, 0.02), rtol=1e-5, output_step=0.01)
    result.position("bob")  # from tables, which have addresses of this process
    (tmp_path / "result").write_bytes(pickle.dumps(result))
    code = "import pickle, sys; print(pickle.load(open(sys.argv[1], 'rb')).energy.total.tobytes().hex())"
    command = [sys.executable, "-c", code, str(tmp_path / "result")]
    done = subprocess.run(command, capture_output=True, text=True, env=surroundings(), check=False)
    assert (done.returncode, done.stdout.strip()) == (0, result.energy.total.tobytes().hex()), done.stderr


def test_a_body_that_was_used_comes_back_without_its_factors() -> None:
    body = SCENES["unreduced"]().freeze().bodies[0].flexible.body
    assert isinstance(body, UnreducedBody)
    _ = body.held_factors, body.inertia_field, body.mass
    found = again(body)
    assert set(vars(found)) == {f.name for f in fields(body)}
    assert found.stiffness.data.tobytes() == body.stiffness.data.tobytes()
    assert not found.stiffness.data.flags.writeable
    assert found.factorise is body.factorise


def test_a_body_and_a_result_from_files_come_back(tmp_path: Path) -> None:
    lattice_body(1).save(tmp_path / "arm.npz")
    body = kf.FlexibleBody.load(tmp_path / "arm.npz")
    found = again(body)
    (tmp_path / "arm.npz").unlink()
    assert found.basis.tobytes() == lattice_body(1).basis.tobytes()
    assert not found.basis.flags.writeable
    result = SCENES["loop"]().simulate((0.0, 0.02), output_step=0.01)
    result.save(tmp_path / "run.h5")
    loaded = again(kf.load_result(tmp_path / "run.h5"))
    assert loaded.position("crank").tobytes() == result.position("crank").tobytes()


def test_frames_stay_those_of_their_scene() -> None:
    scene = kf.System()
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z"))
    found, frame = again((scene, hub))
    found.add_rigid_body("tip", 1.0, 0.1, parent=frame, joint=kf.Revolute("z"))
    assert found.freeze().free_count == 2
