/* The stack that calls with way-points take, against what docs/controller_in_c.md says: each runs in a thread of its own whose
 * stack is painted before, and the deepest byte that is painted no more counts. */
#define _POSIX_C_SOURCE 200809L

#include "arcfeed.h"

#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STACK = 4 << 20, PAINT = 0xA7, POINTS = ARCFEED_MAX_WAY_POINTS, AXES = ARCFEED_MAX_AXES };

static ArcfeedGenerator *generator;
static size_t axes;
static uintptr_t top;

static void check(ArcfeedStatus status) {
    if (status != ARCFEED_OK) {
        fprintf(stderr, "%s\n", arcfeed_last_error());
        exit(1);
    }
}

static void *reserve(void *unused) {
    top = (uintptr_t)__builtin_frame_address(0);
    check(arcfeed_generator_reserve_way_points(generator));
    return unused;
}

static void *set_route(void *route) {
    top = (uintptr_t)__builtin_frame_address(0);
    check(arcfeed_generator_set_route(generator, axes, route));
    return NULL;
}

static void *cycles(void *unused) {
    ArcfeedMotionState states[AXES];
    ArcfeedEvents events;
    top = (uintptr_t)__builtin_frame_address(0);
    for (int i = 0; i < 4000; i++) {
        check(arcfeed_generator_step(generator, axes, states, &events));
    }
    return unused;
}

/* Bytes of stack below the frame of the function. */
static long used(void *(*call)(void *), void *argument) {
    pthread_attr_t attributes;
    pthread_t thread;
    unsigned char *stack = NULL;
    if (posix_memalign((void **)&stack, 4096, STACK) != 0) {
        exit(1);
    }
    memset(stack, PAINT, STACK);
    pthread_attr_init(&attributes);
    if (pthread_attr_setstack(&attributes, stack, STACK) != 0 || pthread_create(&thread, &attributes, call, argument) != 0) {
        exit(1);
    }
    pthread_join(thread, NULL);
    pthread_attr_destroy(&attributes);
    size_t clean = 0;
    while (clean < STACK && stack[clean] == PAINT) {
        clean++;
    }
    long bytes = (long)(top - (uintptr_t)stack - clean);
    free(stack);
    return bytes;
}

/* Prints the use of three calls. Returns true if none is above its bound. */
static bool measure(size_t count, long reserving, long setting, long cycle) {
    ArcfeedAxisState start[AXES], target[AXES];
    ArcfeedAxisLimits limits[AXES];
    ArcfeedWayPoint points[POINTS] = {0};
    ArcfeedRoute route = {.count = POINTS, .points = points, .target = target, .limits = limits};
    axes = count;
    for (size_t k = 0; k < AXES; k++) {
        start[k] = (ArcfeedAxisState){0, 0, 0};
        target[k] = (ArcfeedAxisState){0.5, 0, 0};
        limits[k] = (ArcfeedAxisLimits){-1, 1, -5, 5, -50, 50};
        for (size_t i = 0; i < POINTS; i++) {
            points[i].position[k] = (double)((i * 7 + k * 37) % 19) / 16 - 0.6;
        }
    }
    check(arcfeed_generator_new(axes, start, limits, 1e-3, ARCFEED_SYNC_TIME, &generator));
    const long reserved = used(reserve, NULL);
    const long set = used(set_route, &route);
    const long stepped = used(cycles, NULL);
    arcfeed_generator_free(generator);
    printf("%zu axes: reserve_way_points %ld, set_route with 64 points %ld, step on it %ld bytes of stack\n", axes, reserved, set,
           stepped);
    return reserved <= reserving && set <= setting && stepped <= cycle;
}

int main(void) {
    bool good = measure(1, 160000, 130000, 20000);
    good &= measure(6, 600000, 600000, 80000);
    good &= measure(8, 800000, 800000, 100000);
    if (!good) {
        fprintf(stderr, "that is more than docs/controller_in_c.md says\n");
    }
    return good ? 0 : 1;
}
