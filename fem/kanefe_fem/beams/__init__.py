"""Beams: elements, sections, loads, and bodies made from them."""
