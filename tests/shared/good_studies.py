"""Good calls of studies."""

from __future__ import annotations

from functools import cache

import numpy as np
import scipy.stats

import kanefe as kf
from good_call import WRITERS, call, files, on
from good_scenes import small


def pendulum(length: float, angle: float = 0.0) -> kf.System:
    return small()


call(
    "kanefe.Study",
    kf.Study,
    build=pendulum,
    outputs=kf.studies.peak("position", "rod"),
    duration=0.01,
    rtol=None,
    simulate=None,
    length=[1.0, 2.0],
)
call(
    "kanefe.Study.sampled",
    kf.Study.sampled,
    build=pendulum,
    outputs=kf.studies.peak("position", "rod"),
    samples=2,
    sampling="latin hypercube",
    sampling_seed=0,
    duration=0.01,
    rtol=None,
    simulate=None,
    length=scipy.stats.norm(10.0, 0.5),
)
study = cache(lambda: kf.Study(pendulum, kf.studies.peak("position", "rod"), duration=0.01, length=[1.0, 2.0]))
WRITERS["store"] = lambda path: study().run("serial", path, progress=False)
on("kanefe.Study.key", study, number=0)
on("kanefe.Study.result", study, parameters={"length": 1.0})
on("kanefe.Study.run", study, executor="serial", store="store", workers=1, retry_failed=False, progress=False)
files("kanefe.StudyTable", kf.StudyTable, store="store")
fit = cache(lambda: kf.studies.GumbelFit.of(np.array([1.0, 2.0, 3.0, 2.5, 1.5])))
call("kanefe.studies.GumbelFit.of", kf.studies.GumbelFit.of, maxima=np.array([1.0, 2.0, 3.0, 2.5]))
on("kanefe.studies.GumbelFit.exceedance", fit, limit=2.0)
on("kanefe.studies.GumbelFit.exceedance_band", fit, limit=2.0, band=0.9)
on("kanefe.studies.GumbelFit.quantile", fit, probability=0.1)
on("kanefe.studies.GumbelFit.quantile_band", fit, probability=0.1, band=0.9)
call("kanefe.studies.events", kf.studies.events, after=0.0, lift="lift*")
R = {"component": None, "after": 0.0, "name": "x"}
call("kanefe.studies.exceedances", kf.studies.exceedances, quantity="position", level=1.0, **R)
call(
    "kanefe.studies.interruptions",
    kf.studies.interruptions,
    body="deck",
    at=(0, 0, 0),
    lateral=0.2,
    longitudinal=0.2,
    sliding=0.2,
    after=0.0,
    name="crew",
)
call("kanefe.studies.peak", kf.studies.peak, quantity="position", kind="absolute", **R)
call("kanefe.studies.spectrum", kf.studies.spectrum, quantity="position", segment=None, **R)
