"""Processes that work as one: tasks, arrays of each process, and errors, with threads for processes."""

from __future__ import annotations

import numpy as np
import pytest

from kanefe.errors import ModelError
from kanefe_fem.processes import team as teams
from kanefe_fem.processes.launcher import check_launcher, refuse_different, versions_here
from kanefe_fem.processes.team import Team, checked_communicator, led, raise_first
from threads_as_processes import on_threads


def sent_back(team: Team, own: list[np.ndarray] | None, factor: float) -> list[np.ndarray]:
    """Each process gets its rows, and returns them times a factor and its number."""
    return team.collect(factor * (team.rank + 1) * team.deal(own))


def test_each_process_has_its_part() -> None:
    parts = [np.full((rank + 1, 2), 1.0) for rank in range(3)]
    found, _ = on_threads(3, lambda comm: led(comm, lambda team: team.run(sent_back, 2.0, own=parts)))
    assert found[1:] == [None, None]
    for rank, part in enumerate(found[0]):
        assert np.array_equal(part, np.full((rank + 1, 2), 2.0 * (rank + 1)))


def keep(team: Team, own: None, what: str) -> int:
    return team.keep(f"{what} of {team.rank}")


def kept(team: Team, own: None, number: int) -> list[str]:
    return team.comm.allgather(team.kept[number])


def test_what_is_kept_has_one_number() -> None:
    def work(team: Team) -> list[str]:
        team.run(keep, "first")
        return team.run(kept, team.run(keep, "second"))

    found, _ = on_threads(2, lambda comm: led(comm, work))
    assert found[0] == ["second of 0", "second of 1"]


def fails(team: Team, own: None, ranks: tuple[int, ...], error: Exception) -> None:
    if team.rank in ranks:
        raise error


@pytest.mark.parametrize(
    ("ranks", "said"),
    [((0,), "no"), ((0, 1, 2), "no"), ((1,), "on process 2 of 3, on "), ((1, 2), "(and on 1 more): no")],
)
def test_an_error_of_one_is_that_of_all(ranks: tuple[int, ...], said: str) -> None:
    def work(team: Team) -> None:
        team.run(fails, ranks, ModelError("no"))

    found, aborted = on_threads(3, lambda comm: led(comm, work))
    assert isinstance(found[0], ModelError)
    assert said in str(found[0])
    assert [type(one) for one in found[1:]] == [SystemExit, SystemExit]
    assert not aborted


def test_an_error_outside_of_kanefe_is_named() -> None:
    found, _ = on_threads(2, lambda comm: led(comm, lambda team: team.run(fails, (1,), MemoryError("full"))))
    assert "on process 2 of 2" in str(found[0])
    assert "MemoryError: full" in str(found[0])


def test_the_team_goes_on_after_an_error_that_the_leader_handles() -> None:
    def work(team: Team) -> list[str]:
        with pytest.raises(ModelError):
            team.run(fails, (1,), ModelError("no"))
        return team.run(kept, team.run(keep, "later"))

    found, _ = on_threads(2, lambda comm: led(comm, work))
    assert found == [["later of 0", "later of 1"], None]


def waits(team: Team, own: None) -> None:
    """The first process waits for the second one, which fails before it sends."""
    if team.rank == 1:
        raise ModelError("lost")
    team.comm.recv(source=1)


def test_an_error_while_others_wait_ends_them(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    monkeypatch.setattr(teams, "PATIENCE", 0.05)
    monkeypatch.setattr("threads_as_processes.LONGEST", 1.0)
    _, aborted = on_threads(2, lambda comm: led(comm, lambda team: team.run(waits)))
    assert 2 in aborted
    assert "process 2 of 2" in capsys.readouterr().err


def test_an_error_of_the_leader_alone_lets_the_others_go() -> None:
    def work(team: Team) -> None:
        raise ModelError("no such group")

    found, _ = on_threads(2, lambda comm: led(comm, work))
    assert isinstance(found[0], ModelError)
    assert isinstance(found[1], SystemExit)


def test_no_error_is_none() -> None:
    raise_first([None, None])


def test_other_versions_are_named() -> None:
    here = versions_here()
    refuse_different([here, dict(here)], ["a", "b"])
    with pytest.raises(ModelError, match=r"process 2 of 2, on b, has numpy 0\.1"):
        refuse_different([here, {**here, "numpy": "0.1"}], ["a", "b"])
    with pytest.raises(ModelError, match=r"numpy not at all.* and 1 more"):
        refuse_different([here, {k: v for k, v in here.items() if k not in ("scipy", "numpy")}], ["a", "b"])


def test_mpirun_of_another_mpi_is_seen() -> None:
    check_launcher(1, {})
    check_launcher(2, {"PMI_SIZE": "2"})
    check_launcher(1, {"OMPI_COMM_WORLD_SIZE": "1"})
    for variable in ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE"):
        with pytest.raises(ModelError, match="has started 4 processes"):
            check_launcher(1, {variable: "4"})


def test_what_is_no_communicator_is_refused() -> None:
    with pytest.raises(ModelError, match="comm=4 is not a communicator"):
        checked_communicator(4)
