"""Loads in one evaluation: on bodies, between frames, along joint coordinates; which of them can act."""
