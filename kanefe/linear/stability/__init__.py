"""Factors of loads at which a rest is lost: buckling, divergence and flutter."""
