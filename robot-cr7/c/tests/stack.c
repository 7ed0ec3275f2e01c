/* The stack that calls with way-points take, against what docs/controller_in_c.md says: each runs in a thread of its own whose
 * stack is painted before, and the deepest byte that is painted no more counts. Of each call the greatest use counts: routes that are
 * free, straight with blends, and both by turns, set in motion, and followed to their end with a hold between. */
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

/* To the end of the route, with a hold on the way. */
static void *cycles(void *unused) {
    ArcfeedMotionState states[AXES];
    ArcfeedEvents events = {0};
    top = (uintptr_t)__builtin_frame_address(0);
    for (int i = 0; !events.reached; i++) {
        if (i == 2000) {
            check(arcfeed_generator_hold(generator));
        } else if (i == 4000) {
            check(arcfeed_generator_resume(generator));
        } else if (i == 1000000) {
            fprintf(stderr, "the end of the route does not come\n");
            exit(1);
        }
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

/* The kinds of routes. */
enum Kind { FREE, STRAIGHT, BY_TURNS, KINDS };

/* Points for a route of a kind, as many as there may be: each blend counts as one. Returns their number. */
static size_t lay(enum Kind kind, ArcfeedWayPoint *points) {
    const size_t counts[KINDS] = {POINTS, POINTS / 2, POINTS / 4 * 3};
    for (size_t i = 0; i < counts[kind]; i++) {
        points[i] = (ArcfeedWayPoint){0};
        for (size_t k = 0; k < AXES; k++) {
            points[i].position[k] = (double)((i * 7 + k * 37) % 19) / 16 - 0.6;
        }
        /* By turns: two straight sections with a blend between them, two free ones. */
        const bool straight = kind == STRAIGHT || (kind == BY_TURNS && i % 4 < 2);
        const bool corner = kind == STRAIGHT || (kind == BY_TURNS && i % 4 == 0);
        points[i].straight = straight;
        points[i].blend = corner ? 0.02 : 0;
    }
    return counts[kind];
}

static long greater(long x, long y) {
    return x > y ? x : y;
}

/* Prints the use of three calls. Returns true if none is above its bound. */
static bool measure(size_t count, long reserving, long setting, long cycle) {
    ArcfeedAxisState start[AXES], target[AXES];
    ArcfeedAxisLimits limits[AXES];
    ArcfeedWayPoint points[POINTS];
    double velocity[AXES];
    long set = 0, stepped = 0;
    axes = count;
    for (size_t k = 0; k < AXES; k++) {
        start[k] = (ArcfeedAxisState){0, 0, 0};
        target[k] = (ArcfeedAxisState){0.5, 0, 0};
        limits[k] = (ArcfeedAxisLimits){-1, 1, -5, 5, -50, 50};
        velocity[k] = k % 2 == 0 ? 0.3 : -0.2;
    }
    check(arcfeed_generator_new(axes, start, limits, 1e-3, ARCFEED_SYNC_TIME, &generator));
    const long reserved = used(reserve, NULL);
    for (enum Kind kind = FREE; kind < KINDS; kind++) {
        ArcfeedRoute route = {.points = points, .target = target, .limits = limits, .last_straight = kind == STRAIGHT};
        route.count = lay(kind, points);
        check(arcfeed_generator_jog(generator, axes, velocity, 1.0));
        for (int i = 0; i < 300; i++) {
            ArcfeedMotionState states[AXES];
            check(arcfeed_generator_step(generator, axes, states, NULL));
        }
        /* The second time on the way of the first one. */
        for (int times = 0; times < 2; times++) {
            set = greater(set, used(set_route, &route));
            for (int i = 0; i < 700 && times == 0; i++) {
                ArcfeedMotionState states[AXES];
                check(arcfeed_generator_step(generator, axes, states, NULL));
            }
        }
        stepped = greater(stepped, used(cycles, NULL));
    }
    arcfeed_generator_free(generator);
    printf("%zu axes: reserve_way_points %ld, set_route %ld, step on it %ld bytes of stack\n", axes, reserved, set, stepped);
    return reserved <= reserving && set <= setting && stepped <= cycle;
}

int main(void) {
    /* Half as much again as measured, since compilers inline differently; to reserve copies the memory itself, which has its size. */
    bool good = measure(1, 160000, 100000, 25000);
    good &= measure(6, 600000, 410000, 120000);
    good &= measure(8, 800000, 540000, 150000);
    if (!good) {
        fprintf(stderr, "that is more than docs/controller_in_c.md says\n");
    }
    return good ? 0 : 1;
}
