"""The frozen scene: bodies in a tree, numbering, scales, and the state that a function of the user sees."""
