/* arcfeed for C and C++. Made by cbindgen from robot-cr7/c/src; do not edit.
 *
 * Every function that can fail returns an ArcfeedStatus; arcfeed_last_error() has the text. Nothing unwinds into C.
 * Units: m, rad, s. Counts of axes and joints are from 1 to ARCFEED_MAX_AXES.
 */

#ifndef ARCFEED_H
#define ARCFEED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// The most solutions of `arcfeed_arm_inverse_all`.
#define ARCFEED_MAX_SOLUTIONS 8

// The greatest number of axes or joints.
#define ARCFEED_MAX_AXES 8

// The most way-points of a route.
#define ARCFEED_MAX_WAY_POINTS 64

// The result of a call. `arcfeed_last_error` explains every value but `ARCFEED_OK`.
typedef enum ArcfeedStatus {
  // Done.
  ARCFEED_OK = 0,
  // A pointer is NULL or not aligned.
  ARCFEED_NULL = 1,
  // An argument breaks a rule: a number is NaN, a limit is negative, a count is wrong, a name is unknown.
  ARCFEED_INVALID = 2,
  // The arguments are valid, but there is no such motion or no such joint values. Nothing has changed.
  ARCFEED_REFUSED = 3,
  // A file cannot be read, or its content is not what it should be.
  ARCFEED_FILE = 4,
  // A defect of the library. The value that was worked on must be freed and not used again.
  ARCFEED_INTERNAL = 5,
} ArcfeedStatus;

// Status of a projected motion.
typedef enum ArcfeedProjectionStatus {
  // The state is being brought inside the limits.
  ARCFEED_PROJECTION_RECOVERING = 0,
  // The velocity across the line to the target is being taken off.
  ARCFEED_PROJECTION_TURNING = 1,
  // On the straight line to the target.
  ARCFEED_PROJECTION_STRAIGHT = 2,
  // At the target, at rest.
  ARCFEED_PROJECTION_REACHED = 3,
} ArcfeedProjectionStatus;

// How the axes move together. Functions take it as an `int32_t`, so that another number is an error and no defect.
typedef enum ArcfeedSynchronisation {
  // Every axis moves as fast as it can and arrives on its own.
  ARCFEED_SYNC_NONE = 0,
  // All axes arrive at the same time, the earliest that is possible.
  ARCFEED_SYNC_TIME = 1,
  // A straight line wherever both states lie on one, otherwise as `ARCFEED_SYNC_TIME`.
  ARCFEED_SYNC_STRAIGHT = 2,
  // A straight line, or an error.
  ARCFEED_SYNC_FORCED_STRAIGHT = 3,
} ArcfeedSynchronisation;

// An arm of 1 to 8 joints. Several threads may read it while none sets its tool.
typedef struct ArcfeedArm ArcfeedArm;

// Generates the motion of 1 to 8 axes one control cycle at a time, towards targets and within limits that may change in
// any cycle. One thread uses it at a time.
typedef struct ArcfeedGenerator ArcfeedGenerator;

// A motion of joints as polynomials of the time, from a file of the format "joint-trajectory/1". It does not change:
// several threads may read it.
typedef struct ArcfeedJointTrajectory ArcfeedJointTrajectory;

// Moves a tool on a straight line, turning about one axis, to a target pose that may change in any cycle. One thread
// uses it at a time.
typedef struct ArcfeedProjection ArcfeedProjection;

// Follows a moving target with 1 to 8 axes, each within its own limits: a conveyor, a teleoperator. One thread uses it at
// a time.
typedef struct ArcfeedTracking ArcfeedTracking;

// The shortest motion of 1 to 8 axes from a state to a state. It does not change: several threads may read it.
typedef struct ArcfeedTrajectory ArcfeedTrajectory;

// The range of positions of an axis; infinite ends for none.
typedef struct ArcfeedRange {
  // Lower end (rad or m).
  double lower;
  // Upper end (rad or m), above the lower one.
  double upper;
} ArcfeedRange;

// A pose of a tool in the base: position (m) and unit quaternion.
typedef struct ArcfeedPose {
  // Position along x (m).
  double x;
  // Position along y (m).
  double y;
  // Position along z (m).
  double z;
  // Scalar part of the quaternion.
  double qw;
  // First vector part of the quaternion.
  double qx;
  // Second vector part of the quaternion.
  double qy;
  // Third vector part of the quaternion.
  double qz;
} ArcfeedPose;

// Position (rad or m), velocity and acceleration of an axis.
typedef struct ArcfeedAxisState {
  // Position (rad or m).
  double position;
  // Velocity (rad/s or m/s).
  double velocity;
  // Acceleration (rad/s^2 or m/s^2).
  double acceleration;
} ArcfeedAxisState;

// Limits of an axis. Lower ones are below 0, upper ones above.
typedef struct ArcfeedAxisLimits {
  // Lowest velocity, below 0.
  double v_min;
  // Highest velocity, above 0.
  double v_max;
  // Lowest acceleration, below 0.
  double a_min;
  // Highest acceleration, above 0.
  double a_max;
  // Lowest jerk, below 0.
  double j_min;
  // Highest jerk, above 0.
  double j_max;
} ArcfeedAxisLimits;

// Position (rad or m) of an axis and its first three derivatives by time.
typedef struct ArcfeedMotionState {
  // Position (rad or m).
  double position;
  // Velocity (rad/s or m/s).
  double velocity;
  // Acceleration (rad/s^2 or m/s^2).
  double acceleration;
  // Jerk (rad/s^3 or m/s^3).
  double jerk;
} ArcfeedMotionState;

// What happened in a cycle. Bit k of a mask belongs to axis k.
typedef struct ArcfeedEvents {
  // The axes that arrived in this cycle: each is in its target exactly.
  uint32_t arrived;
  // The axes that go on after their target and brake because their range ends.
  uint32_t range_ends;
  // Number of way-points of the route that were passed in this cycle; one with a blend is passed where the blend ends.
  size_t passed;
  // The last axis that was under way arrived in this cycle.
  bool reached;
  // A new plan took effect because the target or the limits changed.
  bool replanned;
  // Limits were set below the state of an axis: it is brought back inside while this holds.
  bool outside_limits;
} ArcfeedEvents;

// A position that all axes pass at the same time, and what holds on the section that ends there. Entries past the number
// of axes are not read. Only the position must be given: a field left at 0 sets nothing.
typedef struct ArcfeedWayPoint {
  // The position of each axis (rad or m).
  double position[ARCFEED_MAX_AXES];
  // The velocity of each axis whose bit is in `has_velocity` (rad/s or m/s).
  double velocity[ARCFEED_MAX_AXES];
  // Bit k: axis k passes with `velocity[k]`. The others pass as is best.
  uint32_t has_velocity;
  // Limits of the section that ends here, one entry for each axis; NULL for those of the route.
  const struct ArcfeedAxisLimits *limits;
  // Least duration of the section that ends here (s); 0 for the shortest.
  double least_duration;
  // Between two straight sections the point is passed within this distance (root of the sum of the squares of all axes, rad
  // or m), or the axes rest where that is faster; with 0 they rest.
  double blend;
  // 0 or 1; with 1 all axes move on a straight line to the point.
  uint8_t straight;
} ArcfeedWayPoint;

// Way-points, the target after them, and limits. Points and blends together are at most `ARCFEED_MAX_WAY_POINTS`. A call copies
// what it points to.
typedef struct ArcfeedRoute {
  // Number of way-points, from 0 to `ARCFEED_MAX_WAY_POINTS`.
  size_t count;
  // The way-points; may be NULL if there are none.
  const struct ArcfeedWayPoint *points;
  // The state of each axis at the end.
  const struct ArcfeedAxisState *target;
  // The limits of each axis.
  const struct ArcfeedAxisLimits *limits;
  // Limits of the section that ends in the target, one entry for each axis; NULL for those of the route.
  const struct ArcfeedAxisLimits *last_limits;
  // Least duration of the section that ends in the target (s); 0 for the shortest.
  double last_least_duration;
  // 0 or 1; with 1 all axes move on a straight line to the target.
  uint8_t last_straight;
} ArcfeedRoute;

// Pose of a tool and its first two derivatives, in base axes, at the tool point.
typedef struct ArcfeedPoseState {
  // Tool in base.
  struct ArcfeedPose pose;
  // Linear x, y, z (m/s), then angular x, y, z (rad/s).
  double velocity[6];
  // Linear x, y, z (m/s^2), then angular x, y, z (rad/s^2).
  double acceleration[6];
} ArcfeedPoseState;

// Bounds of the norms of velocity, acceleration and jerk of a tool, each above 0.
typedef struct ArcfeedPoseLimits {
  // Velocity (m/s), acceleration (m/s^2) and jerk (m/s^3) of the tool point.
  double linear[3];
  // Angular velocity (rad/s), acceleration (rad/s^2) and jerk (rad/s^3).
  double angular[3];
} ArcfeedPoseLimits;

// What the axes do in a cycle. Bit k of a mask belongs to axis k.
typedef struct ArcfeedTrackingStatus {
  // The axes that are in the state of the target exactly.
  uint32_t following;
  // The axes that do what their limits allow, because the target exceeds them.
  uint32_t saturated;
  // Every axis is in the state of its target. Axes in neither mask are on their way.
  bool is_following;
} ArcfeedTrackingStatus;

// Choices for a motion from state to state.
typedef struct ArcfeedMotionOptions {
  // An ArcfeedSynchronisation.
  int32_t synchronisation;
  // The motion takes at least this long (s): exactly, unless that duration is impossible. 0 for the shortest.
  double least_duration;
  // The duration is a multiple of this (s), the shortest that is possible. 0 for any duration.
  double cycle;
} ArcfeedMotionOptions;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// A built-in arm by its name, for example "cr7" or "ur5e". On success `*out` holds it, else NULL.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_arm_builtin(const char *name, struct ArcfeedArm **out);

// The arm of a file: JSON of the format "arm-params/1" if the name ends in ".json", else URDF. `base` and `tip` name
// links of a URDF; NULL for the root, and for the hand, `tool0` or the only end of its chain. On success `*out` holds the arm,
// else NULL.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_arm_load(const char *path,
                                    const char *base,
                                    const char *tip,
                                    struct ArcfeedArm **out);

// Frees an arm; NULL is nothing to free.
//
// The arm is not used again.
void arcfeed_arm_free(struct ArcfeedArm *arm);

// Number of joints; 0 for NULL.
//
// The arm is NULL or one that was made and not freed.
size_t arcfeed_arm_joints(const struct ArcfeedArm *arm);

// Name of a joint, counted from 0. The text belongs to the arm.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_arm_joint_name(const struct ArcfeedArm *arm, size_t joint, const char **name);

// The range of each joint (rad or m).
//
// Each pointer is valid for its type, or NULL, which is refused; `ranges` has room for `joints` entries.
enum ArcfeedStatus arcfeed_arm_ranges(const struct ArcfeedArm *arm,
                                      size_t joints,
                                      struct ArcfeedRange *ranges);

// Sets the tool point in the frame of the flange. Allocates.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_arm_set_tool(struct ArcfeedArm *arm, const struct ArcfeedPose *tool);

// The pose of the tool in the base for the joint values `q` (rad or m).
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_arm_forward(const struct ArcfeedArm *arm,
                                       size_t joints,
                                       const double *q,
                                       struct ArcfeedPose *pose);

// Joint values inside the range of the joints that put the tool at `target`, as near to `seed` as can be. `q` and
// `seed` may be the same array.
//
// Each pointer is valid for its type, or NULL, which is refused; `q` has room for `joints` entries.
enum ArcfeedStatus arcfeed_arm_inverse(const struct ArcfeedArm *arm,
                                       const struct ArcfeedPose *target,
                                       size_t joints,
                                       const double *seed,
                                       double *q);

// All joint values that put the tool at `target`, each angle in (-pi, pi], without regard to the range of the joints;
// of a numeric inverse several. `q` gets one solution after the other, `*count` their number.
//
// Each pointer is valid for its type, or NULL, which is refused; `q` has room for `ARCFEED_MAX_SOLUTIONS` times `joints` entries.
enum ArcfeedStatus arcfeed_arm_inverse_all(const struct ArcfeedArm *arm,
                                           const struct ArcfeedPose *target,
                                           size_t joints,
                                           double *q,
                                           size_t *count);

// A generator at `start`, which is the target, too, until one is set. `start` and `limits` have `axes` entries; `cycle`
// is the control cycle (s); `synchronisation` is an ArcfeedSynchronisation. On success `*out` holds the generator, else NULL.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_generator_new(size_t axes,
                                         const struct ArcfeedAxisState *start,
                                         const struct ArcfeedAxisLimits *limits,
                                         double cycle,
                                         int32_t synchronisation,
                                         struct ArcfeedGenerator **out);

// Frees a generator; NULL is nothing to free.
//
// The generator is not used again.
void arcfeed_generator_free(struct ArcfeedGenerator *generator);

// Sets the range of positions of each axis. What is under way must stay inside, else the call is refused.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_generator_set_ranges(struct ArcfeedGenerator *generator,
                                                size_t axes,
                                                const struct ArcfeedRange *ranges);

// Sets the state to reach. A call that is refused changes nothing.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_generator_set_target(struct ArcfeedGenerator *generator,
                                                size_t axes,
                                                const struct ArcfeedAxisState *target);

// Sets the state that one axis, counted from 0, is to reach.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_generator_set_axis_target(struct ArcfeedGenerator *generator,
                                                     size_t axis,
                                                     const struct ArcfeedAxisState *target);

// Sets the limits of all axes. The target must be inside of them, else the call is refused; so it is on a route, which has its own
// limits, until the axes have left it.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_generator_set_limits(struct ArcfeedGenerator *generator,
                                                size_t axes,
                                                const struct ArcfeedAxisLimits *limits);

// Sets target and limits at once: where neither goes with the other's old value.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_generator_set(struct ArcfeedGenerator *generator,
                                         size_t axes,
                                         const struct ArcfeedAxisState *target,
                                         const struct ArcfeedAxisLimits *limits);

// Copies the state of the last step.
//
// Each pointer is valid for its type, or NULL, which is refused; `states` has room for `axes` entries.
enum ArcfeedStatus arcfeed_generator_state(const struct ArcfeedGenerator *generator,
                                           size_t axes,
                                           struct ArcfeedAxisState *states);

// Copies the target; after a stop the place where the axes will stand.
//
// Each pointer is valid for its type, or NULL, which is refused; `target` has room for `axes` entries.
enum ArcfeedStatus arcfeed_generator_target(const struct ArcfeedGenerator *generator,
                                            size_t axes,
                                            struct ArcfeedAxisState *target);

// Moves on by one cycle. `states` gets what to command at its end, one entry for each axis; `events`, if it is not NULL,
// what happened.
//
// Each pointer is valid for its type, or NULL, which is refused; `states` has room for `axes` entries.
enum ArcfeedStatus arcfeed_generator_step(struct ArcfeedGenerator *generator,
                                          size_t axes,
                                          struct ArcfeedMotionState *states,
                                          struct ArcfeedEvents *events);

// Brings every axis to rest in the shortest way of its own, and gives up the targets.
//
// The generator is NULL or one that is in use nowhere else.
enum ArcfeedStatus arcfeed_generator_stop(struct ArcfeedGenerator *generator);

// Brings all axes to rest together on the curve of their plan, and gives up the targets.
//
// The generator is NULL or one that is in use nowhere else.
enum ArcfeedStatus arcfeed_generator_stop_on_path(struct ArcfeedGenerator *generator);

// Moves the axes at `velocity`, one entry for each, until `timeout` (s) is over; then they stop. Another call renews the
// time.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_generator_jog(struct ArcfeedGenerator *generator,
                                         size_t axes,
                                         const double *velocity,
                                         double timeout);

// Sets the scale of time, from 0 to 1.5: 0.5 plays every plan at half its velocity, on the same curve.
//
// The generator is NULL or one that is in use nowhere else.
enum ArcfeedStatus arcfeed_generator_set_scale(struct ArcfeedGenerator *generator, double scale);

// Brings the scale of time to 0: the axes rest on their curve until `arcfeed_generator_resume`.
//
// The generator is NULL or one that is in use nowhere else.
enum ArcfeedStatus arcfeed_generator_hold(struct ArcfeedGenerator *generator);

// Ends a hold.
//
// The generator is NULL or one that is in use nowhere else.
enum ArcfeedStatus arcfeed_generator_resume(struct ArcfeedGenerator *generator);

// Whether an axis has still to reach its target.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_generator_is_underway(const struct ArcfeedGenerator *generator, bool *is_underway);

// Time until the last axis has reached its target (s), at scale 1.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_generator_time_left(const struct ArcfeedGenerator *generator, double *seconds);

// The scale of time at the end of the last cycle.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_generator_scale(const struct ArcfeedGenerator *generator, double *scale);

// Gives the generator the memory that routes are planned in, some 0.1 MB for one axis and 0.6 MB for eight. Called once
// before the first route; it allocates, and takes up to 0.8 MB of stack.
//
// The generator is NULL or one that is in use nowhere else.
enum ArcfeedStatus arcfeed_generator_reserve_way_points(struct ArcfeedGenerator *generator);

// Goes along a route from the present state of motion on, whatever the axes do. Plans it, in a time bounded by the number of
// its points and with up to 0.54 MB of stack for eight axes. The limits of the route take the place of those of the generator.
// A call that is refused changes nothing.
//
// Pointers, those of the route, too, are NULL or point to what their names say.
enum ArcfeedStatus arcfeed_generator_set_route(struct ArcfeedGenerator *generator,
                                               size_t axes,
                                               const struct ArcfeedRoute *route);

// Number of sections of the route set last: one more than it has way-points, and one more for each corner that is rounded and for
// a stop before a straight line that begins in motion; 0 before the first route.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_generator_sections(const struct ArcfeedGenerator *generator,
                                              size_t *count);

// Durations of the sections of the route set last (s); `count` must be their number.
//
// Each pointer is valid for its type, or NULL, which is refused; `seconds` has room for `count` entries.
enum ArcfeedStatus arcfeed_generator_section_durations(const struct ArcfeedGenerator *generator,
                                                       size_t count,
                                                       double *seconds);

// The state of the motion along the route set last at time `t` (s) from its beginning, one entry of `states` for each
// axis, without regard to cycles and other commands. Computes the section of `t` anew.
//
// Each pointer is valid for its type, or NULL, which is refused; `states` has room for `axes` entries.
enum ArcfeedStatus arcfeed_generator_route_at(const struct ArcfeedGenerator *generator,
                                              double t,
                                              size_t axes,
                                              struct ArcfeedMotionState *states);

// The trajectory of a file. On success `*out` holds it, else NULL.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_joint_trajectory_load(const char *path, struct ArcfeedJointTrajectory **out);

// The trajectory of a text, for systems without files. On success `*out` holds it, else NULL.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_joint_trajectory_parse(const char *json, struct ArcfeedJointTrajectory **out);

// Frees a trajectory; NULL is nothing to free.
//
// The trajectory is not used again.
void arcfeed_joint_trajectory_free(struct ArcfeedJointTrajectory *trajectory);

// Number of joints; 0 for NULL.
//
// The trajectory is NULL or one that was loaded and not freed.
size_t arcfeed_joint_trajectory_joints(const struct ArcfeedJointTrajectory *trajectory);

// Name of a joint, counted from 0. The text belongs to the trajectory.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_joint_trajectory_joint_name(const struct ArcfeedJointTrajectory *trajectory,
                                                       size_t joint,
                                                       const char **name);

// Duration (s).
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_joint_trajectory_duration(const struct ArcfeedJointTrajectory *trajectory,
                                                     double *seconds);

// The motion at time `t` (s), one entry of `states` for each joint; `t` is taken to the nearest end. Any time is found
// in about the same time, so that seeking needs no call of its own.
//
// Each pointer is valid for its type, or NULL, which is refused; `states` has room for `joints` entries.
enum ArcfeedStatus arcfeed_joint_trajectory_at(const struct ArcfeedJointTrajectory *trajectory,
                                               double t,
                                               size_t joints,
                                               struct ArcfeedMotionState *states);

// A motion from `start` to rest at `target`. On success `*out` holds the motion, else NULL.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_projection_new(const struct ArcfeedPoseState *start,
                                          const struct ArcfeedPose *target,
                                          const struct ArcfeedPoseLimits *limits,
                                          struct ArcfeedProjection **out);

// Frees a motion; NULL is nothing to free.
//
// The motion is not used again.
void arcfeed_projection_free(struct ArcfeedProjection *projection);

// Sets another target from here on.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_projection_set_target(struct ArcfeedProjection *projection,
                                                 const struct ArcfeedPose *target);

// Sets other limits from here on.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_projection_set_limits(struct ArcfeedProjection *projection,
                                                 const struct ArcfeedPoseLimits *limits);

// Moves on by `period` (s). `state` gets the state; `status`, if it is not NULL, an ArcfeedProjectionStatus.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_projection_step(struct ArcfeedProjection *projection,
                                           double period,
                                           struct ArcfeedPoseState *state,
                                           enum ArcfeedProjectionStatus *status);

// Time to the target if nothing changes (s); negative while that is not known, because the state is still brought
// inside the limits.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_projection_time_left(const struct ArcfeedProjection *projection,
                                                double *seconds);

// The text of the last error of the calling thread; empty if there was none. It names the argument, its value and the
// rule. The text belongs to the library and changes with the next error of this thread; calls that succeed leave it.
const char *arcfeed_last_error(void);

// Axes at `start` that follow a target. `start` and `limits` have `axes` entries; `cycle` is the control cycle (s). A start
// outside the limits is brought back inside. On success `*out` holds the axes, else NULL.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_tracking_new(size_t axes,
                                        const struct ArcfeedAxisState *start,
                                        const struct ArcfeedAxisLimits *limits,
                                        double cycle,
                                        struct ArcfeedTracking **out);

// Frees axes that follow; NULL is nothing to free.
//
// The value is not used again.
void arcfeed_tracking_free(struct ArcfeedTracking *tracking);

// Sets the limits of all axes from the next cycle on.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_tracking_set_limits(struct ArcfeedTracking *tracking,
                                               size_t axes,
                                               const struct ArcfeedAxisLimits *limits);

// Moves on by one cycle, at whose end the target is in the state `target`. `states` gets what to command then; `status`,
// if it is not NULL, what the axes do. A call that is refused moves no axis.
//
// Each pointer is valid for its type, or NULL, which is refused; `target` has `axes` entries, and `states` room for as many.
enum ArcfeedStatus arcfeed_tracking_step(struct ArcfeedTracking *tracking,
                                         size_t axes,
                                         const struct ArcfeedAxisState *target,
                                         struct ArcfeedMotionState *states,
                                         struct ArcfeedTrackingStatus *status);

// Copies the state of the last step.
//
// Each pointer is valid for its type, or NULL, which is refused; `states` has room for `axes` entries.
enum ArcfeedStatus arcfeed_tracking_state(const struct ArcfeedTracking *tracking,
                                          size_t axes,
                                          struct ArcfeedAxisState *states);

// The shortest motion from `start` to `target` within `limits`, each with `axes` entries. On success `*out` holds the
// motion, else NULL.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_trajectory_new(size_t axes,
                                          const struct ArcfeedAxisState *start,
                                          const struct ArcfeedAxisState *target,
                                          const struct ArcfeedAxisLimits *limits,
                                          const struct ArcfeedMotionOptions *options,
                                          struct ArcfeedTrajectory **out);

// Frees a motion; NULL is nothing to free.
//
// The motion is not used again.
void arcfeed_trajectory_free(struct ArcfeedTrajectory *trajectory);

// Duration (s): when the last axis arrives.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_trajectory_duration(const struct ArcfeedTrajectory *trajectory, double *seconds);

// Whether all axes move in proportion, on a straight line.
//
// Each pointer is valid for its type, or NULL, which is refused.
enum ArcfeedStatus arcfeed_trajectory_is_straight(const struct ArcfeedTrajectory *trajectory,
                                                  bool *is_straight);

// The state at time `t` (s), one entry of `states` for each axis. Before 0 it is the start; an axis that has arrived
// goes on with the velocity of its target.
//
// Each pointer is valid for its type, or NULL, which is refused; `states` has room for `axes` entries.
enum ArcfeedStatus arcfeed_trajectory_at(const struct ArcfeedTrajectory *trajectory,
                                         double t,
                                         size_t axes,
                                         struct ArcfeedMotionState *states);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ARCFEED_H */
