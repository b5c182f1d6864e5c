"""The long robustness cases: `stress.py` runs them, and those of the package in full."""
