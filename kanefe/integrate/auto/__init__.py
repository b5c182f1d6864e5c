"""The method of a run: what method="auto" weighs, and what it takes."""
