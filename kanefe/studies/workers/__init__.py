"""Execution of the cases of a study: blocks, pools, time limits."""
