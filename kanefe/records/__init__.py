"""Channels that are recorded while a run goes on, in memory or in a file that can be read at any time."""
