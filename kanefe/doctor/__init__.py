"""``kanefe doctor``: what is installed and works, where kernels and caches are, and a solve on each route."""
