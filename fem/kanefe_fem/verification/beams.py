"""All verification cases of beams."""

from kanefe_fem.verification import beam_frequencies, beam_motion, beam_statics, rotors, slider_crank, stiffened_beams

CASES = (
    *beam_frequencies.CASES,
    *beam_motion.CASES,
    *beam_statics.CASES,
    *rotors.CASES,
    *slider_crank.CASES,
    *stiffened_beams.CASES,
)
