"""Answers with a bound: what an error is made of, each source by a pair of evaluations, and what was refined for it."""

from kanefe.certified.analysis import Certified as Certified
from kanefe.certified.analysis import certify as certify
from kanefe.certified.quantity import Quantity as Quantity
