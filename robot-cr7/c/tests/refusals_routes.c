/* Bad input to way-points and tracking: every call names the argument and its value, and what was refused moves nothing. */
#include "refused.h"

#include <math.h>

/* A route of two points for two axes, and what it points to. */
typedef struct Fixture {
    ArcfeedAxisState start[2], target[2];
    ArcfeedAxisLimits limits[2], section[2];
    ArcfeedWayPoint points[ARCFEED_MAX_WAY_POINTS];
    ArcfeedRoute route;
} Fixture;

static Fixture f;

static ArcfeedGenerator *fresh(void) {
    f = (Fixture){.target = {{1, 0, 0}, {0.5, 0, 0}}, .limits = {LIMITS, LIMITS}, .section = {LIMITS, LIMITS}};
    f.points[0] = (ArcfeedWayPoint){.position = {0.3, 0.2}};
    f.points[1] = (ArcfeedWayPoint){.position = {0.6, 0.1}};
    f.route = (ArcfeedRoute){.count = 2, .points = f.points, .target = f.target, .limits = f.limits};
    ArcfeedGenerator *w = NULL;
    MUST(arcfeed_generator_new(2, f.start, f.limits, 1e-3, ARCFEED_SYNC_TIME, &w));
    MUST(arcfeed_generator_reserve_way_points(w));
    MUST(arcfeed_generator_set_route(w, 2, &f.route));
    return w;
}

static void memory_is_reserved(void) {
    arcfeed_generator_free(fresh());
    ArcfeedGenerator *w = NULL;
    MUST(arcfeed_generator_new(2, f.start, f.limits, 1e-3, ARCFEED_SYNC_TIME, &w));
    size_t sections = 1;
    MUST(arcfeed_generator_sections(w, &sections));
    EXPECT(sections == 0);
    REFUSED(arcfeed_generator_set_route(w, 2, &f.route), ARCFEED_INVALID, "memory", "arcfeed_generator_reserve_way_points");
    NULL_REFUSED(arcfeed_generator_reserve_way_points(NULL), "generator");
    MUST(arcfeed_generator_reserve_way_points(w));
    MUST(arcfeed_generator_reserve_way_points(w));
    MUST(arcfeed_generator_set_route(w, 2, &f.route));
    /* The limits of a route are its own, and so are points beside a range. */
    REFUSED(arcfeed_generator_set_limits(w, 2, f.limits), ARCFEED_REFUSED, "limits", "route");
    const ArcfeedRange ranges[2] = {{-2, 2}, {-2, 0.3}};
    REFUSED(arcfeed_generator_set_ranges(w, 2, ranges), ARCFEED_REFUSED, "axis 2", "0.3");
    arcfeed_generator_free(w);
}

static void routes_are_refused(void) {
    ArcfeedGenerator *w = fresh();
    /* What a route may not be. Entries past the axes are not read. */
    f.points[1].position[2] = NAN;
    MUST(arcfeed_generator_set_route(w, 2, &f.route));
#define ROUTE_REFUSED(change, back, status, first, second)                                                            \
    change;                                                                                                           \
    refused(arcfeed_generator_set_route(w, 2, &f.route), status, first, second, __LINE__);                           \
    back
    ROUTE_REFUSED(f.route.count = 65, f.route.count = 2, ARCFEED_INVALID, "route.count is 65", "at most 64");
    ROUTE_REFUSED(f.route.count = (size_t)-1, f.route.count = 2, ARCFEED_INVALID, "route.count", "at most 64");
    ROUTE_REFUSED(f.route.points = NULL, f.route.points = f.points, ARCFEED_NULL, "route.points", "NULL");
    ROUTE_REFUSED(f.route.target = NULL, f.route.target = f.target, ARCFEED_NULL, "route.target", "NULL");
    ROUTE_REFUSED(f.route.limits = NULL, f.route.limits = f.limits, ARCFEED_NULL, "route.limits", "NULL");
    f.route.points = (ArcfeedWayPoint *)((char *)f.points + 1);
    REFUSED(arcfeed_generator_set_route(w, 2, &f.route), ARCFEED_NULL, "route.points", "aligned");
    f.route.points = f.points;
    ROUTE_REFUSED(f.points[1].position[1] = NAN, f.points[1].position[1] = 0.1, ARCFEED_INVALID, "route.points[1].position[1]", "NaN");
    f.points[1].has_velocity = 2;
    ROUTE_REFUSED(f.points[1].velocity[1] = NAN, f.points[1].velocity[1] = 0, ARCFEED_INVALID, "route.points[1].velocity[1]", "NaN");
    ROUTE_REFUSED(f.points[1].velocity[1] = 1.5, f.points[1].velocity[1] = 0, ARCFEED_REFUSED, "way-point 2, axis 2", "1.5");
    ROUTE_REFUSED(f.points[1].has_velocity = 4, f.points[1].has_velocity = 0, ARCFEED_INVALID, "route.points[1].has_velocity", "100");
    ROUTE_REFUSED(f.points[0].blend = -1, f.points[0].blend = 0, ARCFEED_INVALID, "points[0].blend", "-1");
    ROUTE_REFUSED(f.points[1].blend = NAN, f.points[1].blend = 0, ARCFEED_INVALID, "points[1].blend", "NaN");
    ROUTE_REFUSED(f.points[1].blend = 0.01, f.points[1].blend = 0, ARCFEED_REFUSED, "way-point 2", "straight");
    ROUTE_REFUSED(f.points[0].least_duration = -1, f.points[0].least_duration = 0, ARCFEED_INVALID, "points[0].least_duration", "-1");
    ROUTE_REFUSED(f.points[0].least_duration = NAN, f.points[0].least_duration = 0, ARCFEED_INVALID, "points[0].least_duration", "NaN");
    ROUTE_REFUSED(f.points[1].straight = 2, f.points[1].straight = 0, ARCFEED_INVALID, "route.points[1].straight is 2", "0 or 1");
    ROUTE_REFUSED(f.route.last_straight = 255, f.route.last_straight = 0, ARCFEED_INVALID, "route.last_straight is 255", "0 or 1");
    static ArcfeedWayPoint corners[33];
    for (int i = 0; i < 33; i++) {
        corners[i] = (ArcfeedWayPoint){.position = {0.1 * (i + 1), 0.1 * (i % 2)}, .straight = 1, .blend = 0.01};
    }
    f.route.points = corners;
    f.route.last_straight = 1;
    ROUTE_REFUSED(f.route.count = 33, f.route.count = 2, ARCFEED_INVALID, "route.count is 33, with blends 66", "at most 64");
    f.route.last_straight = 0;
    f.route.points = f.points;
    f.section[1].a_max = NAN;
    ROUTE_REFUSED(f.points[1].limits = f.section, f.points[1].limits = NULL, ARCFEED_INVALID, "route.points[1].limits[1].a_max", "NaN");
    ROUTE_REFUSED(f.route.last_limits = f.section, f.route.last_limits = NULL, ARCFEED_INVALID, "route.last_limits[1].a_max", "NaN");
    ROUTE_REFUSED(f.route.last_least_duration = INFINITY, f.route.last_least_duration = 0, ARCFEED_INVALID, "last_least_duration", "inf");
    ROUTE_REFUSED(f.limits[0].v_min = 1, f.limits[0].v_min = -1, ARCFEED_INVALID, "route.limits[0].v_min", "must be");
    ROUTE_REFUSED(f.target[1].velocity = NAN, f.target[1].velocity = 0, ARCFEED_INVALID, "route.target[1].velocity", "NaN");
    ROUTE_REFUSED(f.target[1].velocity = 2, f.target[1].velocity = 0, ARCFEED_REFUSED, "axis 2", "2");
    REFUSED(arcfeed_generator_set_route(w, 3, &f.route), ARCFEED_INVALID, "axes is 3", "2");
    NULL_REFUSED(arcfeed_generator_set_route(NULL, 2, &f.route), "generator");
    NULL_REFUSED(arcfeed_generator_set_route(w, 2, NULL), "route");
    ArcfeedMotionState states[2];
    ArcfeedEvents events;
    /* Nothing that was refused has moved an axis: this is the first cycle of the route. */
    MUST(arcfeed_generator_step(w, 2, states, &events));
    EXPECT(events.passed == 0 && !events.reached && states[0].position > 0 && states[0].position < 1e-7);
    arcfeed_generator_free(w);
}

static void way_points_are_used(void) {
    ArcfeedGenerator *w = fresh();
    ArcfeedMotionState states[2];
    ArcfeedEvents events;
    double seconds[ARCFEED_MAX_WAY_POINTS + 1];
    NULL_REFUSED(arcfeed_generator_step(NULL, 2, states, NULL), "generator");
    NULL_REFUSED(arcfeed_generator_step(w, 2, NULL, NULL), "states");
    REFUSED(arcfeed_generator_step(w, 1, states, NULL), ARCFEED_INVALID, "axes is 1", "2");
    REFUSED(arcfeed_generator_step(w, 2, states, (ArcfeedEvents *)((char *)&events + 1)), ARCFEED_NULL, "events", "aligned");
    NULL_REFUSED(arcfeed_generator_stop(NULL), "generator");
    NULL_REFUSED(arcfeed_generator_state(w, 2, NULL), "states");
    NULL_REFUSED(arcfeed_generator_section_durations(w, 3, NULL), "seconds");
    REFUSED(arcfeed_generator_section_durations(w, 2, seconds), ARCFEED_INVALID, "count is 2", "3 sections");
    REFUSED(arcfeed_generator_route_at(w, NAN, 2, states), ARCFEED_INVALID, "t is", "NaN");
    NULL_REFUSED(arcfeed_generator_route_at(w, 0.5, 2, NULL), "states");
    /* The last section has a duration and limits of its own. */
    f.route.last_least_duration = 3;
    MUST(arcfeed_generator_set_route(w, 2, &f.route));
    MUST(arcfeed_generator_section_durations(w, 3, seconds));
    EXPECT(seconds[0] < 3 && seconds[1] < 3 && seconds[2] > 3 - 1e-9);
    f.section[0] = f.section[1] = (ArcfeedAxisLimits){-0.1, 0.1, -1, 1, -10, 10};
    f.route.last_limits = f.section;
    f.route.last_least_duration = 0;
    MUST(arcfeed_generator_set_route(w, 2, &f.route));
    MUST(arcfeed_generator_section_durations(w, 3, seconds));
    MUST(arcfeed_generator_time_left(w, &seconds[3]));
    EXPECT(seconds[2] > 4 && fabs(seconds[0] + seconds[1] + seconds[2] - seconds[3]) < 1e-12); /* 0.4 at 0.1 / s */
    f.route.last_limits = NULL;
    /* A stop ends in rest before the target. */
    ArcfeedStatus stepped = ARCFEED_OK;
    for (int i = 0; i < 300 && stepped == ARCFEED_OK; i++) {
        stepped = arcfeed_generator_step(w, 2, states, NULL);
    }
    MUST(arcfeed_generator_stop(w));
    int left = 1000;
    for (events.reached = false; !events.reached && left > 0 && stepped == ARCFEED_OK; left--) {
        stepped = arcfeed_generator_step(w, 2, states, &events);
    }
    EXPECT(stepped == ARCFEED_OK && left > 0 && fabs(states[0].velocity) < 1e-12 && states[0].position > 0.01 && states[0].position < 0.5);
    MUST(arcfeed_generator_state(w, 2, f.start));
    EXPECT(f.start[0].position == states[0].position && f.start[1].velocity == states[1].velocity);
    /* As many points as there can be, and none. */
    for (size_t i = 0; i < ARCFEED_MAX_WAY_POINTS; i++) {
        f.points[i] = (ArcfeedWayPoint){.position = {0.1 * (double)(i + 1), i % 2 == 0 ? 0.1 : 0.0}};
    }
    f.route.count = ARCFEED_MAX_WAY_POINTS;
    MUST(arcfeed_generator_set_route(w, 2, &f.route));
    MUST(arcfeed_generator_section_durations(w, ARCFEED_MAX_WAY_POINTS + 1, seconds));
    f.route.count = 0;
    f.route.points = NULL;
    MUST(arcfeed_generator_set_route(w, 2, &f.route));
    arcfeed_generator_free(w);
    /* A start outside the limits is no error: it is brought back inside. */
    f.start[0].velocity = 1.5;
    MUST(arcfeed_generator_new(2, f.start, f.limits, 1e-3, ARCFEED_SYNC_TIME, &w));
    MUST(arcfeed_generator_reserve_way_points(w));
    MUST(arcfeed_generator_set_route(w, 2, &f.route));
    bool inside = true;
    int cycles = 0;
    for (events.reached = false; !events.reached && cycles < 10000; cycles++) {
        inside &= arcfeed_generator_step(w, 2, states, &events) == ARCFEED_OK;
        inside &= states[0].velocity < 1.5 && states[0].acceleration > -5.000001 && (cycles < 1000 || states[0].velocity < 1);
    }
    EXPECT(inside && states[0].position == 1 && states[0].velocity == 0);
    arcfeed_generator_free(w);
}

/* Along two lines: the corner is rounded by as much as is asked for, and the axes rest in it otherwise. */
static void lines_are_straight(void) {
    for (int blended = 0; blended < 2; blended++) {
        ArcfeedGenerator *w = fresh();
        ArcfeedMotionState states[2];
        ArcfeedEvents events = {0};
        size_t count = 0, passed = 0;
        f.points[0] = (ArcfeedWayPoint){.position = {0.5, 0}, .straight = 1, .blend = blended ? 0.01 : 0};
        f.target[0].position = f.target[1].position = 0.5;
        f.route.count = 1;
        f.route.last_straight = 1;
        MUST(arcfeed_generator_set_route(w, 2, &f.route));
        MUST(arcfeed_generator_sections(w, &count));
        NULL_REFUSED(arcfeed_generator_sections(w, NULL), "count");
        EXPECT(count == (blended ? 3 : 2));
        double nearest = 1, beside = 0;
        for (int i = 0; i < 5000 && !events.reached; i++) {
            MUST(arcfeed_generator_step(w, 2, states, &events));
            const double x = states[0].position, y = states[1].position;
            nearest = fmin(nearest, hypot(x - 0.5, y));
            beside = fmax(beside, fmin(fabs(y), fabs(x - 0.5)));
            passed += events.passed;
        }
        EXPECT(events.reached && passed == 1 && states[0].position == 0.5 && states[1].position == 0.5);
        EXPECT(blended ? nearest > 0.0099 && nearest < 0.0101 && beside > 0.005 && beside < 0.01 : nearest < 1e-12 && beside < 1e-12);
        arcfeed_generator_free(w);
    }
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
        slow &= states[0].velocity < (i < 500 ? 1.5 : 1 + 1e-9) && status.is_following == (status.following == 3) && ((status.following & 2) == 0 || i > 4500);
    }
    EXPECT(slow && status.is_following && states[0].position == 1 && states[1].position == 0.5);
    /* A target that is faster than the axis. */
    target[1].velocity = 0.3;
    MUST(arcfeed_tracking_step(t, 2, target, states, &status));
    EXPECT(status.following == 1 && status.saturated == 2 && !status.is_following);
    arcfeed_tracking_free(t);
}

int main(void) {
    memory_is_reserved();
    routes_are_refused();
    way_points_are_used();
    lines_are_straight();
    tracking();
    return result("refusals of way-points and tracking");
}
