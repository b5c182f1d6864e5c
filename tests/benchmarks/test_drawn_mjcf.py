"""Models of MJCF drawn for the benchmark of robots: held by each kind of equality, they accelerate as MuJoCo has it."""

from __future__ import annotations

import importlib
import warnings
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from benchmarks.drawn_mjcf import Drawing, difference, state_of
from kanefe.robots import mjcf
from kanefe.robots.scene import NotTakenWarning

pytestmark = pytest.mark.mjcf

SEEDS = {"<connect": 49, "<weld": 6, "<joint joint1": 290}
"""What a model has -> the number of one, without polynomials, which numba takes a second for."""


@pytest.mark.parametrize("what", SEEDS)
def test_models_with_equalities_accelerate_as_mujocos(what: str) -> None:
    assert what in Drawing(SEEDS[what]).text
    # round-off of some bodies
    assert difference(SEEDS[what]) < 1e-12


@pytest.mark.parametrize("seed", [66, 144])
def test_a_keyframe_that_fits_but_for_round_off_is_taken(seed: int, tmp_path: Path) -> None:
    """Of seed 66 a loop is locked in a model that moves: the round-off of all speeds is left in its own."""
    mujoco, text = importlib.import_module("mujoco"), Drawing(seed).text
    state, _ = state_of(mujoco.MjModel.from_xml_string(text), np.random.default_rng(seed))
    places, speeds = (" ".join(map(repr, values.tolist())) for values in (state.qpos, state.qvel))
    path = tmp_path / "drawn.xml"
    path.write_text(text.replace("</mujoco>", f'<keyframe><key qpos="{places}" qvel="{speeds}"/></keyframe></mujoco>'))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NotTakenWarning)
        start = kf.read_mjcf(path, key=0, joint_forces=False).freeze().initial_state
    # round-off of speeds and places of some m
    assert start[: state.qpos.size + state.qvel.size] == pytest.approx([*state.qpos, *state.qvel], abs=1e-14)


@pytest.mark.parametrize("what", SEEDS)
def test_the_comparison_sees_an_equality_that_is_not_read(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mjcf, "_add_equality", lambda *model: None)
    assert difference(SEEDS[what]) > 1e-3
