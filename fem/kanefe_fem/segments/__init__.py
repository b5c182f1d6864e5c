"""Slender bodies cut into chains of linear ones."""
