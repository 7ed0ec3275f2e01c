//! The curve of a plan, and how far axes are on it.

use arcfeed_sync::feedrate::AxisState;
use arcfeed_sync::{JointState, Trajectory};

use super::generator_input::{AXES, States};

/// Motions one after the other, and the time of the plan that was found last.
pub struct Curve {
    motions: Vec<Trajectory<AXES>>,
    from: f64,
    /// The latest time that was found, and for how many cycles the axes have been behind it.
    latest: f64,
    behind: usize,
}

/// How far the axes may be behind the latest time without counting as behind, in cycles: where all of them turn at once with
/// little jerk, positions do not tell the time any better. For how many cycles they may be farther behind.
const UNCERTAIN: f64 = 0.25;
const SEVERAL: usize = 5;

impl std::fmt::Debug for Curve {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let durations: Vec<f64> = self.motions.iter().map(Trajectory::duration).collect();
        write!(f, "at {} of {durations:?}", self.from)
    }
}

impl Curve {
    pub fn of(motions: Vec<Trajectory<AXES>>) -> Self {
        Self { motions, from: 0.0, latest: 0.0, behind: 0 }
    }

    /// The state at the time found last.
    pub fn here(&self) -> JointState<AXES> {
        self.at(self.from)
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

    /// Returns true if the axes have been behind a place of the curve where they were for several cycles: they run backward, or
    /// jumped back.
    pub fn runs_back(&self) -> bool {
        self.behind > SEVERAL
    }

    /// Looks for the time of the plan at which the axis that is farthest off is nearest, around the last one, and returns how far it
    /// is off there. Where all axes turn at once a time before the turn and one after it may be as near: of those that are near enough
    /// the one counts whose velocities, at this scale of time, are nearest.
    pub fn advance(&mut self, now: &States, (scale, cycle): (f64, f64), near_enough: f64) -> f64 {
        let start = self.from;
        let off_at = |t: f64| {
            let s = self.at(t);
            now.iter().zip(s.q.iter()).map(|(s, q): (&AxisState, &f64)| (q - s.p).abs()).fold(0.0, f64::max)
        };
        let faster_at = |t: f64| {
            let s = self.at(t);
            now.iter().zip(s.qd.iter()).map(|(s, v): (&AxisState, &f64)| (scale * v - s.v).abs()).fold(0.0, f64::max)
        };
        let mut best = start;
        // An axis that turns back and forth within a hundredth of a cycle needs more places.
        for places in [65, 65 * 32] {
            let wide = 1.6 * cycle * 65.0 / 64.0 / f64::from(places);
            for found in minima(&off_at, |i| (start + wide * f64::from(i)).max(0.0), places) {
                let (off, was) = (off_at(found), off_at(best));
                let better = if off.max(was) < near_enough { faster_at(found) < faster_at(best) } else { off < was };
                if better {
                    best = found;
                }
            }
            if off_at(best) < near_enough {
                break;
            }
        }
        let off = off_at(best);
        self.from = best;
        self.behind = if best < self.latest - UNCERTAIN * cycle { self.behind + 1 } else { 0 };
        self.latest = self.latest.max(best);
        off
    }
}

/// The minima of a function, by golden section beside every place that is lower than those around it: axes that turn have more than one.
fn minima(off_at: &impl Fn(f64) -> f64, place: impl Fn(i32) -> f64, most: i32) -> Vec<f64> {
    let offs: Vec<f64> = (-most..=most).map(|i| off_at(place(i))).collect();
    // The last of equal ones: before the begin all are.
    let least = (1..offs.len() - 1).rev().min_by(|&i, &k| offs[i].total_cmp(&offs[k]));
    let turns = (1..offs.len() - 1).filter(|&i| offs[i] < offs[i - 1] && offs[i] <= offs[i + 1]);
    let beside = |i: usize| {
        let near = i as i32 - most;
        nearest(off_at, place(near - 1), place(near + 1))
    };
    least.into_iter().chain(turns).map(beside).collect()
}

/// The least of a function between two places, where it has one minimum.
fn nearest(off_at: &impl Fn(f64) -> f64, mut lo: f64, mut hi: f64) -> f64 {
    for _ in 0..80 {
        let (x, y) = (hi - 0.618_033_988_75 * (hi - lo), lo + 0.618_033_988_75 * (hi - lo));
        if off_at(x) <= off_at(y) { hi = y } else { lo = x }
    }
    0.5 * (lo + hi)
}
