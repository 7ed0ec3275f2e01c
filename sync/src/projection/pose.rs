//! The synchroniser for a tool: position and orientation.

use arcfeed_feedrate::{AxisLimits, MotionLaw, SpeedChange};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3, Vector6};

use super::feasible_set::FLOOR;
use super::line::{LinePlan, Start};
use super::norm_limits::PoseLimits;
use super::status::ProjectionStatus;
use crate::error::SyncError;
use crate::so3;
#[cfg(not(feature = "std"))]
use num_traits::Float;

/// Pose of a tool and its first two derivatives; rows linear x y z, then angular x y z, in base
/// axes, at the tool point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseState {
    /// Tool in base (m).
    pub pose: Isometry3<f64>,
    /// Velocity (m/s, rad/s).
    pub velocity: Vector6<f64>,
    /// Acceleration (m/s², rad/s²).
    pub acceleration: Vector6<f64>,
}

impl PoseState {
    /// At rest.
    pub fn rest(pose: Isometry3<f64>) -> Self {
        Self { pose, velocity: Vector6::zeros(), acceleration: Vector6::zeros() }
    }
}

/// State and status after a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseStep {
    /// Pose and its derivatives.
    pub state: PoseState,
    /// Status of the motion.
    pub status: ProjectionStatus,
}

/// A tool on a straight line, turning about one axis by the shortest rotation, to a target pose
/// that may change in any cycle (Liu et al. 2024, section 4.2, eqs. 19 and 20, corrected).
///
/// Position and orientation share one scalar and arrive together. **Guarantees**: the norms of
/// linear and angular velocity, acceleration and jerk stay inside their limits at all times, to
/// 1e-9 of them; a start outside (or too close to a limit to divide its motion) is brought inside
/// first, with the largest jerk: accelerations are taken off, then speed above its limit. The
/// target is reached exactly, at rest. Once the motion across the line has come to rest (at once
/// from rest), the tool point moves on a straight line and the tool turns about one fixed axis, by
/// at most pi. Nothing allocates.
///
/// Reach, singularities and joint limits of an arm are not known here.
///
/// Where the paper adds quaternions (eq. 20), rotations are composed of exact exponentials
/// ([`so3`](crate::so3)); the error is taken on the shorter arc (eq. 19 lacks the factor and the
/// choice of sign). Limits are balls, so that the frame of the error, Gram-Schmidt's, does fit
/// there. Products of angular rates (velocities that turn each other) are part of the budget. A
/// start with an angular acceleration across its velocity often has it taken off first, which takes
/// at most acceleration limit over jerk limit.
///
/// ```
/// use arcfeed_sync::nalgebra::{Isometry3, Vector3};
/// use arcfeed_sync::{PoseLimits, PoseProjectionSync, PoseState, ProjectionStatus};
/// let limits = PoseLimits::new([0.5, 3.0, 40.0], [1.5, 8.0, 100.0])?;
/// let start = PoseState::rest(Isometry3::new(Vector3::new(0.4, 0.0, 0.3), Vector3::zeros()));
/// let target = Isometry3::new(Vector3::new(0.4, 0.3, 0.2), Vector3::new(0.0, 0.0, 1.0));
/// let mut sync = PoseProjectionSync::new(&start, target, &limits)?;
/// while !matches!(sync.step(1e-3)?.status, ProjectionStatus::Reached { .. }) {}
/// assert_eq!(sync.state().pose, target);
/// # Ok::<(), arcfeed_sync::SyncError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct PoseProjectionSync {
    limits: PoseLimits,
    target: Isometry3<f64>,
    /// Target of the motion in force: another one while that must go on for a moment.
    toward: Isometry3<f64>,
    /// State at the start of the present motion.
    from: PoseState,
    motion: Motion,
    /// Time since then (s).
    t: f64,
    /// Orientation so far while recovering: its rates have no closed integral.
    turned: UnitQuaternion<f64>,
}

#[derive(Debug, Clone, Copy)]
// One of each synchroniser, never moved about.
#[allow(clippy::large_enum_variant)]
enum Motion {
    Recovering([Recovery; 2]),
    Planned(LinePlan<6>),
}

impl PoseProjectionSync {
    /// From `start`, in any state of motion, to rest at `target`.
    ///
    /// # Errors
    /// [`SyncError::Tool`] naming what is not finite, or not a unit quaternion;
    /// [`SyncError::OutOfRange`] if the numbers leave the range of `f64`.
    pub fn new(start: &PoseState, target: Isometry3<f64>, limits: &PoseLimits) -> Result<Self, SyncError> {
        check_pose("start pose", &start.pose)?;
        check_finite("start velocity", start.velocity.as_slice())?;
        check_finite("start acceleration", start.acceleration.as_slice())?;
        check_pose("target", &target)?;
        let motion = Motion::new(start, &target, limits)?;
        let turned = start.pose.rotation;
        Ok(Self { limits: *limits, target, toward: target, from: *start, motion, t: 0.0, turned })
    }

    /// Another target from here on.
    ///
    /// # Errors
    /// As [`PoseProjectionSync::new`]; the motion then goes on to the old one.
    pub fn set_target(&mut self, target: Isometry3<f64>) -> Result<(), SyncError> {
        if target == self.target {
            return Ok(());
        }
        check_pose("target", &target)?;
        self.turn_to(target)
    }

    /// Takes up a target, unless the acceleration has to be taken off first and this would leave
    /// the velocity limit: so close to it the motion in force goes on, which does so by itself, and
    /// the target is tried again in every cycle.
    fn turn_to(&mut self, target: Isometry3<f64>) -> Result<(), SyncError> {
        let from = self.state();
        let motion = Motion::new(&from, &target, &self.limits)?;
        self.target = target;
        let wait = matches!((&self.motion, &motion), (Motion::Planned(_), Motion::Recovering(b)) if b.iter().any(Recovery::leaves));
        if !wait {
            self.motion = motion;
            self.toward = target;
            self.begin(from, 0.0);
        }
        Ok(())
    }

    /// Other limits from here on.
    ///
    /// # Errors
    /// [`SyncError::OutOfRange`]; the motion then goes on with the old ones.
    pub fn set_limits(&mut self, limits: &PoseLimits) -> Result<(), SyncError> {
        if *limits == self.limits {
            return Ok(());
        }
        let from = self.state();
        self.motion = Motion::new(&from, &self.target, limits)?;
        (self.limits, self.toward) = (*limits, self.target);
        self.begin(from, 0.0);
        Ok(())
    }

    fn begin(&mut self, from: PoseState, t: f64) {
        (self.from, self.t, self.turned) = (from, t, from.pose.rotation);
    }

    /// Advances by `period` (s).
    ///
    /// # Errors
    /// [`SyncError::Period`] if the period is negative or not finite; the motion then stays where
    /// it is.
    pub fn step(&mut self, period: f64) -> Result<PoseStep, SyncError> {
        if !(period.is_finite() && period >= 0.0) {
            return Err(SyncError::Period { value: period });
        }
        if self.toward != self.target {
            self.turn_to(self.target)?;
        }
        if let Motion::Recovering(blocks) = self.motion {
            let end = blocks[0].duration().max(blocks[1].duration());
            let next = (self.t + period).min(end);
            self.turned = turn(&self.turned, &blocks[1], self.t, next);
            let over = self.t + period - next;
            self.t = next;
            if next < end {
                return Ok(PoseStep { state: self.state(), status: ProjectionStatus::Recovering });
            }
            let from = PoseState { acceleration: Vector6::zeros(), ..self.state() };
            self.motion = Motion::Planned(plan(&from, &self.target, &self.limits).ok_or(SyncError::OutOfRange)?);
            self.toward = self.target;
            self.begin(from, over);
        } else {
            self.t += period;
        }
        let status = match &self.motion {
            Motion::Planned(plan) if self.t >= plan.duration => {
                let unused = (self.t - plan.duration).min(period);
                self.t = plan.duration;
                match self.toward == self.target {
                    true => ProjectionStatus::Reached { unused },
                    false => ProjectionStatus::Turning,
                }
            }
            Motion::Planned(plan) if self.t >= plan.brake_end => ProjectionStatus::Straight,
            _ => ProjectionStatus::Turning,
        };
        Ok(PoseStep { state: self.state(), status })
    }

    /// The state now.
    pub fn state(&self) -> PoseState {
        match &self.motion {
            Motion::Recovering(blocks) => {
                let (linear, angular) = (blocks[0].at(self.t), blocks[1].at(self.t));
                let shift = Translation3::from(self.from.pose.translation.vector + linear.0);
                PoseState {
                    pose: Isometry3::from_parts(shift, self.turned),
                    velocity: stack(&linear.1, &angular.1),
                    acceleration: stack(&linear.2, &angular.2),
                }
            }
            Motion::Planned(plan) if self.t >= plan.duration => PoseState::rest(self.toward),
            Motion::Planned(plan) => self.planned(plan),
        }
    }

    fn planned(&self, plan: &LinePlan<6>) -> PoseState {
        let x = plan.x(self.t);
        let w = plan.w(self.t);
        let in_base =
            |value: fn(&arcfeed_feedrate::MotionState) -> f64| plan.frame * Vector6::from_fn(|k, _| value(&w[k]));
        let (wp, wv, wa) = (in_base(|s| s.p), in_base(|s| s.v), in_base(|s| s.a));
        let (u, turn) = (upper(&plan.u), lower(&plan.u));
        let position = self.from.pose.translation.vector + (u * x.p + upper(&wp));

        let along = so3::exp(&(turn * x.p));
        let (omega, alpha) = so3::angular_rates(&lower(&wp), &lower(&wv), &lower(&wa));
        let (omega, alpha) = (along * omega, along * alpha);
        let rotation = along * so3::exp(&lower(&wp)) * self.from.pose.rotation;
        PoseState {
            pose: Isometry3::from_parts(position.into(), UnitQuaternion::new_normalize(rotation.into_inner())),
            velocity: stack(&(u * x.v + upper(&wv)), &(turn * x.v + omega)),
            acceleration: stack(&(u * x.a + upper(&wa)), &(turn * x.a + alpha + (turn * x.v).cross(&omega))),
        }
    }

    /// Time to the target if nothing changes (s); `None` while the state is brought inside the
    /// limits.
    pub fn remaining(&self) -> Option<f64> {
        match &self.motion {
            Motion::Planned(plan) if self.toward == self.target => Some(plan.duration - self.t),
            _ => None,
        }
    }

    /// The target.
    pub const fn target(&self) -> &Isometry3<f64> {
        &self.target
    }

    /// The limits.
    pub const fn limits(&self) -> &PoseLimits {
        &self.limits
    }
}

impl Motion {
    fn new(from: &PoseState, target: &Isometry3<f64>, limits: &PoseLimits) -> Result<Self, SyncError> {
        if let Some(plan) = plan(from, target, limits) {
            return Ok(Self::Planned(plan));
        }
        let (v, a) = (&from.velocity, &from.acceleration);
        let linear = Recovery::new(upper(v), upper(a), limits.linear());
        let angular = Recovery::new(lower(v), lower(a), limits.angular());
        match (linear, angular) {
            (Some(linear), Some(angular)) => Ok(Self::Recovering([linear, angular])),
            _ => Err(SyncError::OutOfRange),
        }
    }
}

fn plan(from: &PoseState, target: &Isometry3<f64>, limits: &PoseLimits) -> Option<LinePlan<6>> {
    let inside = |x: Vector3<f64>, bound: f64| x.norm() <= bound * (1.0 + 2.0 * FLOOR);
    let (v, a) = (&from.velocity, &from.acceleration);
    let fits = inside(upper(v), limits.linear()[0])
        && inside(upper(a), limits.linear()[1])
        && inside(lower(v), limits.angular()[0])
        && inside(lower(a), limits.angular()[1]);
    if !fits {
        return None;
    }
    let way = target.translation.vector - from.pose.translation.vector;
    let turn = target.rotation * from.pose.rotation.inverse();
    LinePlan::new(&Start { v: *v, a: *a }, limits, |d| {
        stack(&(way - upper(d)), &so3::log(&(turn * so3::exp(&-lower(d)))))
    })
}

/// One block on its way back inside: the acceleration is taken off, then a speed above its limit.
#[derive(Debug, Clone, Copy)]
struct Recovery {
    v: Vector3<f64>,
    a: Vector3<f64>,
    /// Time to take the acceleration off (s).
    release: f64,
    /// Direction of the velocity after that, and the change of speed along it.
    direction: Vector3<f64>,
    change: SpeedChange,
}

impl Recovery {
    /// `None` if the numbers leave the range of `f64`.
    fn new(v: Vector3<f64>, a: Vector3<f64>, &[v_max, a_max, j_max]: &[f64; 3]) -> Option<Self> {
        let release = a.norm() / j_max;
        let later = v + a * (0.5 * release);
        let speed = later.norm();
        let direction = if speed > 0.0 { later / speed } else { Vector3::zeros() };
        let target = speed.min(v_max);
        let limits = AxisLimits::symmetric(v_max, a_max, j_max).ok()?;
        let change = SpeedChange::new(speed, 0.0, target, &limits).ok()?;
        release.is_finite().then_some(Self { v, a, release, direction, change })
    }

    /// Returns true if taking the acceleration off leads out of the velocity limit.
    fn leaves(&self) -> bool {
        self.change.duration() > 0.0
    }

    fn duration(&self) -> f64 {
        self.release + self.change.duration()
    }

    /// Displacement, velocity and acceleration.
    fn at(&self, t: f64) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
        let releasing = |t: f64| {
            // The acceleration falls off linearly.
            let part = if self.release > 0.0 { t / self.release } else { 0.0 };
            (
                self.v * t + self.a * (t * t * (0.5 - part / 6.0)),
                self.v + self.a * (t * (1.0 - 0.5 * part)),
                self.a * (1.0 - part),
            )
        };
        if t < self.release {
            return releasing(t);
        }
        let before = releasing(self.release).0;
        let t = t - self.release;
        let s = self.change.at(t);
        let coasting = (t - self.change.duration()).max(0.0);
        (before + self.direction * (s.p + s.v * coasting), self.direction * s.v, self.direction * s.a)
    }
}

/// The orientation after the time from `t` to `end`, in steps short enough for the integration to
/// be exact to round-off.
fn turn(from: &UnitQuaternion<f64>, rates: &Recovery, t: f64, end: f64) -> UnitQuaternion<f64> {
    const MOST: f64 = 64.0;
    // Directions change while the acceleration is taken off only.
    let steps = (16.0 * (end - t) / rates.release.max(1e-300)).ceil().max(1.0).min(MOST);
    let h = (end - t) / steps;
    let offset = 3f64.sqrt() / 6.0;
    let mut rotation = *from;
    for i in 0..steps as u32 {
        let begin = t + h * f64::from(i);
        let early = rates.at(begin + (0.5 - offset) * h).1;
        let late = rates.at(begin + (0.5 + offset) * h).1;
        rotation = so3::step(&rotation, &early, &late, h);
    }
    rotation
}

fn upper(x: &Vector6<f64>) -> Vector3<f64> {
    x.fixed_rows::<3>(0).into_owned()
}

fn lower(x: &Vector6<f64>) -> Vector3<f64> {
    x.fixed_rows::<3>(3).into_owned()
}

fn stack(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

fn check_finite(what: &'static str, values: &[f64]) -> Result<(), SyncError> {
    match values.iter().find(|x| !x.is_finite()) {
        Some(&value) => Err(SyncError::Tool { what, value, rule: "finite" }),
        None => Ok(()),
    }
}

fn check_pose(what: &'static str, pose: &Isometry3<f64>) -> Result<(), SyncError> {
    check_finite(what, pose.translation.vector.as_slice())?;
    check_finite(what, pose.rotation.coords.as_slice())?;
    let value = pose.rotation.coords.norm();
    if (value - 1.0).abs() > 1e-9 {
        return Err(SyncError::Tool { what, value, rule: "of a quaternion of norm 1" });
    }
    Ok(())
}
