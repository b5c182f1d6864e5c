"""What a study tells of its runs: reducers, maxima, operability, and its page."""
