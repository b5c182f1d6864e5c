"""The frozen scene: bodies in a tree, numbering, scales, and the state passed to functions of the user."""
