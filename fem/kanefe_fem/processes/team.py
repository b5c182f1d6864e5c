"""Processes that work as one: the first leads and calls tasks, in which all take part; none waits for one that failed.

The tasks are functions of a module, ``task(team, own, *given)``: `own` is what the leader alone brings (None
elsewhere), and `given` is small and the same for all. What a task leaves for later ones is in `Team.kept`, by a number
that is the same on all processes. After each task all compare how it went, so that an error of one ends it on all; an
error inside of a computation in which the others wait for this process cannot be told to them, and then the process
ends them all after `PATIENCE`.
"""

from __future__ import annotations

import os
import socket
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn, Protocol

import numpy as np

from kanefe.errors import KanefeError, ModelError
from kanefe_fem.processes.launcher import refuse_different, versions_here

PATIENCE = 10.0
"""Time in s for which a process with an error waits for the others, before it ends them all."""

NAP = 0.001
"""Time in s between two looks of a process that waits, so that it leaves its core to others."""


class Communicator(Protocol):
    """A communicator of mpi4py, such as ``MPI.COMM_WORLD``."""

    @property
    def rank(self) -> int: ...  # noqa: D102

    @property
    def size(self) -> int: ...  # noqa: D102

    def Dup(self) -> Any: ...  # noqa: D102


class ProcessesError(ModelError):
    """An error on one of several processes; the message names the process and its machine."""


class Team:
    """The processes of a communicator of MPI.

    Parameters
    ----------
    comm : mpi4py communicator
        All its processes make a team at once.

    Attributes
    ----------
    rank, size : int
        Number of this process, 0 for the leader, and how many there are.
    kept : dict of int to object
        What tasks leave for later ones.
    """

    def __init__(self, comm: Communicator) -> None:
        self.comm = comm.Dup()
        self.rank, self.size = int(comm.rank), int(comm.size)
        self.kept: dict[int, Any] = {}
        self._number = 0

    def keep(self, thing: Any) -> int:
        """Keep something for later tasks; return its number, which is the same on all processes."""
        self._number += 1
        self.kept[self._number] = thing
        return self._number

    def run(self, task: Callable[..., Any], *given: Any, own: Any = None) -> Any:
        """Do a task on all processes, and return what it returns here; the leader alone calls this.

        Raises
        ------
        KanefeError
            The error of the first process on which there was one.
        """
        self._meet()
        self.comm.bcast((task, given))
        return self._do(task, given, own)

    def serve(self) -> bool:
        """Take part in tasks until the leader is done; return whether it succeeded. All others call this."""
        while True:
            self._meet()
            order = self.comm.bcast(None)
            if isinstance(order, bool):
                return order
            task, given = order
            try:
                self._do(task, given, None)
            except KanefeError:
                continue  # the leader has it too, and decides what comes next

    def end(self, success: bool) -> None:
        """Let the others go; the leader alone calls this."""
        self._meet()
        self.comm.bcast(success)

    def close(self) -> None:
        """Free what is kept, and the communicator."""
        for thing in self.kept.values():
            getattr(thing, "destroy", bool)()  # PETSc's objects on several processes outlive their last reference
        self.kept.clear()
        self.comm.Free()

    def deal(self, parts: Sequence[np.ndarray] | None) -> np.ndarray:
        """Return the own one of several arrays, one for each process, that the leader has."""
        if parts is None:
            shape, kind = self.comm.recv(source=0)
            found = np.empty(shape, kind)
            self.comm.Recv(found, source=0)
            return found
        for rank in range(1, self.size):
            part = np.ascontiguousarray(parts[rank])
            self.comm.send((part.shape, part.dtype.str), dest=rank)
            self.comm.Send(part, dest=rank)
        return parts[0]

    def collect(self, part: np.ndarray) -> list[np.ndarray]:
        """Return the parts of all processes on the leader, in their order; nothing on the others."""
        part = np.ascontiguousarray(part)
        if self.rank:
            self.comm.send((part.shape, part.dtype.str), dest=0)
            self.comm.Send(part, dest=0)
            return []
        parts = [part]
        for rank in range(1, self.size):
            shape, kind = self.comm.recv(source=rank)
            parts.append(np.empty(shape, kind))
            self.comm.Recv(parts[-1], source=rank)
        return parts

    def _meet(self, trouble: BaseException | None = None) -> None:
        """Wait until all processes are here; with a trouble, no longer than `PATIENCE`."""
        arrived, start = self.comm.Ibarrier(), time.monotonic()
        while not arrived.Test():
            if trouble is not None and time.monotonic() - start > PATIENCE:
                self._abort(trouble)
            time.sleep(NAP)

    def _do(self, task: Callable[..., Any], given: Sequence[Any], own: Any) -> Any:
        trouble: Exception | None = None
        found = None
        try:
            found = task(self, own, *given)
        except Exception as error:  # noqa: BLE001  # of whatever kind: the others must hear of it
            trouble = error
        self._meet(trouble)
        told = None if trouble is None else (socket.gethostname(), _plain(trouble))
        raise_first(self.comm.allgather(told), trouble)
        return found

    def _abort(self, trouble: BaseException) -> NoReturn:
        where = f"process {self.rank + 1} of {self.size} on {socket.gethostname()}"
        print(f"kanefe: {where} failed and ends all: {trouble}", file=sys.stderr, flush=True)
        self.comm.Abort(2)  # the exit code of all errors of the command line
        os._exit(2)


def raise_first(told: Sequence[tuple[str, Exception] | None], own: Exception | None = None) -> None:
    """Raise the first error of what all processes told, None for those without one.

    The error of all is raised as it is, and so is that of the leader; that of another process names it.
    """
    failed = [number for number, one in enumerate(told) if one is not None]
    if not failed:
        return
    host, error = told[failed[0]] or ("", None)
    if isinstance(error, KanefeError) and (failed[0] == 0 or len(failed) == len(told)):
        raise error from own
    where = f"on process {failed[0] + 1} of {len(told)}, on {host}"
    others = f" (and on {len(failed) - 1} more)" if len(failed) > 1 else ""
    raise ProcessesError(f"{where}{others}: {error}") from own


def _plain(error: Exception) -> Exception:
    """Return an error that can be sent to other processes."""
    return error if isinstance(error, ModelError) else ProcessesError(f"{type(error).__name__}: {error}")


def checked_communicator(comm: Any) -> Communicator:
    """Return a communicator; raise a ModelError if it is something else."""
    if not all(hasattr(comm, name) for name in ("rank", "size", "Dup", "Ibarrier")):
        raise ModelError(
            f"comm={comm!r} is not a communicator of mpi4py. Remedy: mpi4py.MPI.COMM_WORLD, or leave it out"
        )
    return comm


def led(comm: Communicator, work: Callable[[Team], Any]) -> Any:
    """Return what the leader's work with its team returns; None on the other processes, which help.

    Raises
    ------
    KanefeError
        On the leader. On the others SystemExit, so that there is one message.
    """
    team = Team(comm)
    if team.rank == 0:
        with leading(team):
            refuse_different(*zip(*team.run(_versions), strict=True))
            return work(team)
    success = team.serve()
    team.close()
    if not success:
        raise SystemExit(0)
    return None


def _versions(team: Team, own: None) -> list[tuple[dict[str, str], str]]:
    """Return versions and host of each process."""
    return list(team.comm.allgather((versions_here(), socket.gethostname())))


@contextmanager
def leading(team: Team) -> Iterator[Team]:
    """Lead a team in a block, and let the others go at its end."""
    try:
        yield team
    except BaseException:
        team.end(success=False)
        raise
    else:
        team.end(success=True)
    finally:
        team.close()
