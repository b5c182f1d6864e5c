"""A mesh in arrays: cells, groups, surfaces, shape functions, checks."""
