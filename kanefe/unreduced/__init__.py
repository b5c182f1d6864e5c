"""Flexible bodies with all degrees of freedom of their mesh: sparse matrices, and the equations of scenes with them.

inertia_field   inertia forces of a body from the accelerations of its mass points
body            UnreducedBody, and how it is made
condensed       the scene without what is large: a model of frames that the bodies carry
border          the linear equations of a step: sparse bodies, and a small border
scene           residuals, accelerations and energies of a scene
channels        what results read
"""
