//! Collects the pieces of a speed law.

use super::law::SpeedLaw;
use super::piece::{Piece, Shape};
use crate::error::FeedError;
use crate::scurve::profile::SProfile;
use crate::state::MotionState;

/// Longer motions stand still for all that numbers can tell: 30 million years, s.
const LONGEST: f64 = 1e15;

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
        let speeds = self.pieces.iter().skip(1).map(|next| next.v).chain([v_end]);
        let sound = self.time <= LONGEST
            && (end + v_end).is_finite()
            && self.pieces.iter().zip(speeds).all(|(piece, v_end)| piece.is_in_range(v_end));
        if !sound {
            return Err(FeedError::OutOfRange { what: "duration of the plan" });
        }
        let end = MotionState { p: end, v: v_end, a: 0.0, j: 0.0 };
        Ok(SpeedLaw { pieces: self.pieces, end, duration: self.time })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MotionLaw;

    /// `x = (1 - s)^2 + e^2` decays from speed 1 to e within `asinh(1 / e)`. From the start of the piece alone the position ran back
    /// by up to 6e-10 near its end, where exponentials cancel.
    #[test]
    fn speed_that_decays_to_almost_nothing_never_runs_back() {
        let e = 1e-8;
        let mut builder = Builder::with_capacity(1);
        builder.push_slope(0.0, 1.0, [1.0 + e * e, e * e], -1.0, 1.0);
        let law = builder.finish(1.0, e).expect("finite");
        let duration = (1.0_f64 / e).asinh();
        assert!((law.duration() - duration).abs() < 1e-7 * duration, "{} {duration}", law.duration());
        let mut last = 0.0;
        for i in 0..=1000 {
            let state = law.at(law.duration() * f64::from(i) / 1000.0);
            let left = duration * (1.0 - f64::from(i) / 1000.0);
            let expected = [1.0 - e * left.sinh(), e * left.cosh()];
            for (got, expected) in [state.p, state.v].into_iter().zip(expected) {
                assert!((got - expected).abs() < 1e-7, "{i}: {got} for {expected}");
            }
            assert!(state.p >= last && state.v > 0.0, "{i}: {state:?} after {last}");
            last = state.p;
        }
    }
}
