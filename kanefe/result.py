"""Result: the outputs of a run, with plots and files."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kanefe.arguments import checked
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe.instants.instant import Instant
from kanefe.instants.missed_statics import Missed, is_known, missed_statics
from kanefe.integrate.status import summary
from kanefe.integrate.trajectory import Trajectory
from kanefe.results.channels import Channels, RunChannels
from kanefe.results.table_reader import TableReader

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kanefe.results.accuracy import Accuracy
    from kanefe.results.force_errors import ForceError
    from kanefe.views.player.drawn_modes import StressField
    from kanefe.views.player.page import Page
    from kanefe.views.plots import Figure

LOOKED_AT = 9
"""Number of output times at which ``print(result)`` evaluates what the modes of flexible bodies miss."""


class Result(TableReader):
    """Outputs of a run, by body and interface name. They are computed on request.

    The first axis of arrays is the T output times; they are read-only. The frame of a body is R of a rigid body (at its
    joint) and the mesh frame G of a flexible one; with ``interface=`` it is the moving frame n of that interface.

    Parameters
    ----------
    model : Model
    trajectory : Trajectory

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, -9.81, 0))
    >>> rod = scene.add_rigid_body("rod", mass=1.0, inertia=1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    >>> result = scene.simulate((0.0, 1.0), rtol=1e-8)
    >>> result.joint_coordinates("rod").shape
    (501, 1)
    >>> bool(abs(result.energy.balance_error).max() < 1e-6)
    True
    """

    _accuracy: Accuracy | None = None

    def __init__(self, model: Model, trajectory: Trajectory) -> None:
        super().__init__(RunChannels(model, trajectory))

    @classmethod
    def from_channels(cls, channels: Channels) -> Result:
        """Return a result with other channels, such as those of a file."""
        result = cls.__new__(cls)
        TableReader.__init__(result, channels)
        return result

    def __str__(self) -> str:
        lines = [summary(self.status, self.statistics, self.events)]
        return "\n".join([*lines, *(f"  modes   {missed}" for missed in self._missed)])

    def _repr_html_(self) -> str:
        """Return the card of the run that notebooks show."""
        from kanefe.views.cards.run_card import run_card

        return run_card(self)

    @cached_property
    def _missed(self) -> list[Missed]:
        """The deformation that the modes of flexible bodies miss, at some of the output times."""
        run = self.run
        if run is None or not is_known(run.model):
            return []
        rows = np.unique(np.linspace(0, len(self.times) - 1, LOOKED_AT).round().astype(int))
        return missed_statics([Instant(run.model, self.times[row], run.states[row]) for row in rows])

    @property
    def accuracy(self) -> Accuracy:
        """How wrong it may be, of a run that was asked for an accuracy: `kanefe.Accuracy`; ``print`` shows a table.

        Raises
        ------
        ModelError
            If it was not.
        """
        if self._accuracy is None:
            raise ModelError(
                "this run was not asked for an accuracy. Remedy: simulate(..., accuracy=1e-3, of=['position tip'])"
            )
        return self._accuracy

    def raise_for_status(self) -> None:
        """Raise a SimulationError with the cause if the run failed.

        Raises
        ------
        SimulationError

        Examples
        --------
        ``result = scene.simulate((0.0, 5.0)); result.raise_for_status()``
        """
        self.status.raise_if_failed()

    @checked
    def at(self, t: float) -> Instant:
        """Return the scene at an output time, to view it or to start a run from it.

        Parameters
        ----------
        t : float
            One of `times`, s; between them nothing is stored.

        Raises
        ------
        ModelError
            If there is no such output time, or the result was read from a file, which has no model.

        Examples
        --------
        ``scene.simulate((2.0, 5.0), start=result.at(2.0))``
        """
        run = self.run
        if run is None:
            raise ModelError(
                "a result read from a file has no model, and so no state to continue from. Remedy: pickle the result, "
                "or simulate(checkpoint=..., resume=...)"
            )
        time = numbers(t)
        if time.shape != () or not np.isfinite(time):
            raise ModelError(f"t of result.at must be a finite time in s, not {t!r}")
        row = int(np.abs(self.times - time).argmin())
        if abs(self.times[row] - time) > 1e-9 * max(float(np.ptp(self.times)), abs(float(time))):
            raise ModelError(
                f"t = {t:g} s is not an output time; the nearest is {self.times[row]:.10g} s. Remedy: that one, or "
                "simulate(..., output_times=[...])"
            )
        return Instant(run.model, self.times[row], run.states[row])

    def force_errors(self) -> tuple[ForceError, ...]:
        """Return the estimated error of each force of the run, the largest relative to its channel first.

        Five parts of the run, of sixty steps or in all a tenth of it, are run again from stored states with 0.01
        rtol. The error is the largest difference to these: what stiffness makes of the errors that rtol allows, and not
        how far the motion itself has strayed since the start of the run. Of scenes with flexible bodies it is
        estimated when a force is first read; ``print(result)`` and ``result.statistics["force_error"]`` have the worst,
        or ``"force_error_unknown"`` why there is none, and an `AccuracyWarning` is issued where that of a force that is
        read is above 100 rtol of its largest value.

        Raises
        ------
        ModelError
            If there is no estimate: of a file, controllers, rigid contacts, unreduced bodies, or outputs too far apart.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System(gravity=(0, 0, -9.81))
        >>> rod = scene.add_rigid_body("rod", 1.0, 1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("y"))
        >>> worst = scene.simulate((0.0, 2.0)).force_errors()[0]
        >>> worst.name, worst.share < 1e-4
        ('rod', True)
        """
        from kanefe.results.force_errors import force_errors

        if self.run is None:
            raise ModelError(
                "a result read from a file has no model to run again. Remedy: result.force_errors() before it is saved"
            )
        return force_errors(self.run)

    @checked
    def plot(self, what: str = "overview", *names: str, path: str | Path | None = None) -> Figure:
        """Draw a plot and return matplotlib's figure, also written to `path` (.png, .pdf, .svg) if given.

        Parameters
        ----------
        what : str
            "overview", "energy", "momentum", "contacts", or a quantity such as "position" or "coupling_force".
        *names : str
            Body and, if the quantity has one, interface; or contacts. Without names, all bodies or contacts are
            drawn.
        path : path, optional
            File to write; its folder is created.

        Raises
        ------
        ModelError, FileError, MissingDependency
            If there is no such plot, the file cannot be written, or matplotlib is not installed.

        Examples
        --------
        ``result.plot("coupling_force", "arm", "root", path="root.png")``
        """
        from kanefe.views.plots import draw

        return draw(self, what, names, path)

    @checked("path")
    def to_vtk(
        self, path: str | Path, *, fps: float | None = None, every: int | None = None, scale: float = 1.0
    ) -> Path:
        """Write the moving scene for ParaView: a .pvd file, and a folder of .vtu files beside it.

        Contacts are points with their force (draw them as glyphs) and their status: 0 open, 1 sticks, 2 slips.
        Springs, ropes and other loads along a line are lines, which say whether they are slack. Cells have a number
        "body", "contact" or "load"; the names in this order are field data of each file: "bodies" (as in `bodies`),
        "contacts", "loads"; "TimeValue" is its time. Wedges of 6 and 18 nodes are Lagrange's (73), right in all VTK.

        Parameters
        ----------
        path : path
            Of the .pvd file; its folder is created.
        fps : float, optional
            Frames per second of the run's time (the nearest output times).
        every : int, optional
            Number of output times per frame. Without `fps` and `every`, at most 200 frames.
        scale : float
            Factor on the elastic displacements.

        Returns
        -------
        Path
            Of the .pvd file.

        Raises
        ------
        ModelError, FileError, MissingDependency
            If an option is not valid, the files cannot be written, or pyevtk is not installed.
        """
        from kanefe.views.vtk import write_series

        return write_series(self, path, fps=fps, every=every, scale=scale)

    @checked("path", "colour", "forces")
    def to_html(
        self,
        path: str | Path,
        *,
        colour: str | None = None,
        stress: StressField | Sequence[StressField] = (),
        forces: bool = False,
        fps: float | None = None,
        every: int | None = None,
        scale: float = 1.0,
        title: str | None = None,
    ) -> Path:
        """Write an animation of the scene as one HTML file, which any browser opens, also without a network.

        Flexible bodies move by their modal coordinates, all bodies by their frames, interpolated between output times.
        Rigid bodies are drawn by their surfaces, else as boxes of their mass and inertia; massless ones as axes.

        Parameters
        ----------
        path : path
            Ends in .html; its folder is created.
        colour : str, optional
            Initial colours of flexible bodies: "displacement", "stress" (von Mises; for beams the axial and bending
            stress) or "none". Default: stress if it is given.
        stress : StressField or sequence of them
            Returned by ``kanefe_fem.recover(result, name)``, for the bodies whose stress is shown.
        forces : bool
            Show reactions of joints too, as arrows. They are computed at each output time: with contacts this takes
            seconds. Contact forces are always shown.
        fps : float, optional
            Instants per second of the run's time (the nearest output times).
        every : int, optional
            Number of output times per instant. Without `fps` and `every`, at most 1000.
        scale : float
            Initial factor on the elastic displacements.
        title : str, optional

        Returns
        -------
        Path

        Raises
        ------
        ModelError, FileError
            If an option is not valid, a body's position is not finite, or the file cannot be written.

        Examples
        --------
        ``result.to_html("run.html", stress=kanefe_fem.recover(result, "arm"))``
        """
        from kanefe.views.player.page import checked_path, page_of, write_page

        checked_path(path)
        options = {"colour": colour, "stress": stress, "forces": forces, "fps": fps, "every": every}
        return write_page(page_of(self, **options, scale=scale, title=title), path)  # type: ignore[arg-type]

    @checked("colour", "forces")
    def view(
        self,
        *,
        colour: str | None = None,
        stress: StressField | Sequence[StressField] = (),
        forces: bool = False,
        fps: float | None = None,
        every: int | None = None,
        scale: float = 1.0,
        title: str | None = None,
    ) -> Page:
        """Show an animation of the scene: in the notebook, else in the browser, from a temporary file (path printed).

        Parameters and errors: `to_html`.

        Examples
        --------
        ``result.view()``
        """
        from kanefe.views.player.page import page_of, shown

        options = {"colour": colour, "stress": stress, "forces": forces, "fps": fps, "every": every}
        return shown(page_of(self, **options, scale=scale, title=title))  # type: ignore[arg-type]

    @checked
    def save(self, path: str | Path, *, forces: bool = True) -> None:
        """Write the result to one HDF5 file; if that fails an old file is kept. `kanefe.load_result` reads it.

        Parameters
        ----------
        path : path
            Its folder is created.
        forces : bool
            Save accelerations, joint reactions, driving and coupling forces too, which take most of the time.

        Raises
        ------
        FileError, MissingDependency
            If the file cannot be written, or h5py is not installed.
        """
        from kanefe.results.file import save_result

        save_result(self, path, forces=forces)


@checked
def load_result(path: str | Path) -> Result:
    """Read a result that was written by `Result.save`.

    Raises
    ------
    FileError
        If the file does not exist, is truncated, or of another format or version.
    MissingDependency
        If h5py is not installed.
    """
    from kanefe.results.file import read_channels

    return Result.from_channels(read_channels(path))
