"""Screened runs: superposition while everything sticks to a moving frame, integration only near events."""

from kanefe.screening.screened_run import ScreenedRun as ScreenedRun
from kanefe.screening.windows import screen as screen
