"""What a run and its results need is built at once, where nothing is there, and nothing else."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

import kanefe as kf
from kanefe.kernels.compiler import compiled_functions as units
from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.compiler.addresses import house_address
from kanefe.kernels.compiler.libraries import ENGINE, Library
from kanefe_fem.demo import beam_arm, swing_scene
from loop_scenes import four_bar
from steel_beams import steel_bar

pytestmark = pytest.mark.skipif(not IS_COMPILED, reason="kernels are run as Python")


def _pendulum(torque: Callable[[float], Any] | None = None, stiffness: float = 0.0) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    upper = scene.add_rigid_body("upper", 1.0, 0.1, com=(0.1, 0, 0), joint=kf.Revolute("y"))
    lower = scene.add_rigid_body(
        "lower", 1.0, 0.1, com=(0.1, 0, 0), parent=upper, at=(0.2, 0, 0), joint=kf.Revolute("y")
    )
    if torque is not None:
        scene.add_torque(upper, torque)
    if stiffness:
        scene.add_spring("spring", upper, lower, stiffness=stiffness)
    return scene


def _driven() -> kf.System:
    return _pendulum(lambda t: (0.0, math.sin(t), 0.0))


def _sprung() -> kf.System:
    return _pendulum(stiffness=10.0)


def _bar() -> kf.System:
    return steel_bar(reduction=kf.CraigBampton(modes=4), damping=kf.ModalDamping(0.01))


def _swung() -> kf.System:
    return swing_scene(beam_arm())


@pytest.mark.parametrize(
    ("make", "method", "most_unused"),
    [
        (_pendulum, "auto", 0),
        (_driven, "auto", 0),
        (_sprung, "auto", 0),
        (four_bar, "auto", 0),
        (_bar, "extrapolation", 0),
        (_bar, "radau5", 0),
        (_swung, "auto", 3),
        (_bar, "auto", 3),  # two methods and exact derivatives, which are as likely to be taken
    ],
)
def test_there_is_one_build(
    make: Callable[[], kf.System], method: str, most_unused: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run() -> None:
        scene = make()
        result = scene.simulate((0.0, 0.1), method=method, rtol=1e-5, output_step=0.01)
        result.position(result.bodies[0])
        result.acceleration(result.bodies[0])
        assert len(result.energy.total)

    counts, used = _counts_of(run, monkeypatch)
    assert len(counts) == 1
    assert len(set(counts[0]) - used) <= most_unused


def _held() -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    held = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=10.0))
    scene.add_rigid_body("rod", 1.0, 0.1, com=(0.1, 0, 0), joint=held)
    return scene


def _block() -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    block = scene.add_rigid_body("block", 2.0, 0.01, joint=kf.Free(position=(0, 0, 0.051)))
    table = scene.add_surface("table", scene.ground, kf.shapes.Plane("z"))
    box = scene.add_surface("box", block, kf.shapes.Box((0.2, 0.1, 0.1)))
    scene.add_contact("lies", box, table, normal=kf.HuntCrossley(1e6, damping=1.0), friction=kf.Coulomb(0.3))
    return scene


@pytest.mark.parametrize("make", [_held, _bar, _block])
def test_what_comes_to_rest_is_built_at_once(make: Callable[[], kf.System], monkeypatch: pytest.MonkeyPatch) -> None:
    counts, used = _counts_of(lambda: kf.linearise(make(), start=kf.equilibrium(make())), monkeypatch)
    assert len(counts) == 1
    assert used <= set(counts[0])


@pytest.mark.parametrize(("method", "is_asked"), [("dop853", False), ("extrapolation", False), ("radau5", True)])
def test_complex_numbers_are_built_only_for_methods_with_a_jacobian(
    method: str, is_asked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    counts, _ = _counts_of(lambda: _bar().simulate((0.0, 0.01), method=method, output_step=0.01), monkeypatch)
    assert [f"{ENGINE}-complex" in names for names in counts] == [is_asked]


def _counts_of(run: Callable[[], object], monkeypatch: pytest.MonkeyPatch) -> tuple[list[list[str]], set[str]]:
    """Return the libraries of each build of a run where nothing is built, and those that it loads."""
    run()  # so that there are files of all that is used
    counts: list[list[str]] = []
    used: set[str] = set()
    there, opened = units.path_of, units._opened

    def told(libraries: Sequence[Library], *_: Any) -> None:
        counts.append([library.name for library in libraries])

    def found(library: Library) -> Path | None:
        return there(library) if any(library.name in names for names in counts) else None

    def loaded(path: Path) -> Any:
        used.add(path.stem.rsplit("-", 3)[0])  # stamp, size and digest follow
        return opened(path)

    monkeypatch.setattr(units, "_loaded", {})
    monkeypatch.setattr(units, "_libraries", {})
    monkeypatch.setattr(units, "path_of", found)
    monkeypatch.setattr(units, "_opened", loaded)
    monkeypatch.setattr("kanefe.kernels.compiler.side_by_side.build_libraries", told)
    house_address.cache_clear()
    run()
    return counts, used
