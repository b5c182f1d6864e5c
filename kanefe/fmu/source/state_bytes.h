/* States as bytes that may leave the process: stamped with their format, the scene (its token) and a sum. */
#ifndef STATE_BYTES_H
#define STATE_BYTES_H

#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "engine.h"

static const char STATE_FORMAT[] = "kanefe state 1";

#define STAMP_SIZE (sizeof STATE_FORMAT + sizeof TOKEN + sizeof(uint64_t))

/* Fowler, Noll and Vo's hash, 1a. */
static uint64_t state_sum(const unsigned char *bytes, size_t size)
{
    uint64_t sum = UINT64_C(0xcbf29ce484222325);

    for (size_t i = 0; i < size; i++)
        sum = (sum ^ bytes[i]) * UINT64_C(0x100000001b3);
    return sum;
}

static size_t state_bytes_size(void) { return STAMP_SIZE + engine_state_size(); }

static void state_to_bytes(const void *kept, void *bytes)
{
    unsigned char *to = bytes;
    uint64_t sum = state_sum(kept, engine_state_size());

    memcpy(to, STATE_FORMAT, sizeof STATE_FORMAT);
    memcpy(to += sizeof STATE_FORMAT, TOKEN, sizeof TOKEN);
    memcpy(to += sizeof TOKEN, &sum, sizeof sum);
    memcpy(to + sizeof sum, kept, engine_state_size());
}

/* Returns where the state is in the bytes, NULL with a message if they are none of this model. */
static const void *state_in_bytes(const void *bytes, size_t size, char *message)
{
    const unsigned char *from = bytes;
    uint64_t sum;

    if (size < STAMP_SIZE || memcmp(from, STATE_FORMAT, sizeof STATE_FORMAT)) {
        snprintf(message, MESSAGE_SIZE, "these bytes are not a state in the format of this unit (%s). Remedy: bytes "
                 "that the same unit has serialised", STATE_FORMAT);
        return NULL;
    }
    from += sizeof STATE_FORMAT;
    if (memcmp(from, TOKEN, sizeof TOKEN)) {
        snprintf(message, MESSAGE_SIZE, "these bytes are a state of another scene, %.38s; this unit is %s. Remedy: "
                 "states of the same export", (const char *)from, TOKEN);
        return NULL;
    }
    from += sizeof TOKEN;
    memcpy(&sum, from, sizeof sum);
    from += sizeof sum;
    if (size != state_bytes_size() || sum != state_sum(from, engine_state_size())) {
        snprintf(message, MESSAGE_SIZE, "the bytes of this state are damaged: they are %s. Remedy: serialise it again",
                 size == state_bytes_size() ? "not those that were written" : "too few or too many");
        return NULL;
    }
    return from;
}

#endif
