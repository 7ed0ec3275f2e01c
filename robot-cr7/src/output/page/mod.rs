//! A motion as one page for a browser: the arm that moves, the curves of tool and joints, the limits and where they bind.

mod data;
mod shape;

use arcfeed_interp::TorqueLimits;
use arcfeed_kinematics::{JointLimits, Joints};

use self::data::{JointCurves, Page};
use self::shape::ArmShape;
use super::arm_poses::{ArmPoses, short};
use super::binding_line::limited_by;
use super::report::Report;
use super::series::Series;
use crate::input::meshes::LinkMesh;
use crate::run::trajectory_row::TrajectoryRow;

/// Samples of the curves, at the most: more than a wide screen has columns.
const MOST_ROWS: usize = 3000;
/// Radius of the links over the length of the outstretched arm.
const SLENDER: f64 = 0.02;

/// What the page shows besides the samples.
#[derive(Debug, Clone)]
pub struct PageFacts<'a, const N: usize> {
    /// The robot.
    pub robot: String,
    /// Names of its joints.
    pub joint_names: Vec<String>,
    /// Their limits.
    pub joints: &'a JointLimits<N>,
    /// Those of their torques, where these are limited.
    pub torque: Option<&'a TorqueLimits<'a, N>>,
    /// Meshes of its links, which are drawn instead of capsules; any number of triangles.
    pub meshes: Vec<LinkMesh>,
}

/// The highest speed along a motion.
#[derive(Debug, Clone, Copy)]
pub struct SpeedCeiling<'a> {
    /// Time (s) and the highest speed there (m/s), increasing in time.
    pub by_time: &'a [(f64, f64)],
    /// From which place of the path on (m), increasing, which limit sets it, in words.
    pub limits: &'a [(f64, String)],
}

/// Collects the samples of a motion, and makes one HTML file of them, which needs nothing else.
///
/// Memory is bounded however long the motion is: a long one keeps the least and the greatest value of each run of samples.
#[derive(Debug)]
pub struct MotionPage<'a, const N: usize> {
    facts: PageFacts<'a, N>,
    series: Series,
}

impl<'a, const N: usize> MotionPage<'a, N> {
    /// For a motion of `samples` samples.
    pub fn new(facts: PageFacts<'a, N>, samples: usize) -> Self {
        let columns = 3 + N * (4 + usize::from(facts.torque.is_some()));
        let series = Series::with_rows(columns, samples, MOST_ROWS);
        Self { facts, series }
    }

    /// The next sample, with its place on the path (m) and the speed there (m/s).
    pub fn push(&mut self, row: &TrajectoryRow<N>, s: f64, feed: f64) {
        let torque = |torque: &TorqueLimits<'_, N>| -> [f64; N] {
            torque.torque(&row.q.into(), &row.qd.into(), &row.qdd.into()).into()
        };
        let torque = self.facts.torque.map(torque);
        let joints = [row.q, row.qd, row.qdd, row.jerk].into_iter().chain(torque).flatten();
        self.series.push([row.t, s, feed].into_iter().chain(joints));
    }

    /// The page of the motion that `report` is about.
    pub fn finish(mut self, report: &Report, ceiling: &SpeedCeiling<'_>, poses: &ArmPoses<N>) -> String {
        self.series.cut();
        let PageFacts { robot, joint_names, joints, torque, meshes } = &self.facts;
        let series = &self.series;
        let degrees = 1f64.to_degrees();
        let curves = |name, unit, first: usize, factor: f64, least: [f64; N], most: [f64; N]| JointCurves {
            name,
            unit,
            values: (0..N).map(|k| series.column(first + k).iter().map(|v| short(v * factor)).collect()).collect(),
            limits: least.iter().zip(&most).map(|(a, b)| [a * factor, b * factor].map(short)).collect(),
        };
        let even = |name, unit, first, factor, most: &Joints<N>| {
            curves(name, unit, first, factor, (-most).into(), (*most).into())
        };
        let mut quantities = vec![
            even("velocity", "deg/s", 3 + N, degrees, joints.velocity()),
            even("acceleration", "deg/s\u{b2}", 3 + 2 * N, degrees, joints.acceleration()),
            even("jerk", "deg/s\u{b3}", 3 + 3 * N, degrees, joints.jerk()),
            curves("position", "deg", 3, degrees, (*joints.lower()).into(), (*joints.upper()).into()),
        ];
        if let Some(torque) = torque {
            quantities.push(even("torque", "N m", 3 + 4 * N, 1.0, torque.limits()));
        }
        let column = |i: usize| series.column(i).iter().map(|v| short(*v)).collect::<Vec<_>>();
        let page = Page {
            report,
            limited_by: limited_by(&report.binding, report.length_m),
            robot,
            joint_names,
            t: column(0),
            s: column(1),
            feed: column(2),
            limit: thinned(ceiling.by_time).iter().map(|&(t, v)| [short(t), short(v)]).collect(),
            ceiling: ceiling.limits.iter().map(|(s, name)| (short(*s), name.as_str())).collect(),
            quantities,
            radius: short(SLENDER * poses.reach()),
            poses: poses.poses(),
            shape: ArmShape::new(poses.chain(), meshes),
        };
        page.to_html()
    }
}

/// Points of a curve, the lowest of each run of them.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let lowest = |run: &[(f64, f64)]| run.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
    points.chunks(points.len().div_ceil(MOST_ROWS).max(1)).filter_map(lowest).collect()
}
