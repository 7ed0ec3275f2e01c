//! The files of `cr7 plan`.

use crate::plot::{
    Along, ArmAtEnds, Bound, JointQuantity, PathMotion, PathPlace, feed_picture, joint_picture, motion_picture,
    path_picture, speed_path_picture,
};
use crate::{ArmPoses, BindingBar, BindingLine, LineTime, Series, SpeedFigure, StreamReport};
use arcfeed_kinematics::JointLimits;
use nalgebra::Isometry3;

use crate::cli::output::REPORTS;
use crate::cli::ros;

/// The files of the command.
pub const FILES: [&str; 18] = [
    "trajectory.csv",
    "path.svg",
    "path_speed.svg",
    "motion.svg",
    "feed.svg",
    "feed_time.svg",
    "joint_velocity.svg",
    "joint_acceleration.svg",
    "joint_jerk.svg",
    COMPILED,
    "stream.svg",
    LINES,
    ros::FILES[0],
    ros::FILES[1],
    ros::FILES[2],
    PAGE,
    REPORTS[0],
    REPORTS[1],
];
/// The file.
pub const PAGE: &str = "report.html";
/// The file of the compiled motion, where one is asked for.
pub const COMPILED: &str = "joint_trajectory.json";
/// The time of each line of a program.
pub const LINES: &str = "lines.csv";
/// The keys that make a motion faster that has too many samples.
pub const LEVERS: &str = "feed.feed_mm_s and the limits of the job";

/// One row for each line of the file.
pub fn write_lines(file: std::fs::File, lines: &[LineTime]) -> std::io::Result<()> {
    let mut writer = csv::Writer::from_writer(file);
    for line in lines {
        writer.serialize(line).map_err(std::io::Error::other)?;
    }
    writer.flush()
}

pub type Picture = (&'static str, Result<String, std::io::Error>);

/// What the pictures of a motion show beside its samples.
pub struct Drawn<'a, const N: usize> {
    pub name: &'a str,
    /// Points of each chord segment in the frame of the workpiece, m, and their largest deviations, m.
    pub segments: Vec<Vec<[f64; 3]>>,
    pub deviations: Vec<f64>,
    /// m.
    pub chord_tolerance: f64,
    /// The highest speed (m/s) by the way of the tool (m), and by the time (s).
    pub limit: Vec<(f64, f64)>,
    pub limit_by_time: Vec<(f64, f64)>,
    /// The arm along the motion, and the frame of the workpiece in that of its base.
    pub poses: ArmPoses<N>,
    pub workpiece: Isometry3<f64>,
    /// Places with the speed there.
    pub places: Vec<PathPlace>,
    pub joints: &'a JointLimits<N>,
}

/// Pictures of a motion whose time, place, feed and joint rates are the columns of `series`.
pub fn pictures<const N: usize>(drawn: &Drawn<'_, N>, series: &Series, binding: &[BindingLine]) -> Vec<Picture> {
    let name = drawn.name;
    let ends = drawn.poses.poses().first().zip(drawn.poses.poses().last());
    let arm = ends.map(|(start, end)| ArmAtEnds { start, end, workpiece: &drawn.workpiece });
    let motion = PathMotion { places: &drawn.places, binding, arm };
    let duration = series.column(0).last().copied().unwrap_or(0.0);
    let picture = |quantity, column: usize, limits: [f64; N]| {
        let values: [&[f64]; N] = std::array::from_fn(|k| series.column(column + k));
        joint_picture(name, quantity, series.column(0), &values, &limits.map(Bound::Constant), &[])
    };
    let joints = drawn.joints;
    let rates = [joints.velocity(), joints.acceleration(), joints.jerk()].map(|limits| (*limits).into());
    vec![
        ("path.svg", path_picture(name, &drawn.segments, &drawn.deviations, drawn.chord_tolerance, Some(motion))),
        ("path_speed.svg", speed_path_picture(name, motion)),
        ("motion.svg", Ok(motion_picture(name, drawn.poses.poses(), duration))),
        ("feed.svg", feed_picture(name, Along::Length, &series.pairs(1, 2), &drawn.limit)),
        ("feed_time.svg", feed_picture(name, Along::Time, &series.pairs(0, 2), &drawn.limit_by_time)),
        ("joint_velocity.svg", picture(JointQuantity::Velocity, 3, rates[0])),
        ("joint_acceleration.svg", picture(JointQuantity::Acceleration, 3 + N, rates[1])),
        ("joint_jerk.svg", picture(JointQuantity::Jerk, 3 + 2 * N, rates[2])),
    ]
}

/// The speed that a limit curve allows at `s`: between two grid points its square may lie on the straight line through both.
pub fn limit_at(limit: &[(f64, f64)], s: f64) -> f64 {
    let i = limit.partition_point(|l| l.0 <= s).clamp(1, limit.len() - 1);
    let ((s0, v0), (s1, v1)) = (limit[i - 1], limit[i]);
    (v0 * v0 + (v1 * v1 - v0 * v0) * (s - s0) / (s1 - s0)).max(0.0).sqrt()
}

/// The speed under its limit, with the stretches in which the look-ahead held it back.
pub fn stream_figure(name: &str, stream: &StreamReport, speed: &[(f64, f64)], limit: &[(f64, f64)]) -> SpeedFigure {
    let mm = |points: &[(f64, f64)]| points.iter().map(|p| (p.0 * 1e3, p.1 * 1e3)).collect::<Vec<_>>();
    let bar = |name: &str, intervals| BindingBar { name: name.to_owned(), joint: None, intervals };
    let waits = stream.waits_m_s.iter().map(|wait| (wait.0, wait.0)).collect::<Vec<_>>();
    SpeedFigure {
        file: "stream.svg".to_owned(),
        title: format!("{name}, streamed with {} segments ahead", stream.look_ahead),
        facts: format!("with the whole path known before: {:.4} s", stream.whole_duration_s),
        x_label: "path length s [mm]".to_owned(),
        y_label: "feed [mm/s]".to_owned(),
        speeds: vec![("streamed".to_owned(), mm(speed))],
        initial: mm(limit),
        ceiling: Vec::new(),
        bindings: vec![
            bar("look-ahead", mm(&stream.held_back_m)),
            bar("waits", mm(&waits).into_iter().map(|(s, _)| (s, s)).collect()),
        ],
    }
}
