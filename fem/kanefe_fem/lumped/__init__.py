"""Lumped masses and springs, and the mean motion of the nodes to which they are attached."""
