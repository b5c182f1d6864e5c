/* FMI 3.0: the functions of the standard, over a model. */
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "communication.h"
#include "engine.h"
#include "state_bytes.h"

#define EXPORT __attribute__((visibility("default")))

typedef uint32_t reference;
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } status;
typedef const char *text;
typedef void (*log_function)(void *, status, text, text);

typedef struct {
    engine *model;
    log_function log;
    void *environment;
} instance;

static status refuse(void *c, const char *message)
{
    instance *of = c;

    if (of->log)
        of->log(of->environment, ERROR, "logStatusError", message);
    return ERROR;
}

EXPORT text fmi3GetVersion(void) { return "3.0"; }

EXPORT status fmi3SetDebugLogging(void *c, bool is_on, size_t count, const text categories[])
{
    (void)c, (void)is_on, (void)count, (void)categories;
    return OK;
}

static void *instantiate(text token, void *environment, log_function log)
{
    char message[MESSAGE_SIZE] = "";
    instance *of = calloc(1, sizeof *of);

    if (!of)
        return NULL;
    of->log = log;
    of->environment = environment;
    if (!token || strcmp(token, TOKEN))
        refuse(of, "the instantiation token is not that of the model description");
    else if (!(of->model = engine_make(message)))
        refuse(of, message);
    if (!of->model) {
        free(of);
        return NULL;
    }
    return of;
}

EXPORT void *fmi3InstantiateModelExchange(text name, text token, text resources, bool is_visible, bool is_logging,
                                          void *environment, log_function log)
{
    (void)name, (void)resources, (void)is_visible, (void)is_logging;
    return IS_LINEAR ? instantiate(token, environment, log) : NULL;
}

EXPORT void *fmi3InstantiateCoSimulation(text name, text token, text resources, bool is_visible, bool is_logging,
                                         bool uses_events, bool may_return, const reference asked[], size_t count,
                                         void *environment, log_function log, void *update)
{
    (void)name, (void)resources, (void)is_visible, (void)is_logging;
    (void)uses_events, (void)may_return, (void)asked, (void)count, (void)update;
    return IS_LINEAR ? NULL : instantiate(token, environment, log);
}

EXPORT void *fmi3InstantiateScheduledExecution(text name, text token, text resources, bool is_visible, bool is_logging,
                                               void *environment, log_function log, void *a, void *b, void *d)
{
    (void)name, (void)token, (void)resources, (void)is_visible, (void)is_logging;
    (void)environment, (void)log, (void)a, (void)b, (void)d;
    return NULL;
}

EXPORT void fmi3FreeInstance(void *c)
{
    if (c) {
        engine_free(((instance *)c)->model);
        free(c);
    }
}

EXPORT status fmi3EnterInitializationMode(void *c, bool has_tolerance, double tolerance, double start, bool has_stop,
                                          double stop)
{
    char message[MESSAGE_SIZE] = "";

    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    return engine_begin_at(((instance *)c)->model, start, message) ? refuse(c, message) : OK;
}

#define NOTHING(name)                                                                                                  \
    EXPORT status name(void *c)                                                                                        \
    {                                                                                                                  \
        (void)c;                                                                                                       \
        return OK;                                                                                                     \
    }
NOTHING(fmi3ExitInitializationMode)
NOTHING(fmi3EnterEventMode)
NOTHING(fmi3Terminate)
NOTHING(fmi3EnterConfigurationMode)
NOTHING(fmi3ExitConfigurationMode)
NOTHING(fmi3EvaluateDiscreteStates)
NOTHING(fmi3EnterContinuousTimeMode)
NOTHING(fmi3EnterStepMode)

EXPORT status fmi3Reset(void *c)
{
    engine_reset(((instance *)c)->model);
    return OK;
}

EXPORT status fmi3GetFloat64(void *c, const reference asked[], size_t count, double values[], size_t room)
{
    engine *model = ((instance *)c)->model;
    double rates[STATE_COUNT + 1];
    const double *found = NULL;

    if (room < count)
        return refuse(c, "there is too little room for the values");
    for (size_t i = 0; i < count; i++) {
        reference r = asked[i];
        if (r < INPUT_COUNT) {
            values[i] = engine_input(model, r);
        } else if (r < INPUT_COUNT + OUTPUT_COUNT) {
            if (!found && !(found = engine_outputs(model)))
                return refuse(c, "the outputs cannot be computed");
            values[i] = found[r - INPUT_COUNT];
        } else if (r == INPUT_COUNT + OUTPUT_COUNT) {
            values[i] = engine_time(model);
        } else if (r < FIRST_STATE + STATE_COUNT) {
            values[i] = engine_states(model)[r - FIRST_STATE];
        } else if (r < FIRST_STATE + 2 * STATE_COUNT) {
            engine_rates(model, rates);
            values[i] = rates[r - FIRST_STATE - STATE_COUNT];
        } else {
            return refuse(c, "there is no such variable");
        }
    }
    return OK;
}

EXPORT status fmi3SetFloat64(void *c, const reference asked[], size_t count, const double values[], size_t given)
{
    engine *model = ((instance *)c)->model;

    if (given < count)
        return refuse(c, "there are too few values");
    for (size_t i = 0; i < count; i++) {
        if (!(values[i] - values[i] == 0.0))
            return refuse(c, "an input must be a finite number");
        if (asked[i] < INPUT_COUNT)
            engine_set_input(model, asked[i], values[i]);
        else if (asked[i] >= FIRST_STATE && asked[i] < FIRST_STATE + STATE_COUNT)
            engine_states(model)[asked[i] - FIRST_STATE] = values[i];
        else
            return refuse(c, "only inputs can be set");
    }
    return OK;
}

#define NONE_OF(kind, type)                                                                                            \
    EXPORT status fmi3Get##kind(void *c, const reference asked[], size_t count, type values[], size_t room)            \
    {                                                                                                                  \
        (void)asked, (void)values, (void)room;                                                                         \
        return count ? refuse(c, "all variables are Float64") : OK;                                                    \
    }                                                                                                                  \
    EXPORT status fmi3Set##kind(void *c, const reference asked[], size_t count, const type values[], size_t given)     \
    {                                                                                                                  \
        (void)asked, (void)values, (void)given;                                                                        \
        return count ? refuse(c, "all variables are Float64") : OK;                                                    \
    }
NONE_OF(Float32, float)
NONE_OF(Int8, int8_t)
NONE_OF(UInt8, uint8_t)
NONE_OF(Int16, int16_t)
NONE_OF(UInt16, uint16_t)
NONE_OF(Int32, int32_t)
NONE_OF(UInt32, uint32_t)
NONE_OF(Int64, int64_t)
NONE_OF(UInt64, uint64_t)
NONE_OF(Boolean, bool)
NONE_OF(String, text)

typedef const uint8_t *bytes;

EXPORT status fmi3GetBinary(void *c, const reference asked[], size_t count, size_t sizes[], bytes values[], size_t room)
{
    (void)asked, (void)sizes, (void)values, (void)room;
    return count ? refuse(c, "all variables are Float64") : OK;
}

EXPORT status fmi3SetBinary(void *c, const reference asked[], size_t count, const size_t sizes[], const bytes values[],
                            size_t given)
{
    (void)asked, (void)sizes, (void)values, (void)given;
    return count ? refuse(c, "all variables are Float64") : OK;
}

EXPORT status fmi3GetClock(void *c, const reference asked[], size_t count, bool values[])
{
    (void)asked, (void)values;
    return count ? refuse(c, "there are no clocks") : OK;
}

EXPORT status fmi3SetClock(void *c, const reference asked[], size_t count, const bool values[])
{
    (void)asked, (void)values;
    return count ? refuse(c, "there are no clocks") : OK;
}

EXPORT status fmi3GetNumberOfVariableDependencies(void *c, reference asked, size_t *count)
{
    (void)asked, (void)count;
    return refuse(c, "dependencies of variables are not told");
}

EXPORT status fmi3GetVariableDependencies(void *c, reference asked, size_t elements[], reference on[], size_t of[],
                                          int kinds[], size_t count)
{
    (void)asked, (void)elements, (void)on, (void)of, (void)kinds, (void)count;
    return refuse(c, "dependencies of variables are not told");
}

EXPORT status fmi3GetFMUState(void *c, void **kept)
{
    if (!KEEPS_STATES)
        return refuse(c, "states of a scene in Python cannot be got");
    if (!*kept && !(*kept = malloc(engine_state_size())))
        return refuse(c, "there is no memory for a state");
    engine_save(((instance *)c)->model, *kept);
    return OK;
}

EXPORT status fmi3SetFMUState(void *c, void *kept)
{
    engine_restore(((instance *)c)->model, kept);
    return OK;
}

EXPORT status fmi3FreeFMUState(void *c, void **kept)
{
    (void)c;
    free(*kept);
    *kept = NULL;
    return OK;
}

EXPORT status fmi3SerializedFMUStateSize(void *c, void *kept, size_t *size)
{
    (void)c, (void)kept;
    *size = state_bytes_size();
    return OK;
}

EXPORT status fmi3SerializeFMUState(void *c, void *kept, uint8_t to[], size_t size)
{
    if (size < state_bytes_size())
        return refuse(c, "there is too little room for a state");
    state_to_bytes(kept, to);
    return OK;
}

EXPORT status fmi3DeserializeFMUState(void *c, const uint8_t from[], size_t size, void **kept)
{
    char message[MESSAGE_SIZE];
    const void *state;

    if (!KEEPS_STATES)
        return refuse(c, "states of a scene in Python cannot be set");
    if (!(state = state_in_bytes(from, size, message)))
        return refuse(c, message);
    if (!*kept && !(*kept = malloc(engine_state_size())))
        return refuse(c, "there is no memory for a state");
    memcpy(*kept, state, engine_state_size());
    return OK;
}

#define NO_DERIVATIVE(name)                                                                                            \
    EXPORT status name(void *c, const reference unknown[], size_t unknowns, const reference known[], size_t knowns,    \
                       const double along[], size_t directions, double found[], size_t room)                           \
    {                                                                                                                  \
        (void)unknown, (void)unknowns, (void)known, (void)knowns;                                                      \
        (void)along, (void)directions, (void)found, (void)room;                                                        \
        return refuse(c, "there are no directional derivatives");                                                      \
    }
NO_DERIVATIVE(fmi3GetDirectionalDerivative)
NO_DERIVATIVE(fmi3GetAdjointDerivative)

/* Clocks, of which there are none: functions of references, a count and up to three arrays. */
#define NO_CLOCKS(name)                                                                                                \
    EXPORT status name(void *c, const reference asked[], size_t count, void *one, void *two, void *three)              \
    {                                                                                                                  \
        (void)asked, (void)one, (void)two, (void)three;                                                                \
        return count ? refuse(c, "there are no clocks") : OK;                                                          \
    }
NO_CLOCKS(fmi3GetIntervalDecimal)
NO_CLOCKS(fmi3GetIntervalFraction)
NO_CLOCKS(fmi3GetShiftDecimal)
NO_CLOCKS(fmi3GetShiftFraction)
NO_CLOCKS(fmi3SetIntervalDecimal)
NO_CLOCKS(fmi3SetIntervalFraction)
NO_CLOCKS(fmi3SetShiftDecimal)
NO_CLOCKS(fmi3SetShiftFraction)

EXPORT status fmi3ActivateModelPartition(void *c, reference clock, double t)
{
    (void)clock, (void)t;
    return refuse(c, "there are no clocks");
}

EXPORT status fmi3UpdateDiscreteStates(void *c, bool *again, bool *ends, bool *nominals, bool *values, bool *is_defined,
                                       double *t)
{
    (void)c, (void)t;
    *again = *ends = *nominals = *values = *is_defined = false;
    return OK;
}

EXPORT status fmi3CompletedIntegratorStep(void *c, bool keeps_state, bool *enters_events, bool *ends)
{
    (void)c, (void)keeps_state;
    *enters_events = *ends = false;
    return OK;
}

EXPORT status fmi3SetTime(void *c, double t)
{
    engine_set_time(((instance *)c)->model, t);
    return OK;
}

EXPORT status fmi3SetContinuousStates(void *c, const double x[], size_t count)
{
    if (count != STATE_COUNT)
        return refuse(c, "the number of states is another");
    if (count)
        memcpy(engine_states(((instance *)c)->model), x, count * sizeof *x);
    return OK;
}

EXPORT status fmi3GetContinuousStates(void *c, double x[], size_t count)
{
    if (count != STATE_COUNT)
        return refuse(c, "the number of states is another");
    if (count)
        memcpy(x, engine_states(((instance *)c)->model), count * sizeof *x);
    return OK;
}

EXPORT status fmi3GetContinuousStateDerivatives(void *c, double rates[], size_t count)
{
    if (count != STATE_COUNT)
        return refuse(c, "the number of states is another");
    engine_rates(((instance *)c)->model, rates);
    return OK;
}

EXPORT status fmi3GetEventIndicators(void *c, double values[], size_t count)
{
    (void)c, (void)values, (void)count;
    return OK;
}

EXPORT status fmi3GetNominalsOfContinuousStates(void *c, double x[], size_t count)
{
    (void)c;
    for (size_t i = 0; i < count; i++)
        x[i] = 1.0;
    return OK;
}

EXPORT status fmi3GetNumberOfEventIndicators(void *c, size_t *count)
{
    (void)c;
    *count = 0;
    return OK;
}

EXPORT status fmi3GetNumberOfContinuousStates(void *c, size_t *count)
{
    (void)c;
    *count = STATE_COUNT;
    return OK;
}

EXPORT status fmi3GetOutputDerivatives(void *c, const reference asked[], size_t count, const int32_t orders[],
                                       double values[], size_t room)
{
    (void)asked, (void)count, (void)orders, (void)values, (void)room;
    return refuse(c, "there are no derivatives of outputs");
}

EXPORT status fmi3DoStep(void *c, double t, double dt, bool keeps_state, bool *needs_events, bool *ends, bool *is_early,
                         double *reached)
{
    char message[MESSAGE_SIZE] = "";
    engine *model = ((instance *)c)->model;
    int failed;

    (void)keeps_state;
    *needs_events = *ends = *is_early = false;
    failed = step_from(model, t, dt, message);
    *reached = engine_time(model);
    return failed ? refuse(c, message) : OK;
}
