/* Bad input from C: every call names the argument and its value, and nothing crashes. */
#include "arcfeed.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures;
static int checks;

/* The call must give that status and an error that contains every given word. */
static void refused(ArcfeedStatus got, ArcfeedStatus want, const char *first, const char *second, int line) {
    const char *text = arcfeed_last_error();
    checks++;
    if (got != want || strstr(text, first) == NULL || strstr(text, second) == NULL) {
        failures++;
        fprintf(stderr, "line %d: status %d, not %d; '%s' should name '%s' and '%s'\n", line, (int)got, (int)want, text, first,
                second);
    }
}
#define REFUSED(call, status, first, second) refused(call, status, first, second, __LINE__)
#define NULL_REFUSED(call, name) refused(call, ARCFEED_NULL, name, "NULL", __LINE__)

static void must(ArcfeedStatus got, int line) {
    checks++;
    if (got != ARCFEED_OK) {
        failures++;
        fprintf(stderr, "line %d: %s\n", line, arcfeed_last_error());
    }
}
#define MUST(call) must(call, __LINE__)

static void expect(bool holds, int line) {
    checks++;
    if (!holds) {
        failures++;
        fprintf(stderr, "line %d: does not hold\n", line);
    }
}
#define EXPECT(holds) expect(holds, __LINE__)

static const ArcfeedAxisLimits LIMITS = {-1, 1, -5, 5, -50, 50};

static void generator_is_made(void) {
    ArcfeedAxisState start[2] = {{0, 0, 0}, {0, 0, 0}};
    ArcfeedAxisLimits limits[2] = {LIMITS, LIMITS};
    ArcfeedGenerator *g = (ArcfeedGenerator *)start; /* is set to NULL by a call that fails */
    NULL_REFUSED(arcfeed_generator_new(2, NULL, limits, 1e-3, ARCFEED_SYNC_TIME, &g), "start");
    EXPECT(g == NULL);
    NULL_REFUSED(arcfeed_generator_new(2, start, NULL, 1e-3, ARCFEED_SYNC_TIME, &g), "limits");
    NULL_REFUSED(arcfeed_generator_new(2, start, limits, 1e-3, ARCFEED_SYNC_TIME, NULL), "out");
    REFUSED(arcfeed_generator_new(0, start, limits, 1e-3, ARCFEED_SYNC_TIME, &g), ARCFEED_INVALID, "axes", "0");
    REFUSED(arcfeed_generator_new(9, start, limits, 1e-3, ARCFEED_SYNC_TIME, &g), ARCFEED_INVALID, "axes", "9");
    REFUSED(arcfeed_generator_new(2, start, limits, 1e-3, 17, &g), ARCFEED_INVALID, "synchronisation", "17");
    REFUSED(arcfeed_generator_new(2, start, limits, 0, ARCFEED_SYNC_TIME, &g), ARCFEED_INVALID, "cycle", "0");
    REFUSED(arcfeed_generator_new(2, start, limits, NAN, ARCFEED_SYNC_TIME, &g), ARCFEED_INVALID, "cycle", "NaN");
    start[1].velocity = NAN;
    REFUSED(arcfeed_generator_new(2, start, limits, 1e-3, 1, &g), ARCFEED_INVALID, "start[1].velocity", "NaN");
    start[1].velocity = 0;
    start[0].acceleration = INFINITY;
    REFUSED(arcfeed_generator_new(2, start, limits, 1e-3, 1, &g), ARCFEED_INVALID, "start[0].acceleration", "inf");
    start[0].acceleration = 0;
    double *const fields[] = {&limits[1].v_min, &limits[1].v_max, &limits[1].a_min,
                              &limits[1].a_max, &limits[1].j_min, &limits[1].j_max};
    const char *const names[] = {"limits[1].v_min", "limits[1].v_max", "limits[1].a_min",
                                 "limits[1].a_max", "limits[1].j_min", "limits[1].j_max"};
    for (int i = 0; i < 6; i++) {
        const double kept = *fields[i];
        *fields[i] = NAN;
        REFUSED(arcfeed_generator_new(2, start, limits, 1e-3, 1, &g), ARCFEED_INVALID, names[i], "NaN");
        *fields[i] = -kept; /* reversed */
        REFUSED(arcfeed_generator_new(2, start, limits, 1e-3, 1, &g), ARCFEED_INVALID, names[i], "must be");
        *fields[i] = kept;
    }
    MUST(arcfeed_generator_new(2, start, limits, 1e-3, ARCFEED_SYNC_TIME, &g));
    arcfeed_generator_free(g);
    arcfeed_generator_free(NULL);
}

static void generator_is_used(void) {
    const ArcfeedAxisState start[2] = {{0, 0, 0}, {0, 0, 0}};
    const ArcfeedAxisLimits limits[2] = {LIMITS, LIMITS};
    ArcfeedGenerator *g = NULL;
    MUST(arcfeed_generator_new(2, start, limits, 1e-3, ARCFEED_SYNC_TIME, &g));
    ArcfeedMotionState states[2];
    ArcfeedAxisState target[2] = {{1, 0, 0}, {NAN, 0, 0}};
    ArcfeedRange ranges[2] = {{-2, 2}, {3, -3}};
    double velocity[2] = {0.5, NAN}, number = 0;
    bool flag = false;
    NULL_REFUSED(arcfeed_generator_set_target(NULL, 2, start), "generator");
    NULL_REFUSED(arcfeed_generator_set_target(g, 2, NULL), "target");
    REFUSED(arcfeed_generator_set_target(g, 3, start), ARCFEED_INVALID, "axes is 3", "2");
    REFUSED(arcfeed_generator_set_target(g, 2, target), ARCFEED_INVALID, "target[1].position", "NaN");
    REFUSED(arcfeed_generator_set_axis_target(g, 2, start), ARCFEED_INVALID, "axis 3", "2");
    NULL_REFUSED(arcfeed_generator_set_axis_target(g, 0, NULL), "target");
    NULL_REFUSED(arcfeed_generator_set_limits(g, 2, NULL), "limits");
    NULL_REFUSED(arcfeed_generator_set(g, 2, start, NULL), "limits");
    NULL_REFUSED(arcfeed_generator_set_ranges(g, 2, NULL), "ranges");
    REFUSED(arcfeed_generator_set_ranges(g, 2, ranges), ARCFEED_INVALID, "ranges[1]", "below upper");
    ranges[1].lower = NAN;
    REFUSED(arcfeed_generator_set_ranges(g, 2, ranges), ARCFEED_INVALID, "ranges[1]", "NaN");
    ranges[1] = (ArcfeedRange){-3, 3};
    MUST(arcfeed_generator_set_ranges(g, 2, ranges));
    target[1] = (ArcfeedAxisState){3.5, 0, 0};
    REFUSED(arcfeed_generator_set_target(g, 2, target), ARCFEED_REFUSED, "axis 2", "outside its range");
    REFUSED(arcfeed_generator_jog(g, 2, velocity, 0.1), ARCFEED_INVALID, "velocity[1]", "NaN");
    velocity[1] = 7;
    REFUSED(arcfeed_generator_jog(g, 2, velocity, 0.1), ARCFEED_REFUSED, "axis 2", "7");
    velocity[1] = 0;
    REFUSED(arcfeed_generator_jog(g, 2, velocity, NAN), ARCFEED_INVALID, "timeout", "NaN");
    REFUSED(arcfeed_generator_jog(g, 2, velocity, -1), ARCFEED_INVALID, "time-out", "-1");
    NULL_REFUSED(arcfeed_generator_jog(g, 2, NULL, 0.1), "velocity");
    REFUSED(arcfeed_generator_set_scale(g, 1.6), ARCFEED_INVALID, "scale", "1.6");
    REFUSED(arcfeed_generator_set_scale(g, NAN), ARCFEED_INVALID, "scale", "NaN");
    NULL_REFUSED(arcfeed_generator_step(NULL, 2, states, NULL), "generator");
    NULL_REFUSED(arcfeed_generator_step(g, 2, NULL, NULL), "states");
    REFUSED(arcfeed_generator_step(g, 1, states, NULL), ARCFEED_INVALID, "axes is 1", "2");
    REFUSED(arcfeed_generator_step(g, 2, (ArcfeedMotionState *)((char *)states + 1), NULL), ARCFEED_NULL, "states", "aligned");
    NULL_REFUSED(arcfeed_generator_stop(NULL), "generator");
    NULL_REFUSED(arcfeed_generator_stop_on_path(NULL), "generator");
    NULL_REFUSED(arcfeed_generator_hold(NULL), "generator");
    NULL_REFUSED(arcfeed_generator_resume(NULL), "generator");
    NULL_REFUSED(arcfeed_generator_state(g, 2, NULL), "states");
    NULL_REFUSED(arcfeed_generator_target(g, 2, NULL), "target");
    NULL_REFUSED(arcfeed_generator_is_underway(NULL, &flag), "generator");
    NULL_REFUSED(arcfeed_generator_is_underway(g, NULL), "is_underway");
    NULL_REFUSED(arcfeed_generator_time_left(g, NULL), "seconds");
    NULL_REFUSED(arcfeed_generator_scale(NULL, &number), "generator");
    /* Nothing that was refused has moved an axis. */
    MUST(arcfeed_generator_step(g, 2, states, NULL));
    EXPECT(states[0].position == 0 && states[1].position == 0 && states[0].velocity == 0);
    arcfeed_generator_free(g);
}

static void way_points(void) {
    ArcfeedAxisState start[2] = {{0, 0, 0}, {0, 0, 0}}, target[2] = {{1, 0, 0}, {0.5, 0, 0}};
    ArcfeedAxisLimits limits[2] = {LIMITS, LIMITS}, section[2] = {LIMITS, LIMITS};
    ArcfeedWayPoint points[ARCFEED_MAX_WAY_POINTS] = {{.position = {0.3, 0.2}}, {.position = {0.6, 0.1}}};
    ArcfeedRoute route = {.count = 2, .points = points, .target = target, .limits = limits};
    ArcfeedWayPoints *w = (ArcfeedWayPoints *)start; /* is set to NULL by a call that fails */
    NULL_REFUSED(arcfeed_way_points_new(2, NULL, &route, 1e-3, &w), "start");
    EXPECT(w == NULL);
    NULL_REFUSED(arcfeed_way_points_new(2, start, NULL, 1e-3, &w), "route");
    NULL_REFUSED(arcfeed_way_points_new(2, start, &route, 1e-3, NULL), "out");
    REFUSED(arcfeed_way_points_new(9, start, &route, 1e-3, &w), ARCFEED_INVALID, "axes", "9");
    REFUSED(arcfeed_way_points_new(2, start, &route, 0, &w), ARCFEED_INVALID, "cycle", "0");
    REFUSED(arcfeed_way_points_new(2, start, &route, NAN, &w), ARCFEED_INVALID, "cycle", "NaN");
    start[1].position = NAN;
    REFUSED(arcfeed_way_points_new(2, start, &route, 1e-3, &w), ARCFEED_INVALID, "start[1].position", "NaN");
    start[1].position = 0;
    MUST(arcfeed_way_points_new(2, start, &route, 1e-3, &w));

    /* What a route may not be. Entries past the axes are not read. */
    points[1].position[2] = NAN;
    MUST(arcfeed_way_points_set_route(w, 2, &route));
#define ROUTE_REFUSED(change, back, status, first, second)                                                            \
    change;                                                                                                           \
    refused(arcfeed_way_points_set_route(w, 2, &route), status, first, second, __LINE__);                             \
    back
    ROUTE_REFUSED(route.count = 65, route.count = 2, ARCFEED_INVALID, "route.count is 65", "at most 64");
    ROUTE_REFUSED(route.count = (size_t)-1, route.count = 2, ARCFEED_INVALID, "route.count", "at most 64");
    ROUTE_REFUSED(route.points = NULL, route.points = points, ARCFEED_NULL, "route.points", "NULL");
    ROUTE_REFUSED(route.target = NULL, route.target = target, ARCFEED_NULL, "route.target", "NULL");
    ROUTE_REFUSED(route.limits = NULL, route.limits = limits, ARCFEED_NULL, "route.limits", "NULL");
    route.points = (ArcfeedWayPoint *)((char *)points + 1);
    REFUSED(arcfeed_way_points_set_route(w, 2, &route), ARCFEED_NULL, "route.points", "aligned");
    route.points = points;
    ROUTE_REFUSED(points[1].position[1] = NAN, points[1].position[1] = 0.1, ARCFEED_INVALID, "route.points[1].position[1]", "NaN");
    points[1].has_velocity = 2;
    ROUTE_REFUSED(points[1].velocity[1] = NAN, points[1].velocity[1] = 0, ARCFEED_INVALID, "route.points[1].velocity[1]", "NaN");
    ROUTE_REFUSED(points[1].velocity[1] = 1.5, points[1].velocity[1] = 0, ARCFEED_REFUSED, "way-point 2, axis 2", "1.5");
    ROUTE_REFUSED(points[1].has_velocity = 4, points[1].has_velocity = 0, ARCFEED_INVALID, "route.points[1].has_velocity", "100");
    ROUTE_REFUSED(points[0].least_duration = -1, points[0].least_duration = 0, ARCFEED_INVALID, "points[0].least_duration", "-1");
    ROUTE_REFUSED(points[0].least_duration = NAN, points[0].least_duration = 0, ARCFEED_INVALID, "points[0].least_duration", "NaN");
    section[1].a_max = NAN;
    ROUTE_REFUSED(points[1].limits = section, points[1].limits = NULL, ARCFEED_INVALID, "route.points[1].limits[1].a_max", "NaN");
    ROUTE_REFUSED(route.last_limits = section, route.last_limits = NULL, ARCFEED_INVALID, "route.last_limits[1].a_max", "NaN");
    ROUTE_REFUSED(route.last_least_duration = INFINITY, route.last_least_duration = 0, ARCFEED_INVALID, "last_least_duration", "inf");
    ROUTE_REFUSED(limits[0].v_min = 1, limits[0].v_min = -1, ARCFEED_INVALID, "route.limits[0].v_min", "must be");
    ROUTE_REFUSED(target[1].velocity = NAN, target[1].velocity = 0, ARCFEED_INVALID, "route.target[1].velocity", "NaN");
    ROUTE_REFUSED(target[1].velocity = 2, target[1].velocity = 0, ARCFEED_REFUSED, "axis 2", "2");
    REFUSED(arcfeed_way_points_set_route(w, 3, &route), ARCFEED_INVALID, "axes is 3", "2");
    NULL_REFUSED(arcfeed_way_points_set_route(NULL, 2, &route), "way_points");
    NULL_REFUSED(arcfeed_way_points_set_route(w, 2, NULL), "route");

    ArcfeedMotionState states[2];
    ArcfeedProgress progress;
    double seconds[ARCFEED_MAX_WAY_POINTS + 1];
    NULL_REFUSED(arcfeed_way_points_step(NULL, 2, states, NULL), "way_points");
    NULL_REFUSED(arcfeed_way_points_step(w, 2, NULL, NULL), "states");
    REFUSED(arcfeed_way_points_step(w, 1, states, NULL), ARCFEED_INVALID, "axes is 1", "2");
    REFUSED(arcfeed_way_points_step(w, 2, states, (ArcfeedProgress *)((char *)&progress + 1)), ARCFEED_NULL, "progress", "aligned");
    NULL_REFUSED(arcfeed_way_points_stop(NULL), "way_points");
    NULL_REFUSED(arcfeed_way_points_state(w, 2, NULL), "states");
    NULL_REFUSED(arcfeed_way_points_duration(w, NULL), "seconds");
    NULL_REFUSED(arcfeed_way_points_section_durations(w, 3, NULL), "seconds");
    REFUSED(arcfeed_way_points_section_durations(w, 2, seconds), ARCFEED_INVALID, "count is 2", "3 sections");
    REFUSED(arcfeed_way_points_at(w, NAN, 2, states), ARCFEED_INVALID, "t is", "NaN");
    NULL_REFUSED(arcfeed_way_points_at(w, 0.5, 2, NULL), "states");
    /* Nothing that was refused has moved an axis: this is the first cycle of the route. */
    MUST(arcfeed_way_points_step(w, 2, states, &progress));
    EXPECT(progress.passed == 0 && !progress.reached && states[0].position > 0 && states[0].position < 1e-7);
    /* The last section has a duration and limits of its own. */
    route.last_least_duration = 3;
    MUST(arcfeed_way_points_set_route(w, 2, &route));
    MUST(arcfeed_way_points_section_durations(w, 3, seconds));
    EXPECT(seconds[0] < 3 && seconds[1] < 3 && seconds[2] > 3 - 1e-9);
    section[0] = section[1] = (ArcfeedAxisLimits){-0.1, 0.1, -1, 1, -10, 10};
    route.last_limits = section;
    route.last_least_duration = 0;
    MUST(arcfeed_way_points_set_route(w, 2, &route));
    MUST(arcfeed_way_points_section_durations(w, 3, seconds));
    MUST(arcfeed_way_points_duration(w, &seconds[3]));
    EXPECT(seconds[2] > 4 && fabs(seconds[0] + seconds[1] + seconds[2] - seconds[3]) < 1e-12); /* 0.4 at 0.1 / s */
    route.last_limits = NULL;
    /* As many points as there can be, and none. */
    for (size_t i = 0; i < ARCFEED_MAX_WAY_POINTS; i++) {
        points[i] = (ArcfeedWayPoint){.position = {0.1 * (double)(i + 1), i % 2 == 0 ? 0.1 : 0.0}};
    }
    route.count = ARCFEED_MAX_WAY_POINTS;
    MUST(arcfeed_way_points_set_route(w, 2, &route));
    MUST(arcfeed_way_points_section_durations(w, ARCFEED_MAX_WAY_POINTS + 1, seconds));
    route.count = 0;
    route.points = NULL;
    MUST(arcfeed_way_points_set_route(w, 2, &route));
    arcfeed_way_points_free(w);
    /* A start outside the limits is no error: it is brought back inside. */
    start[0].velocity = 1.5;
    MUST(arcfeed_way_points_new(2, start, &route, 1e-3, &w));
    bool inside = true;
    int cycles = 0;
    for (progress.reached = false; !progress.reached && cycles < 10000; cycles++) {
        inside &= arcfeed_way_points_step(w, 2, states, &progress) == ARCFEED_OK;
        inside &= states[0].velocity < 1.5 && states[0].acceleration > -5.000001 && (cycles < 1000 || states[0].velocity < 1);
    }
    EXPECT(inside && states[0].position == 1 && states[0].velocity == 0);
    arcfeed_way_points_free(w);
}

static void tracking(void) {
    ArcfeedAxisState start[2] = {{0, 0, 0}, {0, 0, 0}}, target[2] = {{1, 0, 0}, {0.5, 0, 0}};
    ArcfeedAxisLimits limits[2] = {LIMITS, LIMITS};
    ArcfeedMotionState states[2];
    ArcfeedTrackingStatus status;
    ArcfeedTracking *t = (ArcfeedTracking *)start;
    NULL_REFUSED(arcfeed_tracking_new(2, NULL, limits, 1e-3, &t), "start");
    EXPECT(t == NULL);
    NULL_REFUSED(arcfeed_tracking_new(2, start, NULL, 1e-3, &t), "limits");
    NULL_REFUSED(arcfeed_tracking_new(2, start, limits, 1e-3, NULL), "out");
    REFUSED(arcfeed_tracking_new(0, start, limits, 1e-3, &t), ARCFEED_INVALID, "axes", "0");
    REFUSED(arcfeed_tracking_new(2, start, limits, -1, &t), ARCFEED_INVALID, "cycle", "-1");
    start[0].velocity = NAN;
    REFUSED(arcfeed_tracking_new(2, start, limits, 1e-3, &t), ARCFEED_INVALID, "start[0].velocity", "NaN");
    start[0].velocity = 1.5; /* outside the limits: brought back inside */
    MUST(arcfeed_tracking_new(2, start, limits, 1e-3, &t));
    NULL_REFUSED(arcfeed_tracking_step(NULL, 2, target, states, NULL), "tracking");
    NULL_REFUSED(arcfeed_tracking_step(t, 2, NULL, states, NULL), "target");
    NULL_REFUSED(arcfeed_tracking_step(t, 2, target, NULL, NULL), "states");
    REFUSED(arcfeed_tracking_step(t, 2, target, states, (ArcfeedTrackingStatus *)((char *)&status + 1)), ARCFEED_NULL, "status",
            "aligned");
    REFUSED(arcfeed_tracking_step(t, 1, target, states, NULL), ARCFEED_INVALID, "axes is 1", "2");
    target[1].acceleration = INFINITY;
    REFUSED(arcfeed_tracking_step(t, 2, target, states, NULL), ARCFEED_INVALID, "target[1].acceleration", "inf");
    target[1].acceleration = 0;
    limits[1].j_min = NAN;
    REFUSED(arcfeed_tracking_set_limits(t, 2, limits), ARCFEED_INVALID, "limits[1].j_min", "NaN");
    limits[1].j_min = -50;
    NULL_REFUSED(arcfeed_tracking_set_limits(t, 2, NULL), "limits");
    NULL_REFUSED(arcfeed_tracking_set_limits(NULL, 2, limits), "tracking");
    REFUSED(arcfeed_tracking_set_limits(t, 3, limits), ARCFEED_INVALID, "axes is 3", "2");
    NULL_REFUSED(arcfeed_tracking_state(t, 2, NULL), "states");
    NULL_REFUSED(arcfeed_tracking_state(NULL, 2, start), "tracking");
    /* Nothing that was refused has moved an axis. */
    MUST(arcfeed_tracking_state(t, 2, start));
    EXPECT(start[0].position == 0 && start[0].velocity == 1.5 && start[1].position == 0);
    /* Limits that are set hold: a slow second axis. */
    limits[1] = (ArcfeedAxisLimits){-0.1, 0.1, -5, 5, -50, 50};
    MUST(arcfeed_tracking_set_limits(t, 2, limits));
    bool slow = true;
    for (int i = 0; i < 8000; i++) {
        slow &= arcfeed_tracking_step(t, 2, target, states, &status) == ARCFEED_OK && states[1].velocity < 0.1 + 1e-9;
        slow &= status.is_following == (status.following == 3) && ((status.following & 2) == 0 || i > 4500);
    }
    EXPECT(slow && status.is_following && states[0].position == 1 && states[1].position == 0.5);
    /* A target that is faster than the axis. */
    target[1].velocity = 0.3;
    MUST(arcfeed_tracking_step(t, 2, target, states, &status));
    EXPECT(status.following == 1 && status.saturated == 2 && !status.is_following);
    arcfeed_tracking_free(t);
}

static void trajectory(void) {
    const ArcfeedAxisState start[1] = {{0, 0, 0}};
    ArcfeedAxisState target[1] = {{1, 0, 0}};
    ArcfeedMotionOptions options = {ARCFEED_SYNC_TIME, 0, 0};
    ArcfeedTrajectory *t = NULL;
    ArcfeedMotionState state[1];
    NULL_REFUSED(arcfeed_trajectory_new(1, start, target, &LIMITS, NULL, &t), "options");
    NULL_REFUSED(arcfeed_trajectory_new(1, start, NULL, &LIMITS, &options, &t), "target");
    options.least_duration = -1;
    REFUSED(arcfeed_trajectory_new(1, start, target, &LIMITS, &options, &t), ARCFEED_INVALID, "duration", "-1");
    options.least_duration = 0;
    options.cycle = NAN;
    REFUSED(arcfeed_trajectory_new(1, start, target, &LIMITS, &options, &t), ARCFEED_INVALID, "cycle", "NaN");
    options.cycle = 0;
    target[0].velocity = 2; /* above the limit */
    REFUSED(arcfeed_trajectory_new(1, start, target, &LIMITS, &options, &t), ARCFEED_REFUSED, "axis 1", "2");
    target[0].velocity = 0;
    MUST(arcfeed_trajectory_new(1, start, target, &LIMITS, &options, &t));
    REFUSED(arcfeed_trajectory_at(t, NAN, 1, state), ARCFEED_INVALID, "t is", "NaN");
    NULL_REFUSED(arcfeed_trajectory_at(t, 0.5, 1, NULL), "states");
    NULL_REFUSED(arcfeed_trajectory_duration(NULL, NULL), "trajectory");
    NULL_REFUSED(arcfeed_trajectory_is_straight(t, NULL), "is_straight");
    arcfeed_trajectory_free(t);
}

static void projection(void) {
    ArcfeedPoseState start = {{0.4, 0, 0.3, 1, 0, 0, 0}, {0}, {0}}, state;
    ArcfeedPose target = {0.4, 0.3, 0.2, 1, 0, 0, 0};
    ArcfeedPoseLimits limits = {{0.5, 3, 40}, {1.5, 8, 100}};
    ArcfeedProjection *p = NULL;
    NULL_REFUSED(arcfeed_projection_new(NULL, &target, &limits, &p), "start");
    start.velocity[4] = NAN;
    REFUSED(arcfeed_projection_new(&start, &target, &limits, &p), ARCFEED_INVALID, "start.velocity[4]", "NaN");
    start.velocity[4] = 0;
    start.pose.qx = NAN;
    REFUSED(arcfeed_projection_new(&start, &target, &limits, &p), ARCFEED_INVALID, "start.pose.qx", "NaN");
    start.pose.qx = 0;
    target.qw = 2;
    REFUSED(arcfeed_projection_new(&start, &target, &limits, &p), ARCFEED_INVALID, "target", "norm");
    target.qw = 1;
    limits.angular[2] = -1;
    REFUSED(arcfeed_projection_new(&start, &target, &limits, &p), ARCFEED_INVALID, "angular jerk limit", "-1");
    limits.angular[2] = 100;
    MUST(arcfeed_projection_new(&start, &target, &limits, &p));
    NULL_REFUSED(arcfeed_projection_step(p, 1e-3, NULL, NULL), "state");
    REFUSED(arcfeed_projection_step(p, NAN, &state, NULL), ARCFEED_INVALID, "period", "NaN");
    NULL_REFUSED(arcfeed_projection_set_target(p, NULL), "target");
    NULL_REFUSED(arcfeed_projection_set_limits(p, NULL), "limits");
    NULL_REFUSED(arcfeed_projection_time_left(p, NULL), "seconds");
    arcfeed_projection_free(p);
}

static void files(void) {
    static const char *const JUMP = "{\"format\": \"joint-trajectory/1\", \"interpolation\": \"quintic\", \"joint_names\": [\"a\"],"
                                    "\"times_s\": [0.0, 1.0, 2.0], \"coefficients_rad_per_s_k\": [[[0,0,0,0,0,0]], [[1,0,0,0,0,0]]]}";
    ArcfeedJointTrajectory *t = NULL;
    ArcfeedArm *arm = NULL;
    NULL_REFUSED(arcfeed_joint_trajectory_load(NULL, &t), "path");
    REFUSED(arcfeed_joint_trajectory_load("no/such/file.json", &t), ARCFEED_FILE, "no/such/file.json", "");
    REFUSED(arcfeed_joint_trajectory_parse("{}", &t), ARCFEED_FILE, "joint_names", "missing");
    REFUSED(arcfeed_joint_trajectory_parse("{\"joint_names\": []}", &t), ARCFEED_INVALID, "axes", "0");
    REFUSED(arcfeed_joint_trajectory_parse("\xff", &t), ARCFEED_INVALID, "json", "UTF-8");
    REFUSED(arcfeed_joint_trajectory_parse(JUMP, &t), ARCFEED_FILE, "joint 1", "jump");
    EXPECT(arcfeed_joint_trajectory_joints(NULL) == 0);
    REFUSED(arcfeed_arm_builtin("r2d2", &arm), ARCFEED_INVALID, "r2d2", "ur5e");
    NULL_REFUSED(arcfeed_arm_builtin(NULL, &arm), "name");
    REFUSED(arcfeed_arm_load("no/such/arm.urdf", NULL, NULL, &arm), ARCFEED_FILE, "no/such/arm.urdf", "");
    EXPECT(arm == NULL && arcfeed_arm_joints(NULL) == 0);
}

static void arm(void) {
    ArcfeedArm *arm = NULL;
    ArcfeedPose pose;
    double q[6] = {0.3, -0.2, 1.4, 0.3, -1.5, 0.0}, all[6 * ARCFEED_MAX_SOLUTIONS];
    size_t count = 7;
    const char *name = NULL;
    MUST(arcfeed_arm_builtin("cr7", &arm));
    NULL_REFUSED(arcfeed_arm_forward(NULL, 6, q, &pose), "arm");
    NULL_REFUSED(arcfeed_arm_forward(arm, 6, NULL, &pose), "q");
    NULL_REFUSED(arcfeed_arm_forward(arm, 6, q, NULL), "pose");
    REFUSED(arcfeed_arm_forward(arm, 5, q, &pose), ARCFEED_INVALID, "5", "6");
    q[3] = NAN;
    REFUSED(arcfeed_arm_forward(arm, 6, q, &pose), ARCFEED_INVALID, "q[3]", "NaN");
    q[3] = 0.3;
    MUST(arcfeed_arm_forward(arm, 6, q, &pose));
    pose.z = NAN;
    REFUSED(arcfeed_arm_inverse(arm, &pose, 6, q, q), ARCFEED_INVALID, "target.z", "NaN");
    pose.z = 9;
    REFUSED(arcfeed_arm_inverse(arm, &pose, 6, q, q), ARCFEED_REFUSED, "reach", "");
    REFUSED(arcfeed_arm_inverse_all(arm, &pose, 6, all, &count), ARCFEED_REFUSED, "reach", "");
    EXPECT(count == 0);
    NULL_REFUSED(arcfeed_arm_inverse_all(arm, &pose, 6, all, NULL), "count");
    NULL_REFUSED(arcfeed_arm_set_tool(arm, NULL), "tool");
    NULL_REFUSED(arcfeed_arm_ranges(arm, 6, NULL), "ranges");
    REFUSED(arcfeed_arm_joint_name(arm, 6, &name), ARCFEED_INVALID, "joint is 6", "6");
    arcfeed_arm_free(arm);
}

int main(void) {
    EXPECT(strcmp(arcfeed_last_error(), "") == 0);
    generator_is_made();
    generator_is_used();
    way_points();
    tracking();
    trajectory();
    projection();
    files();
    arm();
    printf("refusals: %d checks, %d failed\n", checks, failures);
    return failures == 0 ? 0 : 1;
}
