"""The data of bodies for the equations: masses, modes, interfaces, markers, and their cache."""
