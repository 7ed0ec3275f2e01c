//! The check of a tool that follows targets, from the samples of the joints alone.

use arcfeed_kinematics::{ForwardKinematics, Joints};
use nalgebra::Vector3;

use super::limit_line::{LimitLine, LimitUnit};
use super::tool_run::ToolRun;
use super::worst_sample::WorstSample;

/// At the end the tool may miss its target by this much, m and rad.
const END: f64 = 1e-9;
/// Names and units of the limits, in the order of [`ToolRun::limits`].
const LINES: [(&str, LimitUnit); 6] = [
    ("tool speed", LimitUnit::MetrePerSecond),
    ("tool acceleration", LimitUnit::MetrePerSecond2),
    ("tool jerk", LimitUnit::MetrePerSecond3),
    ("tool angular speed", LimitUnit::RadianPerSecond),
    ("tool angular acceleration", LimitUnit::RadianPerSecond2),
    ("tool angular jerk", LimitUnit::RadianPerSecond3),
];

/// Speed, acceleration and jerk of the tool against their limits, and the pose at the end against the target.
///
/// The motion of the tool comes from the joints by forward kinematics: speed and acceleration at each sample, acceleration and jerk also as
/// the means of each cycle, which never exceed the largest values. Where limits are lowered the tool has the time that braking takes to come
/// inside, and meanwhile no more than the limits before.
pub fn tool_lines<A: ForwardKinematics<N>, const N: usize>(arm: &A, run: &ToolRun<N>) -> Vec<LimitLine> {
    let mut worst = [WorstSample::default(); 6];
    let mut before: Option<(f64, [Vector3<f64>; 4])> = None;
    for (t, state, _) in &run.joints.samples {
        let now = rates(arm, &state.q, &state.qd, &state.qdd);
        let limits = in_force(&run.limits, before.map_or(*t, |(before, _)| before));
        let [v, a, omega, alpha] = now;
        let mean = |k: usize| {
            before.map_or(0.0, |(earlier, was): (f64, [Vector3<f64>; 4])| (now[k] - was[k]).norm() / (t - earlier))
        };
        let values = [v.norm(), a.norm().max(mean(0)), mean(1), omega.norm(), alpha.norm().max(mean(2)), mean(3)];
        for ((worst, value), limit) in worst.iter_mut().zip(values).zip(limits) {
            worst.see(*t, value, limit);
        }
        before = Some((*t, now));
    }
    let lines = LINES.into_iter().zip(worst).map(|((name, unit), worst)| worst.line(name, None, unit));
    lines.chain(ends(arm, run)).collect()
}

/// Linear velocity and acceleration, angular velocity and acceleration of the tool.
fn rates<A: ForwardKinematics<N>, const N: usize>(
    arm: &A,
    q: &Joints<N>,
    qd: &Joints<N>,
    qdd: &Joints<N>,
) -> [Vector3<f64>; 4] {
    let at = arm.configuration(q);
    let jacobian = at.jacobian();
    let (first, second) = (jacobian * qd, jacobian * qdd + at.acceleration_bias(qd));
    let rows = |twist: &nalgebra::Vector6<f64>, from: usize| twist.fixed_rows::<3>(from).into_owned();
    [rows(&first, 0), rows(&second, 0), rows(&first, 3), rows(&second, 3)]
}

/// The limits at `t`: those set last, or the higher ones before while the tool brakes to the new ones.
fn in_force(limits: &[(f64, [f64; 6])], t: f64) -> [f64; 6] {
    // A change has the time of the cycle that it begins with.
    let so_far = limits.iter().filter(|(from, _)| *from <= t * (1.0 + 1e-12));
    let mut all = so_far.copied();
    let Some((_, mut now)) = all.next() else { return [0.0; 6] };
    for (from, next) in all {
        let mut until = now;
        for first in [0, 3] {
            // The acceleration is taken off, built up against the motion, and taken off again.
            let braking = now[first] / next[first + 1] + (now[first + 1] + 2.0 * next[first + 1]) / next[first + 2];
            let braking = t < from + braking;
            for k in first..first + 3 {
                until[k] = if braking { now[k].max(next[k]) } else { next[k] };
            }
        }
        now = until;
    }
    now
}

/// By how much the tool misses its target at the end.
fn ends<A: ForwardKinematics<N>, const N: usize>(arm: &A, run: &ToolRun<N>) -> [LimitLine; 2] {
    let (mut t, mut misses) = (0.0, [f64::NAN; 2]);
    if let Some((end, state, _)) = run.joints.samples.last() {
        let pose = arm.forward(&state.q);
        let position = (pose.translation.vector - run.target.translation.vector).norm();
        (t, misses) = (*end, [position, pose.rotation.angle_to(&run.target.rotation)]);
    }
    let line = |miss: f64, name, unit| {
        let mut worst = WorstSample::default();
        worst.see(t, miss, END);
        worst.line(name, None, unit)
    };
    [line(misses[0], "tool at the end", LimitUnit::Metre), line(misses[1], "orientation at the end", LimitUnit::Radian)]
}
