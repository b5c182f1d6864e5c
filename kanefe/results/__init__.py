"""Channels of a run, stored or computed from stored ones on request, and their file."""
