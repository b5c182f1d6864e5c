"""Processes of MPI that work as one, and the matrices that are spread over them."""
