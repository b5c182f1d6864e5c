"""Finite-element models in arrays: M, C and K, groups, ties of interfaces, statics. Independent of bodies."""
