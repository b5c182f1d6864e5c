"""System: the scene that the user builds. `freeze` converts it to the immutable model for the equations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.slopes import SlopeMeasure, slope_measure
from kanefe.equations.given_state import slack_time
from kanefe.equations.model import Model, is_for_many
from kanefe.equations.planar_inertia import check_planar_inertias
from kanefe.equations.start import model_at_start, scene_model
from kanefe.errors import ModelError
from kanefe.fmu.stepping_methods import SteppingMethods
from kanefe.scene.constraints import ConstraintMethods
from kanefe.scene.contacts import ContactMethods
from kanefe.scene.field_loads import FieldLoadMethods
from kanefe.scene.scene import three
from kanefe.scene.segments import SegmentMethods
from kanefe.scene.tree_text import body_rows, tree_text
from kanefe.tree.freeze import build_model
from kanefe.tree.stiffening_check import warn_of_loads_that_do_not_stiffen

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start
    from kanefe.equations.start_report import StartReport
    from kanefe.integrate.options import RunKeywords
    from kanefe.records.record import Record
    from kanefe.result import Result
    from kanefe.scene.targets import Named


@checked("slopes")
class System(SegmentMethods, ContactMethods, FieldLoadMethods, ConstraintMethods, SteppingMethods):
    """A scene of rigid and flexible bodies in a tree.

    Parameters
    ----------
    gravity : array_like, shape (3,)
        In the inertial frame N, m/s2.
    slopes : "rotation-vector" or "tait-bryan"
        Parametrisation of rotations by the slopes of interfaces that carry bodies (Eq. 23).

    Raises
    ------
    ModelError
        If an argument is not valid.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, -9.81, 0))
    >>> rod = scene.add_rigid_body("rod", mass=1.0, inertia=1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    >>> result = scene.simulate((0.0, 1.0), rtol=1e-8)
    >>> result.position("rod").shape
    (501, 3)
    >>> print(scene)
    scene of 1 body, 0 flexible, gravity (0, -9.81, 0) m/s2
    ground
    └─ rod (rigid, 1 kg), revolute z
    """

    def __init__(self, gravity: Sequence[float] = (0.0, 0.0, 0.0), slopes: str = "rotation-vector") -> None:
        super().__init__()
        self._gravity = three(gravity, "gravity")
        self._slopes = slope_measure(slopes)

    def __str__(self) -> str:
        return tree_text(self._entries, self._constraints, self._loads, self._controllers, self.gravity.tolist())

    def _repr_html_(self) -> str:
        """Return the representation in notebooks."""
        from kanefe.views.cards.scene_card import scene_card

        title = str(self).splitlines()[0]
        return scene_card(title, body_rows(self._entries), self._acting())

    def _acting(self) -> list[tuple[str, str]]:
        """Return kind and description of loads, constraints and controllers."""
        of_bodies = [
            ("load", load.label)
            for entry in self._entries
            for load in (*(load for load, _ in entry.loads), *entry.joint_loads, *entry.field_loads)
        ]
        between = [(load.kind, f"{load.name}: {' and '.join(end.label for end in load.ends)}") for load in self._loads]
        constraints = [("constraint", constraint.title) for constraint in self._constraints]
        return [*of_bodies, *between, *constraints, *(("controller", str(one)) for one in self._controllers)]

    @property
    def gravity(self) -> np.ndarray:
        """Gravity in N, shape (3,), m/s2."""
        return self._gravity

    @gravity.setter
    def gravity(self, value: Sequence[float]) -> None:
        self._check_open("gravity")
        self._gravity = three(value, "gravity")

    @property
    def slopes(self) -> SlopeMeasure:
        """Parametrisation of rotations by the slopes of interfaces that carry bodies."""
        return self._slopes

    @checked("t")
    def freeze(self, t: float = 0.0, start: Start = None) -> Model:
        """Return the immutable model of the scene. Afterwards additions are possible only to a `copy` of it.

        Its start is made consistent with loop joints and couplers: see `kanefe.equations.start.scene_model`. Springs
        without a rest length are slack there.

        Parameters
        ----------
        t : float
            Time of the start, s, for motions of driven joints.
        start : state, optional
            State at the start: see `simulate`. Default: the start given in the scene.

        Raises
        ------
        ModelError
            If the scene is empty, a loop cannot be closed (the message names it and its remaining opening), the state
            is not one of this scene, or a body with inertia about one axis can rotate about others.

        Warns
        -----
        StiffeningWarning
            If a body with stiffening="inertial" carries bodies, loads or loops, whose effect on its stiffness is
            neglected.
        StartWarning
            If positions or speeds that were given contradict the loops and were changed, with what they became.
        """
        if start is None and self._kept is not None and self._kept[0] == t and is_for_many(self._kept[1]):
            warn_of_loads_that_do_not_stiffen(self._kept[1])
            return self._kept[1]
        model = model_at_start(self._scene_model(slack_time(start, t)), t, start)
        check_planar_inertias(model, t)
        warn_of_loads_that_do_not_stiffen(model)
        self.is_frozen = True
        if start is None:
            self._kept = t, model  # not reused with functions of the user, which may change
        return model

    def _scene_model(self, t: float) -> Model:
        """Return the model from which all starts are made, with springs that are slack at time t (s)."""
        kept = self._unstarted
        if self.is_frozen and kept is not None and kept.slack_time == t and not kept.has_functions:
            return kept
        data = build_model(
            self._entries,
            self.gravity,
            self.slopes,
            self._constraints,
            self._controllers,
            self._surfaces_on_markers(),
        )
        self._unstarted = scene_model(data, self._loads, t)
        return self._unstarted

    @checked
    def start_report(self, t: float = 0.0) -> StartReport:
        """Return how the scene starts: what was given, what followed, how well loops are held, strain energies.

        The scene is frozen for it: see `freeze`.

        Parameters
        ----------
        t : float
            Time of the start, s.

        Returns
        -------
        StartReport
            ``print(scene.start_report())`` shows a table.

        Raises
        ------
        ModelError
            As `freeze`, such as where a loop cannot be closed.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> driver = scene.add_rigid_body("driver", 1.0, 0.1, joint=kf.Revolute("z", position=0.0, speed=2.0))
        >>> follower = scene.add_rigid_body("follower", 1.0, 0.1, joint=kf.Revolute("z"))
        >>> scene.add_gear("gear", {driver: 2.0, follower: 1.0}, 0.3)
        >>> [(one.origin, one.value) for one in scene.start_report().coordinates]
        [('given', 0.0), ('follows', 0.3)]
        """
        from kanefe.equations.start_report import start_report

        model = self.freeze(t)
        return start_report(model.route, t, model.initial_state)

    @checked(
        *("method", "output_times", "checkpoint", "resume", "most_steps", "progress", "record_file"),
        *("accuracy", "most_memory"),
    )
    def simulate(
        self,
        t_span: tuple[float, float],
        *,
        start: Start = None,
        record: Named | Record | Sequence[str | Record] = (),
        record_file: str | Path | None = None,
        accuracy: float | None = None,
        of: Any = (),
        most_memory: float | None = None,
        stiffer: str | Sequence[str] = (),
        **options: Unpack[RunKeywords],
    ) -> Result:
        """Run the scene; with `accuracy` or `of` as often and as finely as that asks for.

        A run that fails returns its results so far, with a `RunStatus` that names the failure, its time, the body or
        mode, and a remedy, and issues a `SimulationWarning`; ``result.raise_for_status()`` raises it as an error.
        Ctrl-C stops a run in the same way, and so does an error of a function of the user once the run has begun.

        Parameters
        ----------
        t_span : (float, float)
            Start and end in s.
        start : state, optional
            Coordinates and speeds at the start: ``result.at(t)``, an `Equilibrium`, the `SceneState` passed to
            functions of the user, or a vector named by `Model.state_names`. A state of another scene is used body by
            body, by name: driven joints may become free and free ones driven; deformations are transferred to other
            modes or a finer mesh; and bodies that are not in the state start as they were added. Its time is not used:
            loads and drives are those of `t_span`. Default: the start given in the scene.
        record : str, Record, or sequence of these, optional
            Channels to be recorded while the run goes on, at times or events of their own: see `Record`. They are in
            ``result.records``, by name of column. States at times that are only recorded are not kept, so that a long
            run needs the memory of its output times and its records. Records do not change the steps of a run.
        record_file : path, optional
            File for the records, in place of memory. It is written as the run goes on, and `kanefe.load_records`
            reads it at any time, also after the process was killed; when the run ends, it becomes an HDF5 file. If its
            disk is full, the run goes on without.
        accuracy : float, optional
            Largest relative error of what `of` names, from steps, modes, stiffening, meshes and outputs together: the
            scene is run several times, with one of these finer than before, until what they change says that it is met.
            The result is that of the last run; ``print(result.accuracy)`` has the bound, and the error by source.
        of : str, callable, Quantity, or sequence or mapping of these, optional
            What has the accuracy: channels, as in `record`, or functions of the result. `kanefe.Quantity` gives each an
            accuracy of its own.
        most_memory : float, optional
            Memory of the process that an accuracy may take, bytes; its runs may take `most_seconds` together.
        stiffer : str or sequence of str, optional
            Contacts whose friction anchors are part of the error, against rigid ones. Laws of others are data.
        **options
            The other parameters below.

        Other Parameters
        ----------------
        method : str
            "auto", the default, chooses from the scene, and ``result.statistics`` has its choice and reason; or a name.
            ``print(kf.methods())`` lists all methods with their options and purposes. Solvers of other packages are
            among them; "sundials-cvode" needs ``pip install 'kanefe[sundials]'``.
        rtol : float, optional
            Relative error of a step, default 1e-6; see below.
        atol : float, optional
            Absolute error of a step, default 0.1 rtol; down to a tenth of that if "auto" finds undamped vibrations that
            are small relative to the scene; see below.
        step : float, optional
            Fixed step in s, instead of the tolerances. After an event with an action, steps begin at the event; with
            generalised-alpha and HHT, touches of contacts end no step. Their wall time is in ``result.statistics``.
        output_step : float, optional
            Time between stored states in s; default a 500th of the span, or with a fixed step the nearest number of
            whole steps.
        output_times : array_like, optional
            Times of the stored states, ascending, s.
        events : sequence of Event or str
            Events to be located: see `Event`. A text is the name of an event of a load or contact that is located on
            request: ``"hoist slack"``, ``"feet lift of point 2"``, ``"feet * of point *"``.
        checkpoint : path, optional
            File from which the run can be resumed. It is written at the start, periodically, and at the end, also after
            a failure, and is complete at any time, also if the process is killed.
        checkpoint_seconds : float
            Time between checkpoints by the wall clock, default 30. They take a twentieth of the run time at most.
        resume : path, optional
            Checkpoint of the same scene and options to resume from; the result is that of one run. It may be the same
            file as `checkpoint`. Flexible bodies must be the same to the bit, as from a file or the cache.
        most_steps : int, optional
            Number of accepted steps of this call after which the run stops.
        most_seconds : float, optional
            Time by the wall clock, without compilation, after which it stops.
        progress : bool, optional
            Show a progress bar with the time left; default: only on a terminal.

        Returns
        -------
        Result

        Raises
        ------
        ModelError
            If the scene, its start or an option is not valid.
        SimulationError
            If the run cannot begin.
        FileError
            If the checkpoint or the file of records cannot be written at the start, or the checkpoint to resume from
            cannot be read or is of another run.

        Notes
        -----
        A step may have an error of ``atol * scale + rtol * |y|`` in a component y of the state. The scale is a large
        value of the component, so that one number is suitable for all units: a radian for an angle; for a distance the
        size of the scene (its flexible bodies and the offsets of its bodies; else radii of gyration; else distances of
        points from their origin); for a modal coordinate the amplitude that moves the body by its own size; for speeds
        the same per second; for energies the kinetic energy of such speeds. A modal speed is measured by its amplitude,
        speed / frequency. The same scene in millimetres or kilometres takes the same steps. Generalised-alpha has no
        atol: a step may have an error of ``rtol * scale``.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System(gravity=(0, -9.81, 0))
        >>> rod = scene.add_rigid_body("rod", mass=1.0, inertia=1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("z"))
        >>> lowest = kf.Event("lowest", lambda t, state: state.joint_coordinates("rod")[0] + 1.5707963, direction=-1)
        >>> result = scene.simulate((0.0, 1.0), rtol=1e-8, events=lowest)
        >>> print(result.status)
        the run finished at t = 1 s
        >>> result.events["lowest"].round(6)
        array([0.483334])
        """
        if accuracy is not None or isinstance(of, str) or callable(of) or of != ():
            from kanefe.certified.run import certified_run

            more = {"most_memory": most_memory, "stiffer": stiffer, "record": record, "record_file": record_file}
            return certified_run(self, t_span, accuracy, of, {**options, **more, "start": start})
        if most_memory is not None or stiffer:
            raise ModelError("most_memory and stiffer are of runs with an accuracy. Remedy: accuracy=1e-3, of=[...]")
        from kanefe.integrate.options import RunOptions
        from kanefe.integrate.run import run
        from kanefe.integrate.run_checks.energy_check import account
        from kanefe.result import Result

        asked = RunOptions(t_span=t_span, **options)
        model = self.freeze(asked.span[0], start)
        recorder = None
        if not (isinstance(record, tuple) and not record) or record_file is not None:
            from kanefe.records.recorder import recorder_of

            recorder = recorder_of(model, asked, record, record_file)
        done = run(model, asked, _poles_in_words, recorder)
        account(model, done)
        return Result(model, done)


def _poles_in_words(model: Model, t: float, y: np.ndarray) -> str | None:
    """Return `kanefe.linear.sampled.sampled_loop.poles_in_words`, imported only for runs that fail."""
    from kanefe.linear.sampled.sampled_loop import poles_in_words

    return poles_in_words(model, t, y)
