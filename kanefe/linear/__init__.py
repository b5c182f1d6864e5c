"""Linear analysis: equilibrium, linearisation about a state, modes, Campbell diagram, frequency response, stability."""
