"""A reduction that was ended in the middle goes on where it was, and gives the same modes."""

from __future__ import annotations

import os
import time

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
import scenes
from kanefe.fe_model.factorise import splu_factorise
from kanefe.fe_model.progress import stages
from kanefe.reduction.block_lanczos import lowest_modes
from kanefe.storage import unfinished

SIZE, MODES = 500, 12
STIFFNESS = np.arange(1.0, SIZE + 1.0) ** 2


class Counted:
    """Solutions of a diagonal matrix, counted; one of them ends the run."""

    def __init__(self, end=10**9):
        self.count, self._end = 0, end

    def solve(self, b):
        self.count += 1
        if self.count > self._end:
            raise KeyboardInterrupt
        return (b.T / STIFFNESS).T


def modes(solutions):
    return lowest_modes(sp.identity(SIZE, format="csr"), MODES, solutions.solve)


@pytest.fixture
def often(monkeypatch):
    monkeypatch.setattr(unfinished, "SECONDS", 0.0)


def ended(folder, solutions):
    with pytest.raises(KeyboardInterrupt), unfinished.resumable(folder):
        modes(solutions)


def test_modes_go_on_where_they_were(tmp_path, often):
    whole = Counted()
    expected = modes(whole)
    ended(tmp_path / "body", Counted(end=whole.count - 2))
    rest = Counted()
    with stages(1) as shown, unfinished.resumable(tmp_path / "body"):
        found = modes(rest)
    assert rest.count == 2  # those that the first run did not come to
    assert any("directions of a run that was ended" in text for text in shown.told)
    assert not list(tmp_path.iterdir())
    # round-off of directions that are multiplied by M again
    np.testing.assert_allclose(found[0], STIFFNESS[:MODES], rtol=1e-12)
    np.testing.assert_allclose(np.abs(found[1]), np.abs(expected[1]), atol=1e-10)


def test_a_part_that_is_damaged_is_computed_again(tmp_path, often):
    ended(tmp_path / "body", Counted(end=3))
    (file,) = (tmp_path / "body").iterdir()
    file.write_bytes(file.read_bytes()[:200])
    again, whole = Counted(), Counted()
    modes(whole)
    with unfinished.resumable(tmp_path / "body"):
        np.testing.assert_allclose(modes(again)[0], STIFFNESS[:MODES], rtol=1e-12)
    assert again.count == whole.count


def test_constraint_modes_are_kept(tmp_path, often):
    model, ends = scenes.lattice_model(1, interior=12), {"root": "clamped", "tip": "rigid"}
    counts = []

    class Factors:
        def __init__(self, matrix):
            self._factors = splu_factorise(matrix)

        def solve(self, b):
            counts[-1] += 1
            if counts[-1] > limit:
                raise KeyboardInterrupt
            return self._factors.solve(b)

    def made():
        counts.append(0)
        with unfinished.resumable(tmp_path / "body"):
            return kf.flexible_body(
                model, ends, reduction=kf.CraigBampton(modes=3), factorise=lambda matrix, definite=True: Factors(matrix)
            )

    limit = 2  # the test of the factors, and the constraint modes
    with pytest.raises(KeyboardInterrupt):
        made()
    limit = 10**9
    again, whole = made(), made()
    assert counts[1] == counts[2] - 1
    np.testing.assert_allclose(again.stiffness, whole.stiffness, rtol=1e-12, atol=1e-12 * np.abs(whole.stiffness).max())


def test_short_work_writes_nothing(tmp_path):
    ended(tmp_path / "body", Counted(end=3))
    assert not list(tmp_path.iterdir())


def test_what_nobody_took_up_is_removed(tmp_path, often):
    for name, age in (("old", 8), ("new", 6)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "part.npz").touch()
        os.utime(tmp_path / name, (time.time() - age * 86400.0,) * 2)
    with unfinished.resumable(tmp_path / "own"):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["new"]
