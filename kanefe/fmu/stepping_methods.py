"""The part of `System` that is stepped from outside: simulations, and functional mock-up units."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Unpack, cast

from kanefe.arguments import checked
from kanefe.scene.held_inputs import HeldInputMethods

if TYPE_CHECKING:
    from kanefe.equations.given_state import Start
    from kanefe.integrate.events.event import Event
    from kanefe.integrate.options import StepKeywords
    from kanefe.scene.targets import Named
    from kanefe.stepping.simulation import Simulation
    from kanefe.stepping.steppable import Steppable


class SteppingMethods(HeldInputMethods):
    """The methods of `System` for steps from outside."""

    @checked("method")
    def start(
        self,
        t: float = 0.0,
        *,
        start: Start = None,
        inputs: Named | None = None,
        outputs: Named | None = None,
        every: float = 0.01,
        duration: float | None = None,
        events: Sequence[Event | str] | Event | str = (),
        **steps: Unpack[StepKeywords],
    ) -> Simulation:
        """Return a simulation of the scene that is stepped: ``sim.step(0.01, {"motor hub": 3.0})``.

        For controllers and optimisers that call the scene, and for co-simulation. The scene itself is not frozen. Steps
        are those of `simulate` with inputs that are constant from step to step; when inputs change, a method restarts
        with its last step size.

        Parameters
        ----------
        t : float
            Start of the simulation, s.
        start : state, optional
            As for `simulate`, also ``sim.state`` of another simulation.
        inputs : str, sequence or mapping of str
            Possible inputs of each step: ``"motor hub"`` (N m along an angle, N along a distance), ``"force tip x"``,
            ``"torque arm/tip z'"``, which act in addition to other loads and are zero at first; ``"load NAME"``, the
            value of a load of the scene by its name in `linearise`; ``"drive hub"``, the acceleration of a joint that a
            `Motion` drives, which continues from its position and speed. A mapping gives other names.
        outputs : str, sequence or mapping of str
            As the readings of controllers (see `add_controller`), and ``"coupling_force arm/root force_x"``,
            ``"joint_reaction tip"``, ``"driving_force hub"``, ``"loop_force pin"``, ``"load rope tension"``. Default:
            free coordinates and speeds of joints, and position and rotation of bodies on free joints.
        every : float
            Approximate length of a step, s, used by method="auto".
        duration : float, optional
            Approximate duration of the simulation, s, used by method="auto" and for the accuracy of event times.
            Default a hundred steps, but at least 1 s. The simulation may be longer.
        events
            As for `simulate`.
        **steps
            method, rtol, atol and step, as for `simulate`. Solvers of other packages, which depend on earlier steps,
            are refused.

        Raises
        ------
        ModelError
            If the scene, its start or an option is not valid, or there is no such input or output.

        Examples
        --------
        >>> import kanefe as kf
        >>> scene = kf.System()
        >>> cart = scene.add_rigid_body("cart", 2.0, joint=kf.Prismatic("x"))
        >>> sim = scene.start(inputs="motor cart", outputs=("joint_coordinates cart", "joint_speeds cart"))
        >>> sim.step(0.5, {"motor cart": 8.0})
        >>> {name: round(value, 9) for name, value in sim.outputs.items()}
        {'joint_coordinates cart': 0.5, 'joint_speeds cart': 2.0}
        """
        from kanefe.integrate.options import RunOptions
        from kanefe.stepping.asked import Asked, stretch
        from kanefe.stepping.simulation import started

        options = RunOptions(t_span=stretch(t, every, duration), events=events, **steps)
        return started(cast("Steppable", self), Asked(start, inputs, outputs, every, options))

    @checked("path", "fmi", "method")
    def to_fmu(
        self,
        path: str | Path,
        *,
        fmi: str = "2.0",
        t: float = 0.0,
        start: Start = None,
        inputs: Named | None = None,
        outputs: Named | None = None,
        every: float = 0.01,
        duration: float | None = None,
        **steps: Unpack[StepKeywords],
    ) -> Path:
        """Write the scene as a functional mock-up unit for co-simulation; return its path.

        It has the results of the simulation that `start` returns: inputs are held over a communication step, states can
        be read, set and serialised. It contains the compiled kernels and needs no Python. With functions in Python,
        rigid contacts or forces as outputs, the unit needs kanefe where it runs, and cannot save states: a warning and
        its description say so. For a linear model for exchange see `Linearisation.to_fmu`.

        Parameters
        ----------
        path : path
            Path of the .fmu file; its stem is the name of the model.
        fmi : "2.0" or "3.0"
            Version of the standard.
        every : float
            Usual length of a communication step, s.
        t, start, inputs, outputs, duration
            As for `start`.
        **steps
            As for `start`. If "auto" would switch from one method to another, the second is used from the start.

        Raises
        ------
        ModelError
            If an argument is not valid, there is no C compiler, or functions cannot be sent to another process.
        FileError
            If the file cannot be written.

        Warns
        -----
        SimulationWarning
            If the unit needs kanefe; the message has the reason.

        Examples
        --------
        ``scene.to_fmu("arm.fmu", inputs="motor hub", outputs=("joint_coordinates hub", "position arm/tip"))``
        """
        from kanefe.fmu.export import write_scene
        from kanefe.integrate.auto.handing_over import HandingOver

        started = partial(self.start, t, start=start, inputs=inputs, outputs=outputs, every=every, duration=duration)
        sim = started(**steps)
        if isinstance(sim.stepper, HandingOver):
            steps["method"] = sim.stepper.second_name
            sim = started(**steps)
        return write_scene(sim, path, fmi, every)
