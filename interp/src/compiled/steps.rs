//! Places where the planned acceleration of the joints steps, and the times around them over which a step is spread.

use arcfeed_feedrate::MotionLaw;

use nalgebra::Isometry3;

use super::piece::State;
use crate::error::PlanError;
use crate::trajectory::Trajectory;

/// A difference of the second derivatives before and after a knot counts as a jump above this, absolute and relative.
const SMOOTH: f64 = 1e-7;
/// Steps below this part of the limit on acceleration are none.
const NO_STEP: f64 = 1e-9;
/// Parts of the time over which a step is spread that may lie before it, the best one first.
const PARTS_BEFORE: [f64; 5] = [0.5, 0.375, 0.625, 0.25, 0.75];

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
/// period: half before it and half after it where that keeps the jerk limit. Where the next step or an end of the motion is nearer,
/// there is less time.
pub(super) fn steps<const N: usize>(trajectory: &Trajectory<'_, N>) -> Result<Vec<Step<N>>, PlanError> {
    let (path, law, limits) = (trajectory.path(), trajectory.law(), trajectory.limits().joints());
    let (joints, period) = (trajectory.joint_path(), trajectory.period());
    let mut steps: Vec<Step<N>> = Vec::new();
    for &s in path.knots() {
        let after = path.jet(s, &joints.near(s).q)?;
        let before = path.jet_before(&after)?;
        let jump = (after.d2 - before.d2).abs();
        let jumps = (0..N).any(|k| jump[k] > SMOOTH * (1.0 + before.d2[k].abs() + after.d2[k].abs()));
        if !jumps {
            continue;
        }
        let t = law.time_at_position(s);
        let sides = [(before, law.at(t.next_down())), (after, law.at(t))];
        let [before, after] = sides.map(|(jet, state)| jet.setpoint(t, &state, Isometry3::identity()));
        let step = after.qdd - before.qdd;
        if (0..N).all(|k| step[k].abs() <= NO_STEP * limits.acceleration()[k]) {
            continue;
        }
        let jerk_of = |part: f64| {
            let mean = step / period + before.jerk * part + after.jerk * (1.0 - part);
            mean.component_div(limits.jerk()).amax()
        };
        let part = PARTS_BEFORE.into_iter().find(|part| jerk_of(*part) <= 1.0);
        let least = |a: &f64, b: &f64| jerk_of(*a).total_cmp(&jerk_of(*b));
        let part = part.or_else(|| PARTS_BEFORE.into_iter().min_by(least)).unwrap_or(0.5);
        let window = [t - part * period, t + (1.0 - part) * period];
        let [before, after] = [before, after].map(|at| State { q: at.q, qd: at.qd, qdd: at.qdd });
        steps.push(Step { t, window, before, after });
    }
    separate(&mut steps, trajectory.duration());
    Ok(steps)
}

/// No window overlaps the next one or leaves the motion.
fn separate<const N: usize>(steps: &mut [Step<N>], duration: f64) {
    let times: Vec<f64> = steps.iter().map(|step| step.t).collect();
    for (i, step) in steps.iter_mut().enumerate() {
        let last = if i == 0 { 0.0 } else { 0.5 * (times[i - 1] + step.t) };
        let next = times.get(i + 1).map_or(duration, |next| 0.5 * (step.t + next));
        step.window = [step.window[0].max(last), step.window[1].min(next)];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arcfeed_kinematics::Joints;

    #[test]
    fn windows_end_in_the_middle_between_two_steps_and_at_the_ends_of_the_motion() {
        let still = State { q: Joints::<2>::zeros(), qd: Joints::zeros(), qdd: Joints::zeros() };
        let step = |t: f64| Step { t, window: [t - 0.5, t + 0.5], before: still, after: still };
        let mut steps = [0.25, 2.0, 2.5, 4.0].map(step);
        separate(&mut steps, 4.25);
        assert_eq!(steps.map(|step| step.window), [[0.0, 0.75], [1.5, 2.25], [2.25, 3.0], [3.5, 4.25]]);
    }
}
