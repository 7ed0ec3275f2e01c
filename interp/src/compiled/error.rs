//! Why there is no joint trajectory.

use arcfeed_feedrate::{LimitId, Quantity};
use thiserror::Error;

use super::certified_limit::CertifiedLimit;
use crate::error::{LimitError, PlanError};

/// Why a trajectory was not compiled.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CompileError {
    /// The tolerance is not a finite number above 0.
    #[error(transparent)]
    Tolerance(#[from] LimitError),
    /// The trajectory could not be sampled.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The planned acceleration steps at every knot, because the planner does not limit jerk.
    #[error(
        "the planner does not limit jerk, so the planned acceleration steps, which quintic pieces cannot follow: \
         plan with a limit on jerk, or compile cubic pieces"
    )]
    AccelerationSteps,
    /// No piece stays within the tolerance.
    #[error(
        "joint {} deviates by up to {bound:.3e} rad at t = {t:.6} s, more than the tolerance of {tolerance:.3e} rad: \
         allow more",
        joint + 1
    )]
    Deviation {
        /// Which joint, from 0.
        joint: usize,
        /// The time, s.
        t: f64,
        /// The bound of the deviation of the best piece, rad.
        bound: f64,
        /// The tolerance, rad.
        tolerance: f64,
    },
    /// No piece keeps a limit of a joint that the plan keeps.
    #[error(
        "no piece keeps the limit: {limit} would be {value:.6e} at t = {t:.6} s, {:.5} % of its limit {allowed:.6e}; \
         plan with a lower limit or allow more deviation",
        100.0 * value.abs() / allowed
    )]
    Limit {
        /// Which limit of which joint.
        limit: LimitId,
        /// The value, SI.
        value: f64,
        /// The limit, SI.
        allowed: f64,
        /// The time, s.
        t: f64,
    },
    /// The compiled motion exceeds a limit, however slow the plan was made.
    #[error("{limit}: allow less deviation, so that the pieces follow the plan more closely, or raise the limit")]
    Exceeded {
        /// Which limit, and what the motion does to it.
        limit: CertifiedLimit,
    },
    /// The torque is limited, and the dynamics state no bounds of it between two samples.
    #[error(
        "the torque is limited, but its dynamics state no bounds (Dynamics::torque_bounds), so that no certificate can be made: \
         implement them, use ArmDynamics, or plan without polynomials"
    )]
    UnboundedTorque,
    /// The pieces do not make a joint trajectory.
    #[error(transparent)]
    Pieces(#[from] JointTrajectoryError),
}

/// Why times and coefficients are no joint trajectory, or two joint trajectories do not join.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum JointTrajectoryError {
    /// There has to be one time more than there are pieces, and one piece at least.
    #[error("{times} times for {pieces} pieces: there has to be a piece, and one time more than there are pieces")]
    Count {
        /// Number of times.
        times: usize,
        /// Number of pieces.
        pieces: usize,
    },
    /// Times have to be finite and to increase from 0.
    #[error("time {index} is {t} s after {previous} s: times have to be finite and to increase from 0")]
    Time {
        /// Which time, from 0.
        index: usize,
        /// The time, s.
        t: f64,
        /// The time before it, s; 0 for the first.
        previous: f64,
    },
    /// A coefficient is not finite.
    #[error("coefficient {power} of joint {} in piece {piece} is {value}", joint + 1)]
    NotFinite {
        /// Which piece, from 0.
        piece: usize,
        /// Which joint, from 0.
        joint: usize,
        /// Which power of the time.
        power: usize,
        /// The value.
        value: f64,
    },
    /// A piece leaves the numbers before its end.
    #[error("piece {piece} lasts {seconds} s, within which the {quantity} of joint {} overflows", joint + 1)]
    Overflow {
        /// Which piece, from 0.
        piece: usize,
        /// Which joint, from 0.
        joint: usize,
        /// Position, velocity, acceleration or jerk of a joint.
        quantity: Quantity,
        /// How long the piece lasts, s.
        seconds: f64,
    },
    /// A quantity jumps from one piece to the next.
    #[error("{quantity} of joint {} jumps by {jump:.3e} at t = {t:.6} s, rounding explains {rounding:.3e}", joint + 1)]
    Jump {
        /// Position, velocity or acceleration of a joint.
        quantity: Quantity,
        /// Which joint, from 0.
        joint: usize,
        /// The time, s.
        t: f64,
        /// The jump, SI.
        jump: f64,
        /// The largest jump that rounding explains.
        rounding: f64,
    },
    /// Two motions join at rest alone.
    #[error("{} joint {} has the {quantity} {value:.3e} where the two motions join: both have to rest there", which, joint + 1)]
    NotAtRest {
        /// Which motion.
        which: &'static str,
        /// Velocity or acceleration of a joint.
        quantity: Quantity,
        /// Which joint, from 0.
        joint: usize,
        /// The value, SI.
        value: f64,
    },
    /// The second motion starts elsewhere than where the first one ends.
    #[error("joint {} ends at {end} rad, but the next motion starts at {start} rad", joint + 1)]
    Elsewhere {
        /// Which joint, from 0.
        joint: usize,
        /// The end of the first motion, rad.
        end: f64,
        /// The start of the second, rad.
        start: f64,
    },
    /// A file cannot be read.
    #[error("joint trajectory: {problem}")]
    File {
        /// What is wrong, and where.
        problem: String,
    },
}
