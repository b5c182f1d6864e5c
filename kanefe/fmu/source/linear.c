/* A linear system: dx/dt = A x + B u, y = y0 + C x + D u. */
#include <stdlib.h>
#include <string.h>

#include "engine.h"

struct engine {
    double x[STATE_COUNT + 1];
    double inputs[INPUT_COUNT + 1];
    double t;
    double outputs[OUTPUT_COUNT + 1];
};

engine *engine_make(char *message)
{
    engine *e = calloc(1, sizeof *e);

    if (!e)
        strcpy(message, "there is no memory for the system");
    return e;
}

void engine_free(engine *e) { free(e); }
void engine_reset(engine *e) { memset(e, 0, sizeof *e); }
double engine_input(const engine *e, size_t i) { return e->inputs[i]; }
void engine_set_input(engine *e, size_t i, double x) { e->inputs[i] = x; }
double *engine_states(engine *e) { return e->x; }
double engine_time(const engine *e) { return e->t; }
void engine_set_time(engine *e, double t) { e->t = t; }

int engine_begin_at(engine *e, double t, char *message)
{
    (void)message;
    e->t = t;
    return 0;
}

int engine_step(engine *e, double dt, char *message)
{
    (void)e, (void)dt;
    strcpy(message, "a linear system is integrated from outside");
    return 1;
}

static void weigh(const double *left, const double *right, const engine *e, int rows, double *out)
{
    for (int i = 0; i < rows; i++) {
        double sum = 0.0;
        for (int k = 0; k < STATE_COUNT; k++)
            sum += left[i * STATE_COUNT + k] * e->x[k];
        for (int k = 0; k < INPUT_COUNT; k++)
            sum += right[i * INPUT_COUNT + k] * e->inputs[k];
        out[i] = sum;
    }
}

void engine_rates(engine *e, double *rates) { weigh(MATRIX_A, MATRIX_B, e, STATE_COUNT, rates); }

const double *engine_outputs(engine *e)
{
    weigh(MATRIX_C, MATRIX_D, e, OUTPUT_COUNT, e->outputs);
    for (int i = 0; i < OUTPUT_COUNT; i++)
        e->outputs[i] += OFFSETS[i];
    return e->outputs;
}

size_t engine_state_size(void) { return sizeof(struct engine); }
void engine_save(const engine *e, void *kept) { memcpy(kept, e, sizeof *e); }
void engine_restore(engine *e, const void *kept) { memcpy(e, kept, sizeof *e); }
