"""Studies: one scene many times, over parameters, on any number of processes or machines, with a table as result.

`kanefe.Study` defines the runs, `kanefe.StudyTable` holds the results, `operability` computes statistics of maxima.
Reducers, such as ``kf.studies.peak("position", "tip")``, reduce a run to numbers, so that no histories are stored.
"""

from kanefe.studies.statistics.crew import interruptions as interruptions
from kanefe.studies.statistics.event_counts import events as events
from kanefe.studies.statistics.gumbel import GumbelFit as GumbelFit
from kanefe.studies.statistics.operability import Operability as Operability
from kanefe.studies.statistics.reducers import exceedances as exceedances
from kanefe.studies.statistics.reducers import peak as peak
from kanefe.studies.statistics.reducers import spectrum as spectrum

__all__ = ["GumbelFit", "Operability", "events", "exceedances", "interruptions", "peak", "spectrum"]
