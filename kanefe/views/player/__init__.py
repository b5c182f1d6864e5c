"""A run as one HTML file that moves: what the browser is given, and the page around it.

The file holds no pictures: each flexible body is its skin with mode shapes, and moves by modal coordinates in time and
the motion of its frame; rigid bodies, surfaces and arrows move by frames. The browser interpolates between output times
(linear, rotations on the unit sphere) and sums the modes on the processor: a sum over 20 modes of 20,000 nodes takes
some 7 ms, the sums serve normals, edges and colours alike, there is no limit to the number of modes, as morph targets
of graphics libraries have one, and tests can ask the page where its nodes are. Skins of more than 100,000 nodes would
want the sum on the graphics processor.
"""
