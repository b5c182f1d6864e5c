/* What the functions of the standard (fmi2.c, fmi3.c) ask of a model: a scene (scene.c) or a linear system (linear.c). */
#ifndef ENGINE_H
#define ENGINE_H

#include <stddef.h>

#include "model.h"

#define MESSAGE_SIZE 512

typedef struct engine engine;

/* Makes a model at its start; none, with a message, if its kernels cannot be loaded. */
engine *engine_make(char *message);
void engine_free(engine *e);
void engine_reset(engine *e);

/* Lets the model begin at another time (s); not 0 if it cannot. */
int engine_begin_at(engine *e, double t, char *message);

/* Goes on by a time (s); not 0 if that fails, and then all is as it was. */
int engine_step(engine *e, double dt, char *message);

double engine_time(const engine *e);
void engine_set_time(engine *e, double t);
double engine_input(const engine *e, size_t i);
void engine_set_input(engine *e, size_t i, double x);
/* Returns all outputs of the present state and inputs, NULL if they cannot be had. */
const double *engine_outputs(engine *e);

size_t engine_state_size(void);
void engine_save(const engine *e, void *kept);
void engine_restore(engine *e, const void *kept);

/* Of a linear system, which is integrated from outside. */
double *engine_states(engine *e);
void engine_rates(engine *e, double *rates);

#endif
