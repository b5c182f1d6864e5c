"""Batches: one scene from many starts, or many scenes that are alike, at once."""

from kanefe.batches.many_runs import simulate_many as simulate_many
