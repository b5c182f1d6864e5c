"""A finite-element model in arrays: M, C and K, groups, ties of interfaces, statics. It knows no body."""
