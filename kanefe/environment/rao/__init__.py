"""Motions of ships in waves: response amplitude operators, their conventions and files."""
