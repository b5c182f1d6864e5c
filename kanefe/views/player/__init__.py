"""A run as an animated HTML file: the data for the browser, and the page around them.

The file contains no pictures. Each flexible body is its skin with mode shapes, and moves by modal coordinates and with
its frame; rigid bodies, surfaces and arrows move with frames. The browser interpolates between output times (linearly,
rotations on the unit sphere) and sums the modes on the CPU: 20 modes of 20,000 nodes take about 7 ms. Normals, edges
and colours use the same sums, the number of modes has no limit, unlike morph targets of graphics libraries, and tests
can read the positions of nodes from the page. Skins of more than 100,000 nodes would need the GPU.
"""
