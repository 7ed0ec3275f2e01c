//! The compiled motion of a plan, as its report states it.

use arcfeed_interp::{CertifiedLimit, JointTrajectory, MotionCertificate};
use arcfeed_kinematics::JointLimits;
use serde::Serialize;

use crate::text::percent;

/// Lines of a report for a terminal.
pub(crate) const LINES: usize = 3;
/// Position, velocity, acceleration and jerk.
const RATES: usize = 4;

/// The largest part of one kind of limit of the joints that a compiled motion uses.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CertifiedRatio {
    /// Name of the quantity, and of the kind of table where one limits it.
    pub name: String,
    /// The joint that uses most of its limit, from 1.
    pub joint: usize,
    /// The largest value found, divided by the limit.
    pub seen: f64,
    /// What is certainly not exceeded, divided by the limit.
    pub ratio: f64,
    /// The time at which the largest value was found, in s.
    pub at_t_s: f64,
}

/// The largest part of one limit of the tool that a compiled motion uses.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CertifiedToolRatio {
    /// Name of the quantity.
    pub name: String,
    /// The largest value found, divided by the limit.
    pub seen: f64,
    /// What is certainly not exceeded, divided by the limit.
    pub ratio: f64,
    /// The time at which the largest value was found, in s.
    pub at_t_s: f64,
}

/// The compiled motion of a plan. Its fields are the keys of the JSON form, SI units in their names.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompiledReport {
    /// Largest deviation of a joint from the plan that was allowed, in rad.
    pub tolerance_rad: f64,
    /// Number of polynomial pieces.
    pub pieces: usize,
    /// Deviation of any joint from the plan that is not exceeded, in rad.
    pub deviation_bound_rad: f64,
    /// Largest deviation of any joint at a sample, in rad.
    pub deviation_measured_rad: f64,
    /// Position, velocity, acceleration, jerk and torque, and tables, as far as they limit: each with the joint that uses most.
    pub certified: Vec<CertifiedRatio>,
    /// Feed, angular speed, tangential and normal acceleration of the tool, and magnitudes of its acceleration and jerk, as far as they
    /// are limited.
    pub certified_tool: Vec<CertifiedToolRatio>,
    /// Distance of the tool from where the plan has it at the same time that is not exceeded, in m.
    pub tool_deviation_bound_m: f64,
}

impl CompiledReport {
    /// The report of `compiled`, made for `tolerance` (rad), which makes of the limits what `certificate` says.
    pub fn new<const N: usize>(tolerance: f64, compiled: &JointTrajectory<N>, certificate: &MotionCertificate) -> Self {
        let tool = certificate.limits().iter().filter(|line| line.id.joint.is_none());
        let certified_tool = tool.map(|line| CertifiedToolRatio {
            name: line.id.quantity.to_string(),
            seen: line.attained / line.limit,
            ratio: line.ratio(),
            at_t_s: line.t,
        });
        let deviation = compiled.deviation();
        Self {
            tolerance_rad: tolerance,
            pieces: compiled.len(),
            deviation_bound_rad: deviation.map_or(f64::NAN, |deviation| deviation.bound),
            deviation_measured_rad: deviation.map_or(f64::NAN, |deviation| deviation.measured),
            certified: worst_of_joints(certificate.limits().iter().copied()),
            certified_tool: certified_tool.collect(),
            tool_deviation_bound_m: certificate.tool().deviation().map_or(f64::NAN, |[distance, _]| distance),
        }
    }

    /// The report of `compiled`, the motion of all parts of a program, from those of its moving parts: each with its begin, s.
    pub(crate) fn of_parts<const N: usize>(
        tolerance: f64,
        compiled: &JointTrajectory<N>,
        joints: &JointLimits<N>,
        parts: impl Iterator<Item = (f64, Self)>,
    ) -> Self {
        let deviation = compiled.deviation();
        let mut whole = Self {
            tolerance_rad: tolerance,
            pieces: compiled.len(),
            deviation_bound_rad: deviation.map_or(f64::NAN, |deviation| deviation.bound),
            deviation_measured_rad: deviation.map_or(f64::NAN, |deviation| deviation.measured),
            certified: worst_of_joints(rates(compiled, joints)),
            certified_tool: Vec::new(),
            tool_deviation_bound_m: 0.0,
        };
        let of_whole = whole.certified.len();
        for (begin, part) in parts {
            whole.tool_deviation_bound_m = whole.tool_deviation_bound_m.max(part.tool_deviation_bound_m);
            for line in part.certified {
                let line = CertifiedRatio { at_t_s: begin + line.at_t_s, ..line };
                match whole.certified.iter().position(|other| other.name == line.name) {
                    Some(known) if known < of_whole || whole.certified[known].ratio >= line.ratio => {}
                    Some(known) => whole.certified[known] = line,
                    None => whole.certified.push(line),
                }
            }
            for line in part.certified_tool {
                let line = CertifiedToolRatio { at_t_s: begin + line.at_t_s, ..line };
                match whole.certified_tool.iter_mut().find(|other| other.name == line.name) {
                    Some(other) if other.ratio >= line.ratio => {}
                    Some(other) => *other = line,
                    None => whole.certified_tool.push(line),
                }
            }
        }
        whole
    }

    /// The lines of a report for a terminal: what is certainly not exceeded. What was seen, and what is too long for a line, is in the
    /// JSON form alone.
    pub(crate) fn lines(&self) -> [String; LINES] {
        let joint =
            |line: &CertifiedRatio| format!("{} {}", line.name.trim_start_matches("joint "), percent(line.ratio));
        let (rates, others) = self.certified.split_at(RATES.min(self.certified.len()));
        let list = |lines: &[CertifiedRatio]| lines.iter().map(joint).collect::<Vec<_>>().join(", ");
        let drives = if others.is_empty() { String::new() } else { format!("{}; ", list(others)) };
        let tool: Vec<String> =
            self.certified_tool.iter().map(|line| format!("{} {}", line.name, percent(line.ratio))).collect();
        [
            format!(
                "{} pieces, {:.3e} rad from the plan at most, the tool {:.3e} mm",
                self.pieces,
                self.deviation_bound_rad,
                1e3 * self.tool_deviation_bound_m
            ),
            format!("certified: {}", list(rates)),
            format!("{drives}tool: {}", if tool.is_empty() { "no limit".to_owned() } else { tool.join(", ") }),
        ]
    }
}

/// Of each kind of limit of the joints the one that is used most, in the order of the first of each.
fn worst_of_joints(limits: impl Iterator<Item = CertifiedLimit>) -> Vec<CertifiedRatio> {
    let mut worst: Vec<CertifiedRatio> = Vec::new();
    for limit in limits {
        let Some(joint) = limit.id.joint else { continue };
        let by = match limit.table {
            Some(table) if table.is_by_speed() => " by its table of speed",
            Some(_) => " by its table of position",
            None => "",
        };
        let line = CertifiedRatio {
            name: format!("{}{by}", limit.id.quantity),
            joint: usize::from(joint) + 1,
            seen: limit.attained / limit.limit,
            ratio: limit.ratio(),
            at_t_s: limit.t,
        };
        match worst.iter_mut().find(|other| other.name == line.name) {
            Some(other) if other.ratio >= line.ratio => {}
            Some(other) => *other = line,
            None => worst.push(line),
        }
    }
    worst
}

/// Position, velocity, acceleration and jerk of the joints.
fn rates<const N: usize>(
    compiled: &JointTrajectory<N>,
    joints: &JointLimits<N>,
) -> impl Iterator<Item = CertifiedLimit> {
    let certificate = compiled.certify(joints.range(), &joints.into());
    let limits: Vec<_> = certificate.bounds().iter().map(|bound| CertifiedLimit::from(*bound)).collect();
    limits.into_iter()
}
