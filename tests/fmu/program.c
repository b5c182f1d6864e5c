/* A program without Python that takes three steps with a unit and prints its first three outputs, to the last bit. */
#include <dlfcn.h>
#include <stdio.h>

static void told(void *environment, const char *name, int status, const char *category, const char *message, ...)
{
    (void)environment, (void)name, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

int main(int count, char **given)
{
    void *callbacks[5] = {(void *)told}, *library = count == 3 ? dlopen(given[1], RTLD_NOW | RTLD_LOCAL) : NULL, *unit;
    unsigned input = 0, output = 1;
    double torque = 0.5, value;

    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    void *(*make)(const char *, int, const char *, const char *, void *, int, int) = dlsym(library, "fmi2Instantiate");
    int (*set)(void *, unsigned *, size_t, double *) = dlsym(library, "fmi2SetReal");
    int (*get)(void *, unsigned *, size_t, double *) = dlsym(library, "fmi2GetReal");
    int (*step)(void *, double, double, int) = dlsym(library, "fmi2DoStep");
    unit = make("unit", 1, given[2], "", callbacks, 0, 0);
    if (!unit || set(unit, &input, 1, &torque))
        return 2;
    for (int k = 0; k < 3; k++)
        if (step(unit, 0.01 * k, 0.01, 1))
            return 3;
    for (; output < 4; output++) {
        if (get(unit, &output, 1, &value))
            return 4;
        printf("%a\n", value);
    }
    return 0;
}
