/* Calls of a control cycle allocate nothing, whether they succeed or are refused. Linked with --wrap for every function
 * that allocates. */
#include "arcfeed.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static long allocations;

void *__real_malloc(size_t);
void *__real_calloc(size_t, size_t);
void *__real_realloc(void *, size_t);
int __real_posix_memalign(void **, size_t, size_t);

void *__wrap_malloc(size_t size) {
    allocations++;
    return __real_malloc(size);
}
void *__wrap_calloc(size_t count, size_t size) {
    allocations++;
    return __real_calloc(count, size);
}
void *__wrap_realloc(void *old, size_t size) {
    allocations++;
    return __real_realloc(old, size);
}
int __wrap_posix_memalign(void **out, size_t alignment, size_t size) {
    allocations++;
    return __real_posix_memalign(out, alignment, size);
}

enum { AXES = 6, CYCLES = 20000 };

static unsigned long long seed = 20261129;

/* A number in [-1, 1): splitmix64. */
static double random_number(void) {
    unsigned long long x = seed += 0x9E3779B97F4A7C15ULL;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
    return (double)((x ^ (x >> 31)) >> 11) / 4503599627370496.0 - 1.0;
}

static void check(ArcfeedStatus status) {
    if (status != ARCFEED_OK) {
        fprintf(stderr, "%s\n", arcfeed_last_error());
        exit(1);
    }
}

/* Way-points and tracking, with targets that are not numbers now and then. */
static bool ahead(void) {
    ArcfeedAxisState start[AXES], target[AXES];
    ArcfeedAxisLimits limits[AXES];
    ArcfeedMotionState states[AXES];
    ArcfeedWayPoint points[2] = {{.position = {0.3, 0.2, 0.1}}, {.position = {0.5, -0.2, 0.4}}};
    ArcfeedRoute route = {.count = 2, .points = points, .target = target, .limits = limits};
    ArcfeedEvents events;
    ArcfeedTrackingStatus status;
    ArcfeedGenerator *generator = NULL;
    ArcfeedTracking *tracking = NULL;
    long refused = 0, passed = 0, reached = 0, rounded = 0;
    for (int k = 0; k < AXES; k++) {
        start[k] = target[k] = (ArcfeedAxisState){0, 0, 0};
        limits[k] = (ArcfeedAxisLimits){-1, 1, -5, 5, -50, 50};
    }
    check(arcfeed_tracking_new(AXES, start, limits, 1e-3, &tracking));
    check(arcfeed_generator_new(AXES, start, limits, 1e-3, ARCFEED_SYNC_TIME, &generator));
    check(arcfeed_generator_reserve_way_points(generator));
    const long made = allocations;
    for (int i = 0; i < CYCLES; i++) {
        if (i % 2000 < 2) { /* first one that is refused */
            for (int k = 0; k < AXES; k++) {
                target[k].position = i % 2000 == 0 ? NAN : random_number();
                points[1].position[k] = random_number();
            }
            /* Every other route is one of lines with a blend. */
            const bool lines = i % 4000 < 2;
            points[0].straight = points[1].straight = route.last_straight = lines;
            points[0].blend = points[1].blend = lines ? 0.02 : 0;
            refused += arcfeed_generator_set_route(generator, AXES, &route) != ARCFEED_OK;
            size_t sections = 0;
            check(arcfeed_generator_sections(generator, &sections));
            rounded += i % 2000 == 1 && sections > 3;
        }
        if (i % 4000 == 2500) {
            check(arcfeed_generator_stop(generator));
        }
        check(arcfeed_generator_step(generator, AXES, states, &events));
        passed += (long)events.passed;
        reached += events.reached;
        refused += arcfeed_tracking_step(tracking, AXES, target, states, &status) != ARCFEED_OK;
        if (i % 100 == 0) {
            check(arcfeed_tracking_set_limits(tracking, AXES, limits));
        }
    }
    const long later = allocations - made;
    arcfeed_generator_free(generator);
    arcfeed_tracking_free(tracking);
    printf("no heap: %ld allocations in %d cycles of way-points and tracking with %ld refusals, %ld points and %ld ends\n", later, CYCLES, refused,
           passed, reached);
    return later == 0 && refused == 20 && passed > 5 && reached > 4 && rounded > 1;
}

int main(void) {
    ArcfeedAxisState start[AXES], target[AXES];
    ArcfeedAxisLimits limits[AXES];
    ArcfeedRange ranges[AXES];
    ArcfeedMotionState states[AXES];
    ArcfeedEvents events;
    double velocity[AXES];
    long refused = 0, arrivals = 0;
    for (int k = 0; k < AXES; k++) {
        start[k] = (ArcfeedAxisState){0, 0, 0};
        limits[k] = (ArcfeedAxisLimits){-1, 1, -5, 5, -50, 50};
        ranges[k] = (ArcfeedRange){-2, 2};
    }
    ArcfeedGenerator *generator = NULL;
    ArcfeedArm *arm = NULL;
    ArcfeedProjection *projection = NULL;
    const ArcfeedPoseState from = {{0.4, 0, 0.3, 1, 0, 0, 0}, {0}, {0}};
    ArcfeedPose to = {0.4, 0.3, 0.2, 1, 0, 0, 0}, pose;
    const ArcfeedPoseLimits bounds = {{0.5, 3, 40}, {1.5, 8, 100}};
    ArcfeedPoseState now;
    check(arcfeed_generator_new(AXES, start, limits, 1e-3, ARCFEED_SYNC_TIME, &generator));
    check(arcfeed_generator_set_ranges(generator, AXES, ranges));
    check(arcfeed_arm_builtin("cr7", &arm));
    check(arcfeed_projection_new(&from, &to, &bounds, &projection));
    const long made = allocations;
    for (int i = 0; i < CYCLES; i++) {
        for (int k = 0; k < AXES; k++) {
            /* One in a hundred is not a number. */
            target[k] = (ArcfeedAxisState){i % 1000 == 7 ? NAN : 2.2 * random_number(), 0.5 * random_number(), 0};
            velocity[k] = 1.1 * random_number();
        }
        if (i % 10 == 0) {
            refused += arcfeed_generator_set_target(generator, AXES, target) != ARCFEED_OK;
        }
        if (i % 170 == 3) {
            refused += arcfeed_generator_jog(generator, AXES, velocity, 0.05) != ARCFEED_OK;
        }
        if (i % 310 == 5) {
            refused += arcfeed_generator_stop(generator) != ARCFEED_OK;
        }
        if (i % 410 == 6) {
            check(arcfeed_generator_stop_on_path(generator));
        }
        refused += arcfeed_generator_set_scale(generator, 0.8 + random_number()) != ARCFEED_OK;
        check(arcfeed_generator_step(generator, AXES, states, &events));
        arrivals += events.reached;
        to.x = 0.4 + 0.1 * random_number();
        if (i % 50 == 0) {
            check(arcfeed_projection_set_target(projection, &to));
        }
        check(arcfeed_projection_step(projection, 1e-3, &now, NULL));
        for (int k = 0; k < AXES; k++) {
            velocity[k] = random_number();
        }
        check(arcfeed_arm_forward(arm, AXES, velocity, &pose));
        pose.x += i % 5 == 0 ? 2.0 : 0.0; /* out of reach */
        refused += arcfeed_arm_inverse(arm, &pose, AXES, velocity, velocity) != ARCFEED_OK;
    }
    const long later = allocations - made;
    arcfeed_generator_free(generator);
    arcfeed_arm_free(arm);
    arcfeed_projection_free(projection);
    printf("no heap: %ld allocations to make values, %ld in %d cycles with %ld refusals and %ld arrivals\n", made, later, CYCLES,
           refused, arrivals);
    return later == 0 && made > 0 && refused > 1000 && ahead() ? 0 : 1;
}
