"""A scene at one time: its outputs, and the effect of an impulse."""
