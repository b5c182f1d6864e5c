"""Studies on a Dask cluster: two workers of this machine, of which one is killed in the middle."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest

import kanefe as kf
from repository import surroundings
from study_scenes import bits, deadly_in_workers, lowest, pendulum

pytestmark = pytest.mark.dask


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    import dask
    import distributed

    environment = os.environ.copy()
    os.environ |= surroundings()  # for workers that are started anew, too
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),  # a death is told at once
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client
    os.environ.clear()
    os.environ.update(environment)


def test_a_worker_that_is_killed_changes_no_bit(client: Any, tmp_path: Path) -> None:
    study = kf.Study(pendulum, lowest, duration=1.0, length=(0.5, 1.0), angle=0.1, seed=range(60))
    workers = client.run(os.getpid)
    victim = min(workers.values())

    def kill() -> None:
        rows = tmp_path / "rows"
        while not any(path.stat().st_size for path in rows.glob("*.jsonl")):
            time.sleep(0.001)
        os.kill(victim, signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    table = study.run(client, store=tmp_path)
    killer.join()
    assert table.counts == {"finished": 120, "stopped": 0, "failed": 0, "not run": 0}
    client.wait_for_workers(2, timeout=30)
    after = client.run(os.getpid).values()
    assert victim not in after  # another took its place
    assert bits(table) == bits(study.run("serial"))


def test_a_case_that_kills_its_workers_is_told(client: Any) -> None:
    study = kf.Study(deadly_in_workers, lowest, duration=0.1, seed=range(3), asking=os.getpid())
    table = study.run(client)
    assert table.counts == {"finished": 2, "stopped": 0, "failed": 1, "not run": 0}
    assert "two worker processes died" in table.lists()["reason"][1]


def test_a_worker_without_kanefe_is_told(client: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    run = client.run
    missing = metadata.PackageNotFoundError("kanefe")

    def without(function: Any, *arguments: Any, **options: Any) -> Any:
        found = run(function, *arguments, **options)
        return found | dict.fromkeys(list(found)[:1], missing) if function is metadata.version else found

    monkeypatch.setattr(client, "run", without)
    study = kf.Study(pendulum, lowest, duration=0.1, length=1.0, angle=0.0)
    with pytest.raises(kf.SimulationError, match=r"the Dask worker tcp.* has no kanefe \(1 of [12] workers\)"):
        study.run(client)
