"""Kane's equations, one section of the paper a file.

The partial velocity matrices are dense over all speeds, as the paper writes them. It is the readable oracle.
"""
