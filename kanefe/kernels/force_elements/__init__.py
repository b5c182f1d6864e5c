"""Loads between frames, one kind a file: functions of one C signature, called by their addresses.

``f(t, numbers, inputs, ends, states, out)`` is given the constants of the load, what Python gives it, the motion of its
ends and its internal states, and writes what it does: see `kanefe.loads.action.LoadKernel`, and `places` for where.
"""
