"""What the equations need of a body: masses, modes, interfaces, markers, and the cache that keeps them."""
