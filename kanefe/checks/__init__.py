"""Cases with limits that the package runs on itself: verification against references, and robustness."""
