/* A scene: its tables as an image of memory, and the kernels of kanefe that step it. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine.h"

__asm__(".section .rodata\n"
        ".balign 64\n"
        ".type kanefe_image, @object\n"
        "kanefe_image:\n"
        ".incbin \"image.bin\"\n"
        ".previous\n");
extern const unsigned char kanefe_image[] __attribute__((visibility("hidden")));

typedef void (*kernel)(int64_t *places, double *numbers);

static kernel functions[FUNCTION_COUNT + 1];
static char not_loaded[MESSAGE_SIZE];
static pthread_once_t once = PTHREAD_ONCE_INIT;

struct engine {
    unsigned char *image;
    unsigned char *before; /* the state before a step */
    unsigned char *aside;  /* the state to which outputs under new inputs return */
    double inputs[INPUT_COUNT + 1];
    double held[INPUT_COUNT + 1];
    double outputs[OUTPUT_COUNT + 1];
    int64_t has_begun;
    int is_read, has_numbers;
};

static void load(void)
{
    Dl_info here;
    char path[4096];
    size_t folder;

    if (!dladdr((void *)load, &here) || strlen(here.dli_fname) > 3800) {
        snprintf(not_loaded, MESSAGE_SIZE, "the folder of this library is not known");
        return;
    }
    strcpy(path, here.dli_fname);
    folder = strrchr(path, '/') ? (size_t)(strrchr(path, '/') - path) + 1 : 0;
    for (int i = 0; i < FUNCTION_COUNT; i++) {
        void *library;
        snprintf(path + folder, sizeof path - folder, "%s", FUNCTION_FILES[i]);
        library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
        functions[i] = library ? (kernel)dlsym(library, FUNCTION_NAMES[i]) : NULL;
        if (!functions[i]) {
            snprintf(not_loaded, MESSAGE_SIZE, "a kernel cannot be loaded: %.400s", dlerror());
            return;
        }
    }
}

static void *at(const engine *e, int64_t place) { return e->image + place; }

static double *vector(engine *e, int row) { return (double *)at(e, AT_VECTORS) + (int64_t)row * SIZE; }

/* The state that is reached, its loops closed: the method itself goes on with one whose loops may be a little open. */
static const double *state_of(engine *e) { return e->has_begun ? (double *)at(e, AT_STATES) : vector(e, STATE); }

static void unpack(engine *e)
{
    memcpy(e->image, kanefe_image, IMAGE_BYTES);
    for (int64_t i = 0; i < POINTER_COUNT; i++)
        *(uint64_t *)at(e, POINTERS[i][0]) = (uint64_t)(uintptr_t)at(e, POINTERS[i][1]);
    for (int64_t i = 0; i < CALLED_COUNT; i++)
        *(uint64_t *)at(e, CALLED[i][0]) = (uint64_t)(uintptr_t)functions[CALLED[i][1]];
    for (int i = 0; i < INPUT_COUNT; i++)
        e->inputs[i] = e->held[i] = INPUT_STARTS[i];
    e->has_begun = 0;
    e->is_read = 0;
}

engine *engine_make(char *message)
{
    engine *e;

    pthread_once(&once, load);
    if (not_loaded[0]) {
        strcpy(message, not_loaded);
        return NULL;
    }
    e = calloc(1, sizeof *e);
    if (e) {
        e->image = aligned_alloc(64, (IMAGE_BYTES + 63) / 64 * 64);
        e->before = malloc(engine_state_size());
        e->aside = malloc(engine_state_size());
    }
    if (!e || !e->image || !e->before || !e->aside) {
        strcpy(message, "there is no memory for the scene");
        engine_free(e);
        return NULL;
    }
    unpack(e);
    return e;
}

void engine_free(engine *e)
{
    if (e) {
        free(e->image);
        free(e->before);
        free(e->aside);
        free(e);
    }
}

void engine_reset(engine *e) { unpack(e); }

double engine_input(const engine *e, size_t i) { return e->inputs[i]; }

void engine_set_input(engine *e, size_t i, double x)
{
    e->inputs[i] = x;
    e->is_read = 0;
}

double engine_time(const engine *e) { return ((double *)at(e, AT_REALS))[TIME]; }


int engine_begin_at(engine *e, double t, char *message)
{
    double *reals = at(e, AT_REALS);

    if (t == reals[TIME])
        return 0;
    if (KNOWS_TIME) {
        snprintf(message, MESSAGE_SIZE,
                 "motions of the scene are given in time: it was exported to begin at %g s, and cannot at %g s. "
                 "Remedy: scene.to_fmu(path, t=%g)", reals[TIME], t, t);
        return 1;
    }
    e->is_read = 0;
    reals[TIME] = reals[TIME_OLD] = t;
    reals[SMALLEST] = fmax(reals[SMALLEST], SMALLEST_STEP * fabs(t));
    for (int i = 0; i < COURSE_COUNT; i++)
        ((double *)at(e, AT_PIECES))[COURSES[i] * PIECE_NUMBERS] = t;
    return 0;
}

void engine_set_time(engine *e, double t) { (void)e, (void)t; }

/* What of the image a run changes. */
size_t engine_state_size(void)
{
    size_t size = sizeof(double[2 * INPUT_COUNT]) + sizeof(int64_t);

    for (int i = 0; i < KEPT_COUNT; i++)
        size += (size_t)KEPT[i][1];
    return size;
}

void engine_save(const engine *e, void *kept)
{
    unsigned char *to = kept;

    memcpy(to, e->inputs, sizeof(double[INPUT_COUNT]));
    to += sizeof(double[INPUT_COUNT]);
    memcpy(to, e->held, sizeof(double[INPUT_COUNT]));
    to += sizeof(double[INPUT_COUNT]);
    memcpy(to, &e->has_begun, sizeof e->has_begun);
    to += sizeof e->has_begun;
    for (int i = 0; i < KEPT_COUNT; to += KEPT[i++][1])
        memcpy(to, at(e, KEPT[i][0]), (size_t)KEPT[i][1]);
}

void engine_restore(engine *e, const void *kept)
{
    const unsigned char *from = kept;

    memcpy(e->inputs, from, sizeof(double[INPUT_COUNT]));
    from += sizeof(double[INPUT_COUNT]);
    memcpy(e->held, from, sizeof(double[INPUT_COUNT]));
    from += sizeof(double[INPUT_COUNT]);
    memcpy(&e->has_begun, from, sizeof e->has_begun);
    from += sizeof e->has_begun;
    for (int i = 0; i < KEPT_COUNT; from += KEPT[i++][1])
        memcpy(at(e, KEPT[i][0]), from, (size_t)KEPT[i][1]);
    e->is_read = 0;
}

static void call(engine *e, const int64_t *of)
{
    functions[of[CALL_FUNCTION]](at(e, of[CALL_PLACES]), at(e, of[CALL_NUMBERS]));
}

/* Writes what is held in the state z to the values of loads. */
static void put_held(engine *e, int64_t values, const double *y)
{
    double *to = at(e, values);

    for (int i = 0; i < HELD_COUNT; i++)
        to[HELD_PLACES[i][0]] = HELD_FACTORS[i] * y[HELD_PLACES[i][1]];
}

/* Writes position, speed and acceleration of driven coordinates, as the kernel put_drives does. */
static void put_drives(engine *e, double t, int64_t values)
{
    const int64_t *motions = at(e, AT_MOTIONS);
    const double *pieces = at(e, AT_PIECES), *spans = at(e, AT_SPANS);
    double *drives = at(e, values);

    for (int i = 0; i < DRIVEN; i++) {
        int64_t low = motions[2 * i], high = low + motions[2 * i + 1];
        const double *c;
        double s;

        if (!(spans[2 * i] <= t && t <= spans[2 * i + 1])) {
            drives[3 * i] = drives[3 * i + 1] = drives[3 * i + 2] = NAN;
            continue;
        }
        while (high - low > 1) {
            int64_t middle = (low + high) / 2;
            if (pieces[middle * PIECE_NUMBERS] <= t)
                low = middle;
            else
                high = middle;
        }
        c = pieces + low * PIECE_NUMBERS + 1;
        s = t - c[-1];
        drives[3 * i] = ((c[3] * s + c[2]) * s + c[1]) * s + c[0];
        drives[3 * i + 1] = (3.0 * c[3] * s + 2.0 * c[2]) * s + c[1];
        drives[3 * i + 2] = 6.0 * c[3] * s + 2.0 * c[2];
        for (int k = 0; k < COURSE_COUNT; k++) /* the course goes on from here with the present input */
            if (COURSES[k] == motions[2 * i])
                drives[3 * i + 2] = e->inputs[LOAD_COUNT + k];
    }
}

/* Has inputs act from now on: the method goes on from there with what it knows of the scene. */
static void hold(engine *e)
{
    double *reals = at(e, AT_REALS), *pieces = at(e, AT_PIECES), *y = vector(e, STATE), t = reals[TIME];
    int64_t *integers = at(e, AT_INTEGERS);

    if (e->has_begun)
        memcpy(y, state_of(e), sizeof(double[SIZE]));
    for (int i = 0; i < LOAD_COUNT; i++)
        y[FIRST_HELD + i] = e->inputs[i];
    for (int i = 0; i < COURSE_COUNT; i++) {
        double *piece = pieces + COURSES[i] * PIECE_NUMBERS, s = t - piece[0];
        double x = (piece[3] * s + piece[2]) * s + piece[1], v = piece[2] + 2.0 * piece[3] * s;
        piece[0] = t, piece[1] = x, piece[2] = v, piece[3] = 0.5 * e->inputs[LOAD_COUNT + i], piece[4] = 0.0;
    }
    memcpy(e->held, e->inputs, sizeof e->held);
    reals[TIME_OLD] = t;
    reals[TIME_EXCESS] = 0.0;
    reals[TO_EVENT] = INFINITY;
    integers[COMMAND] = START;
    integers[STAGE] = 0;
    integers[CONTINUES] = integers[STEPS] > 0;
}

static int failed(engine *e, const char *why, char *message)
{
    snprintf(message, MESSAGE_SIZE, "at t = %.6g s %s", engine_time(e), why);
    engine_restore(e, e->before);
    return 1;
}

/* Goes on to the next time of the step and returns the command of the method; events that end steps are passed in there. */
static int go_on(engine *e)
{
#if HAS_EVENTS
    const double *found = (const double *)at(e, PASS_STEPS[CALL_NUMBERS]) + PASS_STEPS[CALL_RESULT];
    const double *times = at(e, AT_REALS);
    int command;

    do { /* until records of what happened, which nobody asks for, no longer fill their room */
        *(int64_t *)at(e, AT_EVENT_COUNTS) = 0;
        call(e, PASS_STEPS);
        command = (int)found[0];
    } while (command == ACCEPTED && found[1] != 0.0 && times[TIME] < times[STOP]);
    return command == ACCEPTED && found[1] == 0.0 ? FAILED : command;
#else
    call(e, INTEGRATE);
    return (int)((double *)at(e, INTEGRATE[CALL_NUMBERS]))[INTEGRATE[CALL_RESULT]];
#endif
}

int engine_step(engine *e, double dt, char *message)
{
    int64_t *integers = at(e, AT_INTEGERS);
    double *reals = at(e, AT_REALS), stop = reals[TIME] + dt;
    static const int64_t most = (int64_t)1 << 40;
    int command;

    engine_save(e, e->before);
    if (!e->has_begun || memcmp(e->inputs, e->held, sizeof(double[INPUT_COUNT])))
        hold(e);
    reals[STOP] = stop;
    reals[SMALLEST] = fmax(reals[SMALLEST], SMALLEST_STEP * fabs(stop));
    reals[NEXT_OUTPUT] = *(double *)at(e, AT_TIMES) = stop;
    integers[STORED] = integers[IS_LEFT_OPEN] = 0;
    integers[WANTS_DENSE] = HAS_EVENTS;
#if HAS_EVENTS
    ((int64_t *)at(e, PASS_STEPS[CALL_PLACES]))[MOST_STEPS_OVER_EVENTS] = integers[STEPS] + most;
#else
    ((int64_t *)at(e, INTEGRATE[CALL_PLACES]))[MOST_STEPS] = integers[STEPS] + most;
#endif
    put_held(e, AT_INPUTS, vector(e, STATE));
    command = go_on(e);
    if (command == JACOBIAN)
        return failed(e, "the derivatives of the rates are no numbers", message);
    if (command == FAILED)
        return failed(e, "no step is small enough: the motion grows without bound, or a force jumps", message);
    if (command == NO_INERTIA)
        return failed(e, "something has no inertia", message);
    if (command != ACCEPTED && command != DONE)
        return failed(e, "a mechanism is at a singular position, or cannot be closed", message);
    if (reals[TIME] < stop)
        return failed(e, "the step did not come to its end", message);
    e->has_begun = 1;
    e->is_read = 0;
    return 0;
}

static void turned(const double *A, const double *x, double *out) /* A x */
{
    for (int i = 0; i < 3; i++)
        out[i] = A[3 * i] * x[0] + A[3 * i + 1] * x[1] + A[3 * i + 2] * x[2];
}

static void turned_back(const double *A, const double *x, double *out) /* A^T x */
{
    for (int i = 0; i < 3; i++)
        out[i] = A[i] * x[0] + A[3 + i] * x[1] + A[6 + i] * x[2];
}

static void crossed(const double *a, const double *b, double *out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void product(const double *A, const double *B, double *out)
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            out[3 * i + k] = A[3 * i] * B[k] + A[3 * i + 1] * B[3 + k] + A[3 * i + 2] * B[6 + k];
}

/* The logarithm of a rotation: by the largest of its Euler parameters, so that none is singular. */
static void rotation_vector(const double *A, double *out)
{
    double trace = A[0] + A[4] + A[8], squares[4], e[4], norm = 0.0, sine, share;
    int largest = 0;

    squares[0] = 1.0 + trace;
    for (int i = 0; i < 3; i++)
        squares[i + 1] = 2.0 * A[4 * i] - trace + 1.0;
    for (int i = 1; i < 4; i++)
        largest = squares[i] > squares[largest] ? i : largest;
    {
        double K[4][4] = {
            {squares[0], A[7] - A[5], A[2] - A[6], A[3] - A[1]},
            {A[7] - A[5], squares[1], A[1] + A[3], A[2] + A[6]},
            {A[2] - A[6], A[1] + A[3], squares[2], A[5] + A[7]},
            {A[3] - A[1], A[2] + A[6], A[5] + A[7], squares[3]},
        };
        memcpy(e, K[largest], sizeof e);
    }
    for (int i = 0; i < 4; i++)
        norm += e[i] * e[i];
    norm = e[0] < 0.0 ? -sqrt(norm) : sqrt(norm);
    for (int i = 0; i < 4; i++)
        e[i] /= norm;
    sine = sqrt(e[1] * e[1] + e[2] * e[2] + e[3] * e[3]);
    share = sine < 1e-8 * e[0] ? 2.0 / e[0] : 2.0 * atan2(sine, e[0]) / sine;
    for (int i = 0; i < 3; i++)
        out[i] = share * e[i + 1];
}

/* Writes a vector of the motion of a frame, in components of N. */
static void of_frame(const double *row, const frame *f, int what, double *out)
{
    const double *p = row, *R = row + 3, *v = row + 12, *w = row + 15, *a = row + 18, *alpha = row + 21;
    double lever[3], swing[3], more[3], A[9];

    turned(R, f->place, lever);
    switch (what) {
    case POSITION:
        for (int i = 0; i < 3; i++)
            out[i] = p[i] + lever[i];
        return;
    case ROTATION:
        product(R, f->axes, A);
        rotation_vector(A, out);
        return;
    case VELOCITY:
        crossed(w, lever, swing);
        for (int i = 0; i < 3; i++)
            out[i] = v[i] + swing[i];
        return;
    case ANGULAR_VELOCITY:
        memcpy(out, w, sizeof(double[3]));
        return;
    case ACCELERATION:
        crossed(w, lever, swing);
        crossed(w, swing, more);
        crossed(alpha, lever, swing);
        for (int i = 0; i < 3; i++)
            out[i] = a[i] + swing[i] + more[i];
        return;
    default:
        memcpy(out, alpha, sizeof(double[3]));
    }
}

static int put_motions(engine *e, const double *y)
{
#if HAS_FRAMES
    double t = engine_time(e);

    put_drives(e, t, AT_MOTION_DRIVES);
    memcpy(at(e, AT_MOTION_STATE), y, sizeof(double[SIZE - WORKS]));
#if HAS_ACCELERATIONS
    {
        double *numbers = at(e, EVALUATE[CALL_NUMBERS]), *state = at(e, AT_EVALUATED);

        memcpy(state, y, sizeof(double[SIZE]));
        put_drives(e, t, AT_EVALUATED_DRIVES);
        put_held(e, AT_EVALUATED_INPUTS, y);
        numbers[AT_TIME] = t;
        call(e, EVALUATE);
        if (numbers[EVALUATE[CALL_RESULT]] < 0.0)
            return 1;
        memcpy(at(e, AT_MOTION_RATES), state + SIZE + COORDINATE_COUNT, sizeof(double[SPEED_COUNT]));
    }
#endif
    call(e, MOVE);
#else
    (void)e, (void)y;
#endif
    return 0;
}

/* Writes forces and outputs of loads; not 0 where they are not determined. */
static int put_forces(engine *e, const double *y)
{
#if CAN_TELL_FORCES || CAN_TELL_LOADS
    double t = engine_time(e);

    *(double *)at(e, AT_TOLD_TIME) = t;
    put_drives(e, t, AT_TOLD_DRIVES);
    put_held(e, AT_TOLD_INPUTS, y);
    memcpy(at(e, AT_TOLD_STATE), y, sizeof(double[SIZE - WORKS]));
#else
    (void)e, (void)y;
#endif
#if CAN_TELL_FORCES
    call(e, TELL_FORCES);
    if (!*(int64_t *)at(e, AT_IS_TOLD))
        return 1;
#endif
#if CAN_TELL_LOADS
    call(e, TELL_LOADS);
#endif
    return 0;
}

static int read_outputs(engine *e)
{
    const double *rows = NULL;
    double y[SIZE];

    memcpy(y, state_of(e), sizeof y);
    for (int i = 0; i < LOAD_COUNT; i++) /* also those that were set after the last step */
        y[FIRST_HELD + i] = e->inputs[i];
    if (put_motions(e, y) || put_forces(e, y))
        return 1;
#if HAS_FRAMES
    rows = at(e, AT_MOTION_FOUND);
#endif
    (void)rows;
    if (DRIVEN)
        put_drives(e, engine_time(e), AT_OUTPUT_DRIVES);
    for (int i = 0; i < OUTPUT_COUNT; i++) {
        const output *o = &OUTPUTS[i];

        if (o->what == IN_STATE) {
            e->outputs[i] = y[o->place];
        } else if (o->what == DRIVE) {
            e->outputs[i] = ((double *)at(e, AT_OUTPUT_DRIVES))[o->place];
#if CAN_TELL_FORCES
        } else if (o->what == IN_FORCES) { /* of an interface parts are added up */
            const double *forces = (double *)at(e, AT_FORCES) + o->place;

            e->outputs[i] = 0.0;
            for (int k = 0; k < o->other; k++)
                e->outputs[i] += forces[6 * k];
#endif
#if CAN_TELL_LOADS
        } else if (o->what == IN_LOADS) {
            e->outputs[i] = ((double *)at(e, AT_LOADS))[o->place];
#endif
        } else {
#if HAS_FRAMES
            const frame *f = &FRAMES[o->place];
            const double *row = rows + (int64_t)f->row * ROW_NUMBERS;
            double x[3], own[3], A[9];

            if (o->what == DEFLECTION) { /* where the frame is in G, over where it was */
                const frame *g = &FRAMES[o->other];
                const double *body = rows + (int64_t)g->row * ROW_NUMBERS;
                double from[3], way[3];

                of_frame(row, f, POSITION, x);
                of_frame(body, g, POSITION, from);
                for (int k = 0; k < 3; k++)
                    way[k] = x[k] - from[k];
                product(body + 3, g->axes, A);
                turned_back(A, way, own);
                e->outputs[i] = own[o->component] - o->offset;
                continue;
            }
            of_frame(row, f, o->what, x);
            if (o->is_own) {
                product(row + 3, f->axes, A);
                turned_back(A, x, own);
                memcpy(x, own, sizeof x);
            }
            e->outputs[i] = x[o->component];
#endif
        }
    }
    return 0;
}

const double *engine_outputs(engine *e)
{
    int is_without = 1;

    if (!e->is_read) {
#if HAS_EVENTS
        if (memcmp(e->inputs, e->held, sizeof(double[INPUT_COUNT]))) { /* what sticks may slip now: a step tells */
            char message[MESSAGE_SIZE];

            engine_save(e, e->aside);
            is_without = engine_step(e, LITTLE, message) || read_outputs(e);
            engine_restore(e, e->aside);
        } else
#endif
            is_without = read_outputs(e);
        e->is_read = 1;
        e->has_numbers = !is_without;
    }
    return e->has_numbers ? e->outputs : NULL;
}

double *engine_states(engine *e)
{
    (void)e;
    return NULL;
}

void engine_rates(engine *e, double *rates) { (void)e, (void)rates; }
