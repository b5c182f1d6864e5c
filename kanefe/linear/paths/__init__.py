"""Equilibria along a load: continuation, limit points, branch points and branches."""
