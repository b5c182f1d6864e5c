"""Modes of small motions about a rest and about a periodic motion."""
