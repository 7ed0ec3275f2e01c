//! The way from where the arm stands to the start of a motion.

use arcfeed_feedrate::{AxisLimits, AxisState};
use arcfeed_interp::{JointPoint, JointTrajectory};
use arcfeed_kinematics::Joints;
use arcfeed_sync::{MotionOptions, SyncError, Synchronisation, Trajectory};

use super::verified_motion::{NotSendable, VerifiedMotion};

/// The part of the limits that the way to the start uses.
const SHARE: f64 = 0.2;
/// The arm is where the motion starts if no joint is further away, rad.
const SAME: f64 = 1e-6;
/// Times of phases that are nearer to each other are one, s.
const SAME_TIME: f64 = 1e-6;

/// `motion` with a joint move before it that begins at `from` (rad): on a straight line of the joints, with a fifth of the limits of
/// velocity, acceleration and jerk, certified with the rest. Collisions are not looked at.
///
/// # Errors
/// [`NotSendable`].
pub fn lead_in<const N: usize>(motion: &VerifiedMotion<N>, from: &Joints<N>) -> Result<VerifiedMotion<N>, NotSendable> {
    let to = motion.start();
    if (to - from).amax() <= SAME {
        return Ok(motion.clone());
    }
    let lead = joint_move(motion, from, &to).map_err(NotSendable::NoWay)?;
    motion.after(VerifiedMotion::new(JointTrajectory::through(&lead)?, motion.limits())?)
}

/// Points between which quintics are the move: one wherever the jerk of a joint changes.
fn joint_move<const N: usize>(
    motion: &VerifiedMotion<N>,
    from: &Joints<N>,
    to: &Joints<N>,
) -> Result<Vec<JointPoint<N>>, SyncError> {
    let limits = motion.limits();
    let mut axes = [AxisLimits::symmetric(1.0, 1.0, 1.0).map_err(|source| SyncError::State { axis: 0, source })?; N];
    for (axis, place) in axes.iter_mut().enumerate() {
        let [v, a, j] = [limits.velocity(), limits.acceleration(), limits.jerk()].map(|limit| SHARE * limit[axis]);
        *place = AxisLimits::symmetric(v, a, j).map_err(|source| SyncError::State { axis, source })?;
    }
    let rest = |q: &Joints<N>| std::array::from_fn(|k| AxisState::rest(q[k]));
    let options = MotionOptions::new(Synchronisation::StraightLine);
    let way = Trajectory::new(&rest(from), &rest(to), &axes, &options)?;

    let mut times: Vec<f64> = way.axes().iter().flat_map(|axis| axis.phases().map(|(phase, _)| phase.t)).collect();
    times.retain(|&t| t > SAME_TIME && t < way.duration() - SAME_TIME);
    times.sort_by(f64::total_cmp);
    times.dedup_by(|later, earlier| *later - *earlier < SAME_TIME);
    let nanoseconds = |t: f64| (t * 1e9).round() as u64;
    let resting =
        |nanoseconds, q: &Joints<N>| JointPoint { nanoseconds, q: *q, qd: Joints::zeros(), qdd: Joints::zeros() };
    let mut points = vec![resting(0, from)];
    points.extend(times.into_iter().map(|t| {
        let at = way.at(nanoseconds(t) as f64 * 1e-9);
        JointPoint { nanoseconds: nanoseconds(t), q: at.q, qd: at.qd, qdd: at.qdd }
    }));
    points.push(resting(nanoseconds(way.duration()), to));
    Ok(points)
}

#[cfg(test)]
mod tests {
    use arcfeed_kinematics::JointRange;

    use super::*;

    #[test]
    fn the_way_begins_where_the_arm_stands_and_keeps_a_fifth_of_the_limits() {
        let range = JointRange::new(Joints::repeat(-3.0), Joints::repeat(3.0)).expect("a range");
        let limits =
            range.with_rates(Joints::repeat(2.0), Joints::repeat(10.0), Joints::repeat(100.0)).expect("limits");
        let start = Joints::from([0.3, -0.2, 1.0]);
        let rest = JointTrajectory::resting(&start, 0.5).expect("rest");
        let motion = VerifiedMotion::new(rest, &limits).expect("rest keeps limits");
        for off in [1e-7, 1e-5, 0.003, 0.2, 2.5] {
            let from = start + Joints::from([-off, 0.3 * off, -0.01 * off]);
            let whole = lead_in(&motion, &from).expect("a way");
            let trajectory = whole.trajectory();
            assert!((whole.start() - from).amax() < 2e-7, "{off}");
            assert!((trajectory.at(trajectory.duration()).q - start).amax() < 1e-12, "{off}");
            let slow = trajectory.times().len() * 100;
            for i in 0..=slow {
                let at = trajectory.at(trajectory.duration() * i as f64 / slow as f64);
                assert!(at.qd.amax() <= 0.4 + 1e-6 && at.qdd.amax() <= 2.0 + 1e-4, "{off}: {at:?}");
            }
        }
    }
}
