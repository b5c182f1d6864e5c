"""Statistics of the runs of a study: reducers, maxima, operability, and its report."""
