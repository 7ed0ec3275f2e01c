//! The compiled motion of a plan, as its report states it.

use arcfeed_interp::{JointTrajectory, Quantity, ToolCertificate, Trajectory};
use arcfeed_kinematics::JointLimits;
use serde::Serialize;

use crate::text::percent;

/// Lines of a report for a terminal.
pub(crate) const LINES: usize = 3;

/// The largest part of one kind of limit that a compiled motion certainly does not exceed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CertifiedRatio {
    /// Name of the quantity.
    pub name: String,
    /// The joint that uses most of its limit, from 1.
    pub joint: usize,
    /// What is not exceeded, divided by the limit.
    pub ratio: f64,
    /// The time at which it is attained, in s.
    pub at_t_s: f64,
}

/// The largest part of one limit of the tool that a compiled motion certainly does not exceed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CertifiedToolRatio {
    /// Name of the quantity.
    pub name: String,
    /// What is not exceeded, divided by the limit.
    pub ratio: f64,
    /// The time of the largest value found, in s.
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
    /// Position, velocity, acceleration and jerk, each with the joint that uses most of its limit.
    pub certified: Vec<CertifiedRatio>,
    /// Feed, angular speed, tangential and normal acceleration of the tool, as far as they are limited.
    pub certified_tool: Vec<CertifiedToolRatio>,
    /// Distance of the tool from where the plan has it at the same time that is not exceeded, in m.
    pub tool_deviation_bound_m: f64,
}

impl CompiledReport {
    /// The report of `compiled`, made of `plan` for `tolerance` (rad), whose tool does what `tool` says.
    pub fn new<const N: usize>(
        tolerance: f64,
        plan: &Trajectory<'_, N>,
        compiled: &JointTrajectory<N>,
        tool: &ToolCertificate,
    ) -> Self {
        let limits = plan.limits().tool();
        let of_tool = [
            (Quantity::Feed, limits.feed()),
            (Quantity::AngularSpeed, limits.angular_speed()),
            (Quantity::TangentialAcceleration, limits.tangential_acceleration()),
            (Quantity::NormalAcceleration, limits.normal_acceleration()),
        ];
        let certified_tool = of_tool.into_iter().filter_map(|(quantity, limit)| {
            let bound = tool.of(quantity)?;
            Some(CertifiedToolRatio { name: quantity.to_string(), ratio: bound.bound / limit?, at_t_s: bound.t })
        });
        let deviation = compiled.deviation();
        Self {
            tolerance_rad: tolerance,
            pieces: compiled.len(),
            deviation_bound_rad: deviation.map_or(f64::NAN, |deviation| deviation.bound),
            deviation_measured_rad: deviation.map_or(f64::NAN, |deviation| deviation.measured),
            certified: certified(compiled, plan.limits().joints()),
            certified_tool: certified_tool.collect(),
            tool_deviation_bound_m: tool.deviation().map_or(f64::NAN, |[distance, _]| distance),
        }
    }

    /// The report of `compiled`, the motion of all parts of a program, from those of its paths: each with its begin, s.
    ///
    /// Of the tool it says what it does on the paths.
    pub(crate) fn of_parts<const N: usize>(
        tolerance: f64,
        compiled: &JointTrajectory<N>,
        joints: &JointLimits<N>,
        paths: impl Iterator<Item = (f64, Self)>,
    ) -> Self {
        let deviation = compiled.deviation();
        let mut whole = Self {
            tolerance_rad: tolerance,
            pieces: compiled.len(),
            deviation_bound_rad: deviation.map_or(f64::NAN, |deviation| deviation.bound),
            deviation_measured_rad: deviation.map_or(f64::NAN, |deviation| deviation.measured),
            certified: certified(compiled, joints),
            certified_tool: Vec::new(),
            tool_deviation_bound_m: 0.0,
        };
        for (begin, path) in paths {
            whole.tool_deviation_bound_m = whole.tool_deviation_bound_m.max(path.tool_deviation_bound_m);
            for line in path.certified_tool {
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

    /// The lines of a report for a terminal.
    pub(crate) fn lines(&self) -> [String; LINES] {
        let parts: Vec<String> = self
            .certified
            .iter()
            .map(|line| format!("{} {}", line.name.trim_start_matches("joint "), percent(line.ratio)))
            .collect();
        let tool: Vec<String> =
            self.certified_tool.iter().map(|line| format!("{} {}", line.name, percent(line.ratio))).collect();
        [
            format!(
                "{} pieces, {:.3e} rad from the plan at most, the tool {:.3e} mm",
                self.pieces,
                self.deviation_bound_rad,
                1e3 * self.tool_deviation_bound_m
            ),
            format!("certified: {}", parts.join(", ")),
            format!("tool: {}", if tool.is_empty() { "no limit".to_owned() } else { tool.join(", ") }),
        ]
    }
}

/// Position, velocity, acceleration and jerk, each with the joint that uses most of its limit.
fn certified<const N: usize>(compiled: &JointTrajectory<N>, joints: &JointLimits<N>) -> Vec<CertifiedRatio> {
    let certificate = compiled.certify(joints.range(), &joints.into());
    let quantities =
        [Quantity::JointPosition, Quantity::JointVelocity, Quantity::JointAcceleration, Quantity::JointJerk];
    let worst = |quantity: Quantity| {
        let bounds = certificate.bounds().iter().filter(|bound| bound.id.quantity == quantity);
        let worst = bounds.max_by(|a, b| a.ratio().total_cmp(&b.ratio()))?;
        let joint = worst.id.joint.map_or(0, usize::from) + 1;
        Some(CertifiedRatio { name: quantity.to_string(), joint, ratio: worst.ratio(), at_t_s: worst.t })
    };
    quantities.into_iter().filter_map(worst).collect()
}
