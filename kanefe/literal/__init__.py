"""The literal route: the paper's equations as a model asks for them; consistent starts, closed loops, and contacts."""
