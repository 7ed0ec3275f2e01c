//! Where the setpoints of a session come from.

use arcfeed_kinematics::{JointLimits, Joints};

use super::fault::Fault;
use super::verified_motion::VerifiedMotion;

/// The next setpoint of a session.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NextSetpoint<const N: usize = 6> {
    /// Positions, rad.
    pub q: Joints<N>,
    /// True if none follows: the arm stays there.
    pub is_last: bool,
}

/// A source of setpoints. A [`Session`](super::Session) asks for each of them one period before it is due, and holds it against the
/// limits before it is sent.
pub trait SetpointSource<const N: usize = 6> {
    /// Where the arm stands before the first setpoint, rad.
    fn start(&self) -> Joints<N>;

    /// The limits that the setpoints keep.
    fn limits(&self) -> &JointLimits<N>;

    /// The number of setpoints, one every `period` (s), as far as it is known beforehand.
    fn count(&self, period: f64) -> usize;

    /// Setpoint `index`, from 0, one `period` (s) after the one before. They are asked for one after the other, each once.
    ///
    /// # Errors
    /// The doubt that ends the session.
    fn setpoint(&mut self, index: usize, period: f64) -> Result<NextSetpoint<N>, Fault>;

    /// True if the last setpoint is not the end of the motion: somebody has ordered to stop on the way.
    fn is_stopped_by_order(&self) -> bool {
        false
    }
}

impl<const N: usize> SetpointSource<N> for &VerifiedMotion<N> {
    fn start(&self) -> Joints<N> {
        VerifiedMotion::start(self)
    }

    fn limits(&self) -> &JointLimits<N> {
        VerifiedMotion::limits(self)
    }

    fn count(&self, period: f64) -> usize {
        (self.trajectory().duration() / period).ceil() as usize + 1
    }

    fn setpoint(&mut self, index: usize, period: f64) -> Result<NextSetpoint<N>, Fault> {
        let q = self.trajectory().at(index as f64 * period).q;
        Ok(NextSetpoint { q, is_last: index + 1 >= self.count(period) })
    }
}
