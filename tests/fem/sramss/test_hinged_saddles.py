"""Statics and small motions with fixed and hinged saddles by a second method: plain frame elements, nothing of kanefe.

The airframe is a rigid part whose three coordinates carry the saddle nodes; what comes out are the references of SR1
and SR2 for hinged saddles, and those for fixed ones, which two other programs agree on.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.linalg import block_diag, eigh, null_space

from kanefe.checks.verification.references import load_references
from kanefe_fem.sramss import parameters as given

SADDLES = given.ELEMENTS, 2 * given.ELEMENTS
GRAVITY = 9.81


def element(length: float) -> tuple[np.ndarray, np.ndarray]:
    """Return stiffness and consistent mass of a bar and beam along its first axis: (x, y, turn) of both its ends."""
    L = length
    k, m = np.zeros((6, 6)), np.zeros((6, 6))
    bar, beam = np.ix_((0, 3), (0, 3)), np.ix_((1, 2, 4, 5), (1, 2, 4, 5))
    k[bar] = given.YOUNG * given.AREA / L * np.array(((1, -1), (-1, 1)))
    k[beam] = given.YOUNG * given.SECOND_MOMENT / L**3 * np.array((
        (12, 6 * L, -12, 6 * L),
        (6 * L, 4 * L**2, -6 * L, 2 * L**2),
        (-12, -6 * L, 12, -6 * L),
        (6 * L, 2 * L**2, -6 * L, 4 * L**2),
    ))  # fmt: skip
    per_length = given.DENSITY * given.AREA
    m[bar] = per_length * L / 6 * np.array(((2, 1), (1, 2)))
    m[beam] = per_length * L / 420 * np.array((
        (156, 22 * L, 54, -13 * L),
        (22 * L, 4 * L**2, 13 * L, -3 * L**2),
        (54, 13 * L, 156, -22 * L),
        (-13 * L, -3 * L**2, -22 * L, 4 * L**2),
    ))  # fmt: skip
    return k, m


def aircraft(is_hinged: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return what the coordinates do at the nodes, stiffness, mass, and the coordinates of a move upward."""
    share = np.arange(given.ELEMENTS) / given.ELEMENTS
    corners = given.CORNERS
    places = [a + x * (b - a) for a, b in pairwise(corners) for x in share]
    places = np.array([*places, corners[-1]])
    K, M = np.zeros((2, 3 * len(places), 3 * len(places)))
    for i, way in enumerate(np.diff(places, axis=0)):
        length = np.hypot(*way)
        (c, s), at = way / length, np.ix_(range(3 * i, 3 * i + 6), range(3 * i, 3 * i + 6))
        turn = block_diag(*[((c, s, 0), (-s, c, 0), (0, 0, 1))] * 2)
        k, m = element(length)
        K[at] += turn.T @ k @ turn
        M[at] += turn.T @ m @ turn
    for row in (0, 1, -3, -2):
        M[row, row] += given.SKID_MASS
    held = [3 * node + part for node in SADDLES for part in range(2 if is_hinged else 3)]
    free = [row for row in range(len(K)) if row not in held]
    moves = np.zeros((len(K), 3 + len(free)))
    for node in SADDLES:
        y, z = places[node]
        moves[3 * node : 3 * node + 3, :3] = (1, 0, -z), (0, 1, y), (0, 0, not is_hinged)
    moves[free, 3 + np.arange(len(free))] = 1.0
    mass = moves.T @ M @ moves
    mass[:3, :3] += np.diag((given.AIRFRAME_MASS, given.AIRFRAME_MASS, given.AIRFRAME_INERTIA))
    up = np.array([0.0, 1.0, 0.0, *(row % 3 == 1 for row in free)])
    return moves, moves.T @ K @ moves, mass, up


def expected(case: str, saddles: str) -> dict[str, Any]:
    values = load_references()[case].values
    return values[saddles] if saddles == "hinged" else values


@pytest.mark.parametrize("saddles", ["fixed", "hinged"])
def test_frequencies(saddles):
    moves, stiffness, mass, _ = aircraft(saddles == "hinged")
    skids, wanted = moves[[0, 1, -3, -2]], expected("SR2", saddles)
    allowed = null_space(skids)
    springs = (given.TANGENTIAL_STIFFNESS, given.NORMAL_STIFFNESS) * 2
    for name, pair in (
        ("held", (allowed.T @ stiffness @ allowed, allowed.T @ mass @ allowed)),
        ("springs", (stiffness + skids.T @ np.diag(springs) @ skids, mass)),
    ):
        found = np.sqrt(eigh(*pair, eigvals_only=True)) / (2.0 * np.pi)
        np.testing.assert_allclose(found[: len(wanted[name])], wanted[name], rtol=0, atol=5e-5)


@pytest.mark.parametrize("saddles", ["fixed", "hinged"])
def test_level_rest(saddles):
    moves, stiffness, mass, up = aircraft(saddles == "hinged")
    deck = given.NORMAL_STIFFNESS * moves[[1, -2]].T @ moves[[1, -2]]
    across = np.outer(np.eye(len(up))[0], np.eye(len(up))[0])  # nothing else keeps it from gliding
    x = np.linalg.solve(stiffness + deck + across, -GRAVITY * mass @ up)
    skids, wanted = moves @ x, expected("SR1", saddles)
    assert 1e3 * (skids[-2] - x[1]) == pytest.approx(wanted["deflection_mm"], abs=1e-5)
    assert 1e3 * (skids[-3] - skids[0]) == pytest.approx(wanted["wider_mm"], abs=1e-5)
