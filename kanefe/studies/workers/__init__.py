"""How the cases of a study are run: blocks, pools, time limits."""
