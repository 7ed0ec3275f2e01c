//! Collects the pieces of a speed law.

use super::law::SpeedLaw;
use super::piece::{Piece, Shape};
use crate::error::FeedError;
use crate::scurve::profile::SProfile;
use crate::state::MotionState;

/// Collects pieces into a law. The time is summed in compensated form, so that thousands of pieces
/// do not drift.
#[derive(Debug)]
pub(crate) struct Builder {
    pieces: Vec<Piece>,
    time: f64,
    lost: f64,
}

impl Builder {
    pub fn with_capacity(n: usize) -> Self {
        Self { pieces: Vec::with_capacity(n), time: 0.0, lost: 0.0 }
    }

    fn push(&mut self, s: f64, v: f64, a: f64, shape: Shape, dt: f64) {
        self.pieces.push(Piece { t: self.time, s, v, a, shape });
        // Kahan's sum is enough, as the time never falls.
        let y = dt - self.lost;
        let sum = self.time + y;
        self.lost = (sum - self.time) - y;
        self.time = sum;
    }

    /// A phase of constant jerk `j` that lasts `dt`. A phase too short to move the clock is
    /// dropped.
    pub fn push_phase(&mut self, s: f64, v: f64, a: f64, j: f64, dt: f64) {
        if self.time + dt > self.time {
            self.push(s, v, a, Shape::Jerk(j), dt);
        }
    }

    /// The phases of an S-profile that starts at `s0`.
    pub fn push_profile(&mut self, s0: f64, profile: &SProfile) {
        for (phase, dt) in profile.phases() {
            self.push_phase(s0 + phase.s, phase.v, phase.a, phase.j, dt);
        }
    }

    /// A piece of length `h` with constant acceleration, by the speeds at both ends.
    pub fn push_constant(&mut self, s: f64, h: f64, [v, v_end]: [f64; 2], a: f64) {
        self.push(s, v, a, Shape::Slope(0.0), 2.0 * h / (v + v_end));
    }

    /// A piece of length `h` on which `w = da/ds` is constant, by squared speed and acceleration at
    /// its start and squared speed at its end.
    pub fn push_slope(&mut self, s: f64, h: f64, [x, x_end]: [f64; 2], a: f64, w: f64) {
        let (v, v_end) = (x.sqrt(), x_end.sqrt());
        // tanh(r T / 2) = r h / (v + v_end) with r^2 = w: the half-angle formulas, without
        // cancellation.
        let z = w.abs().sqrt() * h / (v + v_end);
        let factor = if z < 1e-4 {
            1.0 + w.signum() * z * z / 3.0
        } else if w > 0.0 {
            z.atanh() / z
        } else {
            z.atan() / z
        };
        self.push(s, v, a, Shape::Slope(w), 2.0 * h / (v + v_end) * factor);
    }

    /// A piece of length `h` with constant jerk, from rest to squared speed `x`.
    pub fn push_from_rest(&mut self, s: f64, h: f64, x: f64) {
        let v = x.sqrt();
        // s = j t^3 / 6 and v = j t^2 / 2.
        let dt = 3.0 * h / v;
        self.push(s, 0.0, 0.0, Shape::Jerk(2.0 * v / (dt * dt)), dt);
    }

    /// A piece of length `h` with constant jerk, from squared speed `x` to rest.
    pub fn push_to_rest(&mut self, s: f64, h: f64, x: f64) {
        let v = x.sqrt();
        let dt = 3.0 * h / v;
        let j = 2.0 * v / (dt * dt);
        self.push(s, v, -j * dt, Shape::Jerk(j), dt);
    }

    /// The law, which ends at position `end` with speed `v_end`.
    ///
    /// # Errors
    /// [`FeedError::OutOfRange`] where a number left the range of `f64`.
    pub fn finish(self, end: f64, v_end: f64) -> Result<SpeedLaw, FeedError> {
        let sound = self.time.is_finite() && (end + v_end).is_finite() && self.pieces.iter().all(Piece::is_finite);
        if !sound {
            return Err(FeedError::OutOfRange { what: "duration of the plan" });
        }
        let end = MotionState { p: end, v: v_end, a: 0.0, j: 0.0 };
        Ok(SpeedLaw { pieces: self.pieces, end, duration: self.time })
    }
}
