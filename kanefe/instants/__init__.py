"""A scene at one time: what it tells, and what an impulse makes of it."""
