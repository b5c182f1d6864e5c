"""Links of one coordinate whose motion is a function of one C signature, called by its address, one kind a file.

``f(numbers, q, out)`` is given the constants of the link and its coordinate, and writes the motion of its frame: see
`kanefe.joints.link.LinkKernel`, and `places` for where.
"""
