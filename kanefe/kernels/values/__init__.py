"""What kernels calculate with: vectors and matrices with operators, and records with named fields."""
