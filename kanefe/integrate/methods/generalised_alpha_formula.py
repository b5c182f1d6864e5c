"""The generalised-alpha formula (Chung & Hulbert 1993), in the form of Bruels, Cardona & Arnold (2012)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from kanefe.frames import Vector
from kanefe.integrate.stepper import StepFailure


class Step(NamedTuple):
    """A step from a given state: a1, u1 and the move of the coordinates are affine in du1."""

    ratio: float
    known_a: Vector
    share_u: float
    known_u: Vector
    share_move: float
    known_move: Vector

    def end(self, du1: Vector) -> tuple[Vector, Vector, Vector]:
        """Return the move, u1 and a1."""
        a1 = self.ratio * du1
        a1 += self.known_a
        return self.known_move + self.share_move * a1, self.known_u + self.share_u * a1, a1


def within(x: float, h: float, u0: Vector, u1: Vector, move: Vector) -> tuple[Vector, Vector]:
    """Return move and speeds after a share x of a step, of third order, with the speeds at both ends.

    A speed that a step does not resolve stays bounded.
    """
    moved = x * (1 - x) ** 2 * h * u0 + x * x * (x - 1) * h * u1 + x * x * (3 - 2 * x) * move
    return moved, (1 - x) * (1 - 3 * x) * u0 + x * (3 * x - 2) * u1 + 6 * x * (1 - x) / h * move


def no_step(converges: bool, other_remedy: str, component: int | None = None) -> StepFailure:
    """Return the failure of a run that finds no step small enough; `component` of the state is worst."""
    return StepFailure(
        "the implicit method found no step: "
        + ("its error stays too large" if converges else "its iteration does not converge"),
        f"check loads for jumps or growth without bound there, {other_remedy}",
        component,
    )


def doublings(error: float) -> int:
    """Return how often a step of third order can be doubled that had this error, of 1 allowed."""
    return max(0, math.floor(math.log2(0.7 / max(error, 1e-9)) / 3))


@dataclass(frozen=True)
class GeneralisedAlpha:
    """The method of one spectral radius, or that of Hilber, Hughes & Taylor (1977), which is the one with alpha_m = 0.

    With the true accelerations du and the algorithmic ones a, ``(1 - alpha_m) a1 + alpha_m a0 = (1 - alpha_f) du1 +
    alpha_f du0``, a step is ``u1 = u0 + h ((1 - gamma) a0 + gamma a1)`` and a move of the coordinates by
    ``h u0 + h^2 ((1/2 - beta) a0 + beta a1)``.

    Attributes
    ----------
    radius : float
        Share of an unresolved mode that a step keeps: 1 keeps all, 0 kills it in one step; of HHT from 0.5 to 1.
    is_hht : bool
    """

    radius: float
    is_hht: bool = False

    @cached_property
    def alpha_m(self) -> float:
        """Weight of the earlier algorithmic acceleration."""
        return 0.0 if self.is_hht else (2 * self.radius - 1) / (self.radius + 1)

    @cached_property
    def alpha_f(self) -> float:
        """Weight of the earlier true acceleration."""
        return (1 - self.radius if self.is_hht else self.radius) / (self.radius + 1)

    @cached_property
    def gamma(self) -> float:
        """Newmark's gamma, of order 2."""
        return 0.5 + self.alpha_f - self.alpha_m

    @cached_property
    def beta(self) -> float:
        """Newmark's beta."""
        return 0.25 * (0.5 + self.gamma) ** 2

    @cached_property
    def ratio(self) -> float:
        """Derivative of a1 by du1."""
        return (1 - self.alpha_f) / (1 - self.alpha_m)

    def move(self, h: float, u0: Vector, a0: Vector, a1: Vector) -> Vector:
        """Return the move of the coordinates in the directions of the speeds."""
        return h * u0 + h * h * ((0.5 - self.beta) * a0 + self.beta * a1)

    def from_start(self, h: float, u0: Vector, du0: Vector, a0: Vector) -> Step:
        """Return a step of h from a state, with all that does not depend on du1 done once."""
        known = (self.alpha_f * du0 - self.alpha_m * a0) / (1 - self.alpha_m)
        return Step(
            self.ratio,
            known,
            h * self.gamma,
            u0 + h * (1 - self.gamma) * a0,
            h * h * self.beta,
            h * u0 + h * h * (0.5 - self.beta) * a0,
        )

    def damping_share(self, h: float) -> float:
        """Return the factor of C in the iteration matrix of du1, s."""
        return self.gamma * self.ratio * h

    def stiffness_share(self, h: float) -> float:
        """Return the factor of K, s2."""
        return self.beta * self.ratio * h * h

    def error(self, h: float, a0: Vector, a1: Vector) -> Vector:
        """Return the third-order part of a move: the error of a step."""
        return (self.beta - 1 / 6) * h * h * (a1 - a0)
