"""Channels of a run: what was stored, what is computed from it when it is asked for, and its file."""
