"""Studies: one scene many times, over parameters, on any number of processes or machines; what comes out is a table.

`kanefe.Study` says what is run, `kanefe.StudyTable` holds what came of it, `operability` makes statistics of maxima.
The reducers, such as ``kf.studies.peak("position", "tip")``, make numbers of a run, so that no histories are kept.
"""

from kanefe.studies.crew import interruptions as interruptions
from kanefe.studies.event_counts import events as events
from kanefe.studies.gumbel import GumbelFit as GumbelFit
from kanefe.studies.operability import Operability as Operability
from kanefe.studies.reducers import exceedances as exceedances
from kanefe.studies.reducers import peak as peak
from kanefe.studies.reducers import spectrum as spectrum

__all__ = ["GumbelFit", "Operability", "events", "exceedances", "interruptions", "peak", "spectrum"]
