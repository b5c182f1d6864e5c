"""Couples of friction on a probe: against spinning about the normal, and against rolling; both hold by anchors."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.frames import Matrix, Vector

if TYPE_CHECKING:
    from kanefe.contact.laws.friction_laws import Coulomb


class Couple(NamedTuple):
    """What friction does on a probe by couples.

    Attributes
    ----------
    moment : ndarray, shape (3,)
        On what touches, in N, N m.
    rates : ndarray, shape (`Coulomb.turning_states`,)
        Of its internal states: the twist about the normal, rad; that of rolling in axes of the surface, rad.
    potential : float
        Energy of the anchors' springs, J.
    taken, work : float
        Power that is lost, and that of slipping alone, W.
    """

    moment: Vector
    rates: Vector
    potential: float
    taken: float
    work: float


def couple_of(
    law: Coulomb,
    stiffness: float,
    damping: float,
    lever: float,
    A: Matrix,
    n: Vector,
    omega: Vector,
    press: float,
    states: Vector,
    gone: Vector,
) -> Couple:
    """Return what friction does against turning (Eq. 11).

    Parameters
    ----------
    law : Coulomb
    stiffness, damping : float
        Of the probe's anchor, N/m and N s/m.
    lever : float
        From the probe's centre to where it touches, m.
    A : ndarray, shape (3, 3)
        From the surface's axes to those of N.
    n, omega : ndarray, shape (3,)
        Normal, and angular velocity of what touches past the surface, in N, rad/s.
    press : float
        Normal force, N; 0 where it does not touch: anchors then follow.
    states : ndarray
        See `Couple`.
    gone : ndarray, shape (3,)
        How far it has turned since a state of rest, rad, in N: added to what the states say.
    """
    moment, rates, potential, taken, work = np.zeros(3), np.zeros(len(states)), 0.0, 0.0, 0.0
    spin = (omega @ n) * n
    twists = []  # where it is, with what follows of it along its direction, the rate, the lever and the most
    if law.torsional > 0.0:
        twist = (states[0] + gone @ n) * n
        twists.append((slice(0, 1), twist, twist, spin, law.torsional, law.sliding * law.torsional * press))
    if law.rolling > 0.0:
        twist = A @ states[-3:] + gone - (gone @ n) * n
        along = twist - (twist @ n) * n
        twists.append((slice(-3, None), twist, along, omega - spin, lever, law.rolling * press))
    for where, twist, along, rate, arm, most in twists:
        k, c = stiffness * arm**2, damping * arm**2
        pull = k * along + c * rate
        size = float(np.linalg.norm(pull))
        drag = pull if size <= most else most / size * pull
        given = (drag - k * twist) / c
        rates[where] = [given @ n] if where.start == 0 else A.T @ given
        moment -= drag
        potential += 0.5 * k * float(twist @ twist)
        taken += float(drag @ rate - k * (twist @ given))
        work += float(drag @ (rate - given)) if press > 0.0 else 0.0
    return Couple(moment, rates, potential, taken, work)


def rested_states(law: Coulomb, stiffness: float, lever: float, A: Matrix, n: Vector, moment: Vector) -> Vector:
    """Return the internal states with which the anchors give a moment (3,), in N: see `couple_of`."""
    states = np.zeros(law.turning_states)
    if law.torsional > 0.0:
        states[0] = -(moment @ n) / (stiffness * law.torsional**2)
    if law.rolling > 0.0:
        states[-3:] = -(A.T @ (moment - (moment @ n) * n)) / (stiffness * lever**2)
    return states
