//! A tool that goes to poses which may be set at any time, with the joints that carry it.

use arcfeed_feedrate::Quantity;
use arcfeed_kinematics::{JointLimits, Joints, KinematicsError, ToolDerivatives, Twist};
use arcfeed_sync::{JointState, PoseLimits, PoseProjectionSync, PoseState, ProjectionStatus, SyncError};
use nalgebra::{Isometry3, Vector3};
use thiserror::Error;

use crate::arm::PathArm;

/// A motion to a target has at most so many cycles.
pub const MAX_CYCLES: usize = 1_000_000;
/// Shares of the tool limits that are tried for one target.
const ATTEMPTS: usize = 16;
/// The least of them.
const LEAST_SHARE: f64 = 0.01;
/// What is left of a share that would use the limit of a joint exactly.
const MARGIN: f64 = 0.999;

/// Why a target of the tool is not followed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ToolTargetError {
    /// A target, a limit or a period that breaks a rule.
    #[error(transparent)]
    Tool(#[from] SyncError),
    /// The arm cannot carry the tool along the way.
    #[error(
        "{time:.3} s on, with the tool at [{:.4}, {:.4}, {:.4}] m on its straight way: {source}; choose another target, or go there by joints",
        position.x, position.y, position.z
    )]
    Unreachable {
        /// The time from now on, s.
        time: f64,
        /// The tool tip there, m in the base.
        position: Vector3<f64>,
        /// The reason.
        source: KinematicsError,
    },
    /// A joint exceeds its limit at every share of the tool limits.
    #[error(
        "{time:.3} s on, joint {} would use its limit of {} {ratio:.3} times, even with {:.1} % of the tool limits: choose a way farther from singular poses, or go there by joints",
        joint + 1, quantity.name(), share * 100.0
    )]
    TooFast {
        /// The time from now on, s.
        time: f64,
        /// The joint, from 0.
        joint: usize,
        /// The limited quantity.
        quantity: Quantity,
        /// The value by its limit.
        ratio: f64,
        /// The share of the tool limits that was tried last.
        share: f64,
    },
    /// The tool is too fast to be slowed down for the joints from here.
    #[error(
        "{time:.3} s on, the tool would use its limit of {what} {ratio:.3} times, because the joints allow no more than {:.1} % of its speed on the new way: set the target when the tool is slower",
        share * 100.0
    )]
    TooFastToTurn {
        /// The time from now on, s.
        time: f64,
        /// The limited quantity of the tool.
        what: &'static str,
        /// The value by its limit.
        ratio: f64,
        /// The share of the tool limits that the joints allow.
        share: f64,
    },
    /// The motion would not end within [`MAX_CYCLES`].
    #[error("the motion to the target has more than {MAX_CYCLES} cycles: raise the limits of the tool, or the period")]
    TooLong,
}

/// One cycle of a [`LiveTool`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveToolStep<const N: usize = 6> {
    /// The joints; `qddd` is the mean jerk of the cycle.
    pub joints: JointState<N>,
    /// Pose and motion of the tool.
    pub tool: PoseState,
    /// Status of the motion of the tool.
    pub status: ProjectionStatus,
}

/// A tool that goes straight to a pose, turning about one axis, carried by the joints of an arm; target and tool limits may change in any
/// cycle (Liu et al. 2024, section 4.2, in task space).
///
/// **Guarantees**: the tool keeps its limits ([`PoseProjectionSync`]). Every joint stays inside its range and its limits of velocity,
/// acceleration and jerk: before a target is accepted, the whole motion to it is gone through cycle by cycle. Where a joint would exceed a
/// limit, the motion is slowed down: it uses a smaller [`share`](LiveTool::share) of the tool limits, whose powers scale velocity,
/// acceleration and jerk. A target that cannot be reached so is refused with the place, and the motion goes on to the one before.
///
/// [`LiveTool::step`] allocates nothing and takes one inverse. [`LiveTool::set_target`] takes one for each cycle that is left, for each
/// share tried, at most 16 times [`MAX_CYCLES`]: some milliseconds for a second of motion. The configuration of the arm stays that of the
/// start. Torques and obstacles are not known here.
///
/// ```
/// use arcfeed_interp::LiveTool;
/// use arcfeed_kinematics::{ForwardKinematics, Joints, models};
/// use arcfeed_sync::{PoseLimits, ProjectionStatus};
/// use nalgebra::Translation3;
///
/// let arm = models::ur5e();
/// let joints = arm.range().with_rates(Joints::repeat(3.0), Joints::repeat(10.0), Joints::repeat(100.0))?;
/// let start = Joints::from([0.0, -1.4, 1.8, -1.9, -1.6, 0.0]);
/// let tool = PoseLimits::new([0.5, 3.0, 40.0], [1.5, 8.0, 100.0])?;
/// let mut motion = LiveTool::new(&arm, &start, &joints, &tool, 1e-3)?;
/// let target = Translation3::new(0.0, 0.2, 0.1) * arm.forward(&start);
/// motion.set_target(&target)?;
/// while !matches!(motion.step()?.status, ProjectionStatus::Reached { .. }) {}
/// assert!((arm.forward(&motion.joints().q).translation.vector - target.translation.vector).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct LiveTool<'a, A, const N: usize = 6> {
    arm: &'a A,
    joint_limits: JointLimits<N>,
    tool_limits: PoseLimits,
    period: f64,
    now: Carried<N>,
    share: f64,
}

/// The tool, and the joints that carry it.
#[derive(Debug, Clone, Copy)]
struct Carried<const N: usize> {
    sync: PoseProjectionSync,
    q: Joints<N>,
    qd: Joints<N>,
    qdd: Joints<N>,
}

/// The largest uses of limits on a way.
#[derive(Debug, Clone, Copy, Default)]
struct Uses {
    /// Of the joints, by velocity, acceleration and jerk.
    joints: [Use; 3],
    /// Of the tool, in the order of [`TOOL`].
    tool: [Use; 4],
}

#[derive(Debug, Clone, Copy, Default)]
struct Use {
    ratio: f64,
    /// The joint, where there is one.
    joint: usize,
    time: f64,
}

impl Use {
    fn see(&mut self, ratio: f64, joint: usize, time: f64) {
        if ratio > self.ratio || ratio.is_nan() {
            *self = Self { ratio, joint, time };
        }
    }
}

const QUANTITIES: [Quantity; 3] = [Quantity::JointVelocity, Quantity::JointAcceleration, Quantity::JointJerk];
const TOOL: [&str; 4] = ["speed", "acceleration", "angular speed", "angular acceleration"];
/// A part by which a limit of the tool is exceeded through rounding.
const ROUNDING: f64 = 1e-9;

impl<'a, A: PathArm<N>, const N: usize> LiveTool<'a, A, N> {
    /// At rest at `start` (rad), with the limits of joints and tool, for a control `period` (s).
    ///
    /// # Errors
    /// [`ToolTargetError::Unreachable`] for joints outside their range or at a singular pose; [`ToolTargetError::Tool`] for a period that is
    /// not a finite number above 0.
    pub fn new(
        arm: &'a A,
        start: &Joints<N>,
        joint_limits: &JointLimits<N>,
        tool_limits: &PoseLimits,
        period: f64,
    ) -> Result<Self, ToolTargetError> {
        if !(period.is_finite() && period > 0.0) {
            return Err(SyncError::Period { value: period }.into());
        }
        let pose = arm.forward(start);
        let sync = PoseProjectionSync::new(&PoseState::rest(pose), pose, tool_limits)?;
        let now = Carried { sync, q: *start, qd: Joints::zeros(), qdd: Joints::zeros() };
        // The same joints come back, or the start is not one to move from.
        let now = now.carried_by(arm, sync).map_err(|source| ToolTargetError::Unreachable {
            time: 0.0,
            position: pose.translation.vector,
            source,
        })?;
        let now = Carried { q: *start, ..now };
        Ok(Self { arm, joint_limits: *joint_limits, tool_limits: *tool_limits, period, now, share: 1.0 })
    }

    /// Another target (tool in base) from here on, under the same tool limits.
    ///
    /// # Errors
    /// [`ToolTargetError`]; the motion then goes on to the target before.
    pub fn set_target(&mut self, target: &Isometry3<f64>) -> Result<(), ToolTargetError> {
        let limits = self.tool_limits;
        self.set(target, &limits)
    }

    /// Other tool limits from here on, for the same target.
    ///
    /// # Errors
    /// As [`LiveTool::set_target`]; the old limits then stay.
    pub fn set_tool_limits(&mut self, limits: &PoseLimits) -> Result<(), ToolTargetError> {
        let target = *self.target();
        self.set(&target, limits)
    }

    /// Another target and other tool limits from here on.
    ///
    /// # Errors
    /// As [`LiveTool::set_target`].
    pub fn set(&mut self, target: &Isometry3<f64>, limits: &PoseLimits) -> Result<(), ToolTargetError> {
        let mut share = 1.0;
        let mut refused = ToolTargetError::TooLong;
        for _ in 0..ATTEMPTS {
            let mut sync = self.now.sync;
            sync.set_limits(&scaled(limits, share)?)?;
            sync.set_target(*target)?;
            let uses = self.ahead(sync, limits)?;
            let Some((k, worst)) = exceeded(&uses.joints, 0.0) else {
                if let Some((k, Use { ratio, time, .. })) = exceeded(&uses.tool, ROUNDING) {
                    return Err(ToolTargetError::TooFastToTurn { time, what: TOOL[k], ratio, share });
                }
                (self.now.sync, self.tool_limits, self.share) = (sync, *limits, share);
                return Ok(());
            };
            let (quantity, Use { ratio, joint, time }) = (QUANTITIES[k], worst);
            refused = ToolTargetError::TooFast { time, joint, quantity, ratio, share };
            // A motion with all times divided by `share` has its k-th derivative multiplied by that power of it.
            share *= uses
                .joints
                .iter()
                .enumerate()
                .fold(MARGIN, |least, (k, worst)| least.min(MARGIN * worst.ratio.powf(-1.0 / (k + 1) as f64)));
            if share.is_nan() || share < LEAST_SHARE {
                break;
            }
        }
        Err(refused)
    }

    /// Goes through the motion of `sync` to its end, from the present joints. The tool is held against `limits`, and while it
    /// comes inside lower ones against those before.
    fn ahead(&self, sync: PoseProjectionSync, limits: &PoseLimits) -> Result<Uses, ToolTargetError> {
        if sync.remaining().is_some_and(|left| left > self.period * MAX_CYCLES as f64) {
            return Err(ToolTargetError::TooLong);
        }
        let mut uses = Uses::default();
        let highest = |of: fn(&PoseLimits) -> &[f64; 3]| {
            let (new, old) = (of(limits), of(&self.tool_limits));
            [new[0].max(old[0]), new[1].max(old[1])]
        };
        let ([v, a], [omega, alpha]) = (highest(PoseLimits::linear), highest(PoseLimits::angular));
        let mut now = Carried { sync, ..self.now };
        for cycle in 1..=MAX_CYCLES {
            let time = cycle as f64 * self.period;
            let (next, status) = now.next(self.arm, self.period, time)?;
            now.compare(&next, &self.joint_limits, self.period, time, &mut uses.joints);
            now = next;
            let tool = now.sync.state();
            let norm = |twist: &Twist, from: usize| twist.fixed_rows::<3>(from).norm();
            let ratios = [
                norm(&tool.velocity, 0) / v,
                norm(&tool.acceleration, 0) / a,
                norm(&tool.velocity, 3) / omega,
                norm(&tool.acceleration, 3) / alpha,
            ];
            uses.tool.iter_mut().zip(ratios).for_each(|(most, ratio)| most.see(ratio, 0, time));
            if matches!(status, ProjectionStatus::Reached { .. }) {
                return Ok(uses);
            }
        }
        Err(ToolTargetError::TooLong)
    }

    /// Moves on by one cycle.
    ///
    /// # Errors
    /// None after a target that was accepted: its whole motion has been gone through.
    pub fn step(&mut self) -> Result<LiveToolStep<N>, ToolTargetError> {
        let (next, status) = self.now.next(self.arm, self.period, self.period)?;
        let jerk = (next.qdd - self.now.qdd) / self.period;
        self.now = next;
        Ok(LiveToolStep { joints: JointState { qddd: jerk, ..self.joints() }, tool: next.sync.state(), status })
    }

    /// The joints now; `qddd` is zero.
    pub fn joints(&self) -> JointState<N> {
        JointState { q: self.now.q, qd: self.now.qd, qdd: self.now.qdd, qddd: Joints::zeros() }
    }

    /// The target.
    pub const fn target(&self) -> &Isometry3<f64> {
        self.now.sync.target()
    }

    /// The part of the tool limits that the motion uses, so that all joints keep theirs: of velocity the share itself, of acceleration its
    /// square, of jerk its cube.
    pub const fn share(&self) -> f64 {
        self.share
    }

    /// Time to the target (s); `None` while the tool is brought inside lower limits.
    pub fn time_left(&self) -> Option<f64> {
        self.now.sync.remaining()
    }
}

impl<const N: usize> Carried<N> {
    /// One cycle of `period` on, `time` (s) after the motion was set.
    fn next<A: PathArm<N>>(
        &self,
        arm: &A,
        period: f64,
        time: f64,
    ) -> Result<(Self, ProjectionStatus), ToolTargetError> {
        let mut sync = self.sync;
        let status = sync.step(period)?.status;
        let near = self.q + (self.qd + self.qdd * (0.5 * period)) * period;
        let next = Self { q: near, ..*self }.carried_by(arm, sync).map_err(|source| ToolTargetError::Unreachable {
            time,
            position: sync.state().pose.translation.vector,
            source,
        })?;
        Ok((next, status))
    }

    /// The joints nearest to these that carry the tool of `sync`.
    fn carried_by<A: PathArm<N>>(&self, arm: &A, sync: PoseProjectionSync) -> Result<Self, KinematicsError> {
        let tool = sync.state();
        let q = arm.inverse(&tool.pose, &self.q)?;
        let along = ToolDerivatives { first: tool.velocity, second: tool.acceleration, third: Twist::zeros() };
        let joints = arm.derivatives(&q, &along)?;
        Ok(Self { sync, q, qd: joints.first, qdd: joints.second })
    }

    /// Adds the use of the limits at `next`, and on the way there, one `period` after this.
    fn compare(&self, next: &Self, limits: &JointLimits<N>, period: f64, time: f64, uses: &mut [Use; 3]) {
        // The mean of a derivative over a cycle never exceeds its largest value. Where the jerk changes its sign within a cycle
        // its mean says little: the position misses the trapezoidal rule by a weighted mean of the jerk times T^3 / 12.
        let means = [next.q - self.q, next.qd - self.qd, next.qdd - self.qdd].map(|step| step / period);
        let trapezoid = next.q - self.q - (self.qd + next.qd) * (0.5 * period);
        let miss = trapezoid.zip_map(&next.q, |miss, q| (miss.abs() - 1e-14 * (1.0 + 2.0 * q.abs())).max(0.0));
        let values = [next.qd, next.qdd, miss * (12.0 / period.powi(3))];
        let limits = [limits.velocity(), limits.acceleration(), limits.jerk()];
        for (k, most) in uses.iter_mut().enumerate() {
            for joint in 0..N {
                let ratio = means[k][joint].abs().max(values[k][joint].abs()) / limits[k][joint];
                most.see(ratio, joint, time);
            }
        }
    }
}

/// The limits with all times divided by `share`.
fn scaled(limits: &PoseLimits, share: f64) -> Result<PoseLimits, SyncError> {
    let powers = |l: &[f64; 3]| [l[0] * share, l[1] * share.powi(2), l[2] * share.powi(3)];
    PoseLimits::new(powers(limits.linear()), powers(limits.angular()))
}

/// The place of the largest use above 1 by more than `rounding`, if there is one.
fn exceeded(uses: &[Use], rounding: f64) -> Option<(usize, Use)> {
    let over =
        uses.iter().copied().enumerate().filter(|(_, worst)| worst.ratio.is_nan() || worst.ratio > 1.0 + rounding);
    over.max_by(|(_, a), (_, b)| a.ratio.total_cmp(&b.ratio))
}
