"""Scenes that are stepped from outside: inputs, outputs, states saved and restored."""
