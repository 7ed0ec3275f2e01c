//! Places where the planned acceleration of the joints steps, and the times around them over which a step is spread.

use arcfeed_feedrate::{MotionLaw, SpeedLaw};

use super::piece::State;
use crate::error::PlanError;
use crate::trajectory::Trajectory;

/// A difference of the second derivatives before and after a knot counts as a jump above this, absolute and relative.
const SMOOTH: f64 = 1e-7;
/// Steps below this part of the limit on acceleration are none.
const NO_STEP: f64 = 1e-9;
/// Halvings of the time in which a place of the path is passed.
const HALVINGS: usize = 80;

/// A step of the planned acceleration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step<const N: usize> {
    /// The time of the step, s.
    pub t: f64,
    /// Start and end of the time over which it is spread, s.
    pub window: [f64; 2],
    /// The planned state just before the step.
    pub before: State<N>,
    /// The planned state just after it.
    pub after: State<N>,
}

/// The steps of the acceleration along a trajectory: one where the curvature of its path jumps and the motion does not rest.
///
/// The planner lets the acceleration step by what the jerk limit allows within one control period. A step is spread over that
/// period, half before it and half after it, or less where the next step or an end of the motion is nearer.
pub(super) fn steps<const N: usize>(trajectory: &Trajectory<'_, N>) -> Result<Vec<Step<N>>, PlanError> {
    let (path, law) = (trajectory.path(), trajectory.law());
    let (joints, least) = (trajectory.joint_path(), trajectory.limits().joints().acceleration() * NO_STEP);
    let mut steps: Vec<Step<N>> = Vec::new();
    for &s in path.knots() {
        let after = path.jet(s, &joints.near(s).q)?;
        let before = path.jet_before(&after)?;
        let jump = (after.d2 - before.d2).abs();
        let jumps = (0..N).any(|k| jump[k] > SMOOTH * (1.0 + before.d2[k].abs() + after.d2[k].abs()));
        if !jumps {
            continue;
        }
        let t = time_of(law, s);
        let motion = law.at(t);
        let state = |d1, d2| State { q: after.q, qd: d1 * motion.v, qdd: d1 * motion.a + d2 * (motion.v * motion.v) };
        let (before, after) = (state(before.d1, before.d2), state(after.d1, after.d2));
        let step = (after.qdd - before.qdd).abs();
        if (0..N).any(|k| step[k] > least[k]) {
            steps.push(Step { t, window: [t, t], before, after });
        }
    }
    spread(&mut steps, trajectory.period(), trajectory.duration());
    Ok(steps)
}

/// The windows: a control period around each step, and no overlap.
fn spread<const N: usize>(steps: &mut [Step<N>], period: f64, duration: f64) {
    let times: Vec<f64> = steps.iter().map(|step| step.t).collect();
    for (i, step) in steps.iter_mut().enumerate() {
        let last = if i == 0 { 0.0 } else { 0.5 * (times[i - 1] + step.t) };
        let next = times.get(i + 1).map_or(duration, |next| 0.5 * (step.t + next));
        step.window = [(step.t - 0.5 * period).max(last), (step.t + 0.5 * period).min(next)];
    }
}

/// The time at which the law passes the place `s`: at a knot of the law exactly there.
pub(super) fn time_of(law: &SpeedLaw, s: f64) -> f64 {
    let (mut low, mut high) = (0.0, law.duration());
    if let Some((t, _)) = law.knots().find(|(_, state)| (state.p - s).abs() <= 1e-13 * s) {
        return t;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if law.at(middle).p < s {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}
