"""Screened runs: what sticks to a moving frame is superposed, and only what comes near a change is integrated."""

from kanefe.screening.screened_run import ScreenedRun as ScreenedRun
from kanefe.screening.windows import screen as screen
