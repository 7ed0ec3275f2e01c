//! The arm along a motion, for pictures that move.

use arcfeed_kinematics::Chain;
use nalgebra::{Isometry3, Vector3};
use serde::Serialize;

use crate::run::trajectory_row::TrajectoryRow;

/// Poses that are kept, at the most.
const MOST_POSES: usize = 800;
/// Distance between two joints that is drawn as a link, m; joints that are nearer turn at one place.
const SHORTEST_LINK: f64 = 1e-3;

/// Six digits, which is what a picture shows.
pub(crate) fn short(value: f64) -> f64 {
    if value.abs() < 1e-12 { 0.0 } else { format!("{value:.5e}").parse().unwrap_or(value) }
}

/// The arm at one moment.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pose {
    /// Time, s.
    pub t: f64,
    /// x, y, z of base, joints, flange and tip of the tool in turn, in the frame of the base, m.
    pub points: Vec<f64>,
    /// Joint values, rad or m.
    pub joints: Vec<f64>,
    /// Speed of the tool along its path, m/s.
    pub feed: f64,
}

impl Pose {
    /// The points one by one, m; the last one is the tip.
    #[cfg(any(feature = "plot", test))]
    pub(crate) fn places(&self) -> impl DoubleEndedIterator<Item = Vector3<f64>> + '_ {
        self.points.chunks_exact(3).map(|p| Vector3::new(p[0], p[1], p[2]))
    }
}

/// Collects poses of an arm along a motion, evenly spread over its samples, both ends included.
#[derive(Debug, Clone)]
pub struct ArmPoses<const N: usize> {
    chain: Chain<N>,
    poses: Vec<Pose>,
    samples: usize,
    seen: usize,
}

impl<const N: usize> ArmPoses<N> {
    /// For a motion of `samples` samples of an arm with its tool.
    pub fn new(chain: Chain<N>, samples: usize) -> Self {
        Self { chain, poses: Vec::new(), samples, seen: 0 }
    }

    /// The next sample, with the speed of the tool along its path (m/s).
    pub fn push(&mut self, row: &TrajectoryRow<N>, feed: f64) {
        let every = self.samples.div_ceil(MOST_POSES).max(1);
        if self.seen.is_multiple_of(every) || self.seen + 1 == self.samples {
            let points = places(&self.chain, &row.q);
            let joints = row.q.iter().map(|v| short(*v)).collect();
            self.poses.push(Pose { t: short(row.t), points, joints, feed: short(feed) });
        }
        self.seen += 1;
    }

    /// The poses in their order.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// The arm.
    #[cfg(feature = "html")]
    pub(crate) fn chain(&self) -> &Chain<N> {
        &self.chain
    }

    /// Length of all links together, m.
    #[cfg(feature = "html")]
    pub(crate) fn reach(&self) -> f64 {
        let joints: f64 = self.chain.joints().iter().map(|joint| joint.origin().translation.vector.norm()).sum();
        joints + self.chain.flange().translation.vector.norm() + self.chain.tool().translation.vector.norm()
    }
}

/// Base, the origin of each joint, flange and tip of the tool, in the frame of the base (m): x, y, z of each in turn.
fn places<const N: usize>(chain: &Chain<N>, q: &[f64; N]) -> Vec<f64> {
    let mut at = *chain.base();
    let mut points: Vec<Vector3<f64>> = vec![at.translation.vector];
    let mut add = |pose: &Isometry3<f64>, always: bool| {
        let point = pose.translation.vector;
        if always || points.last().is_none_or(|last| (point - last).norm() > SHORTEST_LINK) {
            points.push(point);
        }
    };
    for (joint, &value) in chain.joints().iter().zip(q) {
        at = at * joint.origin() * joint.motion(value);
        add(&at, false);
    }
    at *= chain.flange();
    add(&at, false);
    // The tip is always there, so that what follows it finds it.
    add(&(at * chain.tool()), true);
    points.iter().flat_map(|point| point.iter().map(|v| short(*v)).collect::<Vec<_>>()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use arcfeed_kinematics::{ForwardKinematics, Joints, models};

    #[test]
    fn poses_are_spread_over_the_motion_and_end_at_the_tip() {
        let arm = models::ur5e();
        let row = |i: usize| {
            let q = Joints::from([0.1, -1.0, 1.2, -0.7, 0.4, 0.001 * i as f64]);
            TrajectoryRow::new(i as f64, [&q, &q, &q, &q], &arm.forward(&q))
        };
        for samples in [1, 2, 799, 801, 5000] {
            let mut poses = ArmPoses::new(*arm.chain(), samples);
            (0..samples).for_each(|i| poses.push(&row(i), 0.1));
            let poses = poses.poses();
            assert!(poses.len() <= MOST_POSES + 1 && poses.len() >= samples.min(400), "{samples}: {}", poses.len());
            assert_eq!((poses[0].t, poses[poses.len() - 1].t), (0.0, (samples - 1) as f64));
            let tip = poses[poses.len() - 1].places().next_back().expect("a tip");
            assert!((tip - Vector3::from(row(samples - 1).position)).norm() < 1e-5);
        }
    }

    #[test]
    fn numbers_keep_six_digits() {
        assert_eq!(short(123.456_789_1), 123.457);
        assert_eq!(short(-1.234_567_8e-5), -1.23457e-5);
        assert_eq!(short(3e-17), 0.0);
        assert!(short(f64::NAN).is_nan());
    }
}
