/* The communication points of an importer, of either version of the standard, over the own time of the model. */
#ifndef COMMUNICATION_H
#define COMMUNICATION_H

#include <float.h>
#include <math.h>
#include <stdio.h>

#include "engine.h"

#define POINT_TOLERANCE 1e-6 /* largest distance of a communication point from the model's own time, relative to the step */

/* Goes on from t by dt (s); not 0 if that fails, or the model is at another time: it does not go back or skip by itself. */
static inline int step_from(engine *model, double t, double dt, char *message)
{
    double own = engine_time(model);

    if (!(dt > 0.0 && dt - dt == 0.0)) {
        snprintf(message, MESSAGE_SIZE, "a step must be above zero s");
        return 1;
    }
    if (!(fabs(t - own) <= POINT_TOLERANCE * dt + 4.0 * DBL_EPSILON * fabs(own))) {
        snprintf(message, MESSAGE_SIZE,
                 "the communication point is %.9g s, and the unit is at %.9g s. Remedy: a step from there, or a saved "
                 "state of the other time", t, own);
        return 1;
    }
    /* to the importer's next point: two sums of the same steps do not drift apart */
    return engine_step(model, t == own ? dt : t + dt - own, message);
}

#endif
