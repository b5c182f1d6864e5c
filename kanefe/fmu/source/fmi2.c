/* FMI 2.0: the functions of the standard, over a model. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "communication.h"
#include "engine.h"
#include "state_bytes.h"

#define EXPORT __attribute__((visibility("default")))

typedef void *component;
typedef unsigned int reference;
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } status;
typedef void (*logger_function)(void *, const char *, status, const char *, const char *, ...);

typedef struct {
    logger_function logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, status);
    void *environment;
} callbacks;

typedef struct {
    int new_discrete_states_needed, terminate_simulation, nominals_changed, values_changed, next_time_defined;
    double next_time;
} event_info;

typedef struct {
    engine *model;
    char *name;
    callbacks told; /* a copy: callers may not keep theirs */
    int is_logging;
} instance;

static status refuse(instance *of, const char *message)
{
    if (of->told.logger)
        of->told.logger(of->told.environment, of->name, ERROR, "logStatusError", "%s", message);
    return ERROR;
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT status fmi2SetDebugLogging(component c, int is_on, size_t count, const char *const categories[])
{
    (void)count, (void)categories;
    ((instance *)c)->is_logging = is_on;
    return OK;
}

EXPORT component fmi2Instantiate(const char *name, int kind, const char *token, const char *resources,
                                 const callbacks *told, int is_visible, int is_logging)
{
    char message[MESSAGE_SIZE] = "";
    instance *of = calloc(1, sizeof *of);

    (void)resources, (void)is_visible;
    if (!of)
        return NULL;
    if (told)
        of->told = *told;
    of->is_logging = is_logging;
    of->name = malloc(strlen(name ? name : "") + 1);
    if (of->name)
        strcpy(of->name, name ? name : "");
    if (kind != (IS_LINEAR ? 0 : 1))
        refuse(of, IS_LINEAR ? "this is a model for exchange" : "this is a model for co-simulation");
    else if (!token || strcmp(token, TOKEN))
        refuse(of, "the guid is not that of the model description");
    else if (!(of->model = engine_make(message)))
        refuse(of, message);
    if (!of->model) {
        free(of->name);
        free(of);
        return NULL;
    }
    return of;
}

EXPORT void fmi2FreeInstance(component c)
{
    instance *of = c;

    if (!of)
        return;
    engine_free(of->model);
    free(of->name);
    free(of);
}

EXPORT status fmi2SetupExperiment(component c, int has_tolerance, double tolerance, double start, int has_stop, double stop)
{
    char message[MESSAGE_SIZE] = "";

    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    return engine_begin_at(((instance *)c)->model, start, message) ? refuse(c, message) : OK;
}

EXPORT status fmi2EnterInitializationMode(component c) { (void)c; return OK; }
EXPORT status fmi2ExitInitializationMode(component c) { (void)c; return OK; }
EXPORT status fmi2Terminate(component c) { (void)c; return OK; }

EXPORT status fmi2Reset(component c)
{
    engine_reset(((instance *)c)->model);
    return OK;
}

EXPORT status fmi2GetReal(component c, const reference asked[], size_t count, double values[])
{
    engine *model = ((instance *)c)->model;
    double rates[STATE_COUNT + 1];
    const double *found = NULL;

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

EXPORT status fmi2SetReal(component c, const reference asked[], size_t count, const double values[])
{
    engine *model = ((instance *)c)->model;

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
    EXPORT status fmi2Get##kind(component c, const reference asked[], size_t count, type values[])                     \
    {                                                                                                                  \
        (void)asked, (void)values;                                                                                     \
        return count ? refuse(c, "all variables are real") : OK;                                                       \
    }                                                                                                                  \
    EXPORT status fmi2Set##kind(component c, const reference asked[], size_t count, const type values[])               \
    {                                                                                                                  \
        (void)asked, (void)values;                                                                                     \
        return count ? refuse(c, "all variables are real") : OK;                                                       \
    }

typedef const char *text;
NONE_OF(Integer, int)
NONE_OF(Boolean, int)
NONE_OF(String, text)

EXPORT status fmi2GetFMUstate(component c, void **kept)
{
    if (!KEEPS_STATES)
        return refuse(c, "states of a scene in Python cannot be got");
    if (!*kept && !(*kept = malloc(engine_state_size())))
        return refuse(c, "there is no memory for a state");
    engine_save(((instance *)c)->model, *kept);
    return OK;
}

EXPORT status fmi2SetFMUstate(component c, void *kept)
{
    engine_restore(((instance *)c)->model, kept);
    return OK;
}

EXPORT status fmi2FreeFMUstate(component c, void **kept)
{
    (void)c;
    free(*kept);
    *kept = NULL;
    return OK;
}

EXPORT status fmi2SerializedFMUstateSize(component c, void *kept, size_t *size)
{
    (void)c, (void)kept;
    *size = state_bytes_size();
    return OK;
}

EXPORT status fmi2SerializeFMUstate(component c, void *kept, char bytes[], size_t size)
{
    if (size < state_bytes_size())
        return refuse(c, "there is too little room for a state");
    state_to_bytes(kept, bytes);
    return OK;
}

EXPORT status fmi2DeSerializeFMUstate(component c, const char bytes[], size_t size, void **kept)
{
    char message[MESSAGE_SIZE];
    const void *state;

    if (!KEEPS_STATES)
        return refuse(c, "states of a scene in Python cannot be set");
    if (!(state = state_in_bytes(bytes, size, message)))
        return refuse(c, message);
    if (!*kept && !(*kept = malloc(engine_state_size())))
        return refuse(c, "there is no memory for a state");
    memcpy(*kept, state, engine_state_size());
    return OK;
}

EXPORT status fmi2GetDirectionalDerivative(component c, const reference unknown[], size_t unknowns,
                                           const reference known[], size_t knowns, const double along[], double found[])
{
    (void)unknown, (void)unknowns, (void)known, (void)knowns, (void)along, (void)found;
    return refuse(c, "there are no directional derivatives");
}

#if IS_LINEAR

EXPORT status fmi2EnterEventMode(component c) { (void)c; return OK; }
EXPORT status fmi2EnterContinuousTimeMode(component c) { (void)c; return OK; }

EXPORT status fmi2NewDiscreteStates(component c, event_info *info)
{
    (void)c;
    memset(info, 0, sizeof *info);
    return OK;
}

EXPORT status fmi2CompletedIntegratorStep(component c, int keeps_state, int *enters_events, int *ends)
{
    (void)c, (void)keeps_state;
    *enters_events = *ends = 0;
    return OK;
}

EXPORT status fmi2SetTime(component c, double t)
{
    engine_set_time(((instance *)c)->model, t);
    return OK;
}

EXPORT status fmi2SetContinuousStates(component c, const double x[], size_t count)
{
    memcpy(engine_states(((instance *)c)->model), x, count * sizeof *x);
    return OK;
}

EXPORT status fmi2GetContinuousStates(component c, double x[], size_t count)
{
    memcpy(x, engine_states(((instance *)c)->model), count * sizeof *x);
    return OK;
}

EXPORT status fmi2GetDerivatives(component c, double rates[], size_t count)
{
    (void)count;
    engine_rates(((instance *)c)->model, rates);
    return OK;
}

EXPORT status fmi2GetEventIndicators(component c, double values[], size_t count)
{
    (void)c, (void)values, (void)count;
    return OK;
}

EXPORT status fmi2GetNominalsOfContinuousStates(component c, double x[], size_t count)
{
    (void)c;
    for (size_t i = 0; i < count; i++)
        x[i] = 1.0;
    return OK;
}

#else

EXPORT status fmi2DoStep(component c, double t, double dt, int is_final)
{
    char message[MESSAGE_SIZE] = "";

    (void)is_final;
    return step_from(((instance *)c)->model, t, dt, message) ? refuse(c, message) : OK;
}

EXPORT status fmi2SetRealInputDerivatives(component c, const reference asked[], size_t count, const int order[],
                                          const double values[])
{
    (void)asked, (void)count, (void)order, (void)values;
    return refuse(c, "inputs are held over a step");
}

EXPORT status fmi2GetRealOutputDerivatives(component c, const reference asked[], size_t count, const int order[],
                                           double values[])
{
    (void)asked, (void)count, (void)order, (void)values;
    return refuse(c, "there are no derivatives of outputs");
}

EXPORT status fmi2CancelStep(component c) { return refuse(c, "a step is done when it returns"); }

#define NO_STATUS(kind, type)                                                                                          \
    EXPORT status fmi2Get##kind(component c, int what, type *value)                                                    \
    {                                                                                                                  \
        (void)c, (void)what, (void)value;                                                                              \
        return DISCARD;                                                                                                \
    }
NO_STATUS(Status, status)
NO_STATUS(IntegerStatus, int)
NO_STATUS(BooleanStatus, int)
NO_STATUS(StringStatus, text)

EXPORT status fmi2GetRealStatus(component c, int what, double *value)
{
    if (what != 2) /* the last successful time */
        return DISCARD;
    *value = engine_time(((instance *)c)->model);
    return OK;
}

#endif
