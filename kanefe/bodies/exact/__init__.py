"""Beams that bend far: geometrically exact, in coordinates of their strains."""
