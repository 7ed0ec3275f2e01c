//! Projection: a tool on a straight line to a target pose that may change in any cycle.

use std::ptr;

use arcfeed_sync::nalgebra::Vector6;
use arcfeed_sync::{PoseLimits, PoseProjectionSync, PoseState, ProjectionStatus};

use crate::input::{finite, hand_out, held, place, put, read, take_back};
use crate::pose::{ArcfeedPose, pose};
use crate::status::{ArcfeedStatus, Outcome, guarded, of_sync};

/// Moves a tool on a straight line, turning about one axis, to a target pose that may change in any cycle. One thread
/// uses it at a time.
pub struct ArcfeedProjection {
    inner: PoseProjectionSync,
}

/// Pose of a tool and its first two derivatives, in base axes, at the tool point.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArcfeedPoseState {
    /// Tool in base.
    pub pose: ArcfeedPose,
    /// Linear x, y, z (m/s), then angular x, y, z (rad/s).
    pub velocity: [f64; 6],
    /// Linear x, y, z (m/s^2), then angular x, y, z (rad/s^2).
    pub acceleration: [f64; 6],
}

/// Bounds of the norms of velocity, acceleration and jerk of a tool, each above 0.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ArcfeedPoseLimits {
    /// Velocity (m/s), acceleration (m/s^2) and jerk (m/s^3) of the tool point.
    pub linear: [f64; 3],
    /// Angular velocity (rad/s), acceleration (rad/s^2) and jerk (rad/s^3).
    pub angular: [f64; 3],
}

/// Status of a projected motion.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArcfeedProjectionStatus {
    /// The state is being brought inside the limits.
    ArcfeedProjectionRecovering = 0,
    /// The velocity across the line to the target is being taken off.
    ArcfeedProjectionTurning = 1,
    /// On the straight line to the target.
    ArcfeedProjectionStraight = 2,
    /// At the target, at rest.
    ArcfeedProjectionReached = 3,
}

impl From<ProjectionStatus> for ArcfeedProjectionStatus {
    fn from(status: ProjectionStatus) -> Self {
        match status {
            ProjectionStatus::Recovering => Self::ArcfeedProjectionRecovering,
            ProjectionStatus::Turning => Self::ArcfeedProjectionTurning,
            ProjectionStatus::Straight => Self::ArcfeedProjectionStraight,
            ProjectionStatus::Reached { .. } => Self::ArcfeedProjectionReached,
        }
    }
}

fn state_from(c: &ArcfeedPoseState) -> Outcome<PoseState> {
    for (field, values) in [("velocity", &c.velocity), ("acceleration", &c.acceleration)] {
        for (k, &value) in values.iter().enumerate() {
            finite(&format_args!("start.{field}[{k}]"), "", value)?;
        }
    }
    Ok(PoseState {
        pose: pose("start.pose", &c.pose)?,
        velocity: Vector6::from(c.velocity),
        acceleration: Vector6::from(c.acceleration),
    })
}

fn state_to(state: &PoseState) -> ArcfeedPoseState {
    ArcfeedPoseState {
        pose: ArcfeedPose::from(&state.pose),
        velocity: state.velocity.into(),
        acceleration: state.acceleration.into(),
    }
}

fn limits_from(c: &ArcfeedPoseLimits) -> Outcome<PoseLimits> {
    PoseLimits::new(c.linear, c.angular).map_err(of_sync)
}

/// A motion from `start` to rest at `target`. On success `*out` holds the motion, else NULL.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_projection_new(
    start: *const ArcfeedPoseState,
    target: *const ArcfeedPose,
    limits: *const ArcfeedPoseLimits,
    out: *mut *mut ArcfeedProjection,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        *place("out", out)? = ptr::null_mut();
        let start = state_from(&read("start", start)?)?;
        let target = pose("target", &read("target", target)?)?;
        let limits = limits_from(&read("limits", limits)?)?;
        let inner = PoseProjectionSync::new(&start, target, &limits).map_err(of_sync)?;
        hand_out("out", out, ArcfeedProjection { inner })
    })
}

/// Frees a motion; NULL is nothing to free.
///
/// # Safety
/// The motion is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_projection_free(projection: *mut ArcfeedProjection) {
    unsafe { take_back(projection) };
}

/// Sets another target from here on.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_projection_set_target(
    projection: *mut ArcfeedProjection,
    target: *const ArcfeedPose,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let projection = place("projection", projection)?;
        projection.inner.set_target(pose("target", &read("target", target)?)?).map_err(of_sync)
    })
}

/// Sets other limits from here on.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_projection_set_limits(
    projection: *mut ArcfeedProjection,
    limits: *const ArcfeedPoseLimits,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let projection = place("projection", projection)?;
        projection.inner.set_limits(&limits_from(&read("limits", limits)?)?).map_err(of_sync)
    })
}

/// Moves on by `period` (s). `state` gets the state; `status`, if it is not NULL, an ArcfeedProjectionStatus.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_projection_step(
    projection: *mut ArcfeedProjection,
    period: f64,
    state: *mut ArcfeedPoseState,
    status: *mut ArcfeedProjectionStatus,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let projection = place("projection", projection)?;
        let place = place("state", state)?;
        let step = projection.inner.step(period).map_err(of_sync)?;
        *place = state_to(&step.state);
        if status.is_null() { Ok(()) } else { put("status", status, step.status.into()) }
    })
}

/// Time to the target if nothing changes (s); negative while that is not known, because the state is still brought
/// inside the limits.
///
/// # Safety
/// Each pointer is valid for its type, or NULL, which is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arcfeed_projection_time_left(
    projection: *const ArcfeedProjection,
    seconds: *mut f64,
) -> ArcfeedStatus {
    guarded(|| unsafe {
        let left = held("projection", projection)?.inner.remaining();
        put("seconds", seconds, left.unwrap_or(-1.0))
    })
}
