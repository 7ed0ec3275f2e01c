//! The curve of a plan, and how far axes are on it.

use arcfeed_sync::feedrate::AxisState;
use arcfeed_sync::{JointState, Trajectory};

use super::generator_input::{AXES, States};

/// Motions one after the other, and the time of the plan that was found last.
pub struct Curve {
    motions: Vec<Trajectory<AXES>>,
    from: f64,
}

impl std::fmt::Debug for Curve {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let durations: Vec<f64> = self.motions.iter().map(Trajectory::duration).collect();
        write!(f, "at {} of {durations:?}", self.from)
    }
}

impl Curve {
    pub fn of(motions: Vec<Trajectory<AXES>>) -> Self {
        Self { motions, from: 0.0 }
    }

    fn at(&self, t: f64) -> JointState<AXES> {
        let mut left = t;
        for (i, motion) in self.motions.iter().enumerate() {
            if left < motion.duration() || i + 1 == self.motions.len() {
                return motion.at(left);
            }
            left -= motion.duration();
        }
        JointState::default()
    }

    /// Looks for the time of the plan at which the axis that is farthest off is nearest, from the last one on, and returns how far
    /// it is off there.
    pub fn advance(&mut self, now: &States, cycle: f64) -> f64 {
        let start = self.from;
        let off_at = |t: f64| {
            let s = self.at(t);
            now.iter().zip(s.q.iter()).map(|(s, q): (&AxisState, &f64)| (q - s.p).abs()).fold(0.0, f64::max)
        };
        // Golden section beside the best of some places: axes that turn have more than one minimum.
        let wide = 1.6 * cycle / 64.0;
        let places = (0..=64).map(|i| start + wide * f64::from(i));
        let near = places.fold(start, |best, t| if off_at(t) < off_at(best) { t } else { best });
        let (mut lo, mut hi) = ((near - wide).max(start), near + wide);
        for _ in 0..80 {
            let (x, y) = (hi - 0.618_033_988_75 * (hi - lo), lo + 0.618_033_988_75 * (hi - lo));
            if off_at(x) <= off_at(y) { hi = y } else { lo = x }
        }
        let best = 0.5 * (lo + hi);
        let off = off_at(best);
        self.from = best;
        off
    }
}
