"""Laws of normal and friction forces, one family a file."""
