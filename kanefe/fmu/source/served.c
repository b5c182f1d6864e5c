/* A scene with functions in Python: a process of Python with kanefe steps it, and is asked over a socket. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine.h"

enum { RESET, BEGIN_AT, STEP, OUTPUTS };

struct engine {
    pid_t server;
    int line;
    double inputs[INPUT_COUNT + 1];
    double outputs[OUTPUT_COUNT + 1];
    double t;
    int is_read, has_numbers;
};

static int put(int line, const void *bytes, size_t size)
{
    for (const char *from = bytes; size > 0;) {
        ssize_t sent = send(line, from, size, MSG_NOSIGNAL);
        if (sent <= 0)
            return 1;
        from += sent;
        size -= (size_t)sent;
    }
    return 0;
}

static int take(int line, void *bytes, size_t size)
{
    for (char *to = bytes; size > 0;) {
        ssize_t taken = recv(line, to, size, 0);
        if (taken <= 0)
            return 1;
        to += taken;
        size -= (size_t)taken;
    }
    return 0;
}

/* Asks the server with some numbers; not 0, with a message, if it refuses. */
static int ask(engine *e, int64_t what, const double *numbers, int64_t count, double *found, int64_t wanted, char *message)
{
    int64_t asked[2] = {what, count}, told[2];

    if (put(e->line, asked, sizeof asked) || put(e->line, numbers, (size_t)count * sizeof(double)) ||
        take(e->line, told, sizeof told)) {
        snprintf(message, MESSAGE_SIZE,
                 "this unit needs kanefe, and Python does not answer. Remedy: the variable KANEFE_PYTHON, a Python that "
                 "has kanefe %s", VERSION);
        return 1;
    }
    if (told[0]) {
        size_t size = (size_t)told[1], kept = size < MESSAGE_SIZE - 1 ? size : MESSAGE_SIZE - 1;
        char rest;
        if (take(e->line, message, kept))
            return 1;
        message[kept] = 0;
        for (size_t i = kept; i < size; i++)
            if (take(e->line, &rest, 1))
                return 1;
        return 1;
    }
    return told[1] != wanted || take(e->line, found, (size_t)wanted * sizeof(double));
}

static void run_server(int line, const char *scene)
{
    const char *wanted[] = {getenv("KANEFE_PYTHON"), PYTHON, "python3"};
    char number[16];

    snprintf(number, sizeof number, "%d", line);
    for (int i = 0; i < 3; i++)
        if (wanted[i] && (i == 2 || access(wanted[i], X_OK) == 0))
            execlp(wanted[i], wanted[i], "-m", "kanefe.fmu.serve", number, scene, (char *)NULL);
    _exit(127);
}

engine *engine_make(char *message)
{
    Dl_info here;
    char scene[4200];
    int lines[2];
    engine *e = calloc(1, sizeof *e);

    if (!e || !dladdr((void *)engine_make, &here) || strlen(here.dli_fname) > 4000 ||
        socketpair(AF_UNIX, SOCK_STREAM, 0, lines)) {
        strcpy(message, "there is no memory, or no socket, for the scene");
        free(e);
        return NULL;
    }
    strcpy(scene, here.dli_fname);
    if (strrchr(scene, '/'))
        *strrchr(scene, '/') = 0;
    strcat(scene, "/../../resources/scene.pickle");
    e->server = fork();
    if (e->server == 0) {
        close(lines[0]);
        run_server(lines[1], scene);
    }
    close(lines[1]);
    e->line = lines[0];
    if (e->server < 0 || ask(e, RESET, NULL, 0, e->inputs, INPUT_COUNT, message)) {
        engine_free(e);
        return NULL;
    }
    e->t = START;
    return e;
}

void engine_free(engine *e)
{
    if (!e)
        return;
    close(e->line); /* at which the server ends */
    if (e->server > 0)
        waitpid(e->server, NULL, 0);
    free(e);
}

void engine_reset(engine *e)
{
    char message[MESSAGE_SIZE];

    ask(e, RESET, NULL, 0, e->inputs, INPUT_COUNT, message);
    e->t = START;
    e->is_read = 0;
}

int engine_begin_at(engine *e, double t, char *message)
{
    double at_start[INPUT_COUNT + 1]; /* inputs that are set already stay */

    if (t == e->t)
        return 0;
    if (ask(e, BEGIN_AT, &t, 1, at_start, INPUT_COUNT, message))
        return 1;
    e->t = t;
    e->is_read = 0;
    return 0;
}

int engine_step(engine *e, double dt, char *message)
{
    double asked[INPUT_COUNT + 1];

    asked[0] = dt;
    memcpy(asked + 1, e->inputs, sizeof(double[INPUT_COUNT]));
    e->is_read = 0;
    return ask(e, STEP, asked, INPUT_COUNT + 1, &e->t, 1, message);
}

const double *engine_outputs(engine *e)
{
    char message[MESSAGE_SIZE];

    if (!e->is_read) {
        e->is_read = 1;
        e->has_numbers = !ask(e, OUTPUTS, e->inputs, INPUT_COUNT, e->outputs, OUTPUT_COUNT, message);
    }
    return e->has_numbers ? e->outputs : NULL;
}

double engine_time(const engine *e) { return e->t; }
void engine_set_time(engine *e, double t) { (void)e, (void)t; }
double engine_input(const engine *e, size_t i) { return e->inputs[i]; }

void engine_set_input(engine *e, size_t i, double x)
{
    e->inputs[i] = x;
    e->is_read = 0;
}

size_t engine_state_size(void) { return 0; }
void engine_save(const engine *e, void *kept) { (void)e, (void)kept; }
void engine_restore(engine *e, const void *kept) { (void)e, (void)kept; }

double *engine_states(engine *e)
{
    (void)e;
    return NULL;
}

void engine_rates(engine *e, double *rates) { (void)e, (void)rates; }
