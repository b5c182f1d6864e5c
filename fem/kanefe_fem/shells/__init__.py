"""Shells: from a mesh of a surface to a full-order model, or to a flexible body."""
