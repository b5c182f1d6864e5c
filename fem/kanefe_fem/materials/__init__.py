"""Materials, and their assignment to the cells of a mesh."""
