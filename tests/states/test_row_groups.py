"""Rows of loops in groups that have nothing to do with each other: the same as all at once, in less work."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations import constraint_report, dependent_rows
from kanefe.equations.constraint_report import singular_rows
from kanefe.kane.assemble import accelerations
from kanefe.states import constrained_solver
from kanefe.states.constrained_solver import ConstrainedSolver
from kanefe.states.state import State
from kanefe.tree.row_groups import groups_of_rows
from kanefe.tree.row_rates import Rates
from loop_scenes import four_bars

ROUND_OFF = 1e-12
"""Of the solutions, over their size: 1e-16 times the condition of the rows, which are random."""


def random_loops(seed: int, loops: int = 5) -> np.ndarray:
    """Return rows (m, n) of some loops in random order, each of up to 3 independent rows and copies of sums of them."""
    rng = np.random.default_rng(seed)
    blocks = []
    for _ in range(loops):
        own = rng.standard_normal((rng.integers(1, 4), 4))
        blocks.append(np.vstack((own, rng.standard_normal((rng.integers(0, 3), len(own))) @ own)))
    J = np.zeros((sum(map(len, blocks)), 4 * loops))
    at = 0
    for i, block in enumerate(blocks):
        J[at : at + len(block), 4 * i : 4 * i + 4] = block
        at += len(block)
    return J[rng.permutation(len(J))][:, rng.permutation(4 * loops)]


def all_at_once(J: np.ndarray) -> list[np.ndarray]:
    """Return the rows in one group."""
    return [np.arange(len(J))]


@pytest.mark.parametrize("seed", range(5))
def test_no_speed_is_shared_by_two_groups_and_each_group_hangs_together(seed: int) -> None:
    J = random_loops(seed)
    groups = groups_of_rows(J)
    assert sorted(np.concatenate(groups).tolist()) == list(range(len(J)))
    speeds = [set(np.flatnonzero(J[rows].any(axis=0)).tolist()) for rows in groups]
    assert len(set.union(*speeds)) == sum(map(len, speeds))
    assert len(groups) == 5  # each of the loops is one, as its rows have all of its speeds
    assert groups_of_rows(np.eye(3)[:, :2])[2].tolist() == [2]  # a row that has no speed
    assert groups_of_rows(np.zeros((0, 4))) == []


def test_a_chain_of_rows_is_one_group() -> None:
    J = np.eye(6) + np.eye(6, k=1)
    assert [rows.tolist() for rows in groups_of_rows(J[::-1])] == [list(range(6))]


@pytest.mark.parametrize("seed", range(5))
def test_dependent_rows_are_those_without_which_the_rank_of_the_rows_before_is_the_same(seed: int) -> None:
    J = random_loops(seed)
    ranks = [0, *(np.linalg.matrix_rank(J[: i + 1]) for i in range(len(J)))]
    expected = {i for i in range(len(J)) if ranks[i + 1] == ranks[i]}
    size = np.linalg.norm(J, axis=1, keepdims=True)
    assert dependent_rows.dependent_rows(J / size, J) == expected


@pytest.mark.parametrize("seed", range(5))
def test_multipliers_of_groups_are_those_of_all_rows(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(seed)
    J = random_loops(seed)
    M = np.diag(rng.uniform(0.5, 2.0, J.shape[1]))
    rates = Rates(J, np.zeros(len(J)), J**2, np.zeros(len(J)))
    F, c = rng.standard_normal(J.shape[1]), J @ rng.standard_normal(J.shape[1])
    apart = ConstrainedSolver(M, rates)
    found = (*apart.solve(F, c), apart.rank, apart.weakest)
    monkeypatch.setattr(constrained_solver, "groups_of_rows", all_at_once)
    together = ConstrainedSolver(M, rates)
    expected = (*together.solve(F, c), together.rank, together.weakest)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=ROUND_OFF, atol=ROUND_OFF * np.abs(other).max())


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("layout", ["apart", "in a row", "one on the other"])
def test_the_report_is_that_of_all_rows_at_once(layout: str, base: str, monkeypatch: pytest.MonkeyPatch) -> None:
    model = four_bars(4, layout, base=base).freeze()
    found = model.constraint_report()
    for module in (constrained_solver, dependent_rows):
        monkeypatch.setattr(module, "groups_of_rows", all_at_once)
    assert model.constraint_report() == found
    assert len(found.redundant) == 12  # a spatial pin says three times too much in the plane


def test_eigenvalue_problems_are_as_large_as_one_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    model = four_bars(12, "apart").freeze()
    state = State(model, 0.0, model.initial_coordinates, model.initial_speeds)
    sizes: list[int] = []
    _count(monkeypatch, sizes)
    accelerations(state)
    assert sum(sizes) == 5 * 12  # the rows of a spatial pin
    assert max(sizes) <= 5
    rods = four_bars(12, "apart", closed_by="rods").freeze()
    sizes.clear()
    rods.constraint_report()
    assert not sizes  # whether rows depend on each other is not a matter of eigenvalues


def _count(monkeypatch: pytest.MonkeyPatch, sizes: list[int]) -> None:
    solved: Callable[..., object] = np.linalg.eigh

    def counted(A: np.ndarray) -> object:
        sizes.append(len(A))
        return solved(A)

    monkeypatch.setattr(constrained_solver.np.linalg, "eigh", counted)


def test_a_row_that_is_no_number_is_refused() -> None:
    J = np.array(((1.0, np.nan),))
    with pytest.raises(np.linalg.LinAlgError, match="not numbers"):
        ConstrainedSolver(np.eye(2), Rates(J, np.zeros(1), np.ones((1, 2)), np.zeros(1)))


def flat_loops(angle: float) -> kf.System:
    """Return two rhombi of bars of 1 m with cranks at an angle: folded flat at 0, where they may go on two ways."""
    scene = kf.System()
    for i in range(2):
        at = (4.0 * i, 0.0, 0.0)
        one = scene.add_rigid_body(f"crank {i}", 1.0, 0.1, at=at, joint=kf.Revolute("z", position=angle))
        joint = kf.Revolute("z", position=-angle)
        bar = scene.add_rigid_body(f"bar {i}", 1.0, 0.1, parent=one, at=(1, 0, 0), joint=joint)
        joint = kf.Revolute("z", position=angle)
        other = scene.add_rigid_body(f"rocker {i}", 1.0, 0.1, at=(at[0] + 1.0, 0, 0), joint=joint)
        scene.add_loop_joint(f"pin {i}", kf.Revolute("z"), bar.frame(at=(1, 0, 0)), other.frame(at=(1, 0, 0)))
    return scene


def test_a_singular_position_is_one_in_any_group() -> None:
    report = flat_loops(0.0).freeze().constraint_report()
    assert {text.partition(":")[0] for text in report.singular} == {"pin 0", "pin 1"}
    assert not flat_loops(0.4).freeze().constraint_report().is_singular


@pytest.mark.parametrize("first", [0.0, 0.4])
def test_redundant_rows_are_known_from_the_first_state_and_singular_ones_are_still_found(
    first: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    beside = []
    coordinates = constraint_report._coordinates_beside
    monkeypatch.setattr(
        constraint_report, "_coordinates_beside", lambda *given: beside.append(1) or coordinates(*given)
    )
    model = flat_loops(first).freeze()
    closed = [np.tile((angle, -angle, angle), 2) for angle in (first, 0.7, 0.9, 0.0, 1.1)]
    found = [len(singular_rows(State(model, 0.0, q), model.route)) for q in closed]
    assert found == [2 if q[0] == 0.0 else 0 for q in closed]
    assert len(beside) == 2  # of the first state, and of a singular one
