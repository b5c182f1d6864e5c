"""From where on numbers count at events of rigid contacts: the same for both routes."""

from typing import NamedTuple


class Changing(NamedTuple):
    """From where on numbers count when contacts change at an event."""

    round_off_of_gaps: float = 1e-14
    """Gap, relative to the length of what moves and to the distance of a point from the origin, below which its sign is
    round-off. The lowest bounces that are resolved are a hundred times as high."""
    stopped: float = 1e-7
    """Slip speed, relative to the speeds with which a contact point moves, below which it does not slip and its
    acceleration decides. Up to this speed, by `kanefe.kernels.contact.rigid_points.SLIPPING.straight`, the direction of
    an ending slip is known."""
    near: float = 1e-9
    """Gap relative to the length of what moves up to which a contact point takes part in an impact; also, relative to
    the largest value of an event function, up to which others have passed it too."""
    still: float = 1e-10
    """Normal speed below which a contact point does not move, relative to the speeds with which it moves."""
    moment: float = 1e-11
    """Duration, relative to the span, of a fall that reaches a speed below which nothing moves either."""
    crowded: float = 1e-6
    short_flight: float = 5e-8
    """Time within which successive impacts end, and time of flight below which they are combined and the bouncing body
    is at rest, relative to the span."""
    beginning: float = 2.0 / 3.0
    """Power of rtol that gives the speed, relative to the speeds of a scene, up to which a starting slip keeps the
    direction of the friction that would hold it. Friction would turn it there the faster the slower it is, and no step
    is short enough. That direction is known to first order in time, and so the speed to the power 3/2: to rtol."""
    accepted: float = 1e-7
    deeper: float = 10.0
    """Force, relative to the largest, up to which a margin that an event leaves below zero is what its decision does
    not see; and by how much it has to grow until it is looked at again. Margins are those of constraints, decisions
    solve a complementarity problem: where both differ by round-off, one event would follow the other at the same
    moment."""


CHANGING = Changing()

ROUND_OFF_OF_FORCES = 1e-9
"""Force relative to the largest below which its sign is round-off: the residual to which the complementarity problem is
solved."""


class Sticking(NamedTuple):
    """From where on numbers decide whether a contact sticks."""

    round_off_of_accelerations: float = 1e-12
    """Acceleration of a contact point, relative to the sum of those by each of the speeds of the scene, below which its
    sign is round-off; and so is the force that would give it. What falls freely presses on nothing, though its forces
    have a largest one."""
    holds: float = 1.0 - ROUND_OFF_OF_FORCES
    """Fraction of the holding friction from which the accelerations an instant later decide whether it continues to
    hold. """
    ahead: tuple[float, ...] = 1e-9, 1e-8, 1e-7, 1e-6, 1e-5
    """Instants after an event, relative to the span, at which the accelerations are evaluated if those at the event are
    at the friction limit. The first that exceeds round-off decides."""
    not_determined: float = 1e-9
    """Fraction of what a normal force does without friction, below which friction takes away all that it does."""


STICKING = Sticking()


class Striking(NamedTuple):
    """From where on numbers count among the impulses of an impact."""

    struck: float = 1e-11
    """Normal speed below which a contact point does not move after an impact, relative to what its impulses change."""
    shortest: float = 1e-9
    """Change of the rates by accelerations, relative to the largest, in the time in which an impact without collision
    is looked for."""
    apart: float = 1e-12
    """Response of a contact to an impulse at another, relative to those to their own, below which they are not
    coupled."""
    added: float = 1e-9
    """Energy that an impact gives, relative to what its impulses exchange, above which it is no round-off."""
    closely: float = 1e-12
    roughly: float = 1e-6
    """Error of a step through an impact whose slip turns, relative to its numbers; and of one of several in turn."""
    in_turn: int = 60
    still_in_turn: float = 1e-6
    """Largest number of impacts of one contact after the other that stand for one of several; and approach, relative to
    their rates, below which none follows."""
    jumps: float = 0.01
    """Change of a rate, relative to the largest before an impact, from which it counts that contacts struck together
    and not one after the other."""


STRIKING = Striking()


class Solving(NamedTuple):
    """How far the complementarity problem of contacts is solved, and by how many tries."""

    close: float = 1e-12
    nearly: float = 1e-11
    enough: float = 1e-9
    """Residual relative to the largest force up to which a solution is accepted at once, up to which it is not made
    better by problems nearby, and up to which it is accepted if it no longer improves. If rows are dependent, round-off
    in b has no solution."""
    farthest: float = 1e12
    """Force, relative to what one contact alone would have, above which an iteration leads nowhere."""
    sweeps: int = 60
    rounds: int = 3
    newton_steps: int = 30
    nearby: int = 60
    """Number of sweeps of the Gauss-Seidel iteration between two attempts of Newton's method; largest number of rounds
    of both; largest number of Newton steps; and largest number of problems nearby that lead to one: each has half of
    what is added before, which is round-off after forty."""
    dependent: float = 1e-13
    """Pivot, of the largest, below which equations of contact points depend on others."""


SOLVING = Solving()


class Sliding(NamedTuple):
    """Where the slip of an impact ends, turns and branches."""

    impact_ends: float = 1e-12
    """Slip speed, relative to the largest rate at which a contact is struck, below which its slip has ended in the
    impact."""
    straight_slip: float = 1e-13
    weak: float = 1e-13
    """Rate across a slip, relative to what the impulse does, below which it keeps its direction; and eigenvalue,
    relative to what a normal impulse does, below which a contact does not move in its direction. Both are round-off."""
    settled: float = 10.0
    """Rate at which a slip turns, relative to what the impulse could do and to the error of a step, below which it
    keeps its direction from there on: steps leave it no better known."""
    branches: int = 50
    """Largest number of changes between slip, stick, loading and unloading in an impact; theory allows a few."""


SLIDING = Sliding()

HALVINGS = 20
"""Number of times that the interval of a share of the restitution is halved: it is known to a millionth."""


class Sharing(NamedTuple):
    """How an impulse is shared among contacts that are struck together."""

    sharing_step: float = 0.005
    most_sharing_steps: int = 400_000
    """Step of an impact that contacts share by their compliance, relative to the time of the stiffest one on the
    lightest mass: leapfrog's error is a 24th of its square; and largest number of steps, of which a few thousand are
    common."""
    least_restitution: float = 0.1
    """Restitution relative to 1, as which smaller ones count there: a hundredth of the energy. What parts takes shorter
    steps."""
    held: float = 1e-8
    nearly_held: float = 1e-6
    most_sweeps: int = 1000
    """Change of the friction of a sweep there, relative to the normal forces, up to which it is found; up to which it
    is taken after the most sweeps; and how many these are."""
    over: float = 1e-9
    """Approach relative to the rates before below which such an impact is over."""


SHARING = Sharing()
