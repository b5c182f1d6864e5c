"""Materials, and which cells of a mesh have them."""
