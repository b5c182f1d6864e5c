"""Solids: forms, matrices, preload, and bodies made from them."""
