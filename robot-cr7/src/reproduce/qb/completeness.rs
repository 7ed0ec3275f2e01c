//! Theorem 3 of Huang et al. 2025 with viscous friction: a motion that exists and that the scan does
//! not find.
//!
//! A drive lowers a load of 1 kg over 1 m. In the middle the load pulls with more than the drive can
//! hold at rest. Viscous friction holds the rest, but only in motion. Property 3, that a drive can
//! hold the load at rest everywhere, is an assumption that Theorem 3 does not state.

use arcfeed_feedrate::constraint::{JointTorque, SpeedCap};
use arcfeed_feedrate::{FeedError, FeedPlanner, FeedProblem, MotionLaw, Quantity, Reachability};

use super::published::PublishedScan;
use crate::reproduce::Reproduction;

const PLACE: &str = "Theorem 3 with viscous friction: a load that friction holds in motion only";
/// Force of the drive, N; pull of the load, N, from 0.45 m to 0.6 m; friction, N s/m; speed, m/s.
const DRIVE: f64 = 4.0;
const PULL: f64 = 6.0;
const STEEP: (f64, f64) = (0.45, 0.6);
const FRICTION: f64 = 4.0;
const FASTEST: f64 = 0.9;
const INTERVALS: usize = 1000;
/// Time between samples, s.
const PERIOD: f64 = 1e-4;
/// Excess where the pull steps within an interval of the grid, as a share.
const BETWEEN: f64 = 1e-3;

fn pull(s: f64) -> f64 {
    if s > STEEP.0 && s < STEEP.1 { PULL } else { 0.0 }
}

/// A motion by its positions at equal steps of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Lowered {
    /// Time between the positions, s.
    pub period: f64,
    /// Positions, m.
    pub p: Vec<f64>,
}

impl Lowered {
    fn of(law: &impl MotionLaw) -> Self {
        let n = (law.duration() / PERIOD).floor() as usize;
        Self { period: PERIOD, p: (0..=n).map(|i| law.at(i as f64 * PERIOD).p).collect() }
    }

    /// By hand: 0.8 m/s^2 up to 0.75 m/s, constant speed to 0.8 m, and an even brake.
    fn by_hand() -> Self {
        let (v, up, from) = (0.75, 0.8, 0.8);
        let (t_up, s_up) = (v / up, 0.5 * v * v / up);
        let t_down = t_up + (from - s_up) / v;
        let brake = 0.5 * v * v / (1.0 - from);
        let n = ((t_down + v / brake) / PERIOD).floor() as usize;
        let at = |t: f64| {
            let late = t - t_down;
            if t < t_up {
                0.5 * up * t * t
            } else if late < 0.0 {
                s_up + v * (t - t_up)
            } else {
                from + late * (v - 0.5 * brake * late)
            }
        };
        Self { period: PERIOD, p: (0..=n).map(|i| at(i as f64 * PERIOD)).collect() }
    }

    /// Largest share of the force, by differences of the positions, and the way that is covered, m.
    pub fn share(&self) -> (f64, f64) {
        let h = self.period;
        let force =
            |w: &[f64]| (w[2] - 2.0 * w[1] + w[0]) / (h * h) + FRICTION * (w[2] - w[0]) / (2.0 * h) - pull(w[1]);
        let most = self.p.windows(3).map(|w| force(w).abs() / DRIVE).fold(0.0, f64::max);
        (most, self.p.last().copied().unwrap_or(0.0) - self.p.first().copied().unwrap_or(0.0))
    }
}

/// The counterexample.
#[derive(Debug, Clone, PartialEq)]
pub struct CompletenessRun {
    /// A motion that keeps the limit, made by hand.
    pub by_hand: Lowered,
    /// Where the published scan finds no speed, m; `None` if it finds a motion.
    pub refused_at: Option<f64>,
    /// The motion by reachability.
    pub reachability: Lowered,
}

impl CompletenessRun {
    /// Plans the motion by both planners.
    ///
    /// # Errors
    /// [`FeedError`] where reachability finds none.
    pub fn measure() -> Result<Self, FeedError> {
        let s: Vec<f64> = (0..=INTERVALS).map(|i| i as f64 / INTERVALS as f64).collect();
        let all = |x: f64| vec![x; s.len()];
        let (mass, none, friction, cap) = (all(1.0), all(0.0), all(FRICTION), all(FASTEST));
        let load: Vec<f64> = s.iter().map(|&s| -pull(s)).collect();
        let torque = JointTorque::new(&mass, &none, &friction, &load, &[DRIVE])?;
        let cap = SpeedCap::new(&cap, Quantity::Feed)?;
        let problem = FeedProblem::at_points(&s, &[&torque, &cap])?;
        let refused_at = match PublishedScan.plan(&problem) {
            Err(FeedError::StaticallyInfeasible { s, .. } | FeedError::StandsStill { s, .. }) => Some(s),
            Err(_) => Some(f64::NAN),
            Ok(_) => None,
        };
        let reachability = Lowered::of(&Reachability.plan(&problem)?);
        Ok(Self { by_hand: Lowered::by_hand(), refused_at, reachability })
    }

    /// Adds the rows.
    pub fn judge(&self, r: &mut Reproduction) {
        let motions = [("a motion by hand", &self.by_hand, 1e-6), ("reachability", &self.reachability, BETWEEN)];
        for (name, motion, slack) in motions {
            let (share, way) = motion.share();
            let holds = share <= 1.0 + slack && (way - 1.0).abs() < 1e-6;
            r.independent(
                PLACE,
                format!("{name}: force by differences / limit"),
                "at most 1",
                format!("{share:.4}"),
                holds,
            )
            .note(format!("covers {way:.6} m in {:.4} s", motion.p.len() as f64 * motion.period));
        }
        let found = self.refused_at.map_or("one".to_owned(), |s| format!("none, by the point at {s:.3} m"));
        r.independent(
            PLACE,
            "the scan of the paper finds",
            "a motion, if one exists",
            found,
            self.refused_at.is_some(),
        )
        .note("Theorem 3 needs Property 3, a drive that holds at rest everywhere; in motion friction helps");
    }
}
