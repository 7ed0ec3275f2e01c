//! The distance of a run from its path.

use arcfeed_interp::Verification;
use arcfeed_kinematics::Joints;
use nalgebra::Vector3;

use super::play::{Cycle, Played};
use super::stage::Stage;

impl Stage<'_> {
    /// The setpoints of a run against every limit: those of the joints all the time, those of the tool on the path.
    pub fn verify(&self, played: &Played) -> Verification {
        self.live().verify(&played.start, played.cycles.iter().map(|cycle| (&cycle.setpoint, cycle.on_path)))
    }
}

/// Largest distance of the tool from the path over cycles on it: of the setpoints at their arc length, and of the simulated joints from the
/// nearest point of the path.
pub(crate) fn accuracy<'c>(stage: &Stage<'_>, cycles: impl Iterator<Item = &'c Cycle>) -> Option<(f64, f64)> {
    let path = stage.live().path().pose_path();
    let slowest = stage.drive.amax();
    let mut worst: Option<(f64, f64)> = None;
    for cycle in cycles.filter(|c| c.on_path) {
        let p = &cycle.setpoint;
        let (w, drive) = worst.get_or_insert((0.0, 0.0));
        let tool = |q: &Joints<6>| stage.arm.forward(q).translation.vector;
        *w = w.max((tool(&p.q) - path.pose(p.s).translation.vector).norm());
        if slowest == 0.0 {
            *drive = *w;
            continue;
        }
        let reach = 1e-4 + 8.0 * slowest * p.feed.abs();
        *drive = drive.max(nearest(stage, &tool(&cycle.joints), p.s, reach));
    }
    worst
}

/// Distance of `point` from the path around `s`.
fn nearest(stage: &Stage<'_>, point: &Vector3<f64>, s: f64, reach: f64) -> f64 {
    const PIECES: u32 = 12;
    const HALVINGS: usize = 24;
    let curve = stage.live().path().pose_path().curve();
    let (from, to) = ((s - reach).max(0.0), (s + reach).min(curve.length()));
    let at = |s: f64| (curve.point(s) - point).norm();
    let h = (to - from) / f64::from(PIECES);
    let best = (0..=PIECES).map(|i| from + h * f64::from(i)).min_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or(s);
    let (mut low, mut high) = ((best - h).max(from), (best + h).min(to));
    for _ in 0..HALVINGS {
        let (a, b) = (low + 0.4 * (high - low), low + 0.6 * (high - low));
        if at(a) < at(b) {
            high = b;
        } else {
            low = a;
        }
    }
    at(0.5 * (low + high)).min(at(best))
}
