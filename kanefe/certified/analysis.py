"""Any analysis of a scene with an accuracy: equilibria, modes, Campbell diagrams, responses, buckling."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.arguments import checked
from kanefe.certified.bodies_made import BodiesMade
from kanefe.certified.body_sources import body_sources
from kanefe.certified.choice import Levels, settings
from kanefe.certified.limits import Limits
from kanefe.certified.quantity import Of, quantities_of
from kanefe.certified.report_of_search import accuracy_of
from kanefe.certified.run import shown
from kanefe.certified.search import Search
from kanefe.certified.trial import Trial, timed
from kanefe.certified.values import values_of
from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.results.accuracy import Accuracy
from kanefe.scene.segments import SegmentMethods


@dataclass(frozen=True, eq=False)
class Certified:
    """What an analysis gave at its last setting, and how wrong it may be.

    Attributes
    ----------
    answer : object
        Of the analysis.
    accuracy : Accuracy
    """

    answer: Any
    accuracy: Accuracy

    def __str__(self) -> str:
        return f"{self.answer}\n{self.accuracy}"


@checked("scene", "analysis", "accuracy", "most_seconds", "most_memory", "progress")
def certify(
    scene: SegmentMethods,
    analysis: Callable[[Any], Any],
    *,
    of: Of | Sequence[Of] | Mapping[str, Of],
    accuracy: float | None = None,
    most_seconds: float | None = None,
    most_memory: float | None = None,
    progress: bool | None = None,
) -> Certified:
    """Do an analysis of a scene with flexible bodies as finely as an accuracy of its numbers asks for.

    It is repeated with more modes of each body, more stiffening and finer meshes, one at a time, until what such pairs
    say, times 1.5, is at most what is allowed. Errors that these do not show, such as those of material data, are not
    in it. Of runs in time `kanefe.System.simulate` does it, with ``accuracy=``.

    Parameters
    ----------
    scene : System
    analysis : callable
        Of an open copy of the scene: `kanefe.equilibrium`, `kanefe.buckling`, or a function that returns anything, such
        as ``lambda scene: kf.equilibrium(scene).linearise().modes()``.
    of : callable, Quantity, or sequence or mapping of these
        Functions of what the analysis returns, which give numbers: see `kanefe.Quantity`.
    accuracy : float, optional
        Relative, of those that have none of their own.
    most_seconds : float, optional
        Time by the wall clock after which no further evaluation is begun.
    most_memory : float, optional
        Memory of the process that no further evaluation is to exceed, bytes.
    progress : bool, optional
        Show the bound as it falls; default: only on a terminal.

    Returns
    -------
    Certified

    Raises
    ------
    ModelError
        If a quantity or accuracy is not valid, or no body of the scene can be made again.

    Warns
    -----
    AccuracyWarning
        If the accuracy is not met, with the reason.

    Examples
    --------
    >>> import kanefe as kf
    >>> from kanefe_fem import Material, Rectangle, beam_body, straight_beam
    >>> rod = straight_beam(1.0, Rectangle(0.02, 0.02), Material(E=210e9, nu=0.3, rho=7850.0), elements=8)
    >>> scene = kf.System()
    >>> body = beam_body(rod, {"root": "clamped"}, kf.CraigBampton(modes=4))
    >>> _ = scene.add_flexible_body("rod", body, joint=kf.Fixed())
    >>> of = {"first": lambda modes: modes.frequencies[0]}
    >>> found = kf.certify(scene, lambda scene: kf.linearise(scene).modes(), of=of, accuracy=1e-3)
    >>> found.accuracy.is_met
    True
    """
    quantities = quantities_of(of, accuracy)
    texts = [quantity.title for quantity in quantities if isinstance(quantity.what, str)]
    if texts:
        raise ModelError(
            f"of={texts[0]!r}: channels are those of runs. Remedy: a function of what the analysis returns"
        )
    found, kept = body_sources(scene)
    sources = tuple(found)
    if not sources:
        raise ModelError(
            "no body of the scene can be made more accurate: "
            + ("; ".join(f"{one.name}: {one.reason}" for one in kept) or "there is no flexible one")
        )
    bodies = BodiesMade(scene)

    def evaluate(levels: Levels) -> Trial:
        chosen = settings(sources, levels)
        made, making = bodies.of(chosen)
        answer, seconds, texts = timed(lambda: analysis(scene.with_bodies(made) if made else scene.copy()))
        values = [one for quantity in quantities for one in values_of(quantity, answer)]
        return Trial(levels, answer, values, np.zeros(len(values)), (), seconds + making, texts)

    with shown(progress) as tell:
        search = Search(evaluate, sources, quantities, Limits(most_seconds, most_memory), tell, kept)
        search.run()
    for text in search.best.texts:
        warnings.warn(text.message, text.category, stacklevel=outside())
    accuracy_found = accuracy_of(search)
    if not accuracy_found.is_met:
        warnings.warn(f"accuracy not met: {search.reason}", AccuracyWarning, stacklevel=outside())
    return Certified(search.best.answer, accuracy_found)
