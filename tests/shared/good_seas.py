"""Good calls of seas and ships."""

from __future__ import annotations

from functools import cache

import numpy as np

import kanefe as kf
from good_call import call, files, first, on

call("kanefe.RollDamping", kf.RollDamping, ratio=0.1, frequency=0.5, ratio_of_rao=0.05)
SEA = {"seed": 1, "duration": 60.0, "count": 30}
call(
    "kanefe.Sea.bretschneider",
    kf.Sea.bretschneider,
    Hs=2.0,
    Tp=9.0,
    spreading=None,
    spreading_deg=30.0,
    **SEA,
    depth=np.inf,
    gravity=9.81,
)
call("kanefe.Sea.jonswap", kf.Sea.jonswap, Hs=2.0, Tp=9.0, gamma=3.3, spreading=2.0, **SEA)
call("kanefe.Sea.pierson_moskowitz", kf.Sea.pierson_moskowitz, wind=10.0, spreading=2.0, **SEA)
call("kanefe.Sea.state", kf.Sea.state, number=4, spreading=2.0, **SEA)
call("kanefe.Sea.measured", kf.Sea.measured, frequencies=[0.3, 0.5, 0.8, 1.0], densities=[0.0, 1.0, 1.0, 0.0], **SEA)


@cache
def sea() -> kf.Sea:
    return kf.Sea.bretschneider(2.0, 9.0, **SEA)


@cache
def ship() -> kf.Ship:
    return kf.Ship(kf.example_rao(), sea(), speed=0.0, heading_deg=30.0)


on("kanefe.Sea.elevation", sea, times=[0.0, 1.0], x=0.0, y=0.0)
on("kanefe.Sea.kept", sea, order=0)
first("kanefe.Ship", kf.Ship, kf.example_rao, sea=sea(), speed=0.0, heading_deg=30.0, slowest_hz=0.03)
on("kanefe.Ship.at", ship, point=(1, 0, 0), duration=60.0, start=0.0, ramp=10.0, rotations="exact")
on("kanefe.Ship.motions", ship, times=[0.0, 1.0])
on("kanefe.Ship.motions_std", ship, point=(0, 0, 0))
on("kanefe.Ship.response_spectra", ship, omega=[0.5, 0.6])
on("kanefe.Ship.plot_rao", ship, path="x.png")
on("kanefe.MotionRao.at", kf.example_rao, omega=np.array([0.5]), heading_deg=30.0, speed=0.0)
on("kanefe.MotionRao.with_wave_at", kf.example_rao, x=1.0, y=0.0)
files("kanefe.read_rao", kf.read_rao, path="seas.csv", wave_at=(0.0, 0.0), symmetric=None)
