"""``kanefe doctor``: the installed packages, kernels and caches, and a trial solve on each route."""
