"""Channels of a run: stored ones, ones computed from them on request, and their file."""
