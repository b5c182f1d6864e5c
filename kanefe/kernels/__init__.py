"""Kernels: the order-n equations on arrays, compiled by numba.

Nothing here knows of bodies or joints as objects: a scene is a set of tables (`layout.Tables`), written once when it is
frozen. Vectors and small matrices travel as tuples, which the compiler keeps in registers.
"""
