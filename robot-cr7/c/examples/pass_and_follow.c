/* Three axes pass way-points without a stop, take another route on the way, and then follow a conveyor.
 *
 * Checks every cycle: limits, and positions that follow from velocities. */
#include "arcfeed.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { AXES = 3 };

static const double CYCLE = 1e-3; /* s */
static const ArcfeedAxisLimits FAST = {-1, 1, -5, 5, -50, 50};
static const ArcfeedAxisLimits SLOW = {-0.2, 0.2, -2, 2, -20, 20};

static void check(ArcfeedStatus status, const char *what) {
    if (status != ARCFEED_OK) {
        fprintf(stderr, "%s: %s\n", what, arcfeed_last_error());
        exit(1);
    }
}

static void expect(bool holds, const char *what) {
    if (!holds) {
        fprintf(stderr, "not so: %s\n", what);
        exit(1);
    }
}

/* What a plant would see: no axis beyond its limits, and none that jumps. */
static void command(const ArcfeedMotionState *states) {
    static ArcfeedMotionState before[AXES];
    static bool first = true;
    for (int k = 0; k < AXES; k++) {
        const ArcfeedMotionState *s = &states[k];
        expect(fabs(s->velocity) <= 1 + 1e-9 && fabs(s->acceleration) <= 5 + 1e-9, "the limits hold");
        if (!first) {
            const double mean = (s->velocity + before[k].velocity) / 2;
            expect(fabs(s->acceleration - before[k].acceleration) <= 50 * CYCLE + 1e-9, "the jerk keeps its limit");
            /* The error of the trapezium: jerk times the cube of the cycle, by 12. */
            expect(fabs(s->position - before[k].position - CYCLE * mean) <= 2 * 50 * pow(CYCLE, 3) / 12 + 1e-12,
                   "positions follow from velocities");
        }
        before[k] = *s;
    }
    first = false;
}

/* Leaves the states of the end in `end`. */
static void pass(ArcfeedAxisState *end) {
    const ArcfeedAxisState start[AXES] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    const ArcfeedAxisState target[AXES] = {{1.0, 0, 0}, {0.2, 0, 0}, {-0.3, 0, 0}};
    const ArcfeedAxisLimits limits[AXES] = {FAST, FAST, FAST}, slow[AXES] = {SLOW, SLOW, SLOW};
    const ArcfeedWayPoint points[] = {
        {.position = {0.3, 0.2, -0.1}},
        /* The first axis passes at 0.15 rad/s, and all axes come here slowly. */
        {.position = {0.4, 0.3, -0.1}, .velocity = {0.15}, .has_velocity = 1, .limits = slow},
        {.position = {0.8, 0.4, -0.2}, .least_duration = 1.0},
    };
    const ArcfeedRoute route = {.count = 3, .points = points, .target = target, .limits = limits};
    ArcfeedGenerator *generator = NULL;
    check(arcfeed_generator_new(AXES, start, limits, CYCLE, ARCFEED_SYNC_TIME, &generator), "generator");
    check(arcfeed_generator_reserve_way_points(generator), "memory");
    check(arcfeed_generator_set_route(generator, AXES, &route), "route");

    double seconds[4];
    ArcfeedMotionState states[AXES];
    check(arcfeed_generator_section_durations(generator, 4, seconds), "durations");
    check(arcfeed_generator_route_at(generator, seconds[0] + seconds[1], AXES, states), "second point");
    expect(fabs(states[0].position - 0.4) < 1e-9 && fabs(states[0].velocity - 0.15) < 1e-9, "it passes as it should");
    expect(seconds[2] >= 1.0, "a section takes its least duration");

    ArcfeedEvents events;
    int cycles = 0;
    size_t passed = 0;
    for (; passed < 2; cycles++) {
        check(arcfeed_generator_step(generator, AXES, states, &events), "step");
        command(states);
        passed += events.passed;
        expect(passed != 1 || fabs(states[1].velocity) <= 0.2 + 1e-9, "a section has limits of its own");
    }
    /* In motion: the last point is not wanted any more. */
    const ArcfeedWayPoint other[] = {{.position = {0.6, 0.5, 0.0}}};
    const ArcfeedRoute turn = {.count = 1, .points = other, .target = target, .limits = limits};
    check(arcfeed_generator_set_route(generator, AXES, &turn), "another route");
    for (events.reached = false; !events.reached; cycles++) {
        check(arcfeed_generator_step(generator, AXES, states, &events), "step");
        command(states);
        expect(cycles < 10000, "the end comes");
    }
    check(arcfeed_generator_state(generator, AXES, end), "state");
    expect(end[0].position == 1.0 && end[1].position == 0.2 && end[2].position == -0.3, "the end is the target");
    arcfeed_generator_free(generator);
    printf("pass: three points and another route in %d cycles\n", cycles);
}

/* From `start` on, a place on a conveyor that moves along the first axis. */
static void follow(const ArcfeedAxisState *start) {
    const ArcfeedAxisLimits limits[AXES] = {FAST, FAST, FAST};
    ArcfeedAxisState target[AXES] = {{1.1, 0.4, 0}, {0.0, 0, 0}, {0.0, 0, 0}};
    ArcfeedMotionState states[AXES];
    ArcfeedTrackingStatus status = {0, 0, false};
    ArcfeedTracking *tracking = NULL;
    check(arcfeed_tracking_new(AXES, start, limits, CYCLE, &tracking), "tracking");
    int reached = 0;
    for (int i = 1; i <= 3000; i++) {
        target[0].position = 1.1 + 0.4 * CYCLE * i;
        check(arcfeed_tracking_step(tracking, AXES, target, states, &status), "step");
        command(states);
        if (status.is_following && reached == 0) {
            reached = i;
        }
        for (int k = 0; k < AXES; k++) {
            expect(reached == 0 || (states[k].position == target[k].position && states[k].velocity == target[k].velocity),
                   "the axes keep to the target without error");
        }
    }
    expect(reached > 0 && status.following == 7 && status.saturated == 0, "the target is met");
    arcfeed_tracking_free(tracking);
    printf("follow: met after %d cycles, kept to the end\n", reached);
}

int main(void) {
    ArcfeedAxisState end[AXES];
    pass(end);
    follow(end);
    return 0;
}
