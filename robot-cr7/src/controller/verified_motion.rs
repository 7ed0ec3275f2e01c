//! A motion that is certified before a session takes it, and at rest at both ends.

use arcfeed_interp::{Certificate, CertifiedBound, JointTrajectory, JointTrajectoryError, Quantity};
use arcfeed_kinematics::{JointLimits, Joints};
use thiserror::Error;

use crate::run::limit_line::{LimitLine, LimitUnit, TOLERANCE};

/// A velocity up to this is rest, rad/s.
const REST: f64 = 1e-6;
/// An acceleration up to this is that of rest, rad/s^2.
const REST_ACCELERATION: f64 = 1e-3;

/// Longest motion that is sent, s: a day.
const MOST_DURATION: f64 = 86_400.0;

/// A motion of polynomials that is certified to keep every limit of the joints at all times, from rest to rest.
///
/// ```
/// use arcfeed_interp::{Interpolation, JointTrajectory};
/// use arcfeed_kinematics::{JointRange, Joints};
/// use robot_cr7::controller::VerifiedMotion;
///
/// // One joint from 0 to 1 rad in 1 s: q = 10 t^3 - 15 t^4 + 6 t^5, whose velocity reaches 1.875 rad/s.
/// let piece = [0.0, 0.0, 0.0, 10.0, -15.0, 6.0].map(Joints::<1>::repeat);
/// let motion = JointTrajectory::from_pieces(vec![0.0, 1.0], vec![piece], Interpolation::Quintic)?;
/// let range = JointRange::new(Joints::repeat(-2.0), Joints::repeat(2.0))?;
/// let limits = |v| range.with_rates(Joints::repeat(v), Joints::repeat(6.0), Joints::repeat(60.0));
/// assert!(VerifiedMotion::new(motion.clone(), &limits(2.0)?).is_ok());
/// assert!(VerifiedMotion::new(motion, &limits(1.8)?).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct VerifiedMotion<const N: usize = 6> {
    trajectory: JointTrajectory<N>,
    certificate: Certificate,
    limits: JointLimits<N>,
}

impl<const N: usize> VerifiedMotion<N> {
    /// Certifies a motion.
    ///
    /// # Errors
    /// [`NotSendable`].
    pub fn new(trajectory: JointTrajectory<N>, limits: &JointLimits<N>) -> Result<Self, NotSendable> {
        let duration = trajectory.duration();
        // Not `>`: a NaN has to show.
        let ends = duration <= MOST_DURATION;
        if !ends {
            return Err(NotSendable::Long { duration });
        }
        let certificate = trajectory.certify(limits.range(), &limits.into());
        if !certificate.holds(TOLERANCE) {
            return Err(NotSendable::Limit(Box::new(certificate)));
        }
        for (end, t) in [("start", 0.0), ("end", trajectory.duration())] {
            let at = trajectory.at(t);
            for joint in 0..N {
                // Not `>`: a NaN has to show.
                let rests = at.qd[joint].abs() <= REST && at.qdd[joint].abs() <= REST_ACCELERATION;
                if !rests {
                    return Err(NotSendable::Moving { end, joint, velocity: at.qd[joint] });
                }
            }
        }
        Ok(Self { trajectory, certificate, limits: *limits })
    }

    /// This motion after `lead`, which ends where this one starts. The whole is certified anew.
    ///
    /// # Errors
    /// [`NotSendable`], also where they do not join.
    pub fn after(&self, lead: Self) -> Result<Self, NotSendable> {
        Self::new(lead.trajectory.then(&self.trajectory)?, &self.limits)
    }

    /// The motion.
    pub fn trajectory(&self) -> &JointTrajectory<N> {
        &self.trajectory
    }

    /// The limits that it keeps.
    pub fn limits(&self) -> &JointLimits<N> {
        &self.limits
    }

    /// The positions at its start, rad.
    pub fn start(&self) -> Joints<N> {
        self.trajectory.at(0.0).q
    }

    /// Position, velocity, acceleration and jerk, each with the joint that uses most of its limit.
    pub fn limit_lines(&self) -> Vec<LimitLine> {
        let quantities = [
            (Quantity::JointPosition, LimitUnit::Radian),
            (Quantity::JointVelocity, LimitUnit::RadianPerSecond),
            (Quantity::JointAcceleration, LimitUnit::RadianPerSecond2),
            (Quantity::JointJerk, LimitUnit::RadianPerSecond3),
        ];
        let worst = |(quantity, unit): (Quantity, LimitUnit)| {
            let of_it = self.certificate.bounds().iter().filter(|bound| bound.id.quantity == quantity);
            let worst = of_it.max_by(|a, b| a.ratio().total_cmp(&b.ratio()))?;
            Some(line(worst, unit))
        };
        quantities.into_iter().filter_map(worst).collect()
    }
}

fn line(bound: &CertifiedBound, unit: LimitUnit) -> LimitLine {
    LimitLine {
        name: bound.id.quantity.name().to_owned(),
        joint: bound.id.joint.map(|joint| usize::from(joint) + 1),
        unit,
        value: bound.bound.copysign(bound.attained),
        limit: bound.limit,
        ratio: bound.ratio(),
        at_s_m: None,
        at_t_s: bound.t,
        lines: None,
    }
}

/// Why a motion is not sent to an arm.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum NotSendable {
    /// A limit of a joint is exceeded, or a quantity jumps.
    #[error("the motion is not certified: {0}; plan it under the limits of the arm that it is sent to")]
    Limit(Box<Certificate>),
    /// The arm would have to move already at an end.
    #[error("joint {} moves with {:.4} deg/s at the {end} of the motion: an arm is led from rest to rest; plan it so", joint + 1, velocity.to_degrees())]
    Moving {
        /// Which end.
        end: &'static str,
        /// The joint, from 0.
        joint: usize,
        /// Its velocity, rad/s.
        velocity: f64,
    },
    /// It takes too long.
    #[error("the motion takes {duration:.0} s, and at most {MOST_DURATION:.0} s (a day) are sent: send it in parts")]
    Long {
        /// Its duration, s.
        duration: f64,
    },
    /// Two motions do not join.
    #[error("the way to the start does not join the motion: {0}")]
    Join(#[from] JointTrajectoryError),
    /// There is no way to the start.
    #[error("no way to the start of the motion: {0}; move the arm nearer to it by hand")]
    NoWay(arcfeed_sync::SyncError),
}

#[cfg(test)]
mod tests {
    use arcfeed_kinematics::JointRange;

    use super::*;

    #[test]
    fn a_motion_of_more_than_a_day_is_refused() {
        let range = JointRange::new(Joints::repeat(-2.0), Joints::repeat(2.0)).expect("a range");
        let limits = range.with_rates(Joints::repeat(1.0), Joints::repeat(1.0), Joints::repeat(1.0)).expect("limits");
        let rest = |hours: f64| JointTrajectory::resting(&Joints::<1>::zeros(), 3600.0 * hours).expect("rest");
        assert!(VerifiedMotion::new(rest(23.9), &limits).is_ok());
        let error = VerifiedMotion::new(rest(24.1), &limits).expect_err("more than a day");
        assert!(matches!(error, NotSendable::Long { .. }) && error.to_string().contains("in parts"), "{error}");
    }
}
