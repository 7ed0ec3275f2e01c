/* Bad input from C: every call names the argument and its value, and nothing crashes. */
#include "refused.h"

#include <math.h>

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
    trajectory();
    projection();
    files();
    arm();
    return result("refusals");
}
