"""Modes of small motions: about a rest, and beside a motion that repeats."""
