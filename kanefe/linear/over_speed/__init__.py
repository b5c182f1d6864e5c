"""Modes and stability over the speed of a scene."""
