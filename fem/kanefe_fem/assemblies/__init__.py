"""Assemblies from CAD: parts with mass, the joints that their faces propose, and scenes of them."""
