"""Scenes that are stepped from outside: inputs in, outputs out, states kept and taken up again."""
