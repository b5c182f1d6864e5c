"""Studies: one scene many times, over parameters, on any number of processes or machines; what comes out is a table.

`kanefe.Study` says what is run, `kanefe.StudyTable` holds what came of it, `operability` makes statistics of maxima.
The reducers, such as ``kf.studies.peak("position", "tip")``, make numbers of a run, so that no histories are kept.
"""

from kanefe.studies.statistics.crew import interruptions as interruptions
from kanefe.studies.statistics.event_counts import events as events
from kanefe.studies.statistics.gumbel import GumbelFit as GumbelFit
from kanefe.studies.statistics.operability import Operability as Operability
from kanefe.studies.statistics.reducers import exceedances as exceedances
from kanefe.studies.statistics.reducers import peak as peak
from kanefe.studies.statistics.reducers import spectrum as spectrum

__all__ = ["GumbelFit", "Operability", "events", "exceedances", "interruptions", "peak", "spectrum"]
