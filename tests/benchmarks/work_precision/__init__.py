"""What `bench.py` measures: error against CPU time, figures against goals and against a peer, what skipping saves.

Nothing is imported here: the number of threads must be set before numpy is loaded.
"""
