"""Kernels: the order-n equations on records of arrays, compiled by numba.

Nothing here knows of bodies or joints as objects: a scene is a set of tables (`tables.Tables`), written once when it is
frozen. What a kernel is written in (marks, values, records, arrays) comes from one file, `language`.
"""
