"""All verification cases of beams, including the gear of the helicopter."""

from kanefe_fem.verification import (
    beam_frequencies,
    beam_impacts,
    beam_motion,
    beam_statics,
    damped_beams,
    drop_test,
    exact_motion,
    exact_statics,
    moving_force,
    paper_element,
    rotors,
    segmented_beams,
    ship,
    slider_crank,
    stiffened_beams,
    two_discs,
)

CASES = (
    *beam_frequencies.CASES,
    *beam_impacts.CASES,
    *beam_motion.CASES,
    *beam_statics.CASES,
    *damped_beams.BEAM_CASES,
    *drop_test.CASES,
    *exact_motion.CASES,
    *exact_statics.CASES,
    *moving_force.CASES,
    *paper_element.CASES,
    *rotors.CASES,
    *segmented_beams.CASES,
    *ship.CASES,
    *slider_crank.CASES,
    *stiffened_beams.CASES,
    *two_discs.CASES,
)
