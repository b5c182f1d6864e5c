"""Loop joints and couplers in order n: rows, multipliers, and how loops are closed."""
