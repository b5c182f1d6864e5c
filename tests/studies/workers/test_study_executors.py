"""Where studies run: the same bits on all executors, dead workers, what cannot be sent, memory of who asks."""

from __future__ import annotations

import gc
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pytest
import tqdm

import kanefe as kf
from kanefe.studies.workers import scheduling
from kanefe.studies.workers.pools import GivenPool, executor_error, pickled
from kanefe.studies.workers.work import Case, Done, Work
from repository import surroundings
from study_scenes import GRID, bits, deadly_study, lowest, pendulum, slow_study


@pytest.fixture(scope="module")
def study() -> kf.Study:
    return kf.Study(pendulum, lowest, duration=0.1, **GRID)


@pytest.fixture(scope="module")
def expected(study: kf.Study) -> str:
    return bits(study.run("serial"))


def test_processes_give_the_same_bits(study: kf.Study, expected: str) -> None:
    table = study.run("processes", workers=2)
    assert bits(table) == expected
    workers = set(table.lists()["worker"])
    assert not any(name.endswith(f":{os.getpid()}") for name in workers)


def test_threads_give_the_same_bits(study: kf.Study, expected: str) -> None:
    with ThreadPoolExecutor(3) as executor:
        assert bits(study.run(executor)) == expected


class Backwards(Executor):
    """Does what it was given last first."""

    def __init__(self) -> None:
        self._waiting: list[tuple[Future[Any], Callable[[], Any]]] = []
        self._max_workers = 4
        self.most = 0

    def submit(self, function: Any, /, *arguments: Any, **more: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self._waiting.append((future, lambda: function(*arguments, **more)))
        self.most = max(self.most, len(self._waiting))
        timer = threading.Timer(0.02, self._one)
        timer.daemon = True
        timer.start()
        return future

    def _one(self) -> None:
        future, call = self._waiting.pop()
        future.set_result(call())


def test_the_order_changes_nothing(study: kf.Study, expected: str) -> None:
    executor = Backwards()
    table = study.run(executor)
    assert bits(table) == expected
    order = [row["case"] for row in table._store.rows()]
    assert order != sorted(order)


def test_a_worker_that_dies_takes_one_case_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("KANEFE_TEST_KILL", "1")
    study = deadly_study()
    table = study.run("processes", workers=2, store=tmp_path)
    assert table.counts == {"finished": 3, "stopped": 0, "failed": 1, "not run": 0}
    assert "two worker processes died" in table.lists()["reason"][2]
    monkeypatch.delenv("KANEFE_TEST_KILL")
    table = study.run("serial", store=tmp_path, retry_failed=True)
    assert bits(table) == bits(study.run("serial"))


class DyingPool:
    """Two workers that both die, with all that they have, when one of them runs a deadly case."""

    workers, pickles, by_value, takes_blocks = 2, False, False, True
    deaths = (BrokenExecutor,)

    def __init__(self, deadly: set[int]) -> None:
        self.deadly, self.waiting, self.together = deadly, [], []

    def submit(self, function: Any, work: Any, stamp: str, cases: list[Case]) -> Future[Any]:
        future: Future[Any] = Future()
        self.waiting.append((future, cases))
        threading.Timer(0.03, self._work).start()
        return future

    def _work(self) -> None:
        waiting, self.waiting = self.waiting, []
        self.together.append([case.number for _, cases in waiting for case in cases])
        dies = bool(self.deadly & set(self.together[-1]))
        for future, cases in waiting:
            if dies:
                future.set_exception(BrokenExecutor())
            else:
                future.set_result(Done("".join(f"{case.number}\n" for case in cases), len(cases), 0, 0.1 * len(cases)))

    def renew(self) -> bool:
        self.waiting = []
        return True

    def abandon(self) -> None: ...


@pytest.mark.parametrize("deadly", [{0}, {3}, {2, 3}, {17}, {5, 12, 19}])
def test_all_but_what_kills_is_run_once(deadly: set[int]) -> None:
    pool = DyingPool(deadly)
    cases = (Case(number, str(number), {}) for number in range(20))
    blocks = list(scheduling.Scheduler(pool, b"", cases, 20).done())
    failed = [json.loads(block.lines)["case"] for block in blocks if block.failed]
    run = [int(line) for block in blocks if not block.failed for line in block.lines.splitlines()]
    assert sorted(failed) == sorted(deadly)
    assert sorted(run) == sorted(set(range(20)) - deadly)
    assert all([number] in pool.together for number in deadly)  # to blame only when alone


def test_workers_end_with_who_asked(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "study_scenes", str(tmp_path), "slow"]
    asking = subprocess.Popen(command, env=surroundings(), stderr=subprocess.PIPE)
    try:
        assert asking.stderr is not None
        worker = int(asking.stderr.readline())  # the case that is in flight says where
    finally:
        asking.send_signal(signal.SIGKILL)
        asking.wait()
    deadline = time.monotonic() + 20.0
    while is_running(worker) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not is_running(worker)
    assert slow_study().table(tmp_path).counts["not run"] == 2


def is_running(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().split()[2] != "Z"
    except OSError:
        return False


def test_a_script_that_would_run_again_in_its_workers_is_told(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    text = "import kanefe as kf\nfrom study_scenes import *\nstudy = kf.Study(pendulum, lowest, duration=0.1, **GRID)\n"
    for last, expected in (
        ("study.run()\n", "worker processes import script.py for its functions, and would run the study again"),
        ("if __name__ == '__main__':\n    print(study.run(workers=1))\n", "12 cases, 12 finished"),
    ):
        script.write_text(text + last)
        done = subprocess.run(
            [sys.executable, script], env=surroundings(), capture_output=True, text=True, check=False, timeout=60
        )
        assert expected in done.stdout + done.stderr


def test_what_cannot_be_sent_is_told_before_the_first_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["__main__"], "__file__", "script.py", raising=False)  # nothing was typed in

    def inner(length: float) -> kf.System:
        return pendulum(length, 0.0)

    for build, outputs, name in ((inner, lowest, "build"), (pendulum, lambda result: {}, "outputs")):
        parameters = {"length": 1.0} if name == "build" else {"length": 1.0, "angle": 0.0}
        study = kf.Study(build, outputs, duration=0.1, **parameters)
        with pytest.raises(kf.ModelError, match=f"{name} cannot be sent to other processes: .*executor='serial'"):
            study.run("processes", store=tmp_path / name)
        assert study.table(tmp_path / name).counts["not run"] == 1
        assert study.run("serial").counts["finished"] == 1


@pytest.mark.dask
def test_functions_of_scripts_are_sent_whole_to_workers_that_do_not_import_them(study: kf.Study) -> None:
    angle = 0.2
    work = Work(lambda length: pendulum(length, angle), lowest, {"t_span": (0.0, 0.1)})
    found = pickle.loads(pickled(work, by_value=True))
    assert lowest(found.result({"length": 1.0}, progress=False)) == lowest(work.result({"length": 1.0}, progress=False))


TYPED_IN = """
import sys
import kanefe as kf
from study_scenes import lowest, pendulum
if {without}:
    sys.modules["cloudpickle"] = None
def build(angle):
    return pendulum(1.0, angle)
print(kf.Study(build, lowest, duration=0.1, angle=[0.0, 0.1]).run(workers=1))
"""


@pytest.mark.parametrize(
    ("without", "expected"),
    [
        pytest.param(False, "2 cases, 2 finished", marks=pytest.mark.dask),
        (
            True,
            "build cannot be sent to other processes: it is from interactive input, not from a file. Remedy: define it",
        ),
    ],
)
def test_functions_that_were_typed_in_are_sent_by_cloudpickle(without: bool, expected: str) -> None:
    command = [sys.executable, "-c", TYPED_IN.format(without=without)]
    done = subprocess.run(command, env=surroundings(), capture_output=True, text=True, check=False, timeout=60)
    assert expected in done.stdout + done.stderr


@pytest.mark.parametrize(
    ("executor", "workers", "message"),
    [
        ("threads", None, "there is no executor 'threads'. Remedy: 'serial', 'processes'"),
        (3, None, "there is no executor 3"),
        ("serial", 0, "workers must be a whole number above zero, not 0"),
    ],
)
def test_an_executor_that_is_none_is_told(study: kf.Study, executor: Any, workers: Any, message: str) -> None:
    with pytest.raises(kf.ModelError, match=message):
        study.run(executor, workers=workers)


def test_what_a_worker_lacks_is_told() -> None:
    assert "a worker has no kanefe. Remedy: pip install" in str(
        executor_error(ModuleNotFoundError("none", name="kanefe.studies"))
    )
    assert "cannot import a module of build or outputs" in str(
        executor_error(ModuleNotFoundError("none", name="my_scene"))
    )
    assert "the executor failed: OSError: gone" in str(executor_error(OSError("gone")))


def test_an_executor_that_was_shut_down_is_told(study: kf.Study) -> None:
    executor = ThreadPoolExecutor(1)
    executor.shutdown()
    with pytest.raises(kf.SimulationError, match="the executor failed: RuntimeError"):
        study.run(executor)


def test_processes_of_the_user_that_die_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("KANEFE_TEST_KILL", "1")
    with (
        ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor,
        pytest.raises(kf.SimulationError, match=r"processes of the executor died .* run the study again to continue"),
    ):
        deadly_study().run(executor, store=tmp_path)
    assert deadly_study().table(tmp_path).counts["finished"] == 2
    monkeypatch.delenv("KANEFE_TEST_KILL")
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        assert deadly_study().run(executor, store=tmp_path).counts["finished"] == 4


class Counted(str):
    """Lines that are counted while somebody holds them."""

    alive = most = 0

    def __init__(self, text: str) -> None:
        Counted.alive += 1
        Counted.most = max(Counted.most, Counted.alive)

    def __del__(self) -> None:
        Counted.alive -= 1


def test_who_asks_holds_no_more_than_what_is_in_flight(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten thousand runs of 20 ms take no more room than a few: only blocks in flight are held."""
    begun = []  # by two threads, so that the last may be noted before those before it

    def quick(work: Any, stamp: str, cases: list[Case]) -> Done:
        begun.append((cases[0].number, len(cases)))
        return Done(Counted("".join(f"{case.number}\n" for case in cases)), len(cases), 0, 0.02 * len(cases))

    monkeypatch.setattr(scheduling, "run_block", quick)
    made = []

    def cases() -> Any:
        for number in range(10_000):
            made.append(number)
            yield Case(number, str(number), {"seed": number})

    count, ahead = 0, 0
    with ThreadPoolExecutor(2) as executor:
        pool = GivenPool(executor, 2)
        for block in scheduling.Scheduler(pool, b"", cases(), 10_000).done():
            count += block.cases
            ahead = max(ahead, len(made) - count)
            del block
    gc.collect()
    in_flight = scheduling.DEPTH * 2
    sizes = [size for _, size in sorted(begun)]
    assert count == 10_000
    assert Counted.most <= in_flight + 1
    assert Counted.alive == 0
    assert ahead <= in_flight * scheduling.MOST_CASES
    assert sizes[0] == 1  # nothing is known of the first
    assert max(sizes) == 50  # a second of work
    assert len(sizes) < 400
    assert sizes[-1] < 10  # all end together


def test_progress_counts_cases_and_failures(
    study: kf.Study, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tqdm.tqdm", partial(tqdm.tqdm, mininterval=0.0))
    study.run("serial", progress=True)
    assert "12/12 cases" in capsys.readouterr().err
    study.run("serial")
    assert capsys.readouterr().err == ""
    kf.Study(deadly, lowest, duration=0.1, seed=range(3)).run("serial", progress=True)
    assert "1 failed" in capsys.readouterr().err


def deadly(seed: int) -> kf.System:
    if seed == 1:
        raise ValueError
    return pendulum(1.0, 0.0, seed)


def test_what_is_piped_into_python_runs_on_processes(tmp_path: Path) -> None:
    script = """
import kanefe as kf
def build(length):
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    scene.add_rigid_body("rod", 1.0, 0.1, com=(length, 0, 0), joint=kf.Revolute("z"))
    return scene
def lowest(result):
    return {"lowest": result.joint_coordinates("rod").min()}
print(kf.Study(build, lowest, duration=0.1, length=[1.0, 2.0]).run("processes", STORE, workers=1))
"""
    text = script.replace("STORE", repr(str(tmp_path / "store")))
    for command in (["-"], ["-c", text]):  # the second finds the rows of the first
        done = subprocess.run(
            [sys.executable, *command], input=text, env=surroundings(), capture_output=True, text=True, check=False
        )
        assert "2 cases, 2 finished" in done.stdout, done.stderr
    assert len(list((tmp_path / "store" / "rows").iterdir())) == 1
