"""The door to Dask: blocks of cases on the workers of a `dask.distributed.Client`, here or on a cluster.

On a cluster with Slurm, workers are jobs::

    from dask.distributed import Client
    from dask_jobqueue import SLURMCluster

    cluster = SLURMCluster(cores=1, processes=1, memory="4GB", walltime="04:00:00")
    cluster.scale(jobs=64)
    table = study.run(executor=Client(cluster), store="study/")

Each job needs the same version of kanefe. Kernels come with the wheel, or each user prepares them on the machines of
the workers (``kanefe prepare``): a folder that others may write is refused, since its files are executed. A study sends
pickles to its workers, which can contain code: connect to schedulers that you trust. If jobs end or are killed, no case
is lost: Dask gives their blocks to other workers. Rows are returned to the calling process, which alone writes the
store.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import metadata
from typing import Any

from kanefe.errors import MissingDependency, SimulationError

try:
    from distributed.scheduler import KilledWorker
except ImportError as _error:
    raise MissingDependency("dask[distributed]", "Study.run", "pip install 'kanefe[study]'") from _error

SECONDS_FOR_WORKERS = 120.0
"""Time that a cluster may take to start its first worker, as in the queue of Slurm, s."""


class DaskPool:
    """The workers of a client, which the user closes.

    Parameters
    ----------
    client : distributed.Client

    Raises
    ------
    SimulationError
        If there are no workers, or one has no kanefe.
    """

    pickles, by_value, takes_blocks = True, True, True
    deaths: tuple[type[BaseException], ...] = (KilledWorker,)

    def __init__(self, client: Any) -> None:
        self._client = client
        self._futures: set[Any] = set()
        try:
            client.wait_for_workers(1, timeout=SECONDS_FOR_WORKERS)
        except TimeoutError as error:
            raise SimulationError(
                f"the Dask cluster has no worker after {SECONDS_FOR_WORKERS:g} s. Remedy: cluster.scale(...)"
            ) from error
        found = client.run(metadata.version, "kanefe", on_error="return")
        without = [name for name, version in found.items() if isinstance(version, BaseException)]
        if without:
            raise SimulationError(
                f"the Dask worker {without[0]} has no kanefe ({len(without)} of {len(found)} workers). Remedy: pip "
                "install it there, in the same version"
            )

    @property
    def workers(self) -> int:
        """Present number of blocks that run at once, which may change."""
        return max(sum(self._client.ncores().values()), 1)

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Return Dask's future; calls with equal arguments are not merged."""
        future = self._client.submit(function, *arguments, pure=False)
        self._futures.add(future)
        future.add_done_callback(self._futures.discard)
        return future

    def renew(self) -> bool:
        """Return False: other workers continue."""
        return False

    def abandon(self) -> None:
        """Cancel the running blocks."""
        self._client.cancel(list(self._futures))
