"""Damage of stress histories."""
