"""Linearisation of a scene about a state: mass, damping, gyroscopic and stiffness matrices, and A, B, C, D."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe._public import served
from kanefe.arguments import checked
from kanefe.equations.model import Model
from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.frames import Matrix, Vector, shaped_numbers
from kanefe.instants.instant import Instant
from kanefe.instants.missed_statics import is_known, warn_of_missed
from kanefe.linear.azimuth import CONSTANT, change_ahead
from kanefe.linear.inputs import Input, inputs_of
from kanefe.linear.outputs import Output, output_rows, output_values, outputs_of
from kanefe.linear.settled import settled
from kanefe.linear.small_motions import Directions, SmallMotions
from kanefe.linear.state import Freezable, model_in_state
from kanefe.linear.state_space import StateSpace
from kanefe.linear.tangents import tangent_names
from kanefe.linear.unsettled import warn_of_imbalance
from kanefe.scene.targets import Named

if TYPE_CHECKING:
    from pathlib import Path

    from kanefe.equations.given_state import Start
    from kanefe.linear.frequency_response import FrequencyResponse
    from kanefe.linear.input_to_output import Margins
    from kanefe.linear.modes.modes import Modes


class Linearisation(StateSpace):
    """Small motions x of a scene about a state, ``dx/dt = A x + B w``, ``y = C x + D w``; made by `linearise`.

    x are independent tangent coordinates p (displacements, angles, modal coordinates, rotation vectors in the moving
    frame), followed by independent speeds r. Without rolling this is equivalent to

        M d2p/dt2 + (damping + gyroscopic) dp/dt + stiffness p = B_2 w

    About a moving state both are frozen at that state: they give its rates exactly, and are constant if the motion is
    steady in these coordinates. A rolling wheel, or a rotor in a frame that does not spin, is steady if its spin is in
    a revolute joint; in the tangents of a free joint, which spin with the body, gravity would rotate.

    Attributes: see `StateSpace`.
    """

    @cached_property
    def change(self) -> float:
        """Change of A as the scene moves, relative to its largest rates: zero if the motion is steady in x.

        Measured at some azimuths or times, with all joints at their present speeds.
        """
        return change_ahead(self.small)

    def modes(self) -> Modes:
        """Return eigenvalues, frequencies, damping ratios and mode shapes of the whole scene.

        If A changes as the scene moves (see `change`), as for a bladed rotor on a tower, an `AccuracyWarning` is
        issued: the modes at one azimuth are not those of the scene, which `kanefe.floquet` finds.

        Examples
        --------
        ``print(kf.linearise(scene).modes())``
        """
        from kanefe.linear.modes.modes import modes_of

        self._warn_of_change("modes")
        return modes_of(self)

    def _warn_of_change(self, what: str) -> None:
        if self.change > CONSTANT:
            warnings.warn(
                f"{what} of a moving state are those of the scene frozen at t = {self.time:.6g} s; as it moves, its "
                f"small motions change (by {self.change:.2g} of their largest rates). Remedy: kanefe.floquet, "
                "if the motion is periodic",
                AccuracyWarning,
                stacklevel=outside(),
            )

    @checked
    def frequency_response(self, frequencies: Sequence[float] | np.ndarray) -> FrequencyResponse:
        """Return the response of the outputs to inputs of unit amplitude.

        Parameters
        ----------
        frequencies : array_like, shape (F,)
            Hz, not negative.

        Raises
        ------
        ModelError
            If there are no inputs or outputs, or a frequency is not valid.
        """
        from kanefe.linear.frequency_response import frequency_response

        self._warn_of_change("responses")
        return frequency_response(self, frequencies)

    @checked
    def h2_norm(self, output: str | None = None, input: str | None = None) -> float:
        """Return the H2 norm: the rms value of the outputs under two-sided white noise of unit intensity in the inputs.

        By the residues of the modes that matter, so that modes which no input moves, or no output sees, do no harm.

        Parameters
        ----------
        output, input : str, optional
            One of `output_names` and of `input_names`, with or without the unit. Default: all, added up by squares.

        Returns
        -------
        float
            Infinite if a mode that matters does not decay, or an input acts on an output at once (`D`).

        Raises
        ------
        ModelError
            If there is no such name; the message lists them.
        """
        from kanefe.linear.input_to_output import channels_of, h2_norm

        self._warn_of_change("norms")
        return h2_norm(channels_of(self, output, input))

    @checked
    def margins(
        self, output: str | None = None, input: str | None = None, *, gain: float = 1.0, controller: Any = None
    ) -> Margins:
        """Return the margins of the loop ``input = -gain controller(output)``, with their frequencies.

        By the response itself at all frequencies where it can turn, between its poles: no polynomials.

        Parameters
        ----------
        output, input : str, optional
            One of `output_names` and of `input_names`, with or without the unit; not needed if there is only one.
        gain : float
            Unit of the input per unit of the output.
        controller : tuple of array_like, optional
            ``A, B, C, D`` of one with states, ``dx/dt = A x + B output``, ``C x + D output``, or what has them, such as
            `control.StateSpace`; default: none but the gain. Sampled ones: `kanefe.sampled_loop`.

        Raises
        ------
        ModelError
            If there is no such name, several and none is named, the controller is none, or a motion is undamped.

        Examples
        --------
        ``print(small.margins("position arm/tip y", "force arm/tip y", gain=2e3))``
        """
        from kanefe.linear.controllers import in_series
        from kanefe.linear.input_to_output import channels_of, margins

        self._warn_of_change("margins")
        return margins(in_series(channels_of(self, output, input), controller), gain)

    @checked
    def to_control(self, *, modal: bool = False) -> Any:
        """Return a `control.StateSpace` with the names of states, inputs and outputs.

        Parameters
        ----------
        modal : bool
            Whether its states are those of the modes, scaled so that inputs move each as much as outputs see it,
            without modes that no input moves or no output sees. python-control 0.10.2 without slycot calls the H2 norm
            of stable systems infinite otherwise; its margins fail in either form: `h2_norm` and `margins` do not.

        Raises
        ------
        ModelError
            If modes coincide, as rigid motions do, and `modal` is asked for.
        MissingDependency
            If python-control is not installed: ``pip install 'kanefe[control]'``.
        """
        from kanefe.linear._control import modal_space, state_space

        return modal_space(self) if modal else state_space(self)

    @checked
    def to_fmu(self, path: str | Path, *, fmi: str = "2.0") -> Path:
        """Write the linear system as a functional mock-up unit for model exchange; return its path.

        Inputs and states are deviations from the state of the analysis, outputs are absolute.

        Parameters
        ----------
        path : path
            Of the .fmu file; its stem is the name of the model.
        fmi : "2.0" or "3.0"
            Version of the standard.

        Raises
        ------
        ModelError
            If there is no such version, or no C compiler.
        FileError
            If the file cannot be written.

        Examples
        --------
        ``kf.linearise(scene, inputs="motor hub", outputs="position tip").to_fmu("arm.fmu", fmi="3.0")``
        """
        self._warn_of_change("units for exchange")
        return served("write_linear")(self, path, fmi)

    @checked
    def moved(self, x: Sequence[float] | np.ndarray) -> Vector:
        """Return the state y = (q, u, z) displaced from that of the analysis by x (states,), to first order."""
        small = shaped_numbers(x, (len(self.A),), "x")
        n, N, moving = self.model.free_count, self.position_count, self.moving_count
        z = self.small.along_positions.z @ small[:N]
        du = self.small.along_positions.du @ small[:N] + self.small.along_speeds.du @ small[N:moving]
        q = self.model.advance(self.state[: self.model.coordinate_count], z[:n])
        _, u, internal = self.model.parts(self.state)
        internal = internal.copy()
        internal[self.small.arms.places[: len(small) - moving]] += small[moving:]
        return np.concatenate((q, u + du[:n], internal))


@checked("t", "start")
def linearise(
    scene: Freezable | Model,
    *,
    t: float | None = None,
    start: Start = None,
    inputs: Named | None = None,
    outputs: Named | None = None,
) -> Linearisation:
    """Linearise a scene about a state.

    Derivatives are exact to round-off (complex steps through the order-n equations), including springs, stiffening,
    loops and gyroscopic terms. Functions of the user that depend on the state, such as controllers, are differentiated
    by central differences.

    Parameters
    ----------
    scene : System or Model
    t : float, optional
        s; default: the time of the state, or zero.
    start : state, optional
        The state to linearise about, as `kanefe.System.simulate` takes it; default: the start of the scene, with bodies
        that stiffen deformed in balance with their motion. For small motions about rest:
        ``kf.equilibrium(scene).linearise()``.
    inputs : str, sequence or mapping of str, optional
        ``"force body x"``, ``"torque body/interface z'"``, ``"motor body"``, ``"gravity z"``, ``"load <label>"``, or
        ``"drive body"``, the acceleration of a driven coordinate, whose position and rate are then states too. ``x`` is
        along N, ``x'`` along the frame's own axes in this state; without an axis all three. The keys of a mapping are
        names.
        Default: all loads of the scene.
    outputs : str, sequence or mapping of str, optional
        ``"position body/interface x"``, also rotation (a vector), velocity, angular_velocity, acceleration,
        angular_acceleration; ``"deflection body/interface y"`` in the mesh frame; joint_coordinates, joint_speeds,
        modal_coordinates, modal_speeds. Default: free joint coordinates and speeds.

    Raises
    ------
    ModelError
        If a name is unknown, the state is not consistent, the loops are singular, bodies are unreduced, or nothing
        can move.

    Warns
    -----
    AccuracyWarning
        If the modes of a body miss much of its deformation by gravity, spin or tractions.
    UnsettledWarning
        If the state is not in balance, such as a start from which the scene falls or sags; the message has the
        remaining force. Steady and free motions are in balance.

    Notes
    -----
    Closed rigid contacts are constraints: loaded ones stay closed, and sticking ones do not slide. The small motions
    are those within which this holds.

    Examples
    --------
    >>> import kanefe as kf
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> rod = scene.add_rigid_body("rod", 1.0, 1 / 12, com=(0, 0, -0.5), joint=kf.Revolute("y"))
    >>> small = kf.linearise(scene, inputs="motor rod", outputs="position rod x")
    >>> small.state_names
    ('rod: angle [rad]', 'rod: rate [rad/s]')
    >>> round(float(small.modes().frequencies[0]), 4)
    0.6105
    """
    found = linearised(scene, t, start, inputs, outputs)
    warn_of_imbalance(found.imbalance, "linearise")
    if is_known(found.model):
        warn_of_missed(Instant(found.model, found.time, _rested(found.small)), "linearise")
    return found


def linearised(
    scene: Freezable | Model,
    t: float | None,
    start: Start,
    inputs: Named | None,
    outputs: Named | None,
    known: SmallMotions | None = None,
) -> Linearisation:
    """Return the result of `linearise` without warnings, for callers that issue their own or linearise often.

    `known` may be small motions about that state, which are then reused.
    """
    model, time, q, u = model_in_state(scene, t, start, "linearise")
    if start is None:
        q = settled(model, time, q, u)
    given = inputs_of(model, time, q, u, inputs)
    drives = tuple(dict.fromkeys(item.drive for item in given if item.drive is not None))
    is_known = known is not None and known.model is model and not drives and known.t == time
    if known is None or not (is_known and np.array_equal(known.q, q) and np.array_equal(known.u, u)):
        known = SmallMotions(model, time, q, u, drives)
    small = known
    if not len(small.positions.leading) and not len(small.speeds.leading):
        raise ModelError(
            "linearise: nothing in the scene can move: loops and rigid contacts hold all of it. Remedy: a flexible "
            "body, or compliant contacts, kanefe.HuntCrossley(...)"
        )
    measured = outputs_of(small, outputs)
    return linearisation_of(small, given, measured)


def _rested(small: SmallMotions) -> Vector:
    """Return the state (q, u, z) with elastic coordinates in balance with its motion, to first order."""
    model, q = small.model, small.q.copy()
    bodies = [body.flexible for body in model.bodies if body.flexible is not None]
    speeds = np.concatenate([np.arange(terms.speeds.start, terms.speeds.stop) for terms in bodies])
    left = np.zeros(model.free_count)
    left[speeds] = small.mass[np.ix_(speeds, speeds)] @ small.du[speeds]
    for terms in bodies:
        k = terms.body.free_count
        q[terms.eta] += np.linalg.solve(terms.body.stiffness[:k, :k], left[terms.speeds])
    return np.concatenate((q, small.u, model.initial_states))


def linearisation_of(small: SmallMotions, inputs: Sequence[Input], outputs: Sequence[Output]) -> Linearisation:
    """Return the matrices of small motions, with inputs and outputs."""
    model = small.model
    P, R, arms = small.with_arms, small.along_speeds, small.along_arms
    lead_p, lead_r = small.positions.leading, small.speeds.leading
    driven = input_directions(small, inputs)
    still = np.zeros((len(small.arms), len(inputs)))
    B = np.vstack((np.zeros((len(lead_p), len(inputs))), driven.ddu[lead_r], still))
    C = np.hstack([output_rows(small, outputs, along) for along in (P, R, arms)])
    D = output_rows(small, outputs, driven)
    if not small.is_moving:
        C, D = _without_noise(C), _without_noise(D)
    names_z = (*tangent_names(model), *(_drive_name(model, drive, 0) for drive in small.drives))
    names_of_arms = [model.internal_names()[i] for i in small.arms.places]
    names_u = (*model.speed_names(), *(_drive_name(model, drive, 1) for drive in small.drives))
    return Linearisation(
        model=model,
        time=small.t,
        state=small.y,
        A=small.state_matrix(),
        B=B,
        C=C,
        D=D,
        state_names=(*(names_z[i] for i in lead_p), *(names_u[i] for i in lead_r), *names_of_arms),
        input_names=tuple(item.label for item in inputs),
        output_names=tuple(item.label for item in outputs),
        output_values=output_values(small, outputs),
        small=small,
        structural=small.structural_matrix(),
    )


def input_directions(small: SmallMotions, inputs: Sequence[Input]) -> Directions:
    """Return the accelerations due to unit inputs, including drives."""
    n, count = small.model.free_count, len(inputs)
    none = np.zeros((small.size, count))
    wanted = np.zeros((small.size, count))
    for i, item in enumerate(inputs):
        if item.force is not None:
            wanted[:n, i] = small.model.literal.responses(small.here, item.force[:, None])[:, 0]
        elif item.drive is not None:
            wanted[n + small.drives.index(item.drive), i] = 1.0
    of_drives = [i for i, item in enumerate(inputs) if item.drive is not None]
    if of_drives:
        wanted[:, of_drives] = small.accelerations(none[:, of_drives], none[:, of_drives], wanted[:, of_drives])
    return Directions(none, none.copy(), wanted)


def _without_noise(rows: Matrix) -> Matrix:
    """Return rows of differences with round-off set to zero, as most entries are at rest."""
    size = np.abs(rows).max(axis=1, keepdims=True, initial=0.0)
    return np.where(np.abs(rows) < 1e-11 * size, 0.0, rows)


def _drive_name(model: Model, drive: Any, rate: int) -> str:
    body = model.bodies[drive.body]
    name = (body.joint.speed_names if rate else body.joint.coordinate_names)[drive.coordinate]
    return f"{body.name}: driven {name}"
