"""Machine code of kernels: how it is compiled, kept in files and called. Nothing here knows any physics."""
