"""Contacts: shapes, normal and friction forces, and steps of many loose bodies."""
