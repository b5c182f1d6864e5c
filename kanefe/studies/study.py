"""Study: the runs of one scene over parameters."""

from __future__ import annotations

import platform
import tempfile
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kanefe.arguments import checked
from kanefe.errors import ModelError, SimulationWarning, outside
from kanefe.integrate.options import RunOptions
from kanefe.storage.digest import Unhashable, digest_of_functions, installed_versions
from kanefe.studies.cases import Cases, cases_of, key_of
from kanefe.studies.given import check_seconds, check_signature, described, options, shown
from kanefe.studies.outputs import outputs_of
from kanefe.studies.store import Store
from kanefe.studies.table import StudyTable
from kanefe.studies.workers.pools import pickled, pool_of
from kanefe.studies.workers.progress import progress_bar
from kanefe.studies.workers.scheduling import Scheduler
from kanefe.studies.workers.time_limit import TimeIsUp, within
from kanefe.studies.workers.work import OF_SCREENED, SCREENED, Case, Work, exit_in_words, stamp

if TYPE_CHECKING:
    from kanefe.result import Result


@checked("duration", "rtol", "simulate")
class Study:
    """One scene many times, over parameters, with a table as result.

    Parameters
    ----------
    build : function
        ``build(**parameters)`` returns a `System`, or (System, options of ``simulate``). It is identified by its code
        and the outer values that it uses, but not by files that it reads.
    outputs : function, reducer, or sequence of them
        ``outputs(result)`` returns a dict of numbers by name, also texts and arrays of numbers; nothing else of a run
        is stored. Reducers: ``kf.studies.peak`` and others.
    table : sequence of mapping, or DataFrame, optional
        Parameters that change together, one row per case.
    duration : float, optional
        Duration of each run from t = 0, s; or ``simulate={"t_span": ...}``.
    rtol : float, optional
        Relative error of the runs: see `System.simulate`.
    simulate : mapping, optional
        Other options of `System.simulate`; ``{"screened": True}``: runs by `kanefe.screen`, with its options.
    **parameters
        One or several values of each parameter. All combinations are run, the last name varies fastest; with a table,
        all combinations with each row. Values are numbers, texts, booleans, or tuples of them.

    Raises
    ------
    ModelError
        If a parameter has no value, a value twice, or one that cannot be written to a table; if build does not take the
        parameters or needs others; if an option is not valid.

    Examples
    --------
    >>> import kanefe as kf
    >>> def pendulum(length, angle):
    ...     scene = kf.System(gravity=(0, -9.81, 0))
    ...     rod = kf.Revolute("z", position=angle)
    ...     scene.add_rigid_body("rod", 1.0, length**2 / 12, com=(length / 2, 0, 0), joint=rod)
    ...     return scene
    >>> def lowest(result):
    ...     return {"lowest angle": result.joint_coordinates("rod").min()}
    >>> study = kf.Study(pendulum, lowest, duration=0.2, length=[0.5, 1.0], angle=[0.0, 0.1])
    >>> table = study.run(executor="serial")
    >>> print(table)
    4 cases, 4 finished; parameters: length, angle; outputs: lowest angle
    >>> table.column("lowest angle").round(4)
    array([-0.5819, -0.4847, -0.2935, -0.1934])

    With processes, the default, a script runs a study under ``if __name__ == "__main__":``.
    """

    def __init__(
        self,
        build: Callable[..., Any],
        outputs: Any,
        *,
        table: Any = None,
        duration: float | None = None,
        rtol: float | None = None,
        simulate: Mapping[str, Any] | None = None,
        **parameters: Any,
    ) -> None:
        if not callable(build):
            raise ModelError(f"build must be a function that returns a System, not {type(build).__name__}")
        self.cases: Cases = cases_of(table, parameters)
        check_signature(build, self.cases[0])
        self._work = Work(build, outputs_of(outputs), options(duration, rtol, simulate))
        self._sampling: dict[str, Any] = {}
        try:
            self._identity = digest_of_functions(
                build=build, outputs=self._work.outputs, options=self._work.options, kanefe=stamp()
            )
        except Unhashable as error:
            raise ModelError(
                f"the study cannot be distinguished from other studies: {error}. Remedy: make it inside "
                "build or outputs, from the parameters"
            ) from error

    @classmethod
    @checked("sampling_seed", "duration", "rtol", "simulate")
    def sampled(
        cls,
        build: Callable[..., Any],
        outputs: Any,
        samples: int,
        *,
        sampling: str = "latin hypercube",
        sampling_seed: int = 0,
        duration: float | None = None,
        rtol: float | None = None,
        simulate: Mapping[str, Any] | None = None,
        **parameters: Any,
    ) -> Study:
        """Return a study over distributions, sampled by ``scipy.stats.qmc``.

        Parameters
        ----------
        build, outputs, duration, rtol, simulate
            As for a study.
        samples : int
            Number of samples.
        sampling : "latin hypercube", "sobol", "halton" or "random"
            How the samples fill the space.
        sampling_seed : int
            Seed of the samples.
        **parameters
            At least one distribution of scipy.stats, such as ``norm(10, 0.5)``; other parameters have values as for a
            study, which are all combined with each sample.

        Raises
        ------
        ModelError
            If there is no distribution, or an argument is not valid.

        Examples
        --------
        ``kf.Study.sampled(build, peaks, 200, mass=norm(10, 0.5), seed=range(3), duration=5.0)``
        """
        from kanefe.studies.sampling import sampled_rows

        distributions = {name: value for name, value in parameters.items() if hasattr(value, "ppf")}
        grid = {name: value for name, value in parameters.items() if name not in distributions}
        if parameters and not distributions:
            raise ModelError(
                f"none of the parameters {', '.join(map(repr, parameters))} is a distribution to sample. Remedy: one "
                "of scipy.stats, such as norm(10.0, 0.5)"
            )
        rows, record = sampled_rows(distributions, samples, sampling, sampling_seed)
        study = cls(build, outputs, table=rows, duration=duration, rtol=rtol, simulate=simulate, **grid)
        study._sampling = record
        return study

    def __len__(self) -> int:
        """Return the number of cases."""
        return len(self.cases)

    @checked("store", "workers", "retry_failed", "progress")
    def run(
        self,
        executor: Any = "processes",
        store: str | Path | None = None,
        *,
        workers: int | None = None,
        most_seconds: float | None = None,
        retry_failed: bool = False,
        progress: bool | None = None,
    ) -> StudyTable:
        """Run the cases that are not in the store yet, and return the table of all cases.

        The first scene of a study is built in this process as a check, as is the pickling for other processes. A failed
        case is recorded in its row and does not stop the others. However the study ends, finished cases stay in the
        store, and another call continues from there. The results do not depend on executor, number of workers and
        order, to the bit.

        Parameters
        ----------
        executor : str, Executor or Client
            "processes" (of this machine, one per core), "serial", an executor of `concurrent.futures`, or a
            ``dask.distributed.Client`` (``pip install 'kanefe[study]'``; with Slurm: see
            ``kanefe/studies/workers/_dask.py``).
        store : path, optional
            Folder of the study. Default: a temporary one that is removed with the table.
        workers : int, optional
            Number of cases that run at once, if the executor does not define it.
        most_seconds : float, optional
            Time limit of a case, from the call of build to its outputs, s; a case that exceeds it fails.
            ``simulate={"most_seconds": ...}`` stops runs earlier, with their results so far. In threads (of
            `concurrent.futures` and of Dask's workers) such a case is abandoned, but occupies its processor until the
            process ends; compiled code can be stopped with "processes" only. Default: no limit.
        retry_failed : bool
            Run failed cases again.
        progress : bool, optional
            Show a bar with the time left and the failures; default: only on a terminal.

        Returns
        -------
        StudyTable

        Raises
        ------
        ModelError
            If build raises or takes longer than `most_seconds`, or it or outputs cannot be sent to other processes.
        FileError
            If the store contains another study, or cannot be written.
        SimulationError
            If a worker has no kanefe or another version, or the executor fails.

        Warns
        -----
        SimulationWarning
            If Ctrl-C ends the study before all cases are run.

        Examples
        --------
        ``table = study.run(executor=Client(cluster), store="study/")``
        """
        check_seconds(most_seconds)
        folder = None if store is not None else tempfile.TemporaryDirectory(prefix="kanefe_study_")
        where = Store(folder.name if folder is not None else store or "")
        where.begin(self._header())
        table = StudyTable(where.folder, study=self, owns=folder)
        done = {key for key, status in table.statuses() if not (retry_failed and status == "failed")}
        left = [number for number in range(len(self)) if self.key(number) not in done]
        if left:
            if not done:
                self._try_first(left[0], most_seconds)
            self._run(where, left, executor, workers, most_seconds, progress)
        return table

    @checked("store")
    def table(self, store: str | Path) -> StudyTable:
        """Return the table of a store of this study, which may still be running.

        Raises
        ------
        FileError
            If the store does not exist, or contains another study.
        """
        where = Store(store)
        where.check_same(self._header())
        return StudyTable(where.folder, study=self)

    @checked
    def key(self, number: int) -> str:
        """Return the key of a case, which is the same in all studies that run it in the same way."""
        if not 0 <= number < len(self):
            raise ModelError(f"number of a case must be 0 to {len(self) - 1}, not {number}")
        return key_of(self._identity, self.cases[number])

    @checked("parameters")
    def result(self, parameters: Mapping[str, Any]) -> Result:
        """Run the case of some parameters in this process, and return its full result.

        Examples
        --------
        ``study.result({"length": 1.0, "angle": 0.1}).plot()``
        """
        check_signature(self._work.build, parameters)
        return self._work.result(parameters, progress=None)

    def _run(
        self,
        store: Store,
        left: Sequence[int],
        executor: Any,
        workers: int | None,
        most_seconds: float | None,
        progress: bool | None,
    ) -> None:
        with pool_of(executor, workers, len(left)) as pool:
            task = replace(self._work, most_seconds=most_seconds)
            work = pickled(task, pool.by_value) if pool.pickles else task
            cases = (Case(number, self.key(number), self.cases[number]) for number in left)
            scheduler = Scheduler(pool, work, cases, len(left))
            failures = 0
            with progress_bar(progress, len(self), len(self) - len(left)) as bar, store.writer() as writer:
                try:
                    for block in scheduler.done():
                        writer.add(block.lines)
                        failures += block.failed
                        bar.update(block.cases, failures)
                except KeyboardInterrupt:
                    pool.abandon()
                    warnings.warn(
                        "the study was stopped by Ctrl-C; finished cases are in its table. Remedy: run it again with "
                        "store=, to continue",
                        SimulationWarning,
                        stacklevel=outside(),
                    )
                except BaseException:
                    pool.abandon()
                    raise

    def _try_first(self, number: int, most_seconds: float | None) -> None:
        """Build a scene here and check its options: errors common to all cases are raised before the first run."""
        parameters = self.cases[number]
        call = f"build({', '.join(f'{name}={value!r}' for name, value in parameters.items())})"
        try:
            _, options = within(most_seconds, lambda: self._work.built(parameters))
        except ModelError as error:
            raise ModelError(f"{call}: {error}") from error
        except TimeIsUp:
            raise ModelError(
                f"{call} took longer than most_seconds={most_seconds:g}. Nothing was run. Remedy: more seconds, "
                "or a build that ends"
            ) from None
        except SystemExit as error:
            raise ModelError(
                f"{call} {exit_in_words(error)}. Nothing was run. Remedy: a build that returns a scene for the "
                "first case"
            ) from error
        except Exception as error:
            raise ModelError(
                f"{call} raised {type(error).__name__}: {error}. Nothing was run. Remedy: a build "
                "that returns a scene for the first case"
            ) from error
        own = OF_SCREENED if options.get(SCREENED) else ()
        for name in ("start", SCREENED, *own):
            options.pop(name, None)
        try:
            RunOptions(**options)
        except TypeError as error:
            raise ModelError(f"an option of the runs is not one of simulate: {error}") from error

    def _header(self) -> dict[str, Any]:
        return {
            "identity": self._identity,
            "kanefe": stamp(),
            "python": platform.python_version(),
            "packages": installed_versions("numpy", "scipy", "numba", "dask", "distributed"),
            "machine": platform.platform(),
            "count": len(self),
            "cases": self.cases.record(),
            "sampling": self._sampling,
            "options": {name: shown(value) for name, value in self._work.options.items()},
            "build": described(self._work.build),
            "outputs": described(self._work.outputs),
        }
