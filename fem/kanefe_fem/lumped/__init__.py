"""Lumped masses and springs, and how the nodes move that they hang on."""
