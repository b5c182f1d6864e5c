"""All verification cases of beams."""

from kanefe_fem.verification import beam_frequencies

CASES = beam_frequencies.CASES
