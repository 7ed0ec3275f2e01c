//! The time-constrained planning of Liu et al. 2024, section 4.1: its five cases, counted over seeded
//! random joints.
//!
//! The paper searches one cruise velocity for a given duration, in an interval that depends on the
//! mean velocity. Its displacement is read as positive, so a joint that moves down is mirrored. A
//! case that changes the end velocity (steps 3 and 4 of cases 2 and 4) does not reach the state that
//! was asked for and counts as not solved. Start and end accelerations are zero, as in its cases.

use arcfeed_feedrate::{AxisLimits, AxisState, MotionLaw, StateToState};

use crate::reproduce::Random;

/// Limits of Table 4: velocity, acceleration, jerk.
const LIMITS: (f64, f64, f64) = (10.0, 100.0, 1000.0);
/// Random joints.
const JOINTS: usize = 2000;

/// How many joints were solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CaseCounts {
    /// Joints for which a motion of the wanted duration exists.
    pub joints: usize,
    /// Solved by the five cases.
    pub five_cases: usize,
    /// Solved by a search over all cruise velocities.
    pub one_search: usize,
}

/// A joint: velocities at both ends, displacement, duration.
#[derive(Debug, Clone, Copy)]
struct Joint {
    vs: f64,
    ve: f64,
    way: f64,
    time: f64,
}

/// Time of an S-shaped change of velocity.
fn change(from: f64, to: f64) -> f64 {
    let (_, a, j) = LIMITS;
    let dv = (to - from).abs();
    if dv <= a * a / j { 2.0 * (dv / j).sqrt() } else { dv / a + a / j }
}

fn displacement(from: f64, to: f64) -> f64 {
    0.5 * (from + to) * change(from, to)
}

impl Joint {
    /// Way with cruise velocity `v` less the wanted one; `None` where the changes take too long.
    fn miss(&self, v: f64) -> Option<f64> {
        let cruise = self.time - change(self.vs, v) - change(v, self.ve);
        let way = displacement(self.vs, v) + displacement(v, self.ve) + v * cruise;
        (cruise >= -1e-12).then_some(way - self.way)
    }

    /// Whether a cruise velocity between `lo` and `hi` solves the joint.
    fn search(&self, lo: f64, hi: f64) -> bool {
        const STEPS: u32 = 2000;
        let at = |i: u32| self.miss(lo + (hi - lo) * f64::from(i) / f64::from(STEPS));
        let crosses = |i: u32| at(i).zip(at(i + 1)).is_some_and(|(a, b)| a.min(b) <= 1e-12 && a.max(b) >= -1e-12);
        (0..STEPS).any(crosses)
    }

    /// Cases 1 to 5 of section 4.1.
    fn five_cases(&self) -> bool {
        let mean = self.way / self.time;
        let (first, second) = (displacement(self.vs, mean), displacement(mean, self.ve));
        match (mean < self.vs, mean < self.ve) {
            _ if mean == self.vs && mean == self.ve => true,
            (true, true) => first + second < self.way && self.search(0.0, mean),
            (false, false) => first + second < self.way && self.search(mean, LIMITS.0),
            (true, false) => first < self.way && second < self.way && self.search(self.ve, self.vs),
            (false, true) => first < self.way && second < self.way && self.search(self.vs, self.ve),
        }
    }
}

/// Counts over seeded random joints, with durations of 1 to 2 times the shortest.
pub fn counts() -> CaseCounts {
    let mut random = Random::new(41);
    let mut counts = CaseCounts::default();
    let Ok(limits) = AxisLimits::symmetric(LIMITS.0, LIMITS.1, LIMITS.2) else { return counts };
    for _ in 0..JOINTS {
        let (vs, ve, way) = (random.between(-9.0, 9.0), random.between(-9.0, 9.0), random.between(0.0, 10.0));
        let factor = random.between(1.0, 2.0);
        let (start, end) = (AxisState::new(0.0, vs, 0.0), AxisState::new(way, ve, 0.0));
        let Ok(shortest) = StateToState::new(&start, &end, &limits) else { continue };
        let time = factor * shortest.duration();
        if StateToState::with_duration(&start, &end, &limits, time).is_err() {
            continue;
        }
        let joint = Joint { vs, ve, way, time };
        counts.joints += 1;
        counts.five_cases += usize::from(joint.five_cases());
        counts.one_search += usize::from(joint.search(-LIMITS.0, LIMITS.0));
    }
    counts
}
