"""A state of a scene over its speeds: how frames move, which rows hold them, and what acts between them.

Each quantity is found once for a state, on request. Equations of motion stand above, in `kanefe.kane`.
"""
